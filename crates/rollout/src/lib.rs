//! Rollouts of a twin: what a request asks for, computed on any backend, without transport. A worker
//! calls this from its service, and a process with a twin and a backend can call it as well.
//!
//! A rollout takes four steps, each of which has what the next one needs:
//!
//! ```text
//!   RollOutRequest ──► Checked ──────► Plan + Starts ──► Execution ──► RollOutResponse, in parts
//!                      request/        run/plan.rs       run/execute.rs         reply/
//!                      sizes, memory   models, actions   instances on a backend
//! ```
//!
//! - `request` reads the parts of a message: actions, costs, what is returned, what varies.
//! - `world` has what surrounds the object: ground, bodies, grasps.
//! - `twin` has the twin's models: the exact one, the fast variant, the planner's twin.
//! - `run` plans and simulates, `reply` packs what is returned.
//! - `pictures` draws the states of sessions, as cameras see them.
//! - `session` keeps states between calls; `register` and `evaluate` answer the other requests about a
//!   twin.
//!
//! Memory is counted here and taken by the caller; where twins and captures come from is left to the
//! caller, too.

mod backend;
pub mod cut;
mod error;
mod evaluate;
mod observation;
mod pictures;
mod register;
mod reply;
mod request;
mod run;
mod session;
mod twin;
mod world;

pub use self::{
    backend::RolloutBackend,
    error::Error,
    evaluate::evaluate_twin,
    pictures::{Painter, Pictures, SlotPictures},
    register::register_state,
    request::{
        checked::{Checked, Room},
        initial::{CaptureFrame, Start, StartSimulation, Starts, Wanted},
    },
    run::{
        execute::Execution,
        plan::{Plan, shape},
        replay::{Motions, replay},
        settle::settle,
    },
    session::{
        Begun, Session, Sessions, Setup,
        correct::{CorrectionInput, corrected},
        idle, session_states,
    },
    twin::{rest_shape::RestShape, serve::Served, warm::Warm},
    world::Still,
};

#[cfg(test)]
mod tests;
