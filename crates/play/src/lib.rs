//! Plays: simulations in real time that a person moves with a mouse. One browser plays, others may
//! watch; the server advances a session at a worker frame by frame, as fast as time passes, and sends
//! what is seen. Nothing grows with time or with slow readers: of states and facts the newest is kept,
//! inputs wait in a bounded line, and a recording has a bound. `http/plays.rs` has the sockets.

mod clock;
mod goal;
mod message;
mod recording;
mod rows;
mod run;
mod scene;
mod shown;

use std::{
    collections::HashMap,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use bendtwin_core::ids::{PlayId, TwinId};
use bytes::Bytes;
use tokio::sync::{mpsc, watch};
use tokio_util::{sync::CancellationToken, task::TaskTracker};

use self::run::Run;
pub(crate) use self::{
    message::{Begin, Inbox, Message, read},
    recording::{Document, Recording},
};
use crate::{
    app::App,
    context::Context,
    error::{Error, Result},
    options::Limits,
};

/// Replies to the browser that plays, which wait for it to read.
const REPLIES: usize = 64;

/// The plays of a server. Clones share them.
#[derive(Clone, Debug)]
pub(crate) struct Plays {
    limits: Bounds,
    under_way: Arc<Mutex<HashMap<PlayId, Arc<Play>>>>,
    tasks: TaskTracker,
}

/// Bounds of plays.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    plays: usize,
    watchers: usize,
    idle: Duration,
}

/// A play under way.
#[derive(Debug)]
pub(crate) struct Play {
    pub(crate) id: PlayId,
    pub(crate) twin: TwinId,
    frame_s: f64,
    /// The first message to a browser.
    ready: String,
    /// The newest state.
    states: watch::Sender<Bytes>,
    /// Facts beside the states, as a message.
    facts: watch::Sender<Arc<str>>,
    watchers: AtomicUsize,
    recording: Mutex<Option<Arc<Recording>>>,
    /// Cancelled when the play has no more players.
    over: CancellationToken,
    /// The last message, once it has ended.
    farewell: watch::Sender<Option<Arc<str>>>,
}

/// The side of the browser that plays. Dropping it ends the play.
pub(crate) struct Player {
    pub(crate) play: Arc<Play>,
    pub(crate) inbox: Arc<Inbox>,
    /// Answers to what it said.
    pub(crate) replies: mpsc::Receiver<Arc<str>>,
    plays: Plays,
}

/// The states and facts of a play.
pub(crate) struct View {
    pub(crate) play: Arc<Play>,
    pub(crate) states: watch::Receiver<Bytes>,
    pub(crate) facts: watch::Receiver<Arc<str>>,
    pub(crate) farewell: watch::Receiver<Option<Arc<str>>>,
    is_watcher: bool,
}

impl Plays {
    pub(crate) fn new(limits: &Limits) -> Self {
        let limits = Bounds {
            plays: limits.plays,
            watchers: limits.play_watchers,
            idle: Duration::from_secs_f64(limits.play_idle_s),
        };
        Self { limits, under_way: Arc::default(), tasks: TaskTracker::new() }
    }

    /// Begins a play of a twin.
    pub(crate) async fn begin(&self, app: &App, twin: TwinId, begin: Begin) -> Result<Player> {
        let full = Error::PlayFull {
            what: "plays are under way",
            most: self.limits.plays,
            option: "limits.plays",
        };
        if self.lock().len() >= self.limits.plays {
            return Err(full);
        }
        let (replies, receiver) = mpsc::channel(REPLIES);
        let inbox = Arc::new(Inbox::default());
        let run =
            Run::open(app, twin, begin, Arc::clone(&inbox), replies, self.limits.idle).await?;
        let play = Arc::clone(run.play());
        {
            let mut under_way = self.lock();
            if under_way.len() >= self.limits.plays {
                // Others were as quick: the session ends by itself.
                return Err(full);
            }
            under_way.insert(play.id, Arc::clone(&play));
        }
        let plays = self.clone();
        let id = play.id;
        self.tasks.spawn(Context::current().scope(async move {
            run.play_out().await;
            plays.lock().remove(&id);
        }));
        Ok(Player { play, inbox, replies: receiver, plays: self.clone() })
    }

    /// A play that is under way.
    pub(crate) fn get(&self, id: PlayId) -> Result<Arc<Play>> {
        self.lock().get(&id).cloned().ok_or_else(|| Error::PlayEnded(id.to_string()))
    }

    /// The view of one that only watches.
    pub(crate) fn watch(&self, id: PlayId) -> Result<View> {
        let play = self.get(id)?;
        if play.watchers.fetch_add(1, Ordering::SeqCst) >= self.limits.watchers {
            play.watchers.fetch_sub(1, Ordering::SeqCst);
            return Err(Error::PlayFull {
                what: "watch this play",
                most: self.limits.watchers,
                option: "limits.play_watchers",
            });
        }
        Ok(View::of(play, true))
    }

    /// Waits until all of them have ended, which they do when the server stops.
    pub(crate) async fn ended(&self) {
        self.tasks.close();
        self.tasks.wait().await;
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<PlayId, Arc<Play>>> {
        self.under_way.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Play {
    /// The first message to a browser.
    pub(crate) fn ready(&self) -> &str {
        &self.ready
    }

    /// Seconds from frame to frame.
    pub(crate) fn frame_s(&self) -> f64 {
        self.frame_s
    }

    /// The last recording.
    pub(crate) fn recording(&self) -> Result<Arc<Recording>> {
        let recording = self.recording.lock().unwrap_or_else(PoisonError::into_inner);
        recording.clone().ok_or(Error::NothingRecorded)
    }

    /// Puts a recording in the place of what was recorded last.
    pub(crate) fn set_recording(&self, recording: Recording) {
        let recording = Some(Arc::new(recording));
        *self.recording.lock().unwrap_or_else(PoisonError::into_inner) = recording;
    }
}

impl Player {
    /// States and facts of the play.
    pub(crate) fn view(&self) -> View {
        View::of(Arc::clone(&self.play), false)
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.play.over.cancel();
        self.plays.lock().remove(&self.play.id);
    }
}

impl View {
    fn of(play: Arc<Play>, is_watcher: bool) -> Self {
        let (states, facts) = (play.states.subscribe(), play.facts.subscribe());
        let farewell = play.farewell.subscribe();
        Self { play, states, facts, farewell, is_watcher }
    }
}

impl Drop for View {
    fn drop(&mut self) {
        if self.is_watcher {
            self.play.watchers.fetch_sub(1, Ordering::SeqCst);
        }
    }
}
