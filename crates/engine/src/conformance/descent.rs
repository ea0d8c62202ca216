//! Descents: the same walk as by `gradients`, a chart and Adam by hand, however it is cut into calls,
//! left and taken up again.

mod walkers;

use self::walkers::{REQUEST, Walkers, by_hand, distance};
use super::{
    expect::{Outcome, close, ensure},
    scene::Scene,
};
use crate::{
    Backend, Error, PointLoss, Term,
    backend::GradientRequest,
    descent::{Chart, Parameter, Position, Probe, Scale, Slope, Start},
    objective::WeightedTerm,
};
use bendtwin_core::CancelToken;

/// Losses, lengths and final states are those of `gradients` through the chain rule: to 1e-5, which leaves
/// room for a sum in f32 and another order.
pub(super) fn descent_measures_gradients(backend: &dyn Backend) -> Outcome {
    let walkers = Walkers::new(backend)?;
    let mut descent = walkers.descent(backend)?;
    let probes = walkers.probes();
    let slopes = measure(&mut *descent, &probes)?;
    ensure(slopes.len() == probes.len(), || format!("{} slopes", slopes.len()))?;
    let batch: Vec<_> = probes.iter().map(|p| p.instance.clone()).collect();
    let gradients = backend.gradients(&batch, &REQUEST, &CancelToken::default());
    let gradients = gradients.map_err(|e| format!("gradients: {e}"))?;
    for (i, (slope, (gradient, probe))) in
        slopes.iter().zip(gradients.iter().zip(&probes)).enumerate()
    {
        let start = &walkers.starts[probe.walk];
        let own = start.chart.gradient(&probe.instance.model.model().params, &gradient.params);
        let length = own.iter().map(|x| x * x).sum::<f64>().sqrt();
        ensure(length > 0.0, || format!("gradient {i} says nothing"))?;
        close(&format!("length {i}"), slope.length, length, 1e-5 * length)?;
        let total = gradient.loss.total;
        close(&format!("loss {i}"), slope.loss.total, total, 1e-6 * total.abs())?;
        ensure(slope.loss.groups.len() == gradient.loss.groups.len(), || "groups differ".into())?;
        ensure(slope.final_state == gradient.final_state, || format!("final state {i} differs"))?;
    }
    Ok(())
}

/// Steps are Adam's down the weighted sum. The first is the same to 1e-4 of its rate; later ones see parameters
/// that were rounded differently, and then coordinates whose gradient is nearly nothing may go
/// elsewhere: all together to 2 % of the way.
pub(super) fn descent_steps_like_adam(backend: &dyn Backend) -> Outcome {
    let walkers = Walkers::new(backend)?;
    let mut descent = walkers.descent(backend)?;
    let weights = [vec![0.7, 0.2], vec![1.5]];
    let rates = [0.05, 0.03, 0.02];
    for steps in 1..=rates.len() {
        let rate = rates[steps - 1];
        measure(&mut *descent, &walkers.probes())?;
        for (walk, weights) in weights.iter().enumerate() {
            descent.step(walk, weights, rate).map_err(|e| format!("step: {e}"))?;
        }
        let expected = by_hand(backend, &walkers, &weights, &rates[..steps])?;
        for (walk, expected) in expected.iter().enumerate() {
            let got = descent.position(walk).map_err(|e| e.to_string())?;
            let start = &walkers.starts[walk].position.theta;
            ensure(got.adam.steps == steps as u64, || format!("{} steps", got.adam.steps))?;
            let (off, way) = (distance(&got.theta, &expected.theta), distance(start, &got.theta));
            ensure(off <= 0.02 * way && way > 0.0, || {
                format!("walk {walk} after {steps} steps is {off:.2e} off on a way of {way:.2e}")
            })?;
            if steps == 1 {
                let moments = (&got.adam, &expected.adam);
                first_step_matches(walk, &got.theta, &expected.theta, rate)?;
                moments_match(&moments.0.first, &moments.1.first)?;
                moments_match(&moments.0.second, &moments.1.second)?;
            }
        }
    }
    Ok(())
}

fn first_step_matches(walk: usize, got: &[f64], expected: &[f64], rate: f64) -> Outcome {
    for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
        // A coordinate in f32 is off by 1e-7 of itself.
        let tolerance = 1e-4 * rate + 1e-6 * expected.abs();
        close(&format!("walk {walk}, coordinate {i}"), *got, *expected, tolerance)?;
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

/// However measurements are cut into calls and mixed between walks: the same bits.
pub(super) fn descent_slices_equal_one_batch(backend: &dyn Backend) -> Outcome {
    let walkers = Walkers::new(backend)?;
    let (mut whole, mut cut) = (walkers.descent(backend)?, walkers.descent(backend)?);
    for _ in 0..2 {
        let probes = walkers.probes();
        let together = measure(&mut *whole, &probes)?;
        let mut apart = Vec::new();
        for probe in &probes {
            apart.extend(measure(&mut *cut, std::slice::from_ref(probe))?);
        }
        ensure(together == apart, || "slopes differ".into())?;
        for descent in [&mut whole, &mut cut] {
            descent.step(0, &[0.5, 0.5], 0.02).map_err(|e| format!("step: {e}"))?;
            descent.step(1, &[1.0], 0.02).map_err(|e| format!("step: {e}"))?;
        }
        for walk in 0..2 {
            ensure(whole.position(walk) == cut.position(walk), || format!("walk {walk} differs"))?;
        }
    }
    ensure(measure(&mut *whole, &[])?.is_empty(), || "slopes of an empty batch".into())
}

/// `loaded` is the model at the point: its parameters are the chart's there, its losses those that the
/// descent measures, and it stays when the walk goes on. Its parameters to 1e-5.
pub(super) fn descent_hands_out_its_model(backend: &dyn Backend) -> Outcome {
    let walkers = Walkers::new(backend)?;
    let mut descent = walkers.descent(backend)?;
    measure(&mut *descent, &walkers.probes())?;
    descent.step(0, &[1.0, 1.0], 0.05).map_err(|e| format!("step: {e}"))?;
    let loaded = descent.loaded(0).map_err(|e| e.to_string())?;
    let theta = descent.position(0).map_err(|e| e.to_string())?.theta;
    let expected = walkers.starts[0].chart.params(&theta);
    for parameter in Parameter::ALL {
        let pair = parameter.values(&loaded.model().params).iter().zip(parameter.values(&expected));
        for (got, expected) in pair {
            let what = format!("{parameter:?}");
            close(&what, f64::from(*got), f64::from(*expected), 1e-5 * f64::from(expected.abs()))?;
        }
    }
    let mut probe = walkers.probes().swap_remove(0);
    probe.instance.model = loaded;
    let loss = || backend.losses(&[probe.instance.clone()], &CancelToken::default());
    let before = loss().map_err(|e| e.to_string())?;
    let slope = measure(&mut *descent, std::slice::from_ref(&probe))?;
    let total = before.first().map_or(f64::NAN, |l| l.total);
    let measured = slope.first().map_or(f64::NAN, |s| s.loss.total);
    close("the loss of the model handed out", total, measured, 1e-6 * measured.abs())?;
    descent.step(0, &[1.0], 0.05).map_err(|e| format!("step: {e}"))?;
    ensure(loss().ok() == Some(before), || "the model handed out moved on".into())
}

/// Forgotten gradients leave no trace; back at an earlier position, with or without momentum, a walk goes
/// on as it did from there: the same bits.
pub(super) fn descent_goes_back_exactly(backend: &dyn Backend) -> Outcome {
    let walkers = Walkers::new(backend)?;
    let mut descent = walkers.descent(backend)?;
    let timing = walkers.starts[0].loaded.model().timing;
    let own: Vec<Probe> = walkers.probes().into_iter().filter(|p| p.walk == 0).collect();
    let mut positions = vec![walkers.starts[0].position.clone()];
    for i in 0..3 {
        measure(&mut *descent, &own)?;
        if i == 1 {
            descent.discard(0).map_err(|e| format!("discard: {e}"))?;
            let refused = descent.step(0, &[0.5, 0.5], 0.03);
            ensure(matches!(refused, Err(Error::InvalidInput(_))), || {
                format!("a step down forgotten gradients: {refused:?}")
            })?;
            measure(&mut *descent, &own)?;
        }
        descent.step(0, &[0.5, 0.5], 0.03).map_err(|e| format!("step: {e}"))?;
        positions.push(descent.position(0).map_err(|e| e.to_string())?);
    }
    for from in [0, 1, 2] {
        // Gradients of somewhere else must not survive the move.
        measure(&mut *descent, &own)?;
        descent.move_to(0, &positions[from], timing).map_err(|e| format!("move_to: {e}"))?;
        let at = descent.position(0).map_err(|e| e.to_string())?;
        ensure(at == positions[from], || format!("moved to {from}, it is elsewhere"))?;
        measure(&mut *descent, &own)?;
        descent.step(0, &[0.5, 0.5], 0.03).map_err(|e| format!("step: {e}"))?;
        let next = descent.position(0).map_err(|e| e.to_string())?;
        ensure(next == positions[from + 1], || format!("from {from} it goes elsewhere"))?;
        // In another process, as it were.
        let start = Start { position: positions[from].clone(), ..walkers.starts[0].clone() };
        let mut resumed = backend.descent(vec![start], walkers.decay).map_err(|e| e.to_string())?;
        measure(&mut *resumed, &own)?;
        resumed.step(0, &[0.5, 0.5], 0.03).map_err(|e| format!("step: {e}"))?;
        let next = resumed.position(0).map_err(|e| e.to_string())?;
        ensure(next == positions[from + 1], || format!("resumed from {from}, it goes elsewhere"))?;
    }
    let finer = bendtwin_core::Timing { substeps: timing.substeps * 2, ..timing };
    descent.move_to(0, &positions[0], finer).map_err(|e| format!("move_to: {e}"))?;
    let got = descent.loaded(0).map_err(|e| e.to_string())?.model().timing;
    ensure(got == finer, || format!("the timing is {got:?}"))
}

/// Steps of any size end within the bounds, and the parameters there are valid.
pub(super) fn descent_stays_within_bounds(backend: &dyn Backend) -> Outcome {
    let walkers = Walkers::new(backend)?;
    let mut descent = walkers.descent(backend)?;
    let mut reached = 0;
    for _ in 0..2 {
        measure(&mut *descent, &walkers.probes())?;
        for (walk, weights) in [&[1.0, 1.0][..], &[1.0]].into_iter().enumerate() {
            descent.step(walk, weights, 0.3).map_err(|e| format!("step: {e}"))?;
            let theta = descent.position(walk).map_err(|e| e.to_string())?.theta;
            for (i, (x, [low, high])) in
                theta.iter().zip(walkers.starts[walk].chart.bounds()).enumerate()
            {
                // As near as f32 comes to a bound.
                let room = 1e-6 * (1.0 + low.abs().max(high.abs()));
                ensure(*x >= low - room && *x <= high + room, || {
                    format!("walk {walk}, coordinate {i}: {x} leaves {low}..={high}")
                })?;
                reached += usize::from(x - low <= room || high - x <= room);
            }
            let loaded = descent.loaded(walk).map_err(|e| e.to_string())?;
            loaded.model().params.check(&loaded.model().graph)?;
        }
    }
    ensure(reached > 0, || "no bound was reached: the case is no test".into())
}

/// What contradicts itself is refused and moves nothing.
pub(super) fn descent_refuses_nonsense(backend: &dyn Backend) -> Outcome {
    let walkers = Walkers::new(backend)?;
    let mut descent = walkers.descent(backend)?;
    let before = [0, 1].map(|walk| descent.position(walk));
    measure(&mut *descent, &walkers.probes())?;
    let timing = walkers.starts[0].loaded.model().timing;
    let mut stray = walkers.probes();
    stray[1].walk = 7;
    let short = Position::at_rest(vec![0.0]);
    let position = walkers.starts[0].position.clone();
    let mut undefined = position.clone();
    undefined.theta[0] = f64::NAN;
    let never = CancelToken::default();
    let refusals = [
        ("another walk's step", descent.step(2, &[1.0], 0.1).err()),
        ("another walk's position", descent.position(2).err()),
        ("another walk's probe", descent.measure(&stray[1..2], &REQUEST, &never).err()),
        ("too many weights", descent.step(0, &[1.0, 1.0, 1.0], 0.1).err()),
        ("an infinite weight", descent.step(0, &[1.0, f64::INFINITY], 0.1).err()),
        ("a short position", descent.move_to(0, &short, timing).err()),
        ("an undefined position", descent.move_to(0, &undefined, timing).err()),
    ];
    for (what, error) in refusals {
        let refused = matches!(error, Some(Error::InvalidInput(_)));
        ensure(refused, || format!("{what}: {error:?}"))?;
    }
    // A second at once is too long for any of its springs.
    let coarse = bendtwin_core::Timing { fps: 1.0, substeps: 1 };
    let error = descent.move_to(0, &position, coarse).err();
    ensure(matches!(error, Some(Error::Unstable { .. })), || format!("one substep: {error:?}"))?;
    let start = Start { position: short, ..walkers.starts[0].clone() };
    let error = backend.descent(vec![start], walkers.decay).err();
    ensure(matches!(error, Some(Error::InvalidInput(_))), || format!("a short start: {error:?}"))?;
    let after = [0, 1].map(|walk| descent.position(walk));
    ensure(before == after, || "a refused call moved a walk".into())?;
    // What waited still waits.
    descent.step(0, &[1.0, 1.0], 0.1).map_err(|e| format!("the step after them: {e}"))
}

/// A gradient beyond f32 says so, and so does its length: here a weight of 1e38 and an error of 20 m.
pub(super) fn overflowing_gradients_say_so(backend: &dyn Backend) -> Outcome {
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
                nodes: vec![1],
                targets: vec![[20.0, 0.0, 0.0]],
                loss: PointLoss::SquaredDistance,
            },
        }]);
        let gradient = scene.gradient(backend, &GradientRequest::default())?;
        ensure(gradient.overflowed == overflows, || format!("weight {weight}: {gradient:?}"))?;
        let loaded = scene.load(backend)?;
        let chart = Chart::new(scene.params.clone());
        let chart = chart.with(Parameter::SpringStiffness, Scale::Logarithmic, 1.0, |x| [x, x]);
        let position = Position::at_rest(chart.start());
        let probe = Probe { walk: 0, instance: scene.instance(loaded.clone()) };
        let decay = crate::descent::Decay { beta1: 0.9, beta2: 0.99, home: 0.7 };
        let mut descent = backend
            .descent(vec![Start { loaded, chart, position }], decay)
            .map_err(|e| format!("descent: {e}"))?;
        let slopes = measure(&mut *descent, &[probe])?;
        let length = slopes.first().map_or(0.0, |s| s.length);
        ensure(length.is_finite() != overflows, || format!("weight {weight}: length {length}"))?;
    }
    Ok(())
}

fn measure(
    descent: &mut dyn crate::descent::Descent,
    probes: &[Probe],
) -> Result<Vec<Slope>, String> {
    let slopes = descent.measure(probes, &REQUEST, &CancelToken::default());
    slopes.map_err(|e| format!("measure: {e}"))
}
