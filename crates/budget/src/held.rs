//! Bytes that hold a share.

use bytes::Bytes;

/// Bytes that hold a share (or anything that has one) until the last reference to them is gone: on
/// their way through the buffers of a connection, say.
pub fn held(bytes: Bytes, share: impl Send + Sync + 'static) -> Bytes {
    Bytes::from_owner(OwnedBytes { bytes, _share: share })
}

struct OwnedBytes<S> {
    bytes: Bytes,
    _share: S,
}

impl<S> AsRef<[u8]> for OwnedBytes<S> {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Budget;

    #[test]
    fn a_share_is_held_until_the_last_part_is_gone() {
        let budget = Budget::new(64 << 20);
        let share = budget.try_take(2 << 20).unwrap();
        let mut bytes = held(Bytes::from_static(b"abcd"), share);
        let first = bytes.split_to(2);
        drop(bytes);
        assert_eq!((budget.used(), &first[..]), (2 << 20, &b"ab"[..]));
        drop(first);
        assert_eq!(budget.used(), 0);
    }
}
