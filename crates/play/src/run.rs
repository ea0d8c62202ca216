//! A play under way: messages in, frame after frame in real time, states out.

mod commands;
mod facts;
mod session;

use std::{sync::Arc, time::Duration};

use bendtwin_core::{Category, Problem as _, ids::TwinId};
use bendtwin_proto::v1::{
    AdvanceSessionRequest, PlanUpdate, RollOutRequest, RollOutResponse, TwinGeometry,
    initial_state::GivenState,
};
use futures::StreamExt as _;
use tokio::{
    sync::mpsc,
    time::{Instant, Interval, MissedTickBehavior},
};
use tokio_util::sync::CancellationToken;

use self::{facts::Rate, session::NewPlay};
use crate::{
    Error, Host, Play, Result, Updates,
    clock::Clock,
    goal::{Progress, Pursuit, Stage},
    message::{Begin, Inbox},
    recording::Recording,
    reply,
    rows::{Pose, Rows},
    scene::Scene,
    shown::{Bodies, StateMessage},
};

/// Longest time for one frame.
const FRAME_TIMEOUT: Duration = Duration::from_secs(10);
/// Time between two messages with facts.
const FACTS_INTERVAL: Duration = Duration::from_secs(1);
/// Wait before a frame that found no memory is tried again.
const RETRY: Duration = Duration::from_millis(50);

/// A play under way.
pub(super) struct Run {
    host: Arc<dyn Host>,
    play: Arc<Play>,
    lines: Lines,
    stopping: CancellationToken,
    idle: Duration,
    last_message: Instant,
    /// The session at a worker.
    session: String,
    scene: Scene,
    clock: Clock,
    /// The state now, and the one that it began in, with the poses of grippers.
    known: GivenState,
    first: (GivenState, Vec<Pose>),
    /// Number of the last state that was shown, and of the last input that was taken in.
    number: u32,
    input: u32,
    paused: bool,
    /// Frames to simulate although it is paused.
    steps: u32,
    recording: Option<Recording>,
    replay: Option<Replay>,
    plan: Option<Updates>,
    pursuit: Option<Pursuit>,
    /// The last goal, once it is not pursued any more.
    goal: Option<Progress>,
    rate: Rate,
    tick: Interval,
}

/// Both directions of the talk with the browser that plays.
pub(super) struct Lines {
    pub(super) inbox: Arc<Inbox>,
    pub(super) replies: mpsc::Sender<Arc<str>>,
}

/// A frame that was simulated.
struct FrameResult<'a> {
    frame: &'a Rows,
    reply: &'a RollOutResponse,
    /// The gripper of each grasp.
    gripper_of_grasp: Vec<u32>,
}

/// A recording that is shown again.
struct Replay {
    recording: Arc<Recording>,
    segment: usize,
    frame: usize,
}

impl Run {
    /// Opens a session for a play.
    pub(super) async fn open(
        host: Arc<dyn Host>,
        twin: TwinId,
        geometry: &TwinGeometry,
        begin: Begin,
        lines: Lines,
        stopping: CancellationToken,
        idle: Duration,
    ) -> Result<Self> {
        let NewPlay { play, session, scene, first } =
            session::open(&*host, twin, geometry, begin).await?;
        let now = Instant::now();
        let mut tick = tokio::time::interval(FACTS_INTERVAL);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let poses = scene.poses();
        let run = Self {
            clock: Clock::new(play.frame_s, now),
            host,
            play,
            lines,
            stopping,
            idle,
            last_message: now,
            session,
            scene,
            known: first.clone(),
            first: (first, poses),
            number: 0,
            input: 0,
            paused: false,
            steps: 0,
            recording: None,
            replay: None,
            plan: None,
            pursuit: None,
            goal: None,
            rate: Rate::default(),
            tick,
        };
        Ok(run)
    }

    pub(super) fn play(&self) -> &Arc<Play> {
        &self.play
    }

    /// Plays until the last player has left.
    pub(super) async fn play_out(mut self) {
        self.show(None);
        let ended = self.go_on().await;
        let problem = ended.err().map(|error| self.host.problem(error));
        let _ = self.play.farewell.send(Some(reply::ended(problem).into()));
        self.play.over.cancel();
        // Ends its search, which nobody waits for, and not only once the session is closed.
        self.plan = None;
        // The session ends by itself otherwise.
        let _ = self.host.close_session(self.session, FRAME_TIMEOUT).await;
    }

    async fn go_on(&mut self) -> Result<()> {
        let (over, stopping) = (self.play.over.clone(), self.stopping.clone());
        loop {
            let begins = self.begins();
            let idle_end = self.last_message + self.idle;
            tokio::select! {
                biased;
                () = over.cancelled() => return Ok(()),
                () = stopping.cancelled() => return Err(Error::Stopping),
                () = self.lines.inbox.came() => Box::pin(self.take_messages()).await?,
                update = next(&mut self.plan), if self.plan.is_some() => Box::pin(self.planned(update)).await?,
                _ = self.tick.tick() => self.tell(),
                () = tokio::time::sleep_until(begins.unwrap_or(idle_end)), if begins.is_some() => {
                    tokio::select! {
                        biased;
                        () = over.cancelled() => return Ok(()),
                        stepped = Box::pin(self.step()) => stepped?,
                    }
                }
                () = tokio::time::sleep_until(idle_end) => return Err(Error::Idle(self.idle)),
            }
        }
    }

    /// Time at which the next frame begins, if there is to be one.
    fn begins(&self) -> Option<Instant> {
        let stands = self.paused && self.steps == 0 || self.plan.is_some();
        (!stands).then(|| self.clock.begins())
    }

    /// Simulates a frame.
    async fn step(&mut self) -> Result<()> {
        let (request, frame) = match &self.replay {
            Some(Replay { recording, segment, frame }) => {
                recording.segments[*segment].frame(*frame)
            }
            None => {
                let frame = self.scene.next();
                (frame.request(&self.scene.template(), 0..2), frame)
            }
        };
        self.clock.begun();
        match self.advance(request).await {
            Ok(reply) if !reply.diverged.is_empty() => self.diverged().await,
            Ok(reply) => self.passed(&frame, reply).await,
            Err(error) => self.failed(error).await,
        }
    }

    async fn advance(&mut self, request: RollOutRequest) -> Result<RollOutResponse> {
        let name = self.session.clone();
        let advance = AdvanceSessionRequest { name, slots: Vec::new(), rollout: Some(request) };
        self.host.advance_session(advance, FRAME_TIMEOUT).await
    }

    /// Takes in a frame that was simulated.
    async fn passed(&mut self, frame: &Rows, reply: RollOutResponse) -> Result<()> {
        self.steps = self.steps.saturating_sub(1);
        if self.replay.is_none() {
            self.record(frame);
        }
        let state = session::state(&reply);
        self.scene.see(session::points(state.positions.as_ref())?);
        self.known = state;
        self.number = self.number.wrapping_add(1);
        if self.replay.is_some() {
            self.scene.place(frame, 1);
        } else {
            self.scene.passed(frame);
        }
        let gripper_of_grasp = match &self.replay {
            Some(replay) => replay.recording.segments[replay.segment].gripper_of_grasp(),
            None => self.scene.gripper_of_grasp(),
        };
        self.show(Some(&FrameResult { frame, reply: &reply, gripper_of_grasp }));
        self.rate.frame(reply.timing.map_or(0.0, |timing| timing.compute_s));
        self.clock.stepped(Instant::now());
        if self.replay.is_some() {
            return self.next_of_replay().await;
        }
        if let Some(pursuit) = self.pursuit.as_mut().filter(|_| !self.scene.follows()) {
            if pursuit.continues(&self.scene) {
                return self.ask_for_a_plan().await;
            }
            self.end_pursuit(None);
        }
        Ok(())
    }

    fn record(&mut self, frame: &Rows) {
        let Some(recording) = &mut self.recording else { return };
        let segments = recording.segments.len();
        let (generation, template) = (self.scene.generation(), self.scene.template());
        if !recording.push(frame, generation, &self.known, template) {
            self.end_recording();
            self.notice("recording_full", "the recording is full: it ended here");
        } else if recording.segments.len() > segments {
            self.scene.begin_segment();
        }
    }

    /// The motion tore the simulation apart, and nothing has changed.
    async fn diverged(&mut self) -> Result<()> {
        self.paused = true;
        self.steps = 0;
        self.scene.stay();
        self.end_pursuit(Some(Stage::Stopped));
        self.clock.stepped(Instant::now());
        self.notice(
            "diverged",
            "the simulation diverged and is paused where it was: soften what was changed, continue \
             more slowly, or reset",
        );
        if self.replay.is_some() {
            self.end_replay().await?;
        }
        self.tell();
        Ok(())
    }

    /// A frame was not simulated.
    async fn failed(&mut self, error: Error) -> Result<()> {
        let fault = error.fault();
        match fault.category {
            Category::Unavailable | Category::Aborted if !matches!(error, Error::Stopping) => {
                self.reopen(error).await
            }
            Category::ResourceExhausted | Category::DeadlineExceeded => {
                tokio::time::sleep(error.retry_after().unwrap_or(RETRY).min(RETRY * 10)).await;
                self.clock.stepped(Instant::now());
                Ok(())
            }
            Category::InvalidArgument | Category::FailedPrecondition => {
                if self.replay.is_some() {
                    self.refuse(error);
                    return self.end_replay().await;
                }
                if !self.scene.revert() {
                    self.paused = true;
                    self.scene.stay();
                }
                self.refuse(error);
                self.tell();
                Ok(())
            }
            _ => Err(error),
        }
    }

    /// Shows where everything is.
    fn show(&mut self, simulated: Option<&FrameResult<'_>>) {
        let moved = match simulated {
            Some(simulated) => simulated.moved(),
            None => Bodies {
                grippers: self.scene.poses(),
                colliders: self.scene.collider_poses(),
                holding: self.scene.holding(),
                ..Bodies::default()
            },
        };
        let shown = StateMessage {
            flags: self.flags(),
            number: self.number,
            input: self.input,
            moved: &moved,
            positions: self.scene.positions(),
        };
        let _ = self.play.states.send(shown.encode());
    }

    fn flags(&self) -> u8 {
        u8::from(self.paused)
            | u8::from(self.recording.is_some()) << 1
            | u8::from(self.replay.is_some()) << 2
            | u8::from(self.pursuit.is_some()) << 3
    }

    /// Takes in news of the plan.
    async fn planned(&mut self, update: Option<Result<PlanUpdate>>) -> Result<()> {
        let Some(pursuit) = &mut self.pursuit else {
            self.plan = None;
            return Ok(());
        };
        match update {
            Some(Ok(update)) => {
                pursuit.learn(&update);
                if update.last {
                    let path = pursuit.path(&update)?;
                    self.scene.follow(path);
                    self.plan = None;
                    self.clock.restart(Instant::now());
                }
            }
            None => self.end_pursuit(Some(Stage::NotReached)),
            Some(Err(error)) => {
                self.end_pursuit(Some(Stage::Stopped));
                if matches!(error.category(), Category::Unavailable | Category::Aborted) {
                    return self.reopen(error).await;
                }
                self.refuse(error);
            }
        }
        self.tell();
        Ok(())
    }
}

impl FrameResult<'_> {
    /// Everything that moves, at the end of the frame.
    fn moved(&self) -> Bodies {
        let count = self.frame.grippers(1).len();
        let (mut forces, mut holding) = (vec![[0.0f32; 3]; count], vec![false; count]);
        let wrenches = session::wrenches(self.reply);
        for (e, gripper) in self.gripper_of_grasp.iter().enumerate() {
            let g = *gripper as usize;
            if let (Some(sum), Some(wrench)) = (forces.get_mut(g), wrenches.get(e)) {
                (0..3).for_each(|i| sum[i] += wrench[i]);
            }
            if let Some(holds) = holding.get_mut(g) {
                *holds |= self.frame.closed(0).get(e) == Some(&1);
            }
        }
        Bodies {
            grippers: self.frame.grippers(1).to_vec(),
            forces,
            holding,
            colliders: self.frame.colliders(1).to_vec(),
            strain: self.reply.diagnostics.first().map_or(0.0, |d| d.max_strain),
        }
    }
}

/// The next update of a plan.
async fn next(plan: &mut Option<Updates>) -> Option<Result<PlanUpdate>> {
    match plan {
        Some(plan) => plan.next().await,
        None => std::future::pending().await,
    }
}
