use std::convert::Infallible;

use super::*;
use crate::{Evaluate, Origin};

/// A cost that is a function.
struct Cost<F>(F);

impl<F: FnMut(&[Knots]) -> Evaluation> Evaluate for Cost<F> {
    type Error = Infallible;
    fn evaluate(&mut self, plans: &[Knots]) -> Result<Evaluation, Infallible> {
        Ok(self.0(plans))
    }
}

/// Places on a line, each with its own bowl: the lowest cost at place `p` is `floor[p]`, at a goal that lies
/// farther away from better places, so that the costs of nominal plans mislead.
struct Bowls {
    floors: Vec<f64>,
    goals: Vec<[f64; 2]>,
    /// x of a plan beyond which it is beyond the limit, by place.
    limits: Vec<f64>,
    /// Places whose plans diverge.
    lost: Vec<usize>,
}

impl Bowls {
    fn new(floors: &[f64]) -> Self {
        let goals = floors.iter().map(|floor| [0.3 - 0.4 * floor, -0.2]).collect();
        let limits = vec![f64::INFINITY; floors.len()];
        Self { floors: floors.to_vec(), goals, limits, lost: Vec::new() }
    }

    fn cost(&self, place: usize, plan: &[f64]) -> f64 {
        if self.lost.contains(&place) {
            return f64::INFINITY;
        }
        let squares = (2..plan.len()).map(|i| (plan[i] - self.goals[place][i % 2]).powi(2));
        self.floors[place] + squares.sum::<f64>()
    }

    fn excess(&self, place: usize, plan: &[f64]) -> f64 {
        let beyond = plan.iter().step_by(2).map(|x| (x - self.limits[place]).max(0.0));
        beyond.fold(0.0, f64::max)
    }

    fn evaluate<'k>(&self, batch: impl Iterator<Item = (usize, &'k Knots)>) -> Evaluation {
        let mut all = Evaluation::default();
        for (place, plan) in batch {
            all.costs.push(self.cost(place, plan));
            all.excess.push(self.excess(place, plan));
            let slope =
                |i: usize| if i < 2 { 0.0 } else { 2.0 * (plan[i] - self.goals[place][i % 2]) };
            all.gradients.push((0..plan.len()).map(slope).collect());
        }
        all
    }

    /// Searches to the end; sizes of the batches, places of each, and the search.
    fn search(&self, settings: Settings) -> (PlaceSearch, Vec<Vec<usize>>) {
        let nominal = vec![0.0; settings.knots * settings.dims];
        let mut search = PlaceSearch::new(settings, vec![nominal; self.floors.len()]).unwrap();
        let mut batches = Vec::new();
        while search.propose(Duration::ZERO) {
            batches.push(search.batch().map(|(place, _)| place).collect());
            let evaluation = self.evaluate(search.batch());
            search.learn::<Infallible>(evaluation, Duration::ZERO).unwrap();
        }
        (search, batches)
    }
}

fn settings(method: Method) -> Settings {
    Settings {
        knots: 3,
        frame_s: 0.1,
        sigma: vec![0.1],
        samples: 32,
        iterations: 16,
        ..Settings::new(method, 2, 12)
    }
}

fn methods() -> [Method; 4] {
    let gradient = Method::Gradient { rate: vec![0.05] };
    [Method::MPPI, Method::CEM, Method::PredictiveSampling, gradient]
}

const FLOORS: [f64; 8] = [0.5, 0.3, 0.6, 0.2, 0.0, 0.4, 0.7, 0.1];

#[test]
fn rounds_are_the_halvings_and_one_more() {
    let expected = [(1, 1), (2, 2), (3, 3), (4, 3), (5, 4), (8, 4), (9, 5), (256, 9)];
    for (places, count) in expected {
        assert_eq!(rounds(places), count, "{places}");
        // The search halves in this way.
        let halvings = std::iter::successors(Some(places), |n| (*n > 1).then(|| n.div_ceil(2)));
        assert_eq!(halvings.count(), count, "{places}");
    }
}

#[test]
fn the_best_place_is_found_and_its_plan_has_the_simulated_cost() {
    for method in methods() {
        let bowls = Bowls::new(&FLOORS);
        let (search, _) = bowls.search(settings(method.clone()));
        let (place, best) = search.progress().unwrap();
        assert_eq!(place, 4, "{method:?}: {:?}", search.costs());
        assert_eq!(best.cost, bowls.cost(place, best.knots));
        assert!(best.cost < 0.5 * best.nominal_cost, "{method:?}: {}", best.cost);
        assert_eq!((best.iterations, best.diverged), (16, 0));
        let lowest = search.costs().into_iter().fold(f64::INFINITY, f64::min);
        assert_eq!(best.cost, lowest);
        assert_ne!(best.origin, Origin::Nominal);
    }
}

#[test]
fn the_worse_half_is_given_up_after_each_round() {
    let (search, batches) = Bowls::new(&FLOORS[..5]).search(settings(Method::PredictiveSampling));
    // 16 iterations are four for each of the rounds with 5, 3, 2 and 1 places.
    let places: Vec<usize> = batches
        .iter()
        .map(|batch| {
            let mut places = batch.clone();
            places.dedup();
            places.len()
        })
        .collect();
    assert_eq!(places, [[5; 4], [3; 4], [2; 4], [1; 4]].concat());
    // All share the samples; from the second iteration on this method simulates no mean.
    let first: Vec<usize> =
        (0..5).map(|p| batches[0].iter().filter(|of| **of == p).count()).collect();
    assert_eq!(first, [7, 7, 6, 6, 6]);
    assert!(batches.iter().all(|batch| batch.len() <= 32 && batch.len() + 5 >= 32));
    assert_eq!(search.progress().unwrap().1.simulated, batches.concat().len());
}

#[test]
fn a_single_place_is_searched_as_a_search_alone_does() {
    for method in methods() {
        let bowls = Bowls::new(&[0.25]);
        let settings = Settings { seed: 7, ..settings(method.clone()) };
        let (search, _) = bowls.search(settings.clone());
        let mut alone = Cost(|plans: &[Knots]| bowls.evaluate(plans.iter().map(|p| (0, p))));
        let plan = Planner::new(settings).unwrap().plan(&mut alone).unwrap();
        let (_, best) = search.progress().unwrap();
        assert_eq!((best.knots, best.cost, best.origin), (&plan.knots, plan.cost, plan.origin));
        assert_eq!(best.simulated, plan.costs.concat().len(), "{method:?}");
    }
}

#[test]
fn the_same_seed_gives_the_same_plan() {
    for method in methods() {
        let with = |seed| {
            let settings = Settings { seed, ..settings(method.clone()) };
            let (search, _) = Bowls::new(&FLOORS).search(settings);
            (search.progress().unwrap().1.knots.clone(), search.costs())
        };
        assert_eq!(with(3), with(3));
        if method != (Method::Gradient { rate: vec![0.05] }) {
            assert_ne!(with(3), with(4));
        }
    }
}

/// The places of lowest cost are beyond the limit wherever they are good.
#[test]
fn places_within_the_limit_win_over_cheaper_ones_beyond_it() {
    for method in methods() {
        let mut bowls = Bowls::new(&FLOORS);
        bowls.limits[4] = -0.5;
        bowls.limits[7] = -0.5;
        let (search, _) = bowls.search(settings(method.clone()));
        let (place, best) = search.progress().unwrap();
        assert_eq!((place, bowls.excess(place, best.knots)), (3, 0.0), "{method:?}");
        // Where none is within, the least beyond is best.
        bowls.limits = (0..8).map(|p| -0.5 - 0.1 * f64::from(p != 2)).collect();
        let (search, _) = bowls.search(settings(method.clone()));
        assert_eq!(search.progress().unwrap().0, 2, "{method:?}");
    }
}

#[test]
fn lost_places_are_given_up_and_all_of_them_are_an_error() {
    for method in methods() {
        let mut bowls = Bowls::new(&FLOORS);
        bowls.lost = vec![4, 0, 1, 2, 3];
        let (search, batches) = bowls.search(settings(method.clone()));
        let (place, best) = search.progress().unwrap();
        assert_eq!((place, search.costs()[4]), (7, f64::INFINITY), "{method:?}");
        assert!(best.diverged > 0 && best.iterations == 16);
        assert!(batches[1].iter().all(|place| *place > 4));
        bowls.lost = (0..8).collect();
        let mut search = PlaceSearch::new(settings(method), vec![vec![0.0; 6]; 8]).unwrap();
        assert!(search.propose(Duration::ZERO));
        let evaluation = bowls.evaluate(search.batch());
        let error = search.learn::<Infallible>(evaluation, Duration::ZERO).unwrap_err();
        assert!(matches!(error, Error::EveryPlanDiverged));
        assert!(search.progress().is_none_or(|(_, best)| best.cost.is_infinite()));
    }
}

#[test]
fn a_deadline_ends_the_search_after_the_first_iteration() {
    let settings =
        Settings { deadline: Some(Duration::from_secs(3)), ..settings(Method::PredictiveSampling) };
    let bowls = Bowls::new(&FLOORS);
    let mut search = PlaceSearch::new(settings, vec![vec![0.0; 6]; 8]).unwrap();
    assert!(search.propose(Duration::ZERO));
    let evaluation = bowls.evaluate(search.batch());
    search.learn::<Infallible>(evaluation, Duration::from_secs(9)).unwrap();
    assert!(!search.propose(Duration::from_secs(9)));
    let (_, best) = search.progress().unwrap();
    assert_eq!((best.iterations, best.simulated), (1, 32));
}

#[test]
fn too_few_samples_or_iterations_and_wrong_plans_are_refused() {
    let new = |samples, iterations, nominals: Vec<Knots>| {
        let settings = Settings { samples, iterations, ..settings(Method::MPPI) };
        PlaceSearch::new(settings, nominals).map(drop).map_err(|e| e.field)
    };
    let plans = |count: usize| vec![vec![0.0; 6]; count];
    assert_eq!(new(24, 4, plans(8)), Ok(()));
    assert_eq!(new(23, 4, plans(8)), Err("samples"));
    assert_eq!(new(24, 3, plans(8)), Err("iterations"));
    assert_eq!(new(1, 1, plans(1)), Ok(()));
    assert_eq!(new(24, 4, Vec::new()), Err("places"));
    assert_eq!(new(24, 4, vec![vec![0.0; 6], vec![0.0; 5]]), Err("nominal"));
    let mut search = PlaceSearch::new(settings(Method::MPPI), plans(2)).unwrap();
    assert!(search.propose(Duration::ZERO));
    for costs in [31, 33] {
        let evaluation = Evaluation { costs: vec![0.0; costs], ..Evaluation::default() };
        let error = search.learn::<Infallible>(evaluation, Duration::ZERO).unwrap_err();
        assert!(matches!(error, Error::Shape { plans: 32, .. }), "{error}");
    }
}

/// Halving beats the same number of plans spread evenly over the places, each searched alone.
#[test]
fn halving_is_better_than_every_place_alone_with_the_same_budget() {
    for method in [Method::MPPI, Method::CEM, Method::PredictiveSampling] {
        let (mut halved, mut alone) = (0.0, 0.0);
        for seed in 0..20 {
            let bowls = Bowls::new(&FLOORS);
            let all = Settings { seed, ..settings(method.clone()) };
            halved += bowls.search(all.clone()).0.progress().unwrap().1.cost;
            let each = Settings { samples: all.samples / 8, ..all };
            let own = (0..8).map(|place| {
                let mut of =
                    Cost(|plans: &[Knots]| bowls.evaluate(plans.iter().map(|p| (place, p))));
                Planner::new(each.clone()).unwrap().plan(&mut of).unwrap().cost
            });
            alone += own.fold(f64::INFINITY, f64::min);
        }
        assert!(halved < 0.9 * alone, "{method:?}: {halved} {alone}");
    }
}
