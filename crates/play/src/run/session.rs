//! The session of a play: how it begins, how it resumes when its worker is lost, and how a
//! recording is replayed, each segment in a separate session.

use std::{
    sync::{Arc, Mutex, atomic::AtomicUsize},
    time::Duration,
};

use bendtwin_core::ids::{PlayId, TwinId};
use bendtwin_proto::v1::{
    Fidelity, Grasp, InitialState, OpenSessionRequest, RollOutResponse, Tensor, TwinGeometry,
    grasp::Region,
    initial_state::{GivenState, State},
    roll_out_request::Actions,
};
use bytes::Bytes;
use serde_json::json;
use tokio::{sync::watch, time::Instant};
use tokio_util::sync::CancellationToken;

use super::{Replay, Run};
use crate::{
    Error, Host, Play, Result,
    goal::Stage,
    message::Begin,
    recording::Recording,
    scene::{MOST_COLLIDERS, SPEED_LIMIT_M_S, Scene, Setting},
};

/// Time for a first state.
const OPEN_TIMEOUT: Duration = Duration::from_secs(60);
/// Time in which another worker has to be found.
const REOPEN_TIMEOUT: Duration = Duration::from_secs(60);
const REOPEN_INTERVAL: Duration = Duration::from_millis(200);
/// A session ends when its play is gone for so long [s].
const SESSION_IDLE_S: f64 = 900.0;

/// A play that can begin.
pub(super) struct NewPlay {
    pub(super) play: Arc<Play>,
    pub(super) session: String,
    pub(super) scene: Scene,
    pub(super) first: GivenState,
}

/// Opens a session for a play of a twin.
pub(super) async fn open(
    host: &dyn Host,
    twin: TwinId,
    geometry: &TwinGeometry,
    begin: Begin,
) -> Result<NewPlay> {
    let hands = match geometry.hands.as_ref().filter(|hands| !hands.is_absent()) {
        None => Vec::new(),
        Some(hands) => sound(hands.unpack::<u32>("hands"))?.1,
    };
    let frame_s = geometry.fps.recip();
    let fidelity = if begin.fast { Fidelity::Fast } else { Fidelity::Exact };
    let setting = |controls: Vec<[f32; 3]>, positions: Vec<[f32; 3]>| Setting {
        frame_s,
        hands: hands.clone(),
        controls,
        positions,
        fidelity,
    };
    // The list of grasps is known before the state is.
    let mut scene = Scene::new(setting(
        points(geometry.controls.as_ref())?,
        points(geometry.rest_positions.as_ref())?,
    ))?;
    let world = begin.world.map(|world| world.0).unwrap_or_default();
    scene.surround(world.clone(), begin.vary)?;
    let initial = begin.initial.map(|initial| initial.0);
    let open = request(twin, initial, scene.template().grasps, fidelity, &scene);
    let session = host.open_session(open, OPEN_TIMEOUT).await?;
    let first = host.session_state(session.clone(), OPEN_TIMEOUT).await?;
    let mut scene =
        Scene::new(setting(points(first.controls.as_ref())?, points(first.positions.as_ref())?))?;
    scene.surround(world, begin.vary)?;
    for hand in begin.dropped {
        scene.release(hand)?;
    }
    // A state of a session says nothing of grasps until its first frame.
    let first = GivenState { grasping: None, ..first };
    let owner = host.owner().to_owned();
    let play = Arc::new(play(twin, owner, frame_s, geometry, &scene, &first)?);
    Ok(NewPlay { play, session, scene, first })
}

fn play(
    twin: TwinId,
    owner: String,
    frame_s: f64,
    geometry: &TwinGeometry,
    scene: &Scene,
    first: &GivenState,
) -> Result<Play> {
    let id = PlayId::generate();
    let (hands, uuid) = (scene.hand_count(), id.uuid());
    let grippers = scene.poses().into_iter().enumerate();
    let grippers: Vec<_> =
        grippers.map(|(g, pose)| json!({"hand": (g < hands).then_some(g), "pose": pose})).collect();
    let ready = json!({
        "type": "ready",
        "play": id.to_string(),
        "twin": twin.to_string(),
        "fps": frame_s.recip(),
        "nodes": scene.positions().len(),
        "grippers": grippers,
        "controls": points(first.controls.as_ref())?,
        "hands": scene.gripper_of_control(),
        "mass_kg": geometry.mass_kg,
        "most_colliders": MOST_COLLIDERS,
        "speed_limit_m_s": SPEED_LIMIT_M_S,
        "watch": format!("/v1/plays/{uuid}/watch"),
        "recording": format!("/v1/plays/{uuid}/recording"),
    });
    Ok(Play {
        id,
        twin,
        owner,
        frame_s,
        ready: ready.to_string(),
        states: watch::Sender::new(Bytes::new()),
        facts: watch::Sender::new(Arc::from("")),
        watchers: AtomicUsize::new(0),
        recording: Mutex::new(None),
        over: CancellationToken::new(),
        farewell: watch::Sender::new(None),
    })
}

fn request(
    twin: TwinId,
    initial: Option<InitialState>,
    grasps: Vec<Grasp>,
    fidelity: Fidelity,
    scene: &Scene,
) -> OpenSessionRequest {
    OpenSessionRequest {
        twin: twin.to_string(),
        initial,
        slots: 1,
        // What a state that comes to rest lies on.
        world: Some(scene.around().0),
        grasps,
        fidelity: fidelity.into(),
        idle_timeout_s: SESSION_IDLE_S,
    }
}

/// The state at the end of a reply.
pub(super) fn state(reply: &RollOutResponse) -> GivenState {
    GivenState {
        positions: reply.final_positions.clone(),
        velocities: reply.final_velocities.clone(),
        twists: reply.final_twists.clone(),
        controls: reply.final_controls.clone(),
        commanded_controls: reply.final_commanded_controls.clone(),
        grasping: reply.final_grasping.clone(),
    }
}

/// Points of a worker's message [m].
pub(super) fn points(tensor: Option<&Tensor>) -> Result<Vec<[f32; 3]>> {
    match tensor.filter(|tensor| !tensor.is_absent()) {
        None => Ok(Vec::new()),
        Some(tensor) => Ok(sound(tensor.unpack_points("points"))?.1),
    }
}

fn sound<T>(read: Result<T, bendtwin_proto::tensor::TensorError>) -> Result<T> {
    read.map_err(|e| Error::Unreadable(format!("a state of a play: {e}")))
}

/// Force and torque of each grasp on the object, shape [E, 6].
pub(super) fn wrenches(reply: &RollOutResponse) -> Vec<[f32; 6]> {
    let grasps = reply.forces.as_ref().and_then(|forces| forces.grasps.as_ref());
    let read = grasps.and_then(|tensor| tensor.unpack::<f32>("forces").ok());
    read.map_or_else(Vec::new, |(_, values)| values.as_chunks::<6>().0.to_vec())
}

impl Run {
    /// Resumes from the last state at another worker, or the same one.
    pub(super) async fn reopen(&mut self, error: Error) -> Result<()> {
        tracing::warn!(play = %self.play.id, %error, "the session of a play is lost");
        self.notice("reopening", "the worker was lost: looking for another one");
        self.leave_replay();
        self.end_pursuit(Some(Stage::Stopped));
        let given_up = Instant::now() + REOPEN_TIMEOUT;
        let (over, stopping) = (self.play.over.clone(), self.stopping.clone());
        let mut error = error;
        while Instant::now() < given_up {
            tokio::select! {
                () = over.cancelled() => return Ok(()),
                () = stopping.cancelled() => return Err(Error::Stopping),
                opened = self.open_from(self.known.clone()) => match opened {
                    Ok(()) => {
                        let text = format!("it resumes at state {}", self.number);
                        self.notice("reopened", &text);
                        self.clock.restart(Instant::now());
                        self.show(None);
                        self.tell();
                        return Ok(());
                    }
                    Err(again) => error = again,
                },
            }
            tokio::select! {
                () = over.cancelled() => return Ok(()),
                () = tokio::time::sleep(REOPEN_INTERVAL) => {}
            }
        }
        Err(error)
    }

    /// Opens a session in a state, in the place of the one that there is.
    async fn open_from(&mut self, state: GivenState) -> Result<()> {
        let template = self.scene.template();
        let fidelity = template.fidelity();
        let initial = Some(InitialState { state: Some(State::Given(state)) });
        let open = request(self.play.twin, initial, template.grasps, fidelity, &self.scene);
        self.switch(open).await
    }

    async fn switch(&mut self, open: OpenSessionRequest) -> Result<()> {
        let session = self.host.open_session(open, OPEN_TIMEOUT).await?;
        let before = std::mem::replace(&mut self.session, session);
        // If it is lost it needs no end.
        let _ = self.host.close_session(before, OPEN_TIMEOUT).await;
        Ok(())
    }

    /// Shows the recording again.
    pub(super) async fn begin_replay(&mut self) -> Result<()> {
        self.end_recording();
        self.end_pursuit(Some(Stage::Stopped));
        let recording = self.play.recording()?;
        self.fits(&recording)?;
        self.replay = Some(Replay { recording, segment: 0, frame: 0 });
        self.paused = false;
        let begun = self.begin_segment().await;
        if begun.is_err() {
            self.replay = None;
        }
        begun
    }

    /// Refuses a recording with other grippers than this play's.
    fn fits(&self, recording: &Recording) -> Result<()> {
        let own = self.scene.template();
        let map = |actions: &Option<Actions>| match actions {
            Some(Actions::Poses(poses)) => poses.gripper_of_control.clone(),
            _ => None,
        };
        let hands = self.scene.hand_count();
        let fits = recording.segments.iter().all(|segment| {
            let grasps = &segment.template.grasps;
            let is_hand = |grasp: &Grasp| matches!(grasp.region, Some(Region::Hand(_)));
            segment.rows.widths[0] == self.scene.holding().len()
                && map(&segment.template.actions) == map(&own.actions)
                && grasps.len() >= hands
                && grasps.iter().take(hands).all(is_hand)
        });
        if fits {
            Ok(())
        } else {
            Err(Error::invalid("segments", "have other grippers than this play"))
        }
    }

    /// Opens a session in the state in which a segment of the replay begins.
    async fn begin_segment(&mut self) -> Result<()> {
        let Some(Replay { recording, segment, .. }) = &self.replay else { return Ok(()) };
        let segment = &recording.segments[*segment];
        let template = &segment.template;
        let open = OpenSessionRequest {
            twin: self.play.twin.to_string(),
            initial: segment.initial(),
            slots: 1,
            world: None,
            grasps: template.grasps.clone(),
            fidelity: template.fidelity,
            idle_timeout_s: SESSION_IDLE_S,
        };
        self.switch(open).await?;
        self.clock.restart(Instant::now());
        self.tell();
        Ok(())
    }

    /// Goes to the next frame of the replay, or to its end.
    pub(super) async fn next_of_replay(&mut self) -> Result<()> {
        let Some(replay) = &mut self.replay else { return Ok(()) };
        replay.frame += 1;
        let frames = replay.recording.segments[replay.segment].rows.len().saturating_sub(1);
        if replay.frame < frames {
            return Ok(());
        }
        if replay.segment + 1 < replay.recording.segments.len() {
            (replay.segment, replay.frame) = (replay.segment + 1, 0);
            return match self.begin_segment().await {
                Err(error) => self.failed(error).await,
                begun => begun,
            };
        }
        self.end_replay().await?;
        self.notice("replayed", "the replay has ended: the play continues from here");
        Ok(())
    }

    /// Lets the play continue from the state of the replay, with only hands holding the object.
    pub(super) async fn end_replay(&mut self) -> Result<()> {
        self.leave_replay();
        if let Err(error) = self.open_from(self.known.clone()).await {
            return Box::pin(self.reopen(error)).await;
        }
        self.clock.restart(Instant::now());
        self.tell();
        Ok(())
    }
}

impl Run {
    /// Releases what the replay held, since its list of grasps is different.
    fn leave_replay(&mut self) {
        let Some(replay) = self.replay.take() else { return };
        let rows = &replay.recording.segments[replay.segment].rows;
        let last = replay.frame.min(rows.len().saturating_sub(1));
        self.scene.hold_as(rows.closed(last));
        self.scene.stay();
        self.known.grasping = None;
    }
}

impl Replay {
    /// Frames that were shown.
    pub(super) fn so_far(&self) -> usize {
        let before = &self.recording.segments[..self.segment];
        let frames: usize = before.iter().map(|s| s.rows.len().saturating_sub(1)).sum();
        frames + self.frame
    }
}
