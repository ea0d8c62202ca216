//! Ensembles of the fits of a twin, and the spread of their predictions.

use bendtwin_core::{Point, geometry::point_distance, twin::Member};

use super::*;

pub(super) const FITS: usize = 3;

/// A twin with two members: one softer, one with fewer springs and in weaker gravity.
pub(super) fn twin_with_members() -> Twin {
    let twin = twin();
    let softer = Params { spring_stiffness: vec![300.0; 4], ..twin.params.clone() };
    let soft = Twin { params: softer, ..twin.clone() };
    let cut = |values: &[f32]| values[..3].to_vec();
    let params = Params {
        spring_stiffness: cut(&twin.params.spring_stiffness),
        spring_dashpot: cut(&twin.params.spring_dashpot),
        rest_lengths_m: cut(&twin.params.rest_lengths_m),
        ..twin.params.clone()
    };
    let graph = Graph { springs: twin.graph.springs[..3].to_vec(), ..twin.graph.clone() };
    let environment = Environment { gravity: [0.0, 0.0, -5.0], ..twin.environment };
    let short = Twin { graph, params, environment, ..twin.clone() };
    let members = [&soft, &short].map(|fit| Member::of(fit, &twin).unwrap());
    Twin { members: members.into(), ..twin }
}

/// Two actions, each simulated on `members` fits.
pub(super) fn on_fits(members: u32) -> RollOutRequest {
    RollOutRequest {
        vary: Some(Vary { fits: true, ..Vary::default() }),
        ensemble: Some(Ensemble { members, ..Ensemble::default() }),
        returns: recording(3),
        ..request(2)
    }
}

pub(super) fn with_spread(request: &RollOutRequest, part_frames: u32) -> RollOutRequest {
    let returns = request.returns.clone().unwrap_or_default();
    let returns = Some(Returns { spread: true, part_frames, ..returns });
    RollOutRequest { returns, ..request.clone() }
}

#[test]
fn members_of_an_ensemble_are_simulated_on_the_fits() {
    let twin = twin_with_members();
    let request = on_fits(FITS as u32);
    let all = bench(twin.clone()).run(request.clone(), 0).unwrap().remove(0);
    let plain = RollOutRequest { vary: None, ensemble: None, ..request };
    let members = twin.members.iter().map(|member| member.twin(&twin));
    for (fit, own) in std::iter::once(twin.clone()).chain(members).enumerate() {
        let alone = bench(own).run(plain.clone(), 0).unwrap().remove(0);
        for action in 0..2 {
            let instance = action * FITS + fit;
            assert_eq!(row(&all.positions, instance), row(&alone.positions, action));
            assert_eq!(row(&all.final_positions, instance), row(&alone.final_positions, action));
            assert_eq!(f64s(&all.member_costs)[instance], f64s(&alone.costs)[action]);
        }
    }
}

/// The points of one instance.
pub(super) fn row(tensor: &Option<Tensor>, instance: usize) -> Vec<Point> {
    let rows = tensor.as_ref().unwrap().shape[0] as usize;
    let points = points(tensor);
    let width = points.len() / rows;
    points[instance * width..(instance + 1) * width].to_vec()
}

#[test]
fn a_spread_is_the_distance_of_the_other_fits_from_the_twin() {
    let bench = bench(twin_with_members());
    let request = on_fits(FITS as u32);
    let all = bench.run(request.clone(), 0).unwrap().remove(0);
    let part = bench.run(with_spread(&request, 0), 0).unwrap().remove(0);
    let spread = part.spread.as_ref().unwrap();
    assert_eq!(spread.shape, [2, 2, 4], "actions, recorded frames, nodes");
    let spread = floats(&part.spread);
    for action in 0..2 {
        let [own, soft, short] = [0, 1, 2].map(|fit| row(&all.positions, action * FITS + fit));
        for i in 0..own.len() {
            let square = |other: &[Point]| point_distance(other[i], own[i]).powi(2);
            let expected = ((square(&soft) + square(&short)) / 2.0).sqrt();
            let found = f64::from(spread[action * own.len() + i]);
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        // What comes beside it is of the twin itself.
        assert_eq!(row(&part.positions, action), own);
        let end = row(&all.final_positions, action * FITS);
        assert_eq!(row(&part.final_positions, action), end);
    }
    assert!(spread.iter().any(|s| *s > 1e-4), "{spread:?}");
    let instances = part.instances.unwrap().unpack::<u32>("instances").unwrap().1;
    assert_eq!(instances, [0, 3]);
    let controls = part.forces.unwrap().controls.unwrap();
    assert_eq!(controls.shape[0], 2);
    assert_eq!(part.costs, all.costs);
}

#[test]
fn a_spread_comes_in_time_too() {
    let bench = bench(twin_with_members());
    let request = with_spread(&on_fits(FITS as u32), 0);
    let whole = bench.run(request.clone(), 0).unwrap().remove(0);
    let parts = bench.run(with_spread(&request, 3), 16).unwrap();
    assert_eq!(parts.len(), 2);
    for (frame, part) in parts.iter().enumerate() {
        let (of_part, of_whole) = (floats(&part.spread), floats(&whole.spread));
        for action in 0..2 {
            let from = (action * 2 + frame) * 4;
            assert_eq!(of_part[action * 4..action * 4 + 4], of_whole[from..from + 4]);
        }
    }
}

#[test]
fn the_best_come_with_their_spread() {
    let bench = bench(twin_with_members());
    let mut request = with_spread(&on_fits(FITS as u32), 0);
    let all = bench.run(request.clone(), 0).unwrap().remove(0);
    request.returns.iter_mut().for_each(|returns| returns.best = 1);
    let best = bench.run(request, 0).unwrap().remove(0);
    let costs = f64s(&all.costs);
    let lowest = usize::from(costs[1] < costs[0]);
    let all = floats(&all.spread);
    let half = all.len() / 2;
    assert_eq!(floats(&best.spread), all[lowest * half..(lowest + 1) * half]);
}

#[test]
fn fits_that_are_not_there_are_refused() {
    let refusal = |twin: Twin, members: u32| {
        let error = bench(twin).run(on_fits(members), 0).unwrap_err();
        assert_eq!(error.category(), Category::InvalidArgument);
        error.to_string()
    };
    assert!(refusal(twin(), 2).contains("search.starts"));
    assert!(refusal(twin_with_members(), 4).contains("at most 3 members"));
}

#[test]
fn a_member_that_diverged_leaves_no_spread() {
    let mut twin = twin_with_members();
    twin.members[0].params.spring_stiffness = vec![1e9; 4];
    twin.members[0].substeps = 1;
    let mut request = with_spread(&on_fits(2), 0);
    request.returns.iter_mut().for_each(|returns| returns.final_state = false);
    let error = bench(twin).run(request, 0).unwrap_err();
    assert!(error.to_string().contains("substeps"), "{error}");
}
