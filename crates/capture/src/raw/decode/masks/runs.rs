//! Run lengths of pixels.

use super::Size;
use crate::{Error, limits::Budget};

/// Pixels of a mask as run lengths, so that the masks of all frames fit into memory.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::raw) enum Runs {
    /// Labels with their lengths, row by row.
    Rows(Vec<(u32, u32)>),
    /// Lengths of background and of the object by turns, column by column, as COCO has them.
    Columns(Vec<u32>),
}

impl Runs {
    /// Run lengths of labels.
    pub(super) fn of(
        labels: impl Iterator<Item = u32>,
        at: &str,
        budget: &mut Budget,
    ) -> Result<Self, Error> {
        let mut runs: Vec<(u32, u32)> = Vec::new();
        for label in labels {
            match runs.last_mut() {
                Some((last, length)) if *last == label => *length += 1,
                _ => runs.push((label, 1)),
            }
        }
        runs.shrink_to_fit();
        budget.take(8 * runs.len() as u64, at)?;
        Ok(Self::Rows(runs))
    }

    /// Bytes that the lengths take in memory.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Rows(runs) => size_of_val(runs.as_slice()) as u64,
            Self::Columns(lengths) => size_of_val(lengths.as_slice()) as u64,
        }
    }

    /// The labels that show something, with repetitions, without a look at single pixels.
    pub(in crate::raw) fn labels(&self) -> Box<dyn Iterator<Item = u32> + '_> {
        match self {
            Self::Rows(runs) => Box::new(runs.iter().map(|run| run.0).filter(|label| *label != 0)),
            Self::Columns(lengths) => {
                let shown = lengths.iter().skip(1).step_by(2);
                Box::new(shown.filter(|length| **length > 0).map(|_| 1))
            }
        }
    }

    /// Calls `pixel` with the index and the label of every pixel that shows something, in no
    /// particular order.
    pub(in crate::raw) fn each(&self, [width, height]: Size, mut pixel: impl FnMut(usize, u32)) {
        let count = width * height;
        let mut start = 0_usize;
        match self {
            Self::Rows(runs) => {
                for &(label, length) in runs {
                    let end = start.saturating_add(length as usize).min(count);
                    if label != 0 {
                        (start..end).for_each(|index| pixel(index, label));
                    }
                    start = end;
                }
            }
            Self::Columns(lengths) => {
                for (index, &length) in lengths.iter().enumerate() {
                    let end = start.saturating_add(length as usize).min(count);
                    if index % 2 == 1 {
                        for place in start..end {
                            pixel(place % height * width + place / height, 1);
                        }
                    }
                    start = end;
                }
            }
        }
    }
}

/// Lengths of COCO's text, as its `pycocotools` write them: numbers of 5 bits a letter, each from
/// the third on less the one two before it.
pub(super) fn of_text(text: &str) -> Option<Vec<u32>> {
    let mut lengths: Vec<i64> = Vec::new();
    let mut letters = text.bytes();
    while let Some(first) = letters.next() {
        let mut letter = first;
        let (mut number, mut shift) = (0_i64, 0);
        loop {
            let bits = i64::from(letter.checked_sub(48).filter(|bits| *bits < 64)?);
            number |= (bits & 0x1f) << shift;
            shift += 5;
            if bits & 0x20 == 0 {
                if bits & 0x10 != 0 {
                    number |= -1 << shift;
                }
                break;
            }
            if shift > 40 {
                return None;
            }
            letter = letters.next()?;
        }
        if let Some(before) = lengths.len().checked_sub(2).filter(|_| lengths.len() > 2) {
            number += lengths[before];
        }
        lengths.push(number);
    }
    lengths.into_iter().map(|n| u32::try_from(n).ok()).collect()
}
