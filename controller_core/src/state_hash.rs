//! A running hash of what the controller decided, to compare runs on different machines tick by tick.
//!
//! FNV-1a over 32-bit words: two multiplications a word on a Cortex-M, no table. Not meant against malice.

use crate::scalar::Scalar;

/// The hash so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StateHash(u64);

impl Default for StateHash {
    fn default() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }
}

impl StateHash {
    /// Adds a word.
    pub fn add_word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01B3);
    }

    /// Adds a number's bits.
    pub fn add<S: Scalar>(&mut self, value: S) {
        self.add_word(value.to_bits());
    }

    /// The hash as a number.
    #[must_use]
    pub fn value(self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::StateHash;

    #[test]
    fn order_and_bits_matter() {
        let hash = |words: &[u32]| {
            let mut hash = StateHash::default();
            words.iter().for_each(|&word| hash.add_word(word));
            hash.value()
        };
        assert_ne!(hash(&[1, 2]), hash(&[2, 1]));
        assert_ne!(hash(&[0]), hash(&[]));
        // FNV-1a with a 32-bit step, worked by hand for one word.
        assert_eq!(hash(&[1]), (0xCBF2_9CE4_8422_2325_u64 ^ 1).wrapping_mul(0x0100_0000_01B3));
    }
}
