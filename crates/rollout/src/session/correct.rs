//! Corrections: states of a session are brought closer to observations, and their rest shapes with
//! them, for all slots that a call names or for none. A slot that is lost is registered instead, if
//! the call allows it.

mod scene;

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_contract::registration;
use bendtwin_core::{CancelToken, Environment, Params, geometry::point_distance};
use bendtwin_engine::{Backend, Loaded, Model, backend, model::State};
use bendtwin_proto::v1::{self, corrected_session::Correction};
use bendtwin_register::{
    self as register, Around, CorrectOptions, Corrected, Observation, RegisterOptions, Tracking,
    carried,
};

use self::scene::Scene;
pub(crate) use self::scene::grippers;
use super::{Session, Setup, states::given_one};
use crate::{
    error::Error,
    observation,
    request::initial::Start,
    twin::{rest_shape::RestShape, warm::Warm},
};

/// An observation and the options by which slots are corrected.
pub struct CorrectionInput<'w> {
    warm: &'w Warm,
    backend: &'w dyn Backend,
    observation: Observation,
    scene: Scene,
    options: CorrectOptions,
    /// Share of the correction, beyond the noise of the points, that rest shapes take, 0..=1.
    carry: f64,
    registers: bool,
    omits_state: bool,
}

/// A slot that was corrected, or registered.
struct Done {
    start: Start,
    correction: Correction,
    tracking: Tracking,
}

/// A slot that was refused, and its record with this refusal.
struct Refused {
    tracking: Tracking,
    error: register::Error,
}

impl<'w> CorrectionInput<'w> {
    /// A correction from a checked request to a session of a twin.
    ///
    /// # Errors
    /// If a tensor is not what the check saw, or the world cannot be read.
    pub fn new(
        warm: &'w Warm,
        backend: &'w dyn Backend,
        setup: &Setup,
        observation: Option<v1::Observation>,
        options: v1::CorrectOptions,
    ) -> Result<Self, Error> {
        Ok(Self {
            warm,
            backend,
            observation: observation::read(observation, &warm.twin.graph)?,
            scene: Scene::read(&options, setup, &warm.twin)?,
            carry: registration::carry(&options),
            registers: options.register_if_lost,
            omits_state: options.omit_state,
            options: observation::correct_options(Some(options)),
        })
    }

    /// The twin's model in an environment.
    fn model(&self, environment: Environment) -> Result<Loaded, Error> {
        let loaded = &self.warm.loaded;
        if loaded.model().environment == environment {
            return Ok(loaded.clone());
        }
        Ok(self.backend.with_environment(loaded, environment)?)
    }

    /// Corrects a slot, or registers it if it is lost and that is asked for.
    fn slot(
        &self,
        (start, before): (&Start, Tracking),
        memory: Option<Share>,
        cancel: &CancelToken,
    ) -> Result<Result<Done, Refused>, Error> {
        let own = self.warm.loaded.model().environment;
        let (environment, around) = self.scene.of(start, own);
        let loaded = self.model(environment)?;
        let (state, controls) = (&start.state, &start.controls);
        let by = (&self.observation, &self.options);
        let tried = register::correct(loaded.model(), state, controls, &around, by.0, by.1, cancel);
        let misfit = match &tried {
            Ok(corrected) => corrected.misfit,
            Err(register::Error::NotExplained { misfit, .. }) => *misfit,
            Err(other) => return Err(other.clone().into()),
        };
        let tracking = before.after(misfit);
        if self.registers && tracking.is_lost() {
            match self.register(start, &loaded, around, cancel) {
                Ok(done) => return Ok(Ok(done)),
                Err(register::Error::NotExplained { .. } | register::Error::Invalid(_)) => {}
                Err(other) => return Err(other.into()),
            }
        }
        Ok(match tried {
            Ok(corrected) => Ok(self.done(start, corrected, tracking, memory)),
            Err(error) => Err(Refused { tracking, error }),
        })
    }

    /// A slot in a corrected state, with the part of the correction that lasts.
    fn done(
        &self,
        start: &Start,
        corrected: Corrected,
        tracking: Tracking,
        memory: Option<Share>,
    ) -> Done {
        let share = self.carry * corrected.beyond_noise(self.options.noise_m);
        let rest = match share > 0.0 {
            true => {
                let rest = self.rest(start, &corrected.state, share);
                Some(Arc::new(RestShape::new(rest, memory)))
            }
            false => start.rest.clone(),
        };
        let correction = Correction {
            before: Some(observation::residual(corrected.before)),
            after: Some(observation::residual(corrected.after)),
            moved_mm: 1e3 * corrected.moved_m,
            ..Correction::default()
        };
        let start = Start { state: Arc::new(corrected.state), rest, ..start.clone() };
        Done { start, correction, tracking }
    }

    /// The rest shape of a slot that takes a share of the way to another state.
    fn rest(&self, from: &Start, to: &State, share: f64) -> Params {
        let own = self.warm.loaded.model();
        let mut model = Model::clone(own);
        if let Some(rest) = &from.rest {
            rest.put_into(&mut model.params);
        }
        carried(&model, &own.params, &from.state, to, &from.controls, share)
    }

    /// Registers a slot, near where it is or else anywhere, with what is held in place and the rest
    /// shape of the twin.
    fn register(
        &self,
        start: &Start,
        loaded: &Loaded,
        around: Around,
        cancel: &CancelToken,
    ) -> Result<Done, register::Error> {
        let Self { observation, options, .. } = self;
        let (state, controls) = (&start.state, &start.controls);
        let before = register::residual(loaded.model(), state, controls, observation)?;
        let held = state.grasping.holds.iter();
        let held = held.filter_map(|h| Some((h.node, *state.positions.get(h.node as usize)?)));
        // Where control points are not known they go where the object goes.
        let known = start.likely.is_none();
        let near = RegisterOptions {
            initial: Some((State::clone(state), Vec::clone(controls))),
            controls: if known { Vec::clone(controls) } else { Vec::new() },
            held: held.collect(),
            around,
            near: true,
            noise_m: options.noise_m,
            max_residual_m: options.max_residual_m,
            ..RegisterOptions::default()
        };
        let try_from =
            |options| register::register(self.backend, loaded, observation, &options, cancel);
        let found = match try_from(near.clone()) {
            Err(register::Error::NotExplained { .. } | register::Error::Invalid(_)) => {
                try_from(RegisterOptions { initial: None, near: false, ..near })?
            }
            other => other?,
        };
        let grasping = state.grasping.clone();
        let found_state = State { grasping, ..found.state };
        let correction = Correction {
            before: Some(observation::residual(before)),
            after: Some(observation::residual(found.residual)),
            moved_mm: 1e3 * farthest(state, &found_state),
            registered: true,
            ..Correction::default()
        };
        let start = Start {
            around: start.around.clone(),
            ..Start::new(Arc::new(found_state), Arc::new(found.controls))
        };
        Ok(Done { start, correction, tracking: Tracking::default() })
    }
}

/// Corrects slots and leaves them in the corrected states with their rest shapes, for each of which
/// memory was taken if it is counted; unless one of the slots is refused, which is recorded.
///
/// # Errors
/// If a slot is refused or lost, or the backend fails.
pub fn corrected(
    session: &Session,
    slots: &[usize],
    by: &CorrectionInput<'_>,
    memory: Vec<Share>,
    cancel: &CancelToken,
) -> Result<Vec<Correction>, Error> {
    let (starts, _) = session.states(slots);
    let mut memory = memory.into_iter();
    let (mut done, mut refused) = (Vec::with_capacity(slots.len()), Vec::new());
    let now = starts.iter().zip(session.trackings(slots));
    for (&slot, now) in slots.iter().zip(now) {
        match by.slot(now, memory.next(), cancel)? {
            Ok(one) => done.push((slot, one)),
            Err(one) => refused.push((slot, one)),
        }
    }
    if cancel.is_cancelled() {
        // The caller is gone.
        return Err(backend::Error::Cancelled.into());
    }
    if !refused.is_empty() {
        session.record(refused.iter().map(|(slot, one)| (*slot, one.tracking)));
    }
    if let Some((slot, Refused { tracking, error })) = refused.into_iter().next() {
        return Err(Error::of_slot(slot, tracking, error));
    }
    session.record(done.iter().map(|(slot, one)| (*slot, one.tracking)));
    let (graph, grasps) = (&by.warm.twin.graph, session.setup.grasps.len());
    let corrections = done.iter().map(|(slot, Done { start, correction, tracking })| Correction {
        slot: *slot as u32,
        state: (!by.omits_state).then(|| given_one(start, graph, grasps)),
        tracking: Some(observation::tracking(*tracking)),
        ..correction.clone()
    });
    let corrections = corrections.collect();
    session.commit(slots, done.into_iter().map(|(_, one)| one.start).collect(), 0);
    Ok(corrections)
}

/// Largest distance of a node in one state from where it is in another [m].
fn farthest(a: &State, b: &State) -> f64 {
    let pairs = a.positions.iter().zip(&b.positions);
    pairs.map(|(a, b)| point_distance(*a, *b)).fold(0.0, f64::max)
}
