//! Operators on each number, and means and sums along axes.

use super::{
    Error,
    tensor::{Tensor, size},
};

/// Function of two tensors whose shapes fit by numpy's rules: sizes are equal from the last on, 1,
/// or missing.
pub(super) fn broadcast(
    a: &Tensor,
    b: &Tensor,
    value: impl Fn(f32, f32) -> f32,
) -> Result<Tensor, Error> {
    let rank = a.shape.len().max(b.shape.len());
    let padded = |t: &Tensor| {
        let mut shape = vec![1; rank - t.shape.len()];
        shape.extend(&t.shape);
        shape
    };
    let (of_a, of_b) = (padded(a), padded(b));
    let mut shape = Vec::with_capacity(rank);
    for (&m, &n) in of_a.iter().zip(&of_b) {
        if m != n && m != 1 && n != 1 {
            return Err(Error::Network(format!("{:?} does not fit {:?}", a.shape, b.shape)));
        }
        shape.push(if m == 1 { n } else { m });
    }
    let count = size(&shape)?;
    let (step_a, step_b) = (steps(&of_a), steps(&of_b));
    let values = (0..count).map(|i| {
        let (mut rest, mut at_a, mut at_b) = (i, 0, 0);
        for axis in (0..rank).rev() {
            let index = rest % shape[axis];
            rest /= shape[axis];
            at_a += index * step_a[axis];
            at_b += index * step_b[axis];
        }
        value(a.values[at_a], b.values[at_b])
    });
    Ok(Tensor { values: values.collect(), shape })
}

/// Distance of neighbours along each axis, 0 along those that are repeated.
fn steps(shape: &[usize]) -> Vec<usize> {
    let mut steps = vec![0; shape.len()];
    let mut step = 1;
    for (axis, size) in shape.iter().enumerate().rev() {
        steps[axis] = if *size == 1 { 0 } else { step };
        step *= size;
    }
    steps
}

/// Sum or mean along axes; all without any.
pub(super) fn reduce(x: &Tensor, axes: &[i64], keep: bool, mean: bool) -> Result<Tensor, Error> {
    let rank = x.shape.len();
    let mut reduced = vec![axes.is_empty(); rank];
    for axis in axes {
        let index = if *axis < 0 { axis + rank as i64 } else { *axis };
        let slot = usize::try_from(index).ok().and_then(|i| reduced.get_mut(i));
        *slot.ok_or_else(|| Error::Network(format!("axis {axis} of the shape {:?}", x.shape)))? =
            true;
    }
    let kept: Vec<usize> =
        x.shape.iter().zip(&reduced).map(|(n, r)| if *r { 1 } else { *n }).collect();
    let step = steps(&kept);
    let mut sums = vec![0f64; size(&kept)?];
    for (i, value) in x.values.iter().enumerate() {
        let (mut rest, mut at) = (i, 0);
        for axis in (0..rank).rev() {
            at += rest % x.shape[axis] * step[axis];
            rest /= x.shape[axis];
        }
        sums[at] += f64::from(*value);
    }
    let divisor = if mean { (x.values.len() / sums.len().max(1)).max(1) as f64 } else { 1.0 };
    let values = sums.into_iter().map(|sum| (sum / divisor) as f32).collect();
    let shape = if keep {
        kept
    } else {
        let left = x.shape.iter().zip(&reduced).filter(|(_, r)| !**r);
        left.map(|(n, _)| *n).collect()
    };
    Ok(Tensor { shape, values })
}
