//! Medians.

use super::Scalar;

/// Upper median of numbers, which it reorders; `None` of none. NaN counts as the largest number.
pub fn median<T: Scalar>(values: &mut [T]) -> Option<T> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, T::total_cmp).1)
}
