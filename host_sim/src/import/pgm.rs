//! PGM images, ASCII (`P2`) and binary (`P5`), of 8 or 16 bits: what ROS stores maps in.
//!
//! Format: <https://netpbm.sourceforge.net/doc/pgm.html>. Comments (`#` to the end of the line) may stand anywhere in
//! the head, and in the body of `P2`. Of a file with several images the first is read.

use std::path::Path;

use super::{ImportError, Reader, SIDE_MAX};

/// A grey image, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pgm {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The value of white, 1 to 65535.
    pub maximum: u16,
    /// 0 (black) to `maximum`.
    pub values: Vec<u16>,
}

/// Reads an image; `path` is what errors call it.
///
/// # Errors
/// If it is no PGM, is cut short, or has a value above its maximum.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Pgm, ImportError> {
    let reader = Reader::new(path);
    let ascii = match bytes.get(..2) {
        Some(b"P2") => true,
        Some(b"P5") => false,
        _ => {
            let shown: String = bytes.iter().take(2).map(|&byte| byte.escape_ascii().to_string()).collect();
            let problem = format!("begins with `{shown}`");
            return Err(reader.error("head", problem, "give a PGM image (P2 or P5)"));
        }
    };
    let mut scan = Scan { reader: &reader, bytes, at: 2 };
    let width = scan.side("width")?;
    let height = scan.side("height")?;
    let maximum = match u16::try_from(scan.number("maximum")?) {
        Ok(maximum) if maximum > 0 => maximum,
        _ => return Err(reader.error("maximum", "is not 1 to 65535".to_owned(), "correct it")),
    };
    let count = width * height;
    let values = if ascii { scan.ascii(count)? } else { scan.binary(count, maximum)? };
    if let Some(i) = values.iter().position(|&value| value > maximum) {
        let problem = format!("{} is above the maximum {maximum}", values[i]);
        return Err(reader.error(&pixel(i, width), problem, "correct the value or the maximum"));
    }
    Ok(Pgm { width, height, maximum, values })
}

fn pixel(index: usize, width: usize) -> String {
    format!("pixel ({}, {})", index % width.max(1), index / width.max(1))
}

struct Scan<'a> {
    reader: &'a Reader,
    bytes: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    /// The next number behind blanks and comments.
    fn number(&mut self, what: &str) -> Result<u32, ImportError> {
        let mut comment = false;
        while let Some(&byte) = self.bytes.get(self.at) {
            comment = (comment || byte == b'#') && byte != b'\n' && byte != b'\r';
            if !comment && !byte.is_ascii_whitespace() {
                break;
            }
            self.at += 1;
        }
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let value = rest[..digits]
            .iter()
            .try_fold(0_u32, |value, &digit| value.checked_mul(10)?.checked_add(u32::from(digit - b'0')));
        self.at += digits;
        value.filter(|_| digits > 0).ok_or_else(|| {
            let problem = if rest.is_empty() { "the file ends" } else { "no number that can be used" };
            self.reader.error(what, problem.to_owned(), "give a whole PGM image")
        })
    }

    fn side(&mut self, what: &str) -> Result<usize, ImportError> {
        let side = self.number(what)?;
        match usize::try_from(side) {
            Ok(side) if (1..=SIDE_MAX).contains(&side) => Ok(side),
            _ => Err(self.reader.error(what, format!("{side} pixels"), &format!("give 1 to {SIDE_MAX}"))),
        }
    }

    fn ascii(&mut self, count: usize) -> Result<Vec<u16>, ImportError> {
        // A pixel takes two bytes at least: a short file is refused before memory is taken for a long one.
        if self.bytes.len() < count {
            return Err(self.too_short(self.bytes.len(), count));
        }
        let value = |i: usize, value: u32| {
            let too_large =
                |_| self.reader.error(&format!("pixel {i}"), format!("{value}"), "give at most 65535");
            u16::try_from(value).map_err(too_large)
        };
        let mut scan = Scan { reader: self.reader, bytes: self.bytes, at: self.at };
        (0..count).map(|i| value(i, scan.number(&format!("pixel {i}"))?)).collect()
    }

    fn binary(&self, count: usize, maximum: u16) -> Result<Vec<u16>, ImportError> {
        // One blank behind the maximum; 16-bit values have their high byte first.
        let body = self.bytes.get(self.at + 1..).unwrap_or_default();
        let wide = maximum > 255;
        let size = if wide { 2 * count } else { count };
        let body = body.get(..size).ok_or_else(|| self.too_short(body.len(), size))?;
        let values = if wide {
            body.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
        } else {
            body.iter().map(|&value| u16::from(value)).collect()
        };
        Ok(values)
    }

    fn too_short(&self, is: usize, needed: usize) -> ImportError {
        let problem = format!("{is} bytes for pixels that take {needed}");
        self.reader.error("pixels", problem, "give a whole PGM image")
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::proptest;

    use super::{Pgm, parse};

    fn image(bytes: &[u8]) -> Result<Pgm, String> {
        parse(Path::new("a.pgm"), bytes).map_err(|error| error.to_string())
    }

    #[test]
    fn both_forms_and_both_widths_are_read() {
        let expected = Pgm { width: 3, height: 2, maximum: 255, values: vec![0, 1, 2, 10, 205, 255] };
        assert_eq!(image(b"P2 # c\n# 9 9\n3 2\n255\n0 1 2\n10#x\n 205 255\n").unwrap(), expected);
        assert_eq!(image(b"P5\n# made\n3 2 255\n\x00\x01\x02\x0a\xcd\xff").unwrap(), expected);
        let wide = image(b"P5 2 1 1000\n\x03\xe8\x00\x05").unwrap();
        assert_eq!((wide.maximum, wide.values), (1000, vec![1000, 5]));
    }

    #[test]
    fn broken_images_are_refused() {
        for (bytes, said) in [
            (&b""[..], "PGM"),
            (b"P6 1 1 255\n000", "`P6`"),
            (b"P5", "width: the file ends"),
            (b"P5 0 1 255\n", "width: 0 pixels"),
            (b"P5 99999 1 255\n", "99999"),
            (b"P5 99999999999 1 255\n", "width"),
            (b"P5 1 1 0\n0", "maximum"),
            (b"P5 1 1 70000\n0", "maximum"),
            (b"P5 2 2 255\n123", "3 bytes for pixels that take 4"),
            (b"P5 2 1 300\n123", "3 bytes for pixels that take 4"),
            (b"P5 4000 4000 255", "0 bytes"),
            (b"P2 2 1 255\n1    ", "pixel 1: the file ends"),
            (b"P2 2 1 255\n1 x  ", "pixel 1"),
            (b"P2 2 1 255\n1 256", "pixel (1, 0): 256"),
            (b"P2 2 1 9\n1 99999", "99999"),
        ] {
            let error = image(bytes).unwrap_err();
            assert!(error.starts_with("a.pgm: ") && error.contains(said), "{error}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(
            head in "P[25][ #\n]{1,3}[0-9]{1,3} [0-9]{1,2}[ #\n][0-9]{1,5}\n",
            body in proptest::collection::vec(0_u8..=255, 0..80),
        ) {
            let _ = image(&[head.as_bytes(), &body].concat());
            let _ = image(&body);
        }
    }
}
