//! Forces of a reply, in newtons.

use bendtwin_core::Point;
use bendtwin_engine::backend::{Forces, Rollout};
use bendtwin_proto::v1::{Tensor, roll_out_response};

use super::Span;
use crate::run::plan::Plan;

/// Forces of instances over the frames of a span; NaN where an instance has none, as after it diverged.
pub(super) fn pack(
    plan: &Plan,
    span: Span,
    instances: &[usize],
    rollouts: &[Rollout],
) -> roll_out_response::Forces {
    let controls = plan.twin().graph.control_count();
    let colliders = instances.first().map_or(0, |i| plan.variant(*i).world.colliders.len());
    let (count, frames) = (instances.len(), span.frames());
    let nothing = Forces::default();
    let points = |width: usize, of: fn(&Forces) -> &[Point]| {
        rows(
            plan,
            instances,
            rollouts,
            |r| of(r.forces.as_ref().unwrap_or(&nothing)),
            frames * width,
        )
    };
    let wrenches = |width: usize, of: fn(&Forces) -> &[[f32; 6]]| {
        rows(
            plan,
            instances,
            rollouts,
            |r| of(r.forces.as_ref().unwrap_or(&nothing)),
            frames * width,
        )
    };
    let tensor = |shape: &[usize], values: &[f32]| Some(Tensor::pack(shape, values));
    roll_out_response::Forces {
        controls: tensor(
            &[count, frames, controls, 3],
            points(controls, |f| &f.controls).as_flattened(),
        ),
        grasps: tensor(
            &[count, frames, plan.grasps, 6],
            wrenches(plan.grasps, |f| &f.grasps).as_flattened(),
        ),
        ground: tensor(&[count, frames, 3], points(1, |f| &f.ground).as_flattened()),
        colliders: tensor(
            &[count, frames, colliders, 6],
            wrenches(colliders, |f| &f.colliders).as_flattened(),
        ),
    }
}

/// Rows of all instances, `each` of one, scaled to newtons.
fn rows<'r, const N: usize>(
    plan: &Plan,
    instances: &[usize],
    rollouts: &'r [Rollout],
    of: impl Fn(&'r Rollout) -> &'r [[f32; N]],
    each: usize,
) -> Vec<[f32; N]> {
    let mut out = Vec::with_capacity(instances.len() * each);
    for (instance, rollout) in instances.iter().zip(rollouts) {
        let unit = plan.force_unit(*instance);
        let end = out.len() + each;
        out.extend(of(rollout).iter().take(each).map(|row| row.map(|x| unit * x)));
        out.resize(end, [f32::NAN; N]);
    }
    out
}
