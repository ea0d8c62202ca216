//! Arrays of ensembles by action: the spread, which is how far the predictions of the members are apart,
//! and what comes beside it.

use bendtwin_core::{Point, twin::spread};
use bendtwin_engine::backend::Rollout;
use bendtwin_proto::v1::Tensor;

use super::{Arrays, Span, extend_padded};
use crate::{request::initial::Starts, run::plan::Plan};

/// Arrays of one instance of each action, its first member.
pub(super) struct FirstMembers {
    indices: Vec<usize>,
    rollouts: Vec<Rollout>,
    ends: Vec<Point>,
    paths: Vec<Point>,
}

impl FirstMembers {
    pub(super) fn arrays<'a>(&'a self, starts: &'a Starts) -> Arrays<'a> {
        let Self { indices, rollouts, ends, paths } = self;
        Arrays { indices, rollouts, means: &[], starts, ends, paths }
    }
}

/// The first of every `members` instances, which follow one another, with their mean motions if there
/// are any.
pub(super) fn first_members(of: &Arrays<'_>, members: usize) -> FirstMembers {
    let rows = |points: &[Point]| -> Vec<Point> {
        let width = points.len() / of.indices.len().max(1);
        points.chunks(width.max(1)).step_by(members).flatten().copied().collect()
    };
    FirstMembers {
        indices: of.indices.iter().step_by(members).copied().collect(),
        rollouts: match of.means {
            [] => of.rollouts.iter().step_by(members).cloned().collect(),
            means => means.to_vec(),
        },
        ends: rows(of.ends),
        paths: rows(of.paths),
    }
}

/// FLOAT32 [actions, recorded frames, points]: the spread of the recorded points of each action [m].
pub(super) fn pack(plan: &Plan, span: Span, rollouts: &[Rollout]) -> Tensor {
    let twin = plan.twin();
    let rows = plan.returns.recorded_frames(span.frames());
    let width = plan.returns.recorded.count(&twin.skin, twin.graph.node_count());
    let members = plan.ensemble.members;
    let mut values = Vec::with_capacity(rollouts.len() / members * rows * width);
    for action in rollouts.chunks_exact(members) {
        // What a member that diverged did not reach is NaN, and so is the spread there.
        let recorded: Vec<Vec<Point>> = action
            .iter()
            .map(|rollout| {
                let mut all = Vec::new();
                extend_padded(&mut all, &rollout.positions, rows * width);
                all
            })
            .collect();
        let others: Vec<&[Point]> = recorded[1..].iter().map(Vec::as_slice).collect();
        values.extend(spread(&recorded[0], &others));
    }
    Tensor::pack(&[rollouts.len() / members, rows, width], &values)
}
