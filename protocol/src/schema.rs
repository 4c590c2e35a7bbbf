//! The shape of every message as one number, so that two ends know whether they mean the same by the same bytes.
//!
//! The hash is computed while compiling, from what the derives see: names and order of variants and fields, their
//! types, and the limits of lists and texts. It does not see units, frames of reference or what a number is taken to
//! mean; whoever changes one of those renames the field, which changes the hash.
//!
//! Names of types are left out (a [`heapless::Vec`] and a slice are the same on the wire), and so are names that serde
//! renames for files. Nothing of this is in the image but the resulting numbers.

use postcard_schema::Schema;
use postcard_schema::key::hash::fnv1a64::hash_ty_path;

use crate::codec::Message;
use crate::message::{BUILD_ID_BYTES, CHECKPOINTS_PER_MESSAGE, FromBoard, FromHost, NEURONS_PER_MESSAGE};

/// What the hash of a type begins with; keeps it apart from hashes that others make of types like ours.
const SALT: &str = "ekm-nav";

/// A type together with the limits, which the schema of a list or text does not tell: each as a tuple of that length.
type Limited<T> = (T, [(); CHECKPOINTS_PER_MESSAGE], [(); NEURONS_PER_MESSAGE], [(); BUILD_ID_BYTES]);

/// Hash of all messages of both directions; goes with [`crate::message::PROTOCOL_VERSION`].
pub const HASH: u64 = hash::<(FromHost, FromBoard)>();

/// Hash (FNV-1a, 64 bits) of a type's shape and the limits of this version.
#[must_use]
pub const fn hash<T: Schema>() -> u64 {
    // A constant wherever it is called from: the walk through the schema is long, and must not be in the image.
    const { u64::from_le_bytes(hash_ty_path::<Limited<T>>(SALT)) }
}

/// What the frames of one direction begin with: the low 16 bits of the [`hash`] of its messages.
///
/// One in 65,536 changes of the messages leaves it as it was; the whole [`HASH`] in
/// [`crate::message::Hello`] then still tells the two apart.
#[must_use]
pub const fn key<M: Message>() -> u16 {
    let [low, high, ..] = hash::<M>().to_le_bytes();
    u16::from_le_bytes([low, high])
}

#[cfg(test)]
mod tests {
    use postcard_schema::Schema;

    use super::{HASH, hash, key};
    use crate::message::{FromBoard, FromHost, PROTOCOL_VERSION};

    /// The number of a released version must not mean two things. This test fails whenever a message has changed:
    /// then raise `PROTOCOL_VERSION`, write the new pair here, and add golden frames of the new version.
    #[test]
    fn the_hash_changes_together_with_the_version() {
        assert_eq!(
            (PROTOCOL_VERSION, HASH),
            (2, 0xf869_af7a_91da_e0a6),
            "found {HASH:#018x}; see the comment of this test"
        );
    }

    #[test]
    fn the_directions_have_keys_of_their_own() {
        assert_ne!(key::<FromHost>(), key::<FromBoard>());
    }

    mod original {
        #[derive(postcard_schema::Schema)]
        #[expect(dead_code, reason = "only its shape is used")]
        pub enum Message {
            Stop,
            Go { left_mps: f32, right_mps: f32, tick: u32 },
            Say(heapless::Vec<u8, 4>),
        }
    }

    /// Each module is `original` with one change.
    macro_rules! twin {
        ($name:ident { $($variants:tt)* }) => {
            mod $name {
                #[derive(postcard_schema::Schema)]
                #[expect(dead_code, reason = "only its shape is used")]
                pub enum Message { $($variants)* }
            }
        };
    }

    twin!(same { Stop, Go { left_mps: f32, right_mps: f32, tick: u32 }, Say(heapless::Vec<u8, 4>) });
    twin!(field_renamed { Stop, Go { left: f32, right_mps: f32, tick: u32 }, Say(heapless::Vec<u8, 4>) });
    twin!(fields_swapped { Stop, Go { right_mps: f32, left_mps: f32, tick: u32 }, Say(heapless::Vec<u8, 4>) });
    twin!(field_widened { Stop, Go { left_mps: f32, right_mps: f32, tick: u64 }, Say(heapless::Vec<u8, 4>) });
    twin!(field_optional { Stop, Go { left_mps: Option<f32>, right_mps: f32, tick: u32 }, Say(heapless::Vec<u8, 4>) });
    twin!(field_dropped { Stop, Go { left_mps: f32, right_mps: f32 }, Say(heapless::Vec<u8, 4>) });
    twin!(items_widened { Stop, Go { left_mps: f32, right_mps: f32, tick: u32 }, Say(heapless::Vec<u16, 4>) });
    twin!(variant_renamed { Halt, Go { left_mps: f32, right_mps: f32, tick: u32 }, Say(heapless::Vec<u8, 4>) });
    twin!(variants_swapped { Stop, Say(heapless::Vec<u8, 4>), Go { left_mps: f32, right_mps: f32, tick: u32 } });
    twin!(variant_added { Stop, Go { left_mps: f32, right_mps: f32, tick: u32 }, Say(heapless::Vec<u8, 4>), Ask });

    #[test]
    fn whatever_changes_the_meaning_of_bytes_changes_the_hash() {
        let original = hash::<original::Message>();
        assert_eq!(original, hash::<same::Message>());
        let changed = [
            hash::<field_renamed::Message>(),
            hash::<fields_swapped::Message>(),
            hash::<field_widened::Message>(),
            hash::<field_optional::Message>(),
            hash::<field_dropped::Message>(),
            hash::<items_widened::Message>(),
            hash::<variant_renamed::Message>(),
            hash::<variants_swapped::Message>(),
            hash::<variant_added::Message>(),
        ];
        for (index, change) in changed.iter().enumerate() {
            assert_ne!(*change, original, "change {index}");
            assert!(!changed[..index].contains(change), "change {index} is like another");
        }
    }

    #[test]
    fn limits_are_part_of_the_shape() {
        // What `Limited` relies on: a tuple's length is hashed, a list's capacity is not.
        assert_ne!(hash::<[(); 16]>(), hash::<[(); 15]>());
        assert_eq!(hash::<heapless::Vec<u8, 16>>(), hash::<heapless::Vec<u8, 15>>());
        assert_eq!(<heapless::String<4>>::SCHEMA, <heapless::String<5>>::SCHEMA);
    }
}
