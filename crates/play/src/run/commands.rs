//! Requests of the browser that plays.

use bendtwin_proto::{
    json::Read,
    v1::{InitialState, ResetSessionRequest, initial_state::State},
};
use tokio::time::Instant;

use super::{FRAME_TIMEOUT, Run, session};
use crate::{
    Result,
    goal::{Pursuit, Stage},
    message::{Goal, Message},
    recording::Recording,
};

/// Most frames that wait while it is paused.
const MOST_STEPS: u32 = 1000;

impl Run {
    /// Executes a command; a wrong one is answered with its fault, and changes nothing.
    pub(super) async fn take_messages(&mut self) -> Result<()> {
        self.last_message = Instant::now();
        for message in self.lines.inbox.take() {
            if let Err(error) = self.take(message).await {
                match bendtwin_core::Problem::category(&error) {
                    bendtwin_core::Category::Unavailable | bendtwin_core::Category::Aborted => {
                        self.reopen(error).await?;
                    }
                    _ => self.refuse(error),
                }
            }
        }
        Ok(())
    }

    async fn take(&mut self, message: Message) -> Result<()> {
        match message {
            Message::Move { input, grippers, colliders } => {
                self.took(input);
                if !grippers.is_empty() {
                    self.end_pursuit(Some(Stage::Stopped));
                }
                return self.scene.aim(&grippers, &colliders);
            }
            Message::Grasp { input, gripper, node, radius_m, springs } => {
                self.took(input);
                self.end_pursuit(Some(Stage::Stopped));
                return self.scene.grasp(gripper, node, radius_m, springs);
            }
            Message::Release { input, gripper } => {
                self.took(input);
                self.end_pursuit(Some(Stage::Stopped));
                return self.scene.release(gripper);
            }
            Message::World { input, world: Read(world), vary } => {
                self.took(input);
                self.scene.surround(world, vary)?;
            }
            Message::Pause { paused } => {
                self.paused = paused;
                self.steps = 0;
                self.clock.restart(Instant::now());
            }
            Message::Step { frames } => {
                self.paused = true;
                self.steps = self.steps.saturating_add(frames.max(1)).min(MOST_STEPS);
                self.clock.restart(Instant::now());
            }
            Message::Speed { factor } => {
                self.clock.set_speed(factor);
                self.clock.restart(Instant::now());
            }
            Message::Reset {} => self.reset().await?,
            Message::Record { on: true } => {
                if self.replay.is_none() {
                    self.recording = Some(Recording::default());
                    self.scene.begin_segment();
                }
            }
            Message::Record { on: false } => self.end_recording(),
            Message::Replay {} => self.begin_replay().await?,
            Message::Goal(goal) => self.pursue(goal).await?,
            Message::Stop {} => {
                self.end_pursuit(Some(Stage::Stopped));
                if self.replay.is_some() {
                    self.end_replay().await?;
                }
            }
            Message::Seen { .. } => return Ok(()),
        }
        // Flags of a state that stands still change, too.
        self.show(None);
        self.tell();
        Ok(())
    }

    fn took(&mut self, input: u32) {
        self.clock.input(Instant::now());
        if input > 0 {
            self.input = input;
        }
    }

    /// Goes back to the first state.
    async fn reset(&mut self) -> Result<()> {
        self.end_pursuit(Some(Stage::Stopped));
        if self.replay.is_some() {
            self.end_replay().await?;
        }
        let (first, poses) = self.first.clone();
        let initial = Some(InitialState { state: Some(State::Given(first.clone())) });
        let name = self.session.clone();
        let reset = ResetSessionRequest { name, slots: Vec::new(), initial };
        self.host.reset_session(reset, FRAME_TIMEOUT).await?;
        self.scene.see(session::points(first.positions.as_ref())?);
        self.scene.begin_again(&poses);
        self.known = first;
        if let Some(recording) = &mut self.recording {
            recording.part();
        }
        self.number = self.number.wrapping_add(1);
        self.clock.restart(Instant::now());
        Ok(())
    }

    /// Ends the recording; it stays until the next one has ended.
    pub(super) fn end_recording(&mut self) {
        if let Some(recording) = self.recording.take().filter(|r| r.frames() > 0) {
            self.play.set_recording(recording);
        }
    }

    async fn pursue(&mut self, goal: Goal) -> Result<()> {
        if self.replay.is_some() {
            self.end_replay().await?;
        }
        self.end_pursuit(Some(Stage::Stopped));
        self.scene.stay();
        self.pursuit = Some(Pursuit::new(goal, &self.scene)?);
        self.paused = false;
        let asked = self.ask_for_a_plan().await;
        if asked.is_err() {
            self.end_pursuit(Some(Stage::Stopped));
        }
        asked
    }

    /// Asks for a plan from where it is; it stands still meanwhile.
    pub(super) async fn ask_for_a_plan(&mut self) -> Result<()> {
        let Some(pursuit) = &mut self.pursuit else { return Ok(()) };
        let seed = u64::from(self.number);
        let request = pursuit.request(&self.session, &self.scene, seed);
        self.plan = Some(self.host.plan(request, 3 * FRAME_TIMEOUT).await?);
        self.tell();
        Ok(())
    }

    /// Pursues a goal no more.
    pub(super) fn end_pursuit(&mut self, stage: Option<Stage>) {
        self.plan = None;
        let Some(mut pursuit) = self.pursuit.take() else { return };
        if let Some(stage) = stage {
            pursuit.progress.state = stage;
            self.scene.stay();
        }
        self.goal = Some(pursuit.progress);
        self.clock.restart(Instant::now());
        self.tell();
    }
}
