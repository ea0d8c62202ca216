//! A cache of unpacked chunks. Messages of one moment lie in a few neighbouring chunks, so a reader that moves
//! forward unpacks each chunk about once. A hostile file may scatter messages over chunks that unpack to very
//! many bytes each, so the total is bounded.

use super::chunk::Chunk;

/// Bytes that are kept, unless a single chunk has more, and most chunks.
const KEPT_BYTES: u64 = 16 << 20;
const KEPT: usize = 8;
/// Times that all chunks of a file may be unpacked by one reader, and bytes that it may unpack in any case.
const MOST_TIMES: u64 = 16;
const SPARE_BYTES: u64 = 64 << 20;

/// Unpacked chunks of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct OpenChunks {
    /// Numbers and records of chunks, the most recently used first.
    open: Vec<(u32, Vec<u8>)>,
    /// Bytes that were unpacked so far.
    unpacked: u64,
    /// Bytes of all chunks, once they are counted.
    all: Option<u64>,
}

/// What keeps a chunk closed.
#[derive(Debug)]
pub(super) enum Closed<E> {
    /// There is no such chunk.
    Missing,
    /// Chunks were unpacked too often.
    Scattered,
    /// The chunk cannot be unpacked.
    Failed(E),
}

impl OpenChunks {
    /// The records of a chunk; `unpack` gets them where they are not at hand.
    pub(super) fn get<E>(
        &mut self,
        number: u32,
        chunks: &[Chunk],
        unpack: impl FnOnce(&Chunk) -> Result<Vec<u8>, E>,
    ) -> Result<&[u8], Closed<E>> {
        match self.open.iter().position(|(open, _)| *open == number) {
            Some(at) => self.open[..=at].rotate_right(1),
            None => {
                let chunk = chunks.get(number as usize).ok_or(Closed::Missing)?;
                let all = chunks.iter().map(|chunk| chunk.unpacked);
                let all = *self.all.get_or_insert_with(|| all.fold(0, u64::saturating_add));
                self.unpacked = self.unpacked.saturating_add(chunk.unpacked);
                if self.unpacked > all.saturating_mul(MOST_TIMES).saturating_add(SPARE_BYTES) {
                    return Err(Closed::Scattered);
                }
                self.make_room(chunk.unpacked);
                let records = unpack(chunk).map_err(Closed::Failed)?;
                self.open.insert(0, (number, records));
            }
        }
        Ok(self.open.first().map_or(&[], |(_, records)| records))
    }

    /// Drops the least recently used chunks, before a new one is unpacked.
    fn make_room(&mut self, bytes: u64) {
        let kept = |open: &[(u32, Vec<u8>)]| open.iter().map(|(_, b)| b.len() as u64).sum::<u64>();
        while !self.open.is_empty()
            && (self.open.len() >= KEPT || kept(&self.open).saturating_add(bytes) > KEPT_BYTES)
        {
            self.open.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chunks that unpack to this many bytes each.
    fn chunks(sizes: &[u64]) -> Vec<Chunk> {
        let header = |size: &u64| {
            let packed =
                [&[0; 16][..], &size.to_le_bytes(), &[0; 4], &4_u32.to_le_bytes()].concat();
            let packed = [&packed[..], b"zstd", &0_u64.to_le_bytes()].concat();
            Chunk::parse(&packed, 0, packed.len() as u64).unwrap()
        };
        sizes.iter().map(header).collect()
    }

    /// Chunks that were unpacked for a way through them, until one stays closed.
    fn unpacked(sizes: &[u64], way: impl Iterator<Item = u32>) -> (usize, bool) {
        let (all, mut open, mut count) = (chunks(sizes), OpenChunks::default(), 0);
        for number in way {
            let records = open.get(number, &all, |chunk| {
                count += 1;
                // Large enough to be counted, small enough for a test.
                Ok::<_, ()>(vec![number as u8; chunk.unpacked.min(4 << 20) as usize])
            });
            match records {
                Ok(records) => assert_eq!(records.first(), Some(&(number as u8))),
                Err(closed) => {
                    assert!(matches!(closed, Closed::Scattered), "{closed:?}");
                    return (count, true);
                }
            }
        }
        (count, false)
    }

    #[test]
    fn a_reader_that_goes_forward_unpacks_each_chunk_once() {
        // Colour, depth and two masks of each moment in chunks beside each other.
        let way = (0..1000_u32).flat_map(|frame| (0..4).map(move |topic| frame / 50 + topic));
        assert_eq!(unpacked(&[1 << 20; 24], way), (23, false));
    }

    /// 100,000 frames whose colour and depth lie in two chunks, or are scattered over all.
    #[test]
    fn scattered_messages_are_given_up() {
        let between = |n: u32| (0..200_000).map(move |i| i % n);
        assert_eq!(unpacked(&[1 << 20; 8], between(8)), (8, false));
        let (count, scattered) = unpacked(&[1 << 20; 32], between(32));
        assert!(scattered && count <= 32 * 16 + 64, "{count}");
        let (count, scattered) = unpacked(&[16 << 20; 2], between(2));
        assert!(scattered && count <= 2 * 16 + 4, "{count}");
    }

    #[test]
    fn a_chunk_that_is_not_there_is_missing() {
        let mut open = OpenChunks::default();
        let missing = open.get(0, &[], |_| Ok::<_, ()>(Vec::new()));
        assert!(matches!(missing, Err(Closed::Missing)));
    }
}
