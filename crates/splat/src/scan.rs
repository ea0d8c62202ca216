//! Looking through long arrays for numbers that break a rule.

use rayon::prelude::*;

/// Values that a thread checks at a time.
const PIECE: usize = 1 << 13;

/// Index of the first value that does not keep the rule.
///
/// Nearly all input is correct: a piece is first checked without a branch, which compilers turn
/// into vector instructions.
pub(crate) fn first_wrong<T: Copy + Sync>(
    values: &[T],
    keeps: impl Fn(T) -> bool + Sync,
) -> Option<usize> {
    values.par_chunks(PIECE).enumerate().find_map_first(|(k, piece)| {
        let all_keep = piece.iter().fold(true, |all, &x| all & keeps(x));
        if all_keep {
            return None;
        }
        piece.iter().position(|&x| !keeps(x)).map(|i| k * PIECE + i)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_in_different_pieces_is_found() {
        let mut values = vec![1.0_f32; 3 * PIECE + 5];
        assert_eq!(first_wrong(&values, f32::is_finite), None);
        for index in [3 * PIECE + 4, 2 * PIECE, PIECE + 7, 0] {
            values[index] = f32::NAN;
            assert_eq!(first_wrong(&values, f32::is_finite), Some(index));
        }
        assert_eq!(first_wrong(&[], f32::is_finite), None);
    }
}
