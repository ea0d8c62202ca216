//! Terms at the skin, of up to more points than a block has threads and more targets than it scores.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Point};
use bendtwin_engine::{
    Model, Objective, PointLoss, PointSet, Term, backend::GradientRequest, objective::WeightedTerm,
};

use bendtwin_engine_kit::task_terms;

use super::{both, models, relative_within, seed};

/// Aside by so little that the nearest point is hardly ever another at the next rounding [m].
const ASIDE_M: f32 = 0.002;

/// A Chamfer distance, a track, an order, a winding and a coverage of the whole skin; the loss of the
/// track is another each frame.
pub(super) fn terms(model: &Model, frame: usize) -> [Term; 5] {
    let rest = model.skin.positions(&model.graph.rest_positions);
    let targets: Vec<Point> = rest.iter().map(|p| p.map(|x| x + ASIDE_M)).collect();
    let points: Vec<u32> = (0..targets.len() as u32).rev().collect();
    let loss = match frame % 3 {
        0 => PointLoss::Distance,
        1 => PointLoss::SmoothL1 { beta_m: 0.01 },
        _ => PointLoss::SquaredDistance,
    };
    let of = PointSet::Skin;
    let [order, winding, coverage] = task_terms(model, of, &points);
    let track = Term::Track { of, points, targets: targets.iter().rev().copied().collect(), loss };
    [Term::Chamfer { of, targets }, track, order, winding, coverage]
}

fn at_start(terms: [Term; 5]) -> Objective {
    let each = (0..).zip(terms);
    let terms = each.map(|(group, term)| WeightedTerm { frame: 0, weight: 1.0, group, term });
    let groups = ["chamfer", "track", "order", "winding", "coverage"].map(str::to_owned).to_vec();
    Objective { groups, terms: Arc::new(terms.collect()) }
}

/// Without the physics, at the frame that a rollout begins with: values to 1e-5, gradients to 1e-4 of
/// their norm.
#[test]
#[ignore = "needs a CUDA device"]
fn terms_at_the_skin_agree() {
    let request = GradientRequest { initial: true, ..GradientRequest::PARAMS };
    for (name, model) in models() {
        for loss_of in 0..3 {
            let [expected, found] = both(&model, seed(), 0).map(|(b, mut i)| {
                i.objective = at_start(terms(&model, loss_of));
                b.gradients(&[i], &request, &CancelToken::default()).expect("valid").remove(0)
            });
            for (a, b) in expected.loss.groups.iter().zip(&found.loss.groups) {
                assert!((a - b).abs() <= 1e-5 * a, "{name}, loss {loss_of}: {a} and {b}");
            }
            let [a, b] = [expected, found].map(|g| {
                let start = g.initial.expect("it was asked for").positions;
                start.as_flattened().to_vec()
            });
            let apart = relative_within(1e-4, &name, "initial positions", &a, &b);
            println!("{name}, loss {loss_of}: {apart:.2e}");
        }
    }
}
