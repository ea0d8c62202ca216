//! Descents: the same run as by `gradients`, a parameterization and Adam by hand, however it is cut
//! into calls, left and taken up again.

mod pair;

use self::pair::{Pair, REQUEST, by_hand, distance};
use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend, Error, PointLoss, PointSet, Term,
    backend::GradientRequest,
    objective::WeightedTerm,
    optimizer::{
        Adam, GradientNorm, GradientSample, OptimizerInit, Parameter, Parameterization, Position,
        Scale,
    },
};

use crate::{
    expect::{Outcome, close, ensure},
    scene::Scene,
};

/// Losses, lengths and final states are those of `gradients` through the chain rule: to 1e-5, which
/// leaves room for a sum in f32 and another order.
pub(crate) fn optimizer_measures_gradients(backend: &dyn Backend) -> Outcome {
    let pair = Pair::new(backend)?;
    let mut optimizer = pair.optimizer(backend)?;
    let samples = pair.samples();
    let norms = measure(&mut *optimizer, &samples)?;
    ensure(norms.len() == samples.len(), || format!("{} norms", norms.len()))?;
    let batch: Vec<_> = samples.iter().map(|p| p.instance.clone()).collect();
    let gradients = backend.gradients(&batch, &REQUEST, &CancelToken::default());
    let gradients = gradients.map_err(|e| format!("gradients: {e}"))?;
    for (i, (norm, (gradient, sample))) in
        norms.iter().zip(gradients.iter().zip(&samples)).enumerate()
    {
        let start = &pair.inits[sample.run];
        let own = start
            .parameterization
            .gradient(&sample.instance.model.model().params, &gradient.params);
        let length = own.iter().map(|x| x * x).sum::<f64>().sqrt();
        ensure(length > 0.0, || format!("gradient {i} says nothing"))?;
        close(&format!("length {i}"), norm.norm, length, 1e-5 * length)?;
        let total = gradient.loss.total;
        close(&format!("loss {i}"), norm.loss.total, total, 1e-6 * total.abs())?;
        ensure(norm.loss.groups.len() == gradient.loss.groups.len(), || "groups differ".into())?;
        ensure(norm.final_state == gradient.final_state, || format!("final state {i} differs"))?;
    }
    Ok(())
}

/// Steps are Adam's down the weighted sum. The first is the same to 1e-4 of its rate; later ones
/// see parameters that were rounded differently, and then coordinates whose gradient is nearly
/// nothing may go elsewhere: all together to 2 % of the way.
pub(crate) fn optimizer_steps_like_adam(backend: &dyn Backend) -> Outcome {
    let pair = Pair::new(backend)?;
    let mut optimizer = pair.optimizer(backend)?;
    let weights = [vec![0.7, 0.2], vec![1.5]];
    let rates = [0.05, 0.03, 0.02];
    for steps in 1..=rates.len() {
        let rate = rates[steps - 1];
        measure(&mut *optimizer, &pair.samples())?;
        for (run, weights) in weights.iter().enumerate() {
            optimizer.step(run, weights, rate).map_err(|e| format!("step: {e}"))?;
        }
        let expected = by_hand(backend, &pair, &weights, &rates[..steps])?;
        for (run, expected) in expected.iter().enumerate() {
            let got = optimizer.position(run).map_err(|e| e.to_string())?;
            let start = &pair.inits[run].position.theta;
            ensure(got.adam.steps == steps as u64, || format!("{} steps", got.adam.steps))?;
            let (off, way) = (distance(&got.theta, &expected.theta), distance(start, &got.theta));
            ensure(off <= 0.02 * way && way > 0.0, || {
                format!("run {run} after {steps} steps is {off:.2e} off on a way of {way:.2e}")
            })?;
            if steps == 1 {
                let moments = (&got.adam, &expected.adam);
                first_step_matches(run, &got.theta, &expected.theta, rate)?;
                moments_match(&moments.0.first, &moments.1.first)?;
                moments_match(&moments.0.second, &moments.1.second)?;
            }
        }
    }
    Ok(())
}

fn first_step_matches(run: usize, got: &[f64], expected: &[f64], rate: f64) -> Outcome {
    for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
        // A coordinate in f32 is off by 1e-7 of itself.
        let tolerance = 1e-4 * rate + 1e-6 * expected.abs();
        close(&format!("run {run}, coordinate {i}"), *got, *expected, tolerance)?;
    }
    Ok(())
}

fn moments_match(got: &[f64], expected: &[f64]) -> Outcome {
    let largest = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
        close(&format!("moment {i}"), *got, *expected, 1e-5 * largest)?;
    }
    ensure(got.len() == expected.len(), || format!("{} moments", got.len()))
}

/// However measurements are cut into calls and mixed between runs: the same bits.
pub(crate) fn optimizer_slices_equal_one_batch(backend: &dyn Backend) -> Outcome {
    let pair = Pair::new(backend)?;
    let (mut whole, mut cut) = (pair.optimizer(backend)?, pair.optimizer(backend)?);
    for _ in 0..2 {
        let samples = pair.samples();
        let together = measure(&mut *whole, &samples)?;
        let mut apart = Vec::new();
        for sample in &samples {
            apart.extend(measure(&mut *cut, std::slice::from_ref(sample))?);
        }
        ensure(together == apart, || "norms differ".into())?;
        for optimizer in [&mut whole, &mut cut] {
            optimizer.step(0, &[0.5, 0.5], 0.02).map_err(|e| format!("step: {e}"))?;
            optimizer.step(1, &[1.0], 0.02).map_err(|e| format!("step: {e}"))?;
        }
        for run in 0..2 {
            ensure(whole.position(run) == cut.position(run), || format!("run {run} differs"))?;
        }
    }
    ensure(measure(&mut *whole, &[])?.is_empty(), || "norms of an empty batch".into())
}

/// `loaded` is the model at the point: its parameters are the parameterization's there, its losses
/// those that the optimizer measures, and later steps do not change it. Its parameters to 1e-5.
pub(crate) fn optimizer_hands_out_its_model(backend: &dyn Backend) -> Outcome {
    let pair = Pair::new(backend)?;
    let mut optimizer = pair.optimizer(backend)?;
    measure(&mut *optimizer, &pair.samples())?;
    optimizer.step(0, &[1.0, 1.0], 0.05).map_err(|e| format!("step: {e}"))?;
    let loaded = optimizer.loaded(0).map_err(|e| e.to_string())?;
    let theta = optimizer.position(0).map_err(|e| e.to_string())?.theta;
    let expected = pair.inits[0].parameterization.params(&theta);
    for parameter in Parameter::ALL {
        let pair = parameter.values(&loaded.model().params).iter().zip(parameter.values(&expected));
        for (got, expected) in pair {
            let what = format!("{parameter:?}");
            close(&what, f64::from(*got), f64::from(*expected), 1e-5 * f64::from(expected.abs()))?;
        }
    }
    let mut sample = pair.samples().swap_remove(0);
    sample.instance.model = loaded;
    let loss = || backend.losses(&[sample.instance.clone()], &CancelToken::default());
    let before = loss().map_err(|e| e.to_string())?;
    let norm = measure(&mut *optimizer, std::slice::from_ref(&sample))?;
    let total = before.first().map_or(f64::NAN, |l| l.total);
    let measured = norm.first().map_or(f64::NAN, |s| s.loss.total);
    close("the loss of the model handed out", total, measured, 1e-6 * measured.abs())?;
    optimizer.step(0, &[1.0], 0.05).map_err(|e| format!("step: {e}"))?;
    ensure(loss().ok() == Some(before), || "the model handed out moved on".into())
}

/// Discarded gradients leave no trace; back at an earlier position, with or without momentum, a run
/// repeats its steps from there with the same bits.
pub(crate) fn optimizer_goes_back_exactly(backend: &dyn Backend) -> Outcome {
    let pair = Pair::new(backend)?;
    let mut optimizer = pair.optimizer(backend)?;
    let timing = pair.inits[0].loaded.model().timing;
    let own: Vec<GradientSample> = pair.samples().into_iter().filter(|p| p.run == 0).collect();
    let mut positions = vec![pair.inits[0].position.clone()];
    for i in 0..3 {
        measure(&mut *optimizer, &own)?;
        if i == 1 {
            optimizer.discard(0).map_err(|e| format!("discard: {e}"))?;
            let refused = optimizer.step(0, &[0.5, 0.5], 0.03);
            ensure(matches!(refused, Err(Error::InvalidInput(_))), || {
                format!("a step down forgotten gradients: {refused:?}")
            })?;
            measure(&mut *optimizer, &own)?;
        }
        optimizer.step(0, &[0.5, 0.5], 0.03).map_err(|e| format!("step: {e}"))?;
        positions.push(optimizer.position(0).map_err(|e| e.to_string())?);
    }
    for from in [0, 1, 2] {
        // Gradients of somewhere else must not survive the move.
        measure(&mut *optimizer, &own)?;
        optimizer.move_to(0, &positions[from], timing).map_err(|e| format!("move_to: {e}"))?;
        let at = optimizer.position(0).map_err(|e| e.to_string())?;
        ensure(at == positions[from], || format!("moved to {from}, it is elsewhere"))?;
        measure(&mut *optimizer, &own)?;
        optimizer.step(0, &[0.5, 0.5], 0.03).map_err(|e| format!("step: {e}"))?;
        let next = optimizer.position(0).map_err(|e| e.to_string())?;
        ensure(next == positions[from + 1], || format!("from {from} it goes elsewhere"))?;
        // As another process would.
        let start = OptimizerInit { position: positions[from].clone(), ..pair.inits[0].clone() };
        let mut resumed = backend.optimizer(vec![start], pair.decay).map_err(|e| e.to_string())?;
        measure(&mut *resumed, &own)?;
        resumed.step(0, &[0.5, 0.5], 0.03).map_err(|e| format!("step: {e}"))?;
        let next = resumed.position(0).map_err(|e| e.to_string())?;
        ensure(next == positions[from + 1], || format!("resumed from {from}, it goes elsewhere"))?;
    }
    let finer = bendtwin_core::Timing { substeps: timing.substeps * 2, ..timing };
    optimizer.move_to(0, &positions[0], finer).map_err(|e| format!("move_to: {e}"))?;
    let got = optimizer.loaded(0).map_err(|e| e.to_string())?.model().timing;
    ensure(got == finer, || format!("the timing is {got:?}"))
}

/// Steps of any size end within the bounds, and the parameters there are valid.
pub(crate) fn optimizer_stays_within_bounds(backend: &dyn Backend) -> Outcome {
    let pair = Pair::new(backend)?;
    let mut optimizer = pair.optimizer(backend)?;
    let mut reached = 0;
    for _ in 0..2 {
        measure(&mut *optimizer, &pair.samples())?;
        for (run, weights) in [&[1.0, 1.0][..], &[1.0]].into_iter().enumerate() {
            optimizer.step(run, weights, 0.3).map_err(|e| format!("step: {e}"))?;
            let theta = optimizer.position(run).map_err(|e| e.to_string())?.theta;
            for (i, (x, [low, high])) in
                theta.iter().zip(pair.inits[run].parameterization.bounds()).enumerate()
            {
                // As near as f32 comes to a bound.
                let room = 1e-6 * (1.0 + low.abs().max(high.abs()));
                ensure(*x >= low - room && *x <= high + room, || {
                    format!("run {run}, coordinate {i}: {x} leaves {low}..={high}")
                })?;
                reached += usize::from(x - low <= room || high - x <= room);
            }
            let loaded = optimizer.loaded(run).map_err(|e| e.to_string())?;
            loaded.model().params.check(&loaded.model().graph)?;
        }
    }
    ensure(reached > 0, || "no bound was reached: the case is no test".into())
}

/// Contradictory input is refused and changes nothing.
pub(crate) fn optimizer_refuses_nonsense(backend: &dyn Backend) -> Outcome {
    let pair = Pair::new(backend)?;
    let mut optimizer = pair.optimizer(backend)?;
    let before = [0, 1].map(|run| optimizer.position(run));
    measure(&mut *optimizer, &pair.samples())?;
    let timing = pair.inits[0].loaded.model().timing;
    let mut stray = pair.samples();
    stray[1].run = 7;
    let short = Position { theta: vec![0.0], adam: Adam::new(1, 1) };
    let position = pair.inits[0].position.clone();
    let mut undefined = position.clone();
    undefined.theta[0] = f64::NAN;
    let never = CancelToken::default();
    let refusals = [
        ("another run's step", optimizer.step(2, &[1.0], 0.1).err()),
        ("another run's position", optimizer.position(2).err()),
        ("another run's sample", optimizer.measure(&stray[1..2], &REQUEST, &never).err()),
        ("too many weights", optimizer.step(0, &[1.0, 1.0, 1.0], 0.1).err()),
        ("an infinite weight", optimizer.step(0, &[1.0, f64::INFINITY], 0.1).err()),
        ("a short position", optimizer.move_to(0, &short, timing).err()),
        ("an undefined position", optimizer.move_to(0, &undefined, timing).err()),
    ];
    for (what, error) in refusals {
        let refused = matches!(error, Some(Error::InvalidInput(_)));
        ensure(refused, || format!("{what}: {error:?}"))?;
    }
    // A substep of one second is too long for any of its springs.
    let coarse = bendtwin_core::Timing { fps: 1.0, substeps: 1 };
    let error = optimizer.move_to(0, &position, coarse).err();
    ensure(matches!(error, Some(Error::Unstable { .. })), || format!("one substep: {error:?}"))?;
    let start = OptimizerInit { position: short, ..pair.inits[0].clone() };
    let error = backend.optimizer(vec![start], pair.decay).err();
    ensure(matches!(error, Some(Error::InvalidInput(_))), || format!("a short start: {error:?}"))?;
    let after = [0, 1].map(|run| optimizer.position(run));
    ensure(before == after, || "a refused call moved a run".into())?;
    // What waited still waits.
    optimizer.step(0, &[1.0, 1.0], 0.1).map_err(|e| format!("the step after them: {e}"))
}

/// A gradient beyond f32 is marked as such, and its norm is not finite: here a weight of 1e38 and
/// an error of 20 m.
pub(crate) fn overflowing_gradients_say_so(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3], [0.1, 0.0, 0.0]]);
    scene.spring([0, 1], 10.0, 0.1);
    scene.initial.positions[1][0] = 0.12;
    scene.last(2);
    scene.objective.groups = vec!["track".into()];
    for (weight, overflows) in [(1.0, false), (1e38, true)] {
        scene.objective.terms = std::sync::Arc::new(vec![WeightedTerm {
            frame: 2,
            weight,
            group: 0,
            term: Term::Track {
                of: PointSet::Nodes,
                points: vec![1],
                targets: vec![[20.0, 0.0, 0.0]],
                loss: PointLoss::SquaredDistance,
            },
        }]);
        let gradient = scene.gradient(backend, &GradientRequest::default())?;
        ensure(gradient.overflowed == overflows, || format!("weight {weight}: {gradient:?}"))?;
        let loaded = scene.load(backend)?;
        let parameterization = Parameterization::new(scene.params.clone());
        let parameterization =
            parameterization.with(Parameter::SpringStiffness, Scale::Logarithmic, 1.0, |x| [x, x]);
        let position = parameterization.at_rest(parameterization.start());
        let sample = GradientSample { run: 0, instance: scene.instance(loaded.clone()) };
        let decay = bendtwin_engine::optimizer::Decay { beta1: 0.9, beta2: 0.99, prior: 0.7 };
        let mut optimizer = backend
            .optimizer(vec![OptimizerInit { loaded, parameterization, position }], decay)
            .map_err(|e| format!("optimizer: {e}"))?;
        let norms = measure(&mut *optimizer, &[sample])?;
        let length = norms.first().map_or(0.0, |s| s.norm);
        ensure(length.is_finite() != overflows, || format!("weight {weight}: length {length}"))?;
    }
    Ok(())
}

fn measure(
    optimizer: &mut dyn bendtwin_engine::optimizer::Optimizer,
    samples: &[GradientSample],
) -> Result<Vec<GradientNorm>, String> {
    let norms = optimizer.measure(samples, &REQUEST, &CancelToken::default());
    norms.map_err(|e| format!("measure: {e}"))
}
