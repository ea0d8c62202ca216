//! Facts of a play beside its states, as JSON.

use std::sync::atomic::Ordering;

use bendtwin_proto::{
    json::{TensorFormat, Write},
    v1::World,
};
use serde::Serialize;
use tokio::time::Instant;

use super::Run;
use crate::{Error, goal::Progress, message::Factors, reply};

/// Frames that were simulated lately.
#[derive(Debug, Default)]
pub(super) struct Rate {
    since: Option<Instant>,
    frames: u32,
    compute_s: f64,
    /// Frames a second, and milliseconds that one took at the worker.
    last: (f64, f64),
}

impl Rate {
    pub(super) fn frame(&mut self, compute_s: f64) {
        self.frames += 1;
        self.compute_s += compute_s;
    }

    /// Over the time since it was asked for.
    fn measure(&mut self, now: Instant) -> (f64, f64) {
        let since = *self.since.get_or_insert(now);
        let elapsed = now.duration_since(since).as_secs_f64();
        if elapsed >= 0.5 {
            let frames = f64::from(self.frames);
            self.last = (frames / elapsed, 1000.0 * self.compute_s / frames.max(1.0));
            (self.since, self.frames, self.compute_s) = (Some(now), 0, 0.0);
        }
        self.last
    }
}

#[derive(Serialize)]
struct Facts<'a> {
    r#type: &'static str,
    state: u32,
    paused: bool,
    speed: f64,
    /// Frames simulated a second, and milliseconds of each at the worker.
    fps: f64,
    frame_ms: f64,
    /// Frames that it is behind, and those that were skipped since the start.
    behind: f64,
    skipped: u64,
    watchers: usize,
    /// Frames that are being recorded, and those of the recording that there is.
    recording: Option<usize>,
    recorded: Option<usize>,
    /// Frames of the replay until now, and all of them.
    replay: Option<[usize; 2]>,
    goal: Option<&'a Progress>,
    world: Write<'a, World>,
    vary: Factors,
}

impl Run {
    /// Sends changed facts.
    pub(super) fn tell(&mut self) {
        let now = Instant::now();
        let (fps, frame_ms) = self.rate.measure(now);
        let (own, vary) = self.scene.around();
        let replay = self.replay.as_ref();
        let shown = replay.and_then(|r| r.recording.segments[r.segment].template.world.as_ref());
        let world = Write { message: shown.unwrap_or(&own), tensors: TensorFormat::Base64 };
        if let Some(pursuit) = &mut self.pursuit {
            pursuit.see(&self.scene);
        }
        let stands = self.begins().is_none();
        let facts = Facts {
            r#type: "facts",
            state: self.number,
            paused: self.paused,
            speed: self.clock.speed(),
            fps: rounded(fps),
            frame_ms: rounded(frame_ms),
            behind: if stands { 0.0 } else { rounded(self.clock.behind(now)) },
            skipped: self.clock.skipped(),
            watchers: self.play.watchers.load(Ordering::SeqCst),
            recording: self.recording.as_ref().map(|r| r.frames()),
            recorded: self.play.recording().ok().map(|r| r.frames()),
            replay: replay.map(|r| [r.so_far(), r.recording.frames()]),
            goal: self.pursuit.as_ref().map(|p| &p.progress).or(self.goal.as_ref()),
            world,
            vary,
        };
        // Nothing in it fails to be written.
        let text = serde_json::to_string(&facts).unwrap_or_default();
        let _ = self.play.facts.send(text.into());
    }

    /// Answers that something is not done, and why.
    pub(super) fn refuse(&self, error: Error) {
        self.answer(reply::refused(self.host.problem(error)));
    }

    /// Says what happened.
    pub(super) fn notice(&self, event: &'static str, text: &str) {
        self.answer(reply::notice(event, text));
    }

    fn answer(&self, reply: String) {
        // One that does not read its answers does not play any more.
        if self.lines.replies.try_send(reply.into()).is_err() {
            self.play.over.cancel();
        }
    }
}

fn rounded(x: f64) -> f64 {
    (10.0 * x).round() / 10.0
}
