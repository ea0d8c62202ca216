use std::{convert::Infallible, time::Duration};

use super::*;
use crate::{Bounds, Curve, Limit, Method, Origin};

const GOAL: [f64; 2] = [0.3, -0.2];

/// Squared distance of all knots but the first from a goal; infinite beyond `wall` in x, and not to be
/// beyond `limit` there.
struct Bowl {
    wall: f64,
    limit: f64,
    seen: Vec<Knots>,
}

impl Bowl {
    fn new() -> Self {
        Self { wall: f64::INFINITY, limit: f64::INFINITY, seen: Vec::new() }
    }

    fn cost(&self, plan: &[f64]) -> f64 {
        if plan.iter().step_by(2).any(|x| *x > self.wall) {
            return f64::INFINITY;
        }
        (2..plan.len()).map(|i| (plan[i] - GOAL[i % 2]).powi(2)).sum()
    }

    /// Excess of a plan over the limit.
    fn excess(&self, plan: &[f64]) -> f64 {
        plan.iter().step_by(2).map(|x| (x - self.limit).max(0.0)).fold(0.0, f64::max)
    }

    fn gradient(plan: &[f64]) -> Knots {
        let slope = |i: usize| if i < 2 { 0.0 } else { 2.0 * (plan[i] - GOAL[i % 2]) };
        (0..plan.len()).map(slope).collect()
    }
}

impl Evaluate for Bowl {
    type Error = Infallible;
    fn evaluate(&mut self, plans: &[Knots]) -> Result<Evaluation, Infallible> {
        self.seen.extend_from_slice(plans);
        Ok(Evaluation {
            costs: plans.iter().map(|p| self.cost(p)).collect(),
            gradients: plans.iter().map(|p| Self::gradient(p)).collect(),
            excess: plans.iter().map(|p| self.excess(p)).collect(),
        })
    }
}

fn methods() -> [Method; 4] {
    let gradient = Method::Gradient { rate: vec![0.05] };
    [Method::MPPI, Method::CEM, Method::PredictiveSampling, gradient]
}

fn settings(method: Method) -> Settings {
    Settings {
        knots: 4,
        frame_s: 0.1,
        sigma: vec![0.1],
        iterations: 40,
        ..Settings::new(method, 2, 12)
    }
}

#[test]
fn every_method_walks_downhill_and_knows_the_cost_of_what_it_returns() {
    for method in methods() {
        let mut bowl = Bowl::new();
        let plan = Planner::new(settings(method.clone())).unwrap().plan(&mut bowl).unwrap();
        assert!((plan.nominal_cost - 3.0 * 0.13).abs() < 1e-12);
        assert!(plan.cost < 0.05 * plan.nominal_cost, "{method:?}: {}", plan.cost);
        assert_eq!(plan.cost, bowl.cost(&plan.knots));
        assert_eq!(plan.knots[..2], [0.0, 0.0]);
        assert_eq!((plan.iterations, plan.stopped_by_deadline), (40, false));
        assert!(plan.costs.iter().all(|batch| batch.len() <= 64));
        let lowest = plan.costs.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(plan.cost, lowest);
    }
}

#[test]
fn a_plan_is_never_worse_than_the_nominal_one() {
    for method in methods() {
        for seed in 0..10 {
            let settings = Settings {
                samples: 4,
                iterations: 2,
                sigma: vec![0.5],
                seed,
                ..settings(method.clone())
            };
            let mut planner = Planner::new(settings).unwrap();
            planner.set_nominal(GOAL.repeat(4)).unwrap();
            let plan = planner.plan(&mut Bowl::new()).unwrap();
            assert_eq!((plan.cost, plan.origin), (0.0, Origin::Nominal));
        }
    }
}

#[test]
fn a_mean_that_is_worse_than_its_samples_is_not_taken() {
    /// Good on a circle, bad in the middle: where the mean of good samples lies.
    struct Ring;
    impl Evaluate for Ring {
        type Error = Infallible;
        fn evaluate(&mut self, plans: &[Knots]) -> Result<Evaluation, Infallible> {
            let cost = |p: &Knots| (p[2].hypot(p[3]) - 0.3).powi(2);
            Ok(Evaluation { costs: plans.iter().map(cost).collect(), ..Evaluation::default() })
        }
    }
    let settings = Settings {
        knots: 2,
        samples: 256,
        iterations: 1,
        sigma: vec![0.3],
        ..settings(Method::Mppi { temperature: 10.0 })
    };
    let plan = Planner::new(settings).unwrap().plan(&mut Ring).unwrap();
    let mean = plan.costs.last().unwrap();
    assert_eq!(mean.len(), 1);
    assert!(plan.cost < mean[0] && plan.origin == Origin::Sample);
    assert_eq!(plan.best_sample, Some((plan.knots, plan.cost)));
}

#[test]
fn to_stay_still_competes_with_a_plan_that_leads_astray() {
    for method in &methods()[..3] {
        let settings = Settings { iterations: 1, sigma: vec![1e-6], ..settings(method.clone()) };
        let mut planner = Planner::new(settings).unwrap();
        planner.set_nominal([GOAL, [0.5, 0.0], [0.7, 0.2], [0.9, 0.4]].concat()).unwrap();
        let plan = planner.plan(&mut Bowl::new()).unwrap();
        assert_eq!((plan.knots, plan.cost), (GOAL.repeat(4), 0.0));
    }
}

#[test]
fn samples_are_coarse_and_fine() {
    let settings = Settings {
        knots: 64,
        samples: 34,
        iterations: 1,
        sigma: vec![0.5],
        finest: 0.01,
        ..settings(Method::MPPI)
    };
    let mut bowl = Bowl::new();
    Planner::new(settings).unwrap().plan(&mut bowl).unwrap();
    for (i, plan) in bowl.seen[2..34].iter().enumerate() {
        let spread = (plan.iter().map(|x| x * x).sum::<f64>() / 126.0).sqrt();
        let expected = 0.5 * 0.01_f64.powf(i as f64 / 31.0);
        assert!((spread / expected - 1.0).abs() < 0.3, "{i}: {spread} for {expected}");
    }
}

#[test]
fn all_that_is_simulated_keeps_the_bounds() {
    for method in methods() {
        let mut bowl = Bowl::new();
        let bounds = Bounds {
            low: Limit::Each(vec![-0.1, -0.15]),
            high: Limit::All(0.25),
            speed: Limit::Each(vec![0.2, 10.0]),
        };
        let settings = Settings { bounds, correlation: 0.5, ..settings(method) };
        let plan = Planner::new(settings).unwrap().plan(&mut bowl).unwrap();
        for knots in &bowl.seen {
            assert!(knots.chunks(2).all(|k| k[0] >= -0.1 && k[1] >= -0.15 && k[0] <= 0.25));
            // Knots are 4 frames of 0.1 s apart.
            let steps = knots.chunks(2).zip(knots.chunks(2).skip(1));
            assert!(steps.into_iter().all(|(a, b)| (b[0] - a[0]).abs() <= 0.08 + 1e-12));
        }
        for (k, x) in plan.knots.chunks(2).map(|k| k[0]).enumerate() {
            assert!((x - 0.08 * k as f64).abs() < 0.03, "{:?}", plan.knots);
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_plans() {
    for method in methods() {
        let plans = |seed| {
            let settings = Settings { iterations: 3, samples: 8, seed, ..settings(method.clone()) };
            let mut planner = Planner::new(settings).unwrap();
            let first = planner.plan(&mut Bowl::new()).unwrap().knots;
            planner.shift(3.0);
            [first, planner.plan(&mut Bowl::new()).unwrap().knots]
        };
        assert_eq!(plans(3), plans(3));
        assert_ne!(plans(3), plans(4));
    }
}

#[test]
fn the_next_plan_begins_with_the_shifted_one() {
    let mut planner = Planner::new(settings(Method::PredictiveSampling)).unwrap();
    let first = planner.plan(&mut Bowl::new()).unwrap().knots;
    planner.shift(6.0);
    let expected = Curve::Linear.shifted(&first, 2, 1.5, &[0.0, 1.0, 2.0, 3.0]);
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
    assert!(planner.nominal().iter().zip(&expected).all(near));
    let again = planner.plan(&mut Bowl::new()).unwrap().knots;
    assert!(again[..2].iter().zip(&expected).all(near));
}

#[test]
fn at_the_deadline_there_is_the_best_so_far() {
    for method in methods() {
        let deadline = Some(Duration::from_millis(4500));
        let mut planner = Planner::new(Settings { deadline, ..settings(method) }).unwrap();
        let (mut search, mut now, mut bowl) = (planner.search(), Duration::ZERO, Bowl::new());
        while let Some(plans) = search.propose(now) {
            let evaluation = bowl.evaluate(plans).unwrap();
            now += Duration::from_secs(1);
            search.learn::<Infallible>(evaluation, now).unwrap();
        }
        let plan = search.finish(now).unwrap();
        assert_eq!((plan.iterations, plan.stopped_by_deadline), (4, true));
        assert!(plan.cost < plan.nominal_cost && plan.time == Duration::from_secs(4));
    }
}

#[test]
fn diverged_plans_count_for_nothing() {
    for method in methods() {
        let mut bowl = Bowl { wall: 0.2, ..Bowl::new() };
        let plan = Planner::new(settings(method)).unwrap().plan(&mut bowl).unwrap();
        assert!(plan.cost.is_finite() && plan.knots.iter().step_by(2).all(|x| *x <= 0.2));
        assert!(plan.costs.iter().flatten().any(|c| c.is_infinite()));
        let mut nowhere = Bowl { wall: -1.0, ..Bowl::new() };
        let none = Planner::new(settings(Method::MPPI)).unwrap().plan(&mut nowhere);
        assert!(matches!(none, Err(Error::EveryPlanDiverged)));
    }
}

/// The goal is at 0.3 in x: without the limit every method ends there.
#[test]
fn what_is_beyond_the_limit_is_worse_than_all_that_keeps_it() {
    for method in methods() {
        let mut bowl = Bowl { limit: 0.2, ..Bowl::new() };
        let plan = Planner::new(settings(method.clone())).unwrap().plan(&mut bowl).unwrap();
        assert_eq!((plan.excess, bowl.excess(&plan.knots)), (0.0, 0.0), "{method:?}");
        assert!(plan.cost < 0.2 * plan.nominal_cost, "{method:?}: {}", plan.cost);
        let lowest = plan.costs.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        assert!(lowest < plan.cost, "{method:?}: none was beyond, so this shows nothing");
    }
}

#[test]
fn a_search_that_begins_beyond_the_limit_comes_back() {
    let beyond = [[0.0, 0.0], [0.6, -0.2], [0.7, -0.2], [0.6, -0.2]].concat();
    for method in methods() {
        let mut bowl = Bowl { limit: 0.2, ..Bowl::new() };
        let settings = Settings { samples: 8, ..settings(method.clone()) };
        let mut planner = Planner::new(settings).unwrap();
        planner.set_nominal(beyond.clone()).unwrap();
        let mut search = planner.search();
        while let Some(plans) = search.propose(Duration::ZERO) {
            let evaluation = bowl.evaluate(plans).unwrap();
            search.learn::<Infallible>(evaluation, Duration::ZERO).unwrap();
        }
        let progress = search.progress().unwrap();
        assert!(progress.beyond_limit > 0 && progress.diverged == 0, "{method:?}");
        let plan = search.finish(Duration::ZERO).unwrap();
        assert_eq!(plan.excess, 0.0, "{method:?}");
        assert!(plan.cost < 0.2, "{method:?}: {}", plan.cost);
    }
    // If no plan keeps it, the best is the one with the least excess.
    let mut bowl = Bowl { limit: -1.0, ..Bowl::new() };
    let plan = Planner::new(settings(Method::MPPI)).unwrap().plan(&mut bowl).unwrap();
    let least = bowl.seen.iter().map(|p| bowl.excess(p)).fold(f64::INFINITY, f64::min);
    assert_eq!(plan.excess, least);
}

#[test]
fn answers_of_another_shape_are_refused() {
    let mut planner = Planner::new(settings(Method::Gradient { rate: vec![0.1] })).unwrap();
    let mut search = planner.search();
    assert_eq!(search.propose(Duration::ZERO).map(<[_]>::len), Some(64));
    let gradients = vec![vec![0.0; 3]; 64];
    let wrong = Evaluation { costs: vec![1.0; 64], gradients, ..Evaluation::default() };
    let refused = search.learn::<Infallible>(wrong, Duration::ZERO);
    assert!(matches!(refused, Err(Error::Shape { plans: 64, costs: 64, gradients: 0 })));
    assert!(search.finish(Duration::ZERO).is_none());
}

#[test]
fn wrong_settings_are_refused() {
    let good = || settings(Method::MPPI);
    let wrong = [
        Settings { knots: 1, ..good() },
        Settings { finest: 0.0, ..good() },
        Settings { dims: 0, ..good() },
        Settings { samples: 0, ..good() },
        Settings { sigma: vec![0.1; 3], ..good() },
        Settings { sigma: vec![-0.1], ..good() },
        Settings { correlation: 1.0, ..good() },
        Settings { frame_s: f64::NAN, ..good() },
        Settings { knot_times: vec![0.0, 1.0, 1.0, 2.0], ..good() },
        Settings { method: Method::Mppi { temperature: 0.0 }, ..good() },
        Settings { method: Method::Gradient { rate: Vec::new() }, ..good() },
        Settings { method: Method::Cem { elites: 0, memory: 0.0, smallest: 0.0 }, ..good() },
    ];
    for settings in wrong {
        assert!(Planner::new(settings.clone()).is_err(), "{settings:?}");
    }
    let mut planner = Planner::new(good()).unwrap();
    assert!(planner.set_nominal(vec![0.0; 3]).is_err());
    assert!(planner.set_nominal(vec![f64::NAN; 8]).is_err());
}
