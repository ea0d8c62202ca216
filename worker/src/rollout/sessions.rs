//! The calls about sessions that simulate nothing but the way to a first state, corrections of their
//! states, and pictures of them.

mod correct;
mod render;

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_contract::rollout;
use bendtwin_core::{CancelToken, ids::SessionId};
use bendtwin_proto::{
    v1::{
        Fidelity, GetSessionStatesRequest, InitialState, OpenSessionRequest, SessionStates, World,
    },
    worker::v1::{ManageSessionRequest, ManageSessionResponse, manage_session_request::Call},
};
use bendtwin_rollout::{
    Session, Setup, Start, StartSimulation, Starts, Still, Wanted, Warm, idle, session_states,
    shape,
};

use super::{
    error::Error,
    service::{Inner, Unary},
};
use crate::{budget, device::QueuedBackend};

/// States of a slot: its first one and the present one, and one that an advance makes.
const STATES: u64 = 3;
/// Memory of a reply with states, beside its size: as arrays, as a message, and as that is sent.
const STATES_MEMORY: u64 = 3;

impl Inner {
    /// Answers a call about sessions; with the memory of the reply, where that is large.
    pub(super) async fn manage(
        self: &Arc<Self>,
        request: ManageSessionRequest,
        under_way: &Unary,
    ) -> Result<(ManageSessionResponse, Option<Share>), Error> {
        let call = request.call.ok_or_else(|| Error::field("call", "is missing"))?;
        let session = match call {
            Call::Open(open) => self.open(open, request.capture, request.owner, under_way).await?,
            Call::Get(get) => self.sessions.get(&get.name)?,
            Call::States(states) => {
                let (states, share) = self.states(&states).await?;
                let reply = ManageSessionResponse { states: Some(states), ..Default::default() };
                return Ok((reply, Some(share)));
            }
            Call::Fork(fork) => {
                let session = self.sessions.get(&fork.name)?;
                let from = session.chosen(&[fork.from], [])?;
                let others = (0..session.slots()).filter(|s| !from.contains(s));
                let to = session.distinct(&fork.to, others)?;
                let _turn = session.begin_advance().await;
                from.into_iter().for_each(|from| session.fork(from, &to));
                session
            }
            Call::Reset(reset) => {
                let session = self.sessions.get(&reset.name)?;
                let slots = session.distinct(&reset.slots, 0..session.slots())?;
                let states = match reset.initial {
                    None => None,
                    Some(initial) => {
                        let warm = self.twins.get(session.setup.twin).await?;
                        let open = OpenSessionRequest {
                            twin: session.setup.twin.to_string(),
                            initial: Some(initial),
                            slots: slots.len() as u32,
                            ..session.setup.as_request()
                        };
                        let capture = session.setup.capture.clone();
                        Some(self.first_states(&warm, &open, &capture, under_way).await?)
                    }
                };
                let _turn = session.begin_advance().await;
                session.reset(&slots, states);
                session
            }
            Call::Correct(correct) => {
                let corrected = Some(self.correct(correct, under_way).await?);
                return Ok((ManageSessionResponse { corrected, ..Default::default() }, None));
            }
            Call::Render(render) => {
                let (rendered, share) = self.render(render, under_way).await?;
                let rendered = Some(rendered);
                let reply = ManageSessionResponse { rendered, ..Default::default() };
                return Ok((reply, Some(share)));
            }
            Call::Close(close) => {
                if let Ok(session) = self.sessions.get(&close.name) {
                    self.sessions.close(session.id);
                    self.status.changed();
                }
                return Ok((ManageSessionResponse::default(), None));
            }
        };
        let session = Some(session.describe(&self.worker));
        Ok((ManageSessionResponse { session, ..Default::default() }, None))
    }

    /// The states of slots, in memory that was taken before.
    async fn states(
        &self,
        request: &GetSessionStatesRequest,
    ) -> Result<(SessionStates, Share), Error> {
        let session = self.sessions.get(&request.name)?;
        let slots = session.distinct(&request.slots, 0..session.slots())?;
        let warm = self.twins.get(session.setup.twin).await?;
        let (twin, limits) = (shape(warm.twin(), true), self.limits());
        let grasps = session.setup.grasps.len() as u64;
        let bytes = rollout::states_bytes(slots.len() as u64, grasps, &twin, &limits)?;
        let advice = "the states: ask for fewer slots at once";
        let bytes = bytes.saturating_mul(STATES_MEMORY);
        let share = budget::take(&self.memory.rollouts, bytes, advice).await?;
        Ok((session_states(&session, &warm, &slots), share))
    }

    async fn open(
        self: &Arc<Self>,
        open: OpenSessionRequest,
        capture: String,
        owner: String,
        under_way: &Unary,
    ) -> Result<Arc<Session>, Error> {
        let twin = Error::parsed("twin", &open.twin)?;
        let idle = idle(open.idle_timeout_s)?;
        let warm = self.twins.get(twin).await?;
        let first = self.first_states(&warm, &open, &capture, under_way).await?;
        let bytes = first.iter().map(Start::bytes).sum::<u64>().saturating_mul(STATES);
        let share = budget::take(
            &self.memory.sessions,
            bytes,
            "the states of the session: close others, or open it with fewer slots",
        )
        .await?;
        let setup = Setup {
            twin,
            owner,
            capture,
            fidelity: match open.fidelity() {
                Fidelity::Unspecified | Fidelity::Exact => Fidelity::Exact,
                other @ (Fidelity::Fast | Fidelity::Planner) => other,
            },
            world: open.world,
            grasps: open.grasps,
            idle,
        };
        let mut session = Session::new(setup, first, Some(share));
        // So every server knows where to ask for it.
        if let Ok(worker) = self.worker.parse() {
            session.id = SessionId::generate_at(worker);
        }
        let session = self.sessions.add(session)?;
        self.status.changed();
        tracing::info!(session = %session.id, %twin, slots = session.slots(), "session opened");
        Ok(session)
    }

    /// The states in which slots begin, one each.
    pub(super) async fn first_states(
        self: &Arc<Self>,
        warm: &Arc<Warm>,
        open: &OpenSessionRequest,
        capture: &str,
        under_way: &Unary,
    ) -> Result<Vec<Start>, Error> {
        let limits = self.limits();
        rollout::check_session(open, &shape(warm.twin(), !capture.is_empty()), &limits)?;
        let slots = rollout::slots(open)? as usize;
        let (backend, cancel) = (Arc::new(under_way.backend(&self.device)), under_way.cancel());
        let (initial, world) = (open.initial.as_ref(), open.world.as_ref());
        let simulated = self.simulated(warm, initial, world, capture, &backend, cancel).await?;
        let wanted = Wanted::read(open.initial.clone(), &warm.twin().graph, slots)?;
        Ok(match (wanted, simulated) {
            (Wanted::Ready(Starts::Each(starts)), _) => starts,
            (Wanted::Ready(Starts::Shared(start)), _) | (Wanted::Simulation, Some(start)) => {
                vec![start; slots]
            }
            (Wanted::Simulation, None) => return Err(Error::field("initial", "has no state")),
        })
    }

    /// The state that a separate simulation leads to, if `initial` requires one in `world`.
    pub(super) async fn simulated(
        &self,
        warm: &Arc<Warm>,
        initial: Option<&InitialState>,
        world: Option<&World>,
        capture: &str,
        backend: &Arc<QueuedBackend>,
        cancel: &CancelToken,
    ) -> Result<Option<Start>, Error> {
        let work = self.limits().work;
        Ok(match StartSimulation::wanted(initial, capture)? {
            None => None,
            Some(StartSimulation::Frame(at)) => {
                Some(self.replays.start(warm, at, backend, cancel, work).await?)
            }
            Some(StartSimulation::Settled) => {
                let world = Still::read(world)?;
                Some(self.replays.settled(warm, world, backend, cancel, work).await?)
            }
        })
    }
}
