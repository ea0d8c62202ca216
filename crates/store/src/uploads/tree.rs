//! BLAKE3 of content whose parts are hashed one by one, by whichever server receives them. The hash
//! is a tree: a part of a power of two of bytes, at a multiple of its size, is a subtree of it, so the
//! chaining values of the parts are all that the root needs.

use blake3::{
    Hasher,
    hazmat::{ChainingValue, HasherExt as _, Mode, merge_subtrees_non_root, merge_subtrees_root},
};

use crate::Digest;

/// Chaining value of a part that begins at an offset.
pub(super) fn chaining(offset: u64, part: &[u8]) -> ChainingValue {
    Hasher::new().set_input_offset(offset).update(part).finalize_non_root()
}

/// Hash of the whole, of whole parts and the bytes after them, which begin at an offset. There are
/// some of those, at most a part.
pub(super) fn root(parts: &[ChainingValue], offset: u64, rest: &[u8]) -> Digest {
    if parts.is_empty() {
        return blake3::hash(rest);
    }
    let mut all = parts.to_vec();
    all.push(chaining(offset, rest));
    let (left, right) = halves(&all);
    merge_subtrees_root(&subtree(left), &subtree(right), Mode::Hash)
}

fn subtree(parts: &[ChainingValue]) -> ChainingValue {
    match parts {
        [one] => *one,
        parts => {
            let (left, right) = halves(parts);
            merge_subtrees_non_root(&subtree(left), &subtree(right), Mode::Hash)
        }
    }
}

/// The children of a node: the left has as many parts as a complete tree can have.
fn halves(parts: &[ChainingValue]) -> (&[ChainingValue], &[ChainingValue]) {
    parts.split_at(parts.len().div_ceil(2).next_power_of_two().min(parts.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_the_hash_of_the_whole() {
        const PART: usize = 4096;
        let content: Vec<u8> = (0..20 * PART as u32).map(|i| (i % 251) as u8).collect();
        let ends = (1..=content.len()).step_by(1001).chain((1..=20).map(|n| n * PART));
        for end in ends {
            let whole = &content[..end];
            let count = (end - 1) / PART;
            let parts: Vec<_> = (0..count)
                .map(|nth| chaining((nth * PART) as u64, &whole[nth * PART..(nth + 1) * PART]))
                .collect();
            let offset = count * PART;
            let root = root(&parts, offset as u64, &whole[offset..]);
            assert_eq!(root, blake3::hash(whole), "{end}");
        }
    }
}
