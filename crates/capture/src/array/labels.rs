//! Arrays of labels: numbers of objects, truth values, probabilities or logits.

use std::ops::Range;

use super::Array;
use crate::raw::label_number;

/// What the numbers of an array of labels mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// Whole numbers: each is a label.
    Labels,
    /// From 0 to 1: true from a half on.
    Probabilities,
    /// True above 0.
    Logits,
}

/// An array read as labels.
#[derive(Debug)]
pub(crate) struct Labels<'r, 'a> {
    array: &'r Array<'a>,
    meaning: Meaning,
}

impl<'a> Array<'a> {
    /// The array read as labels: integers and truth values unchanged; floats by what all of them
    /// look like.
    pub(crate) fn labels(&self) -> Labels<'_, 'a> {
        let floats = || self.data.chunks_exact(self.dtype.size()).map(|b| self.dtype.float(b));
        let meaning = if !self.is_float() || floats().all(|x| x >= 0.0 && x.fract() == 0.0) {
            Meaning::Labels
        } else if floats().all(|x| (0.0..=1.0).contains(&x)) {
            Meaning::Probabilities
        } else {
            Meaning::Logits
        };
        Labels { array: self, meaning }
    }
}

impl Labels<'_, '_> {
    /// Labels of a range of elements in row-major order; 0 is nothing.
    pub(crate) fn range(&self, range: Range<usize>) -> impl Iterator<Item = u32> {
        let Self { array, meaning } = *self;
        let size = array.dtype.size();
        range.map(move |index| {
            let start = array.place(index) * size;
            let Some(bytes) = array.data.get(start..start + size) else { return 0 };
            if !array.is_float() {
                return label_number(array.dtype.integer(bytes));
            }
            let x = array.dtype.float(bytes);
            match meaning {
                Meaning::Labels => label_number(x as i64),
                Meaning::Probabilities => u32::from(x >= 0.5),
                Meaning::Logits => u32::from(x > 0.0),
            }
        })
    }
}

impl Array<'_> {
    /// Place of an element, given by its index in row-major order, among those of the file.
    fn place(&self, index: usize) -> usize {
        if !self.fortran || self.shape.len() < 2 {
            return index;
        }
        let (mut rest, mut place) = (index, 0);
        let mut stride = self.shape.iter().product::<usize>();
        // From the last dimension, which is the slowest of the file and the fastest of the index.
        for extent in self.shape.iter().rev() {
            stride /= (*extent).max(1);
            place += rest % extent.max(&1) * stride;
            rest /= extent.max(&1);
        }
        place
    }
}
