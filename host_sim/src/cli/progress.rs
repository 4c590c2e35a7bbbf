//! Progress bars on stderr, where there is a terminal to draw them on.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of so many steps; it draws nothing where stderr is not a terminal, and is wiped when dropped.
pub struct Progress(ProgressBar);

impl Progress {
    pub fn new(what: &'static str, steps: u64) -> Self {
        let bar = ProgressBar::new(steps).with_message(what);
        // The template is fixed and right; if a later version refuses it, its own default will do.
        if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self(bar)
    }

    pub fn advance(&self) {
        self.0.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
