//! Batches, repeats, resuming and cancelling: bit for bit.

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend, Error,
    backend::{Diagnose, GradientRequest, Instance, Outputs},
};

use crate::{
    expect::{Outcome, ensure},
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::{Scene, only},
};

/// Scenes of different sizes, lengths and features.
fn mixed() -> Vec<Scene> {
    (0..7)
        .map(|seed| {
            let options = RandomOptions {
                nodes: [24, 3, 70, 1, 24, 41, 9][seed as usize],
                controls: (seed % 3) as usize,
                pins: if seed == 5 { 4 } else { (seed % 2) as usize },
                rod: seed == 5,
                objects: 1 + (seed % 2) as u32,
                bending: seed != 4,
                ground: seed % 2 == 0,
                contact: seed > 3,
                skin_contact: seed % 4 == 2,
                ..RandomOptions::default()
            };
            let model = random_model(seed, &options);
            let frames = 2 + (seed % 4) as usize;
            let (state, controls) = random_motion(seed, &model, frames);
            let objective = random_objective(seed, &model, frames);
            let mut scene = Scene::around(model, state, controls, frames);
            scene.objective = objective;
            scene
        })
        .collect()
}

const OUTPUTS: Outputs = Outputs {
    every: 1,
    initial: true,
    nodes: None,
    final_state: true,
    diagnose: Diagnose::All,
    ..Outputs::NONE
};
const REQUEST: GradientRequest = GradientRequest {
    cut_every: 0,
    controls: true,
    initial: true,
    final_state: true,
    ..GradientRequest::PARAMS
};

fn instances(backend: &dyn Backend) -> Result<Vec<Instance>, String> {
    mixed().iter().map(|s| Ok(s.instance(s.load(backend)?))).collect()
}

/// Results of all three calls, as text in which equal means bit for bit (floats print exactly).
fn everything(backend: &dyn Backend, batch: &[Instance]) -> Result<Vec<String>, String> {
    let cancel = CancelToken::default();
    let rollouts = backend.roll_out(batch, &OUTPUTS, &cancel).map_err(|e| e.to_string())?;
    let losses = backend.losses(batch, &cancel).map_err(|e| e.to_string())?;
    let gradients = backend.gradients(batch, &REQUEST, &cancel).map_err(|e| e.to_string())?;
    let counts = [rollouts.len(), losses.len(), gradients.len()];
    ensure(counts == [batch.len(); 3], || format!("{counts:?} results for {}", batch.len()))?;
    let all = rollouts.iter().zip(&losses).zip(&gradients);
    Ok(all.map(|((r, l), g)| format!("{r:?}\n{l:?}\n{g:?}")).collect())
}

fn same(what: &str, a: &[String], b: &[String]) -> Outcome {
    let different = a.iter().zip(b).position(|(a, b)| a != b);
    ensure(different.is_none() && a.len() == b.len(), || {
        format!("{what}: instance {different:?} of {} differs", a.len())
    })
}

/// A batch of different graphs gives what its instances give alone, in order.
pub(crate) fn batch_equals_one_by_one(backend: &dyn Backend) -> Outcome {
    let batch = instances(backend)?;
    let together = everything(backend, &batch)?;
    let mut alone = Vec::new();
    for instance in &batch {
        alone.push(only(everything(backend, std::slice::from_ref(instance))?)?);
    }
    same("alone or in a batch", &together, &alone)?;
    ensure(everything(backend, &[])?.is_empty(), || "results for an empty batch".into())
}

/// The same batch again, newly loaded: identical.
pub(crate) fn repeats_are_identical(backend: &dyn Backend) -> Outcome {
    let first = everything(backend, &instances(backend)?)?;
    for _ in 0..3 {
        same("repeated", &first, &everything(backend, &instances(backend)?)?)?;
    }
    Ok(())
}

/// Frame by frame from each final state is the same as in one go, contact included.
pub(crate) fn resuming_continues_exactly(backend: &dyn Backend) -> Outcome {
    for (i, scene) in mixed().into_iter().enumerate() {
        let whole = scene.end(backend)?;
        let stepped = scene.states(backend)?.pop();
        ensure(Some(&whole) == stepped.as_ref(), || format!("scene {i} resumes differently"))?;
    }
    Ok(())
}

/// with_params is load with other parameters: identical results, wrong ones refused.
pub(crate) fn new_params_equal_a_new_model(backend: &dyn Backend) -> Outcome {
    for mut scene in mixed() {
        let before = scene.load(backend)?;
        let p = &mut scene.params;
        p.spring_stiffness.iter_mut().for_each(|k| *k *= 0.8);
        p.spring_dashpot.iter_mut().for_each(|x| *x *= 1.1);
        p.rest_lengths_m.iter_mut().for_each(|x| *x *= 1.01);
        p.bend_stiffness.iter_mut().for_each(|x| *x *= 0.9);
        p.bend_damping.iter_mut().for_each(|x| *x *= 1.2);
        p.rest_angles_rad.iter_mut().for_each(|x| *x *= 0.99);
        p.twist_stiffness.iter_mut().for_each(|x| *x *= 0.8);
        p.twist_damping.iter_mut().for_each(|x| *x *= 1.2);
        p.rest_twists_rad.iter_mut().for_each(|x| *x -= 0.3);
        p.drag += 0.1;
        p.contact.ground_friction = 0.5;
        p.contact.object_restitution = 0.1;
        p.contact.collision_distance_m *= 1.1;
        let changed = backend.with_params(&before, scene.params.clone());
        let changed = changed.map_err(|e| format!("with_params: {e}"))?;
        ensure(changed.model().params == scene.params, || "the model keeps old params".into())?;
        let anew = everything(backend, &[scene.instance(scene.load(backend)?)])?;
        same("with_params", &anew, &everything(backend, &[scene.instance(changed)])?)?;

        let mut wrong = scene.params.clone();
        wrong.spring_stiffness.push(1.0);
        let refused = backend.with_params(&before, wrong);
        ensure(matches!(refused, Err(Error::InvalidModel(_))), || {
            "with_params takes a stiffness too many".to_owned()
        })?;
    }
    Ok(())
}

/// A cancelled token stops every call before it starts, and a running one long before its end:
/// sooner than another caller gets a twentieth of its work done. No clock is asked, so that this
/// holds on a device of any speed and under a memory checker.
pub(crate) fn cancellation_stops_everything(backend: &dyn Backend) -> Outcome {
    let mut scene = mixed().swap_remove(2);
    let loaded = scene.load(backend)?;
    let cancelled = CancelToken::default();
    cancelled.cancel();
    let calls = |batch: &[Instance], cancel: &CancelToken| {
        [
            backend.roll_out(batch, &OUTPUTS, cancel).err(),
            backend.losses(batch, cancel).err(),
            backend.gradients(batch, &REQUEST, cancel).err(),
        ]
    };
    for error in calls(&[scene.instance(loaded.clone())], &cancelled) {
        ensure(error == Some(Error::Cancelled), || format!("cancelled before: {error:?}"))?;
    }
    // Only cancelling ends it.
    const PIECES: usize = 400;
    const PIECE: usize = 500;
    scene.objective = Default::default();
    scene.last(PIECE);
    let piece = [scene.instance(loaded.clone())];
    scene.last(PIECES * PIECE);
    let long = [scene.instance(loaded)];
    let cancel = CancelToken::default();
    let work = || backend.losses(&piece, &CancelToken::default()).map_err(|e| e.to_string());
    std::thread::scope(|threads| {
        let running = threads.spawn(|| backend.losses(&long, &cancel).err());
        let began = work().and_then(|_| work());
        cancel.cancel();
        began?;
        let mut pieces = 0;
        while !running.is_finished() {
            pieces += 1;
            ensure(pieces <= PIECES / 20, || "a cancelled call continues".to_owned())?;
            work()?;
        }
        let error = running.join().map_err(|_| "a cancelled call panicked".to_owned())?;
        ensure(error == Some(Error::Cancelled), || format!("cancelled while running: {error:?}"))
    })
}
