//! The typed client of a BendTwin server: upload a capture, fit it, roll the
//! twin out.
//!
//! ```no_run
//! use bendtwin_client::{Client, Cost, FitSettings, JobState, Rollout};
//!
//! # async fn example() -> Result<(), bendtwin_client::Error> {
//! let client = Client::connect("http://127.0.0.1:7070").await?;
//!
//! // A recording becomes a twin.
//! let capture = client.captures().upload("rope.zip".as_ref(), "rope").await?;
//! let fit = client.fits().create(capture.name, &FitSettings::default(), 0).await?;
//! let fit = client.fits().wait(fit.name).await?;
//! assert_eq!(fit.job.state, JobState::Succeeded);
//! let twin = fit.twin.expect("a fit that succeeded has a twin");
//!
//! // 64 ways to move one control point by a centimetre over 30 frames: which comes nearest?
//! let (from, goal) = ([0.0, 0.0, 0.2], [0.01, 0.0, 0.2]);
//! let ends = (0..64).map(|i| [0.01 * (i as f32).cos(), 0.01 * (i as f32).sin(), 0.2]);
//! let knots: Vec<_> = ends.flat_map(|end| [from, end]).collect();
//! let rollout = Rollout::of(twin)
//!     .trajectories([64, 2, 1], knots)
//!     .frames(30)
//!     .cost(Cost::keypoints("tip", 1.0, &[0], &[goal]));
//! let reply = client.rollouts().run(rollout).await?;
//! println!("instance {:?} is best", reply.best());
//! # Ok(())
//! # }
//! ```
//!
//! A session keeps simulations at a worker, so that a closed loop sends no states to and fro:
//!
//! ```no_run
//! use bendtwin_client::{Client, Cost, NewSession, Point, Rollout, TwinId};
//!
//! # async fn example(client: Client, twin: TwinId, done: Vec<Point>, plans: Vec<Point>)
//! # -> Result<(), bendtwin_client::Error> {
//! let sessions = client.sessions();
//! let session = sessions.open(NewSession::of(twin).settled()).await?;
//!
//! // What the robot did: two knots of one control point. The session stays where it ends.
//! let moved = Rollout::of(twin).trajectories([1, 2, 1], done).frames(3).final_state();
//! let reply = sessions.advance(session.name, &[], moved).await?;
//! // From here a lost session resumes: `NewSession::of(twin).going_on(&state)`.
//! let state = reply.state(0);
//!
//! // 64 plans from there, which leave the session where it is.
//! let rollout = Rollout::of(twin)
//!     .from_session(session.name, &[])
//!     .trajectories([64, 2, 1], plans)
//!     .frames(30)
//!     .cost(Cost::keypoints("tip", 1.0, &[0], &[[0.1, 0.0, 0.2]]));
//! let reply = client.rollouts().run(rollout).await?;
//! println!("plan {:?} is best from {state:?}", reply.best());
//! sessions.close(session.name).await?;
//! # Ok(())
//! # }
//! ```
//!
//! Captures travel over HTTP, streamed from disk, large ones resumably
//! ([`Captures::upload_resumable`]); everything else is gRPC over
//! one connection. The token of a server of the same user on the same machine is found by itself
//! ([`token`]). Every [`Error`] carries the server's category, reason,
//! message and request id.

mod captures;
mod client;
mod error;
mod evaluations;
mod fits;
mod keys;
mod labels;
mod page;
mod plans;
mod registrations;
mod resources;
mod rollouts;
mod sessions;
pub mod token;
mod trash;
mod twins;
mod usage;
mod watch;
mod workers;

pub use bendtwin_core::settings::ingest::IngestSettings;
pub use bendtwin_core::{
    Category, FastVariant, Fault, Fidelity, FitSettings, Point, Quality, Twin as TwinModel,
    ids::{
        CaptureId, FitId, InvalidName, KeyId, ProjectId, RetentionId, SessionId, ShareId, TwinId,
        WorkerId,
    },
};
pub use bendtwin_plan::{Bounds, Limit, Method, Movement, Origin};
pub use bendtwin_proto::v1::{
    KeyQuotas, ModelLoss, Progress as JobProgress, StoredBytes, WorkerRequirements as Requirements,
    job::State as JobState,
};

pub use self::{
    captures::{Captures, SupplementKind},
    client::{CA_VARIABLE, Client, Readiness, ReadinessCheck},
    error::Error,
    evaluations::Evaluations,
    fits::{FitOrder, FitPreview, Fits, LossCurve},
    keys::projects::{Project, ProjectChange, Projects},
    keys::shares::{MadeShare, NewShare, Share, Shares},
    keys::sign_ins::{Caller, DeviceCode, SignIns},
    keys::{Key, Keys, MadeKey, NewKey},
    labels::{CaptureFacts, ListQuery, Order, Update},
    page::{Page, PageRequest},
    plans::{PlanUpdate, Planning, Plans},
    registrations::{Observation, Registered, Registration, Registrations, Residual},
    resources::{Capture, DeviceMemory, Fit, Job, Supplement, Twin, Worker},
    rollouts::{
        Collider, Cost, Deviation, Diagnostics, Divergence, ForceBy, Forces, Grasp, Grasping,
        GripperPoses, Implausible, Line, Reply, Rollout, RolloutTiming, Rollouts, Shape, State,
        Statistic, Vary, WirePose, World,
    },
    sessions::{
        Corrected, Correction, NewSession, PictureCamera, Pictures, Prop, Rendering, Session,
        Sessions, Step, StepTimes, Stepped, Tracking,
    },
    trash::retention::{
        NewRetentionRule, Retention, RetentionOutcome, RetentionPreview, RetentionRule,
    },
    trash::{Trash, Trashed},
    twins::{Geometry, Twins},
    usage::{OwnerUsage, Usage},
    watch::Watch,
    workers::Workers,
};
