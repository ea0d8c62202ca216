//! Plays: simulations in real time that a person moves with a mouse. One browser plays, others may
//! watch; a session is advanced frame by frame, as fast as time passes, and the newest state is shown.
//! Nothing grows with time or with slow readers: of states and facts the newest is kept, inputs wait
//! in a bounded line, and a recording has a bound.
//!
//! [`Host`] is all that a play asks of the server that it runs in; sockets and documents of errors
//! are the server's.

mod clock;
mod error;
mod goal;
mod host;
mod message;
mod recording;
mod reply;
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
use bendtwin_proto::v1::TwinGeometry;
use bytes::Bytes;
use tokio::sync::{mpsc, watch};
use tokio_util::{sync::CancellationToken, task::TaskTracker};

use self::run::{Lines, Run};
pub use self::{
    error::{Error, Result},
    host::{Host, Updates},
    message::{Begin, BeginType, Factors, Goal, GoalTarget, Inbox, Message, Target, read},
    recording::{Document, Recording},
    reply::{ended, refused},
};

/// Replies to the browser that plays, which wait for it to read.
const REPLIES: usize = 64;

/// The plays of a host. Clones share them.
#[derive(Clone, Debug)]
pub struct Plays {
    limits: Limits,
    stopping: CancellationToken,
    under_way: Arc<Mutex<HashMap<PlayId, Arc<Play>>>>,
    tasks: TaskTracker,
}

/// Limits of plays.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Plays under way.
    pub plays: usize,
    /// Watchers of a play.
    pub watchers: usize,
    /// Time without a message of the player after which a play ends.
    pub idle: Duration,
}

/// A play under way.
#[derive(Debug)]
pub struct Play {
    id: PlayId,
    twin: TwinId,
    owner: String,
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
#[derive(Debug)]
pub struct Player {
    play: Arc<Play>,
    /// Messages to the play.
    pub inbox: Arc<Inbox>,
    /// Answers to its messages.
    pub replies: mpsc::Receiver<Arc<str>>,
    plays: Plays,
}

/// The states and facts of a play.
#[derive(Debug)]
pub struct View {
    play: Arc<Play>,
    /// The newest state, as a binary message.
    pub states: watch::Receiver<Bytes>,
    /// The newest facts, as a text.
    pub facts: watch::Receiver<Arc<str>>,
    /// The last message, once the play has ended.
    pub farewell: watch::Receiver<Option<Arc<str>>>,
    is_watcher: bool,
}

impl Plays {
    /// No plays yet. All of them end once `stopping` is cancelled.
    pub fn new(limits: Limits, stopping: CancellationToken) -> Self {
        Self { limits, stopping, under_way: Arc::default(), tasks: TaskTracker::new() }
    }

    /// Refuses a play beyond the limit. [`Plays::begin`] does so, too; this is for a caller that has
    /// to read the twin first.
    ///
    /// # Errors
    /// [`Error::Full`].
    pub fn require_room(&self) -> Result<()> {
        self.room_in(&self.lock())
    }

    /// Number of plays in progress.
    pub fn count(&self) -> usize {
        self.lock().len()
    }

    fn room_in(&self, under_way: &HashMap<PlayId, Arc<Play>>) -> Result<()> {
        if under_way.len() < self.limits.plays {
            return Ok(());
        }
        Err(Error::Full {
            what: "plays are under way",
            most: self.limits.plays,
            option: "limits.plays",
        })
    }

    /// Begins a play of a twin with this geometry.
    ///
    /// # Errors
    /// If there are too many plays, the beginning is not valid, or the host opens no session.
    pub async fn begin(
        &self,
        host: Arc<dyn Host>,
        twin: TwinId,
        geometry: &TwinGeometry,
        begin: Begin,
    ) -> Result<Player> {
        self.require_room()?;
        let (replies, receiver) = mpsc::channel(REPLIES);
        let inbox = Arc::new(Inbox::default());
        let lines = Lines { inbox: Arc::clone(&inbox), replies };
        let (stopping, idle) = (self.stopping.clone(), self.limits.idle);
        let run = Run::open(host, twin, geometry, begin, lines, stopping, idle).await?;
        let play = Arc::clone(run.play());
        {
            let mut under_way = self.lock();
            // Others may have been as quick: the session ends by itself.
            self.room_in(&under_way)?;
            under_way.insert(play.id, Arc::clone(&play));
        }
        let plays = self.clone();
        let id = play.id;
        self.tasks.spawn(async move {
            run.play_out().await;
            plays.lock().remove(&id);
        });
        Ok(Player { play, inbox, replies: receiver, plays: self.clone() })
    }

    /// A play that is under way.
    ///
    /// # Errors
    /// [`Error::Ended`].
    pub fn get(&self, id: PlayId) -> Result<Arc<Play>> {
        self.lock().get(&id).cloned().ok_or_else(|| Error::Ended(id.to_string()))
    }

    /// The view of a watcher.
    ///
    /// # Errors
    /// [`Error::Ended`], [`Error::Full`].
    pub fn watch(&self, id: PlayId) -> Result<View> {
        let play = self.get(id)?;
        if play.watchers.fetch_add(1, Ordering::SeqCst) >= self.limits.watchers {
            play.watchers.fetch_sub(1, Ordering::SeqCst);
            return Err(Error::Full {
                what: "watch this play",
                most: self.limits.watchers,
                option: "limits.play_watchers",
            });
        }
        Ok(View::of(play, true))
    }

    /// Waits until all of them have ended, which they do when the host stops.
    pub async fn ended(&self) {
        self.tasks.close();
        self.tasks.wait().await;
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<PlayId, Arc<Play>>> {
        self.under_way.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Play {
    /// The twin that is played with.
    pub fn twin(&self) -> TwinId {
        self.twin
    }

    /// Owner of the key of the client that began it; empty if it is not known.
    pub fn owner(&self) -> &str {
        &self.owner
    }

    /// Seconds from frame to frame.
    pub fn frame_s(&self) -> f64 {
        self.frame_s
    }

    /// The last recording.
    ///
    /// # Errors
    /// [`Error::NothingRecorded`].
    pub fn recording(&self) -> Result<Arc<Recording>> {
        let recording = self.recording.lock().unwrap_or_else(PoisonError::into_inner);
        recording.clone().ok_or(Error::NothingRecorded)
    }

    /// Puts a recording in the place of what was recorded last.
    pub fn set_recording(&self, recording: Recording) {
        let recording = Some(Arc::new(recording));
        *self.recording.lock().unwrap_or_else(PoisonError::into_inner) = recording;
    }
}

impl Player {
    /// States and facts of the play.
    pub fn view(&self) -> View {
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
    /// The first message to a browser.
    pub fn ready(&self) -> &str {
        &self.play.ready
    }

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
