//! Lists of bounded length, without a panic for what does not fit.

use heapless::Vec;

/// The first `N` of the items. (`collect` would panic where there are more, or keep the code for it where there never
/// are.)
pub(crate) fn first<T, const N: usize>(items: impl Iterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    for item in items {
        if list.push(item).is_err() {
            break;
        }
    }
    list
}
