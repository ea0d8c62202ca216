use bendtwin_engine::backend::Loss;

use super::*;

fn ensemble(members: u32, statistic: wire::Statistic, share: f64) -> Ensemble {
    Ensemble::read(Some(Wire { members, statistic: statistic.into(), share }), None)
}

/// Costs of two actions of three members, with two terms that add up to them.
fn part() -> RollOutResponse {
    let costs = [3.0, 1.0, 2.0, f64::INFINITY, 0.0, 6.0];
    let terms: Vec<f64> = costs.iter().flat_map(|c| [c - 1.0, 1.0]).collect();
    RollOutResponse {
        first_instance: 6,
        costs: Some(Tensor::pack(&[6], &costs)),
        cost_names: vec!["a".into(), "b".into()],
        cost_terms: Some(Tensor::pack(&[6, 2], &terms)),
        ..RollOutResponse::default()
    }
}

fn folded(ensemble: Ensemble) -> (Vec<f64>, Vec<f64>, RollOutResponse) {
    let mut part = part();
    ensemble.fold(&mut part);
    (f64s(part.costs.as_ref()), f64s(part.cost_terms.as_ref()), part)
}

#[test]
fn statistics_are_those_of_the_members() {
    let (costs, terms, part) = folded(ensemble(3, wire::Statistic::Mean, 0.0));
    assert_eq!(costs, [2.0, f64::INFINITY]);
    assert_eq!(terms[..2], [1.0, 1.0]);
    assert_eq!((part.first_instance, part.member_costs.unwrap().shape), (2, vec![2, 3]));
    let (costs, terms, _) = folded(ensemble(3, wire::Statistic::Worst, 0.0));
    assert_eq!(costs, [3.0, f64::INFINITY]);
    assert_eq!(terms[..2], [2.0, 1.0]);
    // Of three members a share of a half is two, rounded up, and one of a third is one.
    let (costs, ..) = folded(ensemble(3, wire::Statistic::Cvar, 0.5));
    assert_eq!(costs, [2.5, f64::INFINITY]);
    let (costs, ..) = folded(ensemble(3, wire::Statistic::Cvar, 1.0 / 3.0));
    assert_eq!(costs, [3.0, f64::INFINITY]);
}

#[test]
fn without_an_ensemble_nothing_changes() {
    let (mut part, ensemble) = (part(), Ensemble::read(None, None));
    ensemble.fold(&mut part);
    assert_eq!(part, self::part());
    assert_eq!(ensemble.members, 1);
}

#[test]
fn the_gradient_is_that_of_the_members_that_count() {
    let member = |total: f64, x: f32| Gradient {
        loss: Loss { total, ..Loss::default() },
        controls: vec![[x, 0.0, 0.0]],
        poses: vec![[[x; 4]; 3]],
        norms: vec![f64::from(x)],
        ..Gradient::default()
    };
    let members = || vec![member(1.0, 1.0), member(5.0, 2.0), member(3.0, 6.0)];
    let of = |statistic, share| ensemble(3, statistic, share).gradient(members());
    let mean = of(wire::Statistic::Mean, 0.0);
    assert!((mean.controls[0][0] - 3.0).abs() < 1e-6);
    assert_eq!(of(wire::Statistic::Worst, 0.0).controls[0][0], 2.0);
    let tail = of(wire::Statistic::Cvar, 0.6);
    assert_eq!((tail.controls[0][0], tail.poses[0][2][3], tail.norms[0]), (4.0, 4.0, 4.0));
}

#[test]
fn a_mean_motion_has_the_weights_of_the_fits_or_all_alike() {
    let of = |statistic: wire::Statistic, fits| {
        let wire = Wire { members: 2, statistic: statistic.into(), share: 0.0 };
        Ensemble::read(Some(wire), fits).weights
    };
    assert_eq!(of(wire::Statistic::Mean, Some(vec![0.9, 0.1])), None);
    assert_eq!(of(wire::Statistic::MeanPrediction, Some(vec![0.9, 0.1])), Some(vec![0.9, 0.1]));
    assert_eq!(of(wire::Statistic::MeanPrediction, None), Some(vec![1.0; 2]));
}
