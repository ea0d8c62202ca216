//! Gradients of a reply.

use bendtwin_core::Point;
use bendtwin_engine::backend::Gradient;
use bendtwin_proto::v1::{RollOutResponse, Tensor};

use crate::run::plan::Plan;

/// Growth of a gradient on its way back, by frames, beyond which it says little.
const EXPLODED: f64 = 20.0;

/// Gradients of instances in the same order as the recordings. What is empty is zero: nothing depends
/// on it.
#[derive(Default)]
pub(crate) struct Gradients {
    /// Gradients by control positions, shape [F + 1, C, 3] each.
    controls: Vec<Vec<Point>>,
    /// Gradients by initial positions and velocities, shape [N, 3] each.
    positions: Vec<Vec<Point>>,
    velocities: Vec<Vec<Point>>,
    /// Norms by frame, shape [F + 1] each.
    norms: Vec<Vec<f64>>,
    /// Gradients by the actions, one instance after another.
    pub(crate) actions: Vec<f32>,
}

impl Gradients {
    /// Adds those of an instance, all but the one by its action.
    pub(crate) fn push(&mut self, gradient: Gradient) {
        let initial = gradient.initial.unwrap_or_default();
        self.controls.push(gradient.controls);
        self.positions.push(initial.positions);
        self.velocities.push(initial.velocities);
        self.norms.push(gradient.norms);
    }
}

/// Gradients of the instances that recordings are of.
pub(crate) fn add_gradients(plan: &Plan, gradients: &Gradients, part: &mut RollOutResponse) {
    let (returns, graph) = (&plan.returns, &plan.twin().graph);
    let (count, rows) = (gradients.controls.len(), plan.frames + 1);
    let (width, nodes) = (graph.control_count(), plan.nodes());
    if returns.control_gradients {
        let values = padded(&gradients.controls, rows * width, [0.0; 3]);
        part.control_gradients = Some(Tensor::pack_points(&[count, rows, width], &values));
    }
    if returns.action_gradients {
        part.action_gradients = Some(plan.actions.pack_gradients(count, &gradients.actions));
    }
    if returns.initial_gradients {
        let pack = |of: &[Vec<Point>]| {
            let of_twin: Vec<_> = of.iter().map(|own| plan.spread(own)).collect();
            Some(Tensor::pack_points(&[count, nodes], &padded(&of_twin, nodes, [0.0; 3])))
        };
        part.initial_position_gradients = pack(&gradients.positions);
        part.initial_velocity_gradients = pack(&gradients.velocities);
    }
    if returns.gradient_norms {
        let values = padded(&gradients.norms, rows, 0.0);
        part.gradient_norms = Some(Tensor::pack(&[count, rows], &values));
    }
    let every = plan.costs.are_in_every_frame();
    let exploded = gradients.norms.iter().map(|norms| u32::from(has_exploded(norms, every)));
    let exploded: Vec<u32> = exploded.collect();
    part.gradient_exploded = Some(Tensor::pack(&[count], &exploded));
}

/// True if a norm is no number, or more than 20 times what would come together if every frame from
/// there on that a cost counts in added as much as the last one on which the cost depends: all of them
/// if costs count in every frame, else that one.
fn has_exploded(norms: &[f64], every: bool) -> bool {
    let Some(last) = norms.iter().rposition(|norm| *norm != 0.0) else { return false };
    let counted = |frame: usize| if every { (last - frame + 1) as f64 } else { 1.0 };
    let allowed = |frame: usize| EXPLODED * norms[last] * counted(frame);
    norms.iter().enumerate().take(last + 1).any(|(f, norm)| !norm.is_finite() || *norm > allowed(f))
}

/// Rows of equal length, filled up.
fn padded<T: Copy>(rows: &[Vec<T>], len: usize, with: T) -> Vec<T> {
    let mut values = Vec::with_capacity(rows.len() * len);
    for row in rows {
        let end = values.len() + len;
        values.extend(row.iter().take(len));
        values.resize(end, with);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::has_exploded;

    #[test]
    fn a_gradient_that_grows_by_more_than_its_frames_has_exploded() {
        assert!(!has_exploded(&[], true));
        assert!(!has_exploded(&[0.0, 0.0], true));
        // Nothing depends on the frames after the last cost.
        assert!(!has_exploded(&[59.0, 5.0, 1.0, 0.0, 0.0], true));
        assert!(has_exploded(&[61.0, 5.0, 1.0, 0.0], true));
        assert!(has_exploded(&[5.0, 41.0, 1.0, 0.0], true));
        // A cost in each of a thousand frames.
        let every: Vec<f64> = (0..1000).rev().map(|f| 3.0 * f64::from(f + 1)).collect();
        assert!(!has_exploded(&every, true));
        assert!(has_exploded(&[f64::NAN, f64::NAN], true));
        assert!(has_exploded(&[f64::INFINITY, 1.0], true));
    }

    /// A cost of the last frame alone adds nothing on the way back.
    #[test]
    fn a_gradient_of_the_last_frame_is_to_grow_no_more_with_more_frames() {
        assert!(has_exploded(&[42.0, 5.0, 1.0], false));
        assert!(!has_exploded(&[42.0, 5.0, 1.0], true));
        assert!(!has_exploded(&[19.0, 5.0, 1.0], false));
    }
}
