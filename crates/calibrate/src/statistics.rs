//! Medians.

use bendtwin_core::geometry;

/// Upper median of numbers; `None` of none.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    geometry::median(&mut values.collect::<Vec<_>>())
}
