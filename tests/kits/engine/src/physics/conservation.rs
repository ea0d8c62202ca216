//! Budgets of energy and momentum, on random networks.

use bendtwin_engine::Backend;

use crate::{
    energy,
    expect::{Outcome, close, ensure},
    random::{RandomOptions, random_model, random_motion},
    scene::{Scene, norm},
};

/// A free network in empty space, without drag.
fn free(seed: u64, frames: usize, damping: bool) -> Scene {
    let options = RandomOptions { controls: 0, pins: 0, damping, ..RandomOptions::default() };
    let mut model = random_model(seed, &options);
    model.params.drag = 0.0;
    let (state, _) = random_motion(seed, &model, frames);
    let mut scene = Scene::around(model, state, Vec::new(), frames);
    scene.relax();
    scene
}

fn total(scene: &Scene, state: &bendtwin_engine::model::State) -> f64 {
    energy::elastic(scene, &energy::endpoints(scene, state)) + energy::kinetic(scene, state)
}

/// Kinetic plus elastic energy of an undamped network, averaged over a second, does not drift over
/// four seconds: to 2 %. A symplectic integrator's energy swings by w dt / 2 (about 5 % for the
/// stiffest mode) about a constant; the mean over a second keeps a tenth of that. The rest of the
/// tolerance is for triplets that pass through the straight line, where their force reverses
/// abruptly.
pub(crate) fn energy_of_an_undamped_network(backend: &dyn Backend) -> Outcome {
    for seed in 0..3 {
        let scene = free(seed, 400, false);
        let states = scene.states(backend)?;
        let energies: Vec<f64> = states.iter().map(|s| total(&scene, s)).collect();
        let mean = |span: &[f64]| span.iter().sum::<f64>() / span.len() as f64;
        let (first, last) = (mean(&energies[..100]), mean(&energies[300..]));
        close(&format!("seed {seed}: energy after 3 s"), last, first, 0.02 * first)?;
    }
    Ok(())
}

/// Springs, triplets and both dampings are internal forces: linear and angular momentum of a free
/// body stay, to 0.01 % of the sum of all nodes' |p| and |p| · size: the rounding of 4,000
/// substeps.
pub(crate) fn momentum_of_a_free_body(backend: &dyn Backend) -> Outcome {
    for seed in 0..3 {
        let scene = free(seed, 100, true);
        let end = scene.end(backend)?;
        let (p0, l0) = energy::momentum(&scene, &scene.initial);
        let (p1, l1) = energy::momentum(&scene, &end);
        let speeds = scene.initial.velocities.iter().zip(&scene.graph.masses);
        let scale: f64 = speeds.map(|(v, m)| norm(v.map(f64::from)) * f64::from(*m)).sum();
        for axis in 0..3 {
            let what = format!("seed {seed}: momentum along axis {axis}");
            close(&what, p1[axis], p0[axis], 1e-4 * scale)?;
            let what = format!("seed {seed}: angular momentum about axis {axis}");
            close(&what, l1[axis], l0[axis], 1e-4 * scale * 0.1)?;
        }
    }
    Ok(())
}

/// With dampers alone, kinetic energy falls in every frame (rounding aside: 1e-6 of it).
fn only_falls(backend: &dyn Backend, axial: bool) -> Outcome {
    for seed in 0..4 {
        let mut scene = free(seed, 50, true);
        scene.params.spring_stiffness.fill(0.0);
        scene.params.bend_stiffness.fill(0.0);
        // Slow, or nodes that nothing holds apart would meet: as an arm shrinks, its explicit
        // damping, c_b dt / (m l²), outgrows any substep.
        scene.initial.velocities.iter_mut().flatten().for_each(|v| *v *= 0.1);
        if axial {
            scene.params.bend_damping.fill(0.0);
        } else {
            scene.params.spring_dashpot.fill(0.0);
        }
        let energies: Vec<f64> =
            scene.states(backend)?.iter().map(|s| energy::kinetic(&scene, s)).collect();
        for (frame, pair) in energies.windows(2).enumerate() {
            ensure(pair[1] <= pair[0] * (1.0 + 1e-6), || {
                format!(
                    "seed {seed}: kinetic energy rises from {} to {} in frame {frame}",
                    pair[0], pair[1]
                )
            })?;
        }
        let (first, last) = (energies[0], energies[energies.len() - 1]);
        ensure(last < 0.99 * first, || {
            format!("seed {seed}: damping takes next to nothing: {first} to {last}")
        })?;
    }
    Ok(())
}

/// Axial dashpots alone only take energy.
pub(crate) fn axial_dashpots_never_raise_energy(backend: &dyn Backend) -> Outcome {
    only_falls(backend, true)
}

/// Bending damping alone only takes energy.
pub(crate) fn bend_damping_never_raises_energy(backend: &dyn Backend) -> Outcome {
    only_falls(backend, false)
}
