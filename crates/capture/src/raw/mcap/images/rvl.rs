//! RVL, the lossless compression of depth images by run lengths and differences (A. D. Wilson, Fast
//! Lossless Depth Image Compression, 2017).
//!
//! Numbers are written in groups of three bits, the lowest first, each with a bit that says that
//! another group follows; eight groups fill a word of 32 bits from its highest bit on. The numbers
//! are, alternating: how many pixels are 0, how many are not, and for each of these its difference
//! from the last such pixel, signed by its lowest bit.

/// The numbers of `count` pixels; `None` if there are too few or too many, or a run is too long.
pub(super) fn decode(data: &[u8], count: usize) -> Option<Vec<u16>> {
    let mut groups = Groups { data, word: 0, left: 0 };
    // Grows as data arrive: runs of zeros cost little, but the caller has checked the count.
    let mut pixels: Vec<u16> = Vec::with_capacity(count);
    let mut last = 0_u16;
    while pixels.len() < count {
        let zeros = groups.number()? as usize;
        let filled = pixels.len().checked_add(zeros).filter(|n| *n <= count)?;
        pixels.resize(filled, 0);
        let others = groups.number()? as usize;
        if others > count - filled || (zeros == 0 && others == 0) {
            return None;
        }
        for _ in 0..others {
            let folded = groups.number()?;
            let difference = (folded >> 1) as i32 ^ -((folded & 1) as i32);
            last = last.wrapping_add(difference as u16);
            pixels.push(last);
        }
    }
    Some(pixels)
}

struct Groups<'a> {
    data: &'a [u8],
    word: u32,
    /// Groups left in the word.
    left: u32,
}

impl Groups<'_> {
    fn number(&mut self) -> Option<u32> {
        let mut value = 0;
        for shift in (0..32).step_by(3) {
            if self.left == 0 {
                let (word, rest) = self.data.split_first_chunk()?;
                (self.word, self.data, self.left) = (u32::from_le_bytes(*word), rest, 8);
            }
            let group = self.word >> 28;
            self.word <<= 4;
            self.left -= 1;
            value |= (group & 7) << shift;
            if group & 8 == 0 {
                return Some(value);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of these groups.
    fn words(groups: &[u32]) -> Vec<u8> {
        let word = |eight: &[u32]| {
            (0..8).fold(0_u32, |w, i| (w << 4) | eight.get(i).copied().unwrap_or(0))
        };
        groups.chunks(8).flat_map(|eight| word(eight).to_le_bytes()).collect()
    }

    #[test]
    fn an_image_that_was_encoded_by_hand_is_decoded() {
        // Two zeros, three others: 500, 503, 499; then one zero and none.
        // 500 is 1000 folded: 0, 5, 7, 1 in groups of three bits from the lowest.
        let groups = [2, 3, 8, 8 | 5, 8 | 7, 1, 6, 7, 1, 0];
        let data = words(&groups);
        assert_eq!(decode(&data, 6), Some(vec![0, 0, 500, 503, 499, 0]));
        assert_eq!(decode(&data, 7), None, "it ends early");
        assert_eq!(decode(&data, 5), Some(vec![0, 0, 500, 503, 499]));
        assert_eq!(decode(&data, 4), None, "a run beyond the image");
        assert_eq!(decode(&data[..3], 6), None);
        assert_eq!(decode(&words(&[0, 0, 0, 0]), 6), None, "nothing, for ever");
        assert_eq!(decode(&[0xFF; 64], 6), None, "a number without end");
        assert_eq!(decode(&[], 0), Some(vec![]));
    }
}
