//! Sizes of messages, before they are made.

use prost::length_delimiter_len as varint_len;

/// Bytes of the encoding of a length.
pub(super) fn length(n: u64) -> u64 {
    varint_len(usize::try_from(n).unwrap_or(usize::MAX)) as u64
}

/// Bytes of a message so far; what overflows stays at the largest number, which exceeds every limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Message(pub(super) u64);

impl Message {
    pub(super) fn add(&mut self, bytes: u64) {
        self.0 = self.0.saturating_add(bytes);
    }

    /// A tensor field whose tag takes `tag` bytes and whose elements take `width` each.
    pub(super) fn tensor(&mut self, tag: u64, width: u64, shape: &[u64]) {
        let data = shape.iter().fold(width, |product, d| product.saturating_mul(*d));
        let dims: u64 = shape.iter().map(|d| length(*d)).sum();
        let inside = (2 + 2 + dims).saturating_add(data).saturating_add(1 + length(data));
        self.add(inside.saturating_add(tag + length(inside)));
    }

    /// A text field whose tag takes one byte.
    pub(super) fn text(&mut self, bytes: usize) {
        self.add((1 + varint_len(bytes) + bytes) as u64);
    }

    /// A message inside this one, whose tag takes `tag` bytes.
    pub(super) fn message(&mut self, tag: u64, inside: &Self) {
        self.add(inside.0.saturating_add(tag + length(inside.0)));
    }
}
