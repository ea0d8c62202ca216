//! A worker as the protocol has it, without physics.

pub(crate) mod grasps;
mod ingests;

use std::{
    pin::Pin,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use bendtwin_contract::{rollout::Limits, worker_key};
use bendtwin_core::{
    Category,
    ids::{SessionId, WorkerId},
};
use bendtwin_proto::{
    fault,
    v1::{
        CorrectSessionRequest, CorrectedSession, EvaluateTwinRequest, Evaluation, FitPreview,
        Grasping, ModelLoss, PictureCamera, PredictedMotion, Progress, RegisteredState,
        RenderSessionRequest, RenderedSession, RollOutResponse, Session, SessionStates, Tensor,
        Tracking,
        corrected_session::Correction,
        initial_state::GivenState,
        rendered_session::Pictures,
        roll_out_request::Actions,
        roll_out_response::{Divergence, Implausible, Timing},
    },
    worker::v1::{
        CompleteFitRequest, DownloadRequest, ExecuteEvaluateTwinRequest,
        ExecuteEvaluateTwinResponse, ExecuteRegisterStateRequest, ExecuteRegisterStateResponse,
        ExecuteRollOutRequest, ExecuteRollOutResponse, FailJobRequest, HeartbeatRequest,
        HeartbeatResponse, JobWrite, Lease, LeaseJobRequest, ManageSessionRequest,
        ManageSessionResponse, RegisterRequest, ReportJobRequest, ReportJobResponse,
        SaveCheckpointRequest, TwinWrite, WatchRequest, WatchResponse, complete_fit_request,
        fail_job_request::End,
        lease_job_request::Kind,
        manage_session_request::Call,
        save_checkpoint_request,
        worker_link_client::WorkerLinkClient,
        worker_rollouts_server::{WorkerRollouts, WorkerRolloutsServer},
    },
};
use bytes::Bytes;
use futures::{Stream, StreamExt};
use tokio::{net::TcpListener, sync::Notify};
use tonic::{
    Request, Response, Status,
    service::{Interceptor, interceptor::InterceptedService},
    transport::Channel,
};

use crate::{
    harness::{Server, TOKEN},
    results,
};

pub(crate) use ingests::Made;

type Client = WorkerLinkClient<InterceptedService<Channel, Credentials>>;

/// The token of the tests, and a worker's key.
#[derive(Clone)]
pub(crate) struct Credentials {
    key: String,
}

impl Interceptor for Credentials {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        let value = format!("Bearer {TOKEN}").parse().unwrap();
        request.metadata_mut().insert("authorization", value);
        request.metadata_mut().insert(worker_key::METADATA, self.key.parse().unwrap());
        Ok(request)
    }
}

/// A worker that has registered.
pub(crate) struct Worker {
    pub(crate) id: WorkerId,
    pub(crate) key: String,
    pub(crate) link: Client,
    /// Bounds on rollouts that the server sent.
    pub(crate) rollout_limits: Limits,
    breaks: Arc<AtomicBool>,
}

/// Answers of the fake device.
#[derive(Clone, Default)]
pub(crate) struct Device {
    /// Wait for this before answering.
    pub(crate) hold: Option<Arc<Notify>>,
    /// Wait only with batches of more instances than this.
    pub(crate) hold_above: usize,
    /// Rung when a rollout has begun, and when one was given up.
    pub(crate) begun: Arc<Notify>,
    pub(crate) given_up: Arc<Notify>,
    /// Break the connection off instead of answering.
    pub(crate) breaks: Arc<AtomicBool>,
    /// Answer that as many rollouts are under way as this worker takes, for other servers.
    pub(crate) is_busy: Arc<AtomicBool>,
    /// The cost of an instance is the first number of its actions.
    pub(crate) echoes: bool,
    /// The cost of an instance is the sum of the squares of its actions, infinite if they are all
    /// zero; gradients come if they are asked for.
    pub(crate) bowl: bool,
    /// Costs of every part, where it is to be large.
    pub(crate) part_costs: usize,
    /// Number of parts after which the worker fails.
    pub(crate) ends_after: Option<usize>,
    /// The strain of an instance is four times the farthest that its actions get from 0.5 in x.
    pub(crate) strains: bool,
    /// Instances that advance a session diverge.
    pub(crate) diverges: bool,
    /// Calls about sessions, and the rollouts that advanced one, as they came.
    pub(crate) sessions: Arc<Mutex<Vec<Call>>>,
    pub(crate) advances: Arc<Mutex<Vec<ExecuteRollOutRequest>>>,
    /// Time limits passed on with the rollouts that came [s].
    pub(crate) time_left_s: Arc<Mutex<Vec<f64>>>,
}

/// Calls of the worker with a key.
pub(crate) fn link(server: &Server, key: &str) -> Client {
    let credentials = Credentials { key: key.to_owned() };
    WorkerLinkClient::with_interceptor(server.channel.clone(), credentials)
}

impl Worker {
    pub(crate) async fn register(server: &Server) -> Self {
        Self::register_with(server, Device::default()).await
    }

    /// A worker at this endpoint, where no process answers rollouts.
    pub(crate) async fn register_at(server: &Server, endpoint: &str) -> Self {
        Self::register_as(server, endpoint.to_owned(), Arc::default(), &[]).await
    }

    pub(crate) async fn register_with(server: &Server, device: Device) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let endpoint = format!("http://{}", listener.local_addr().unwrap());
        let incoming = tokio_stream::wrappers::TcpListenerStream::new(listener);
        let breaks = device.breaks.clone();
        let service = tonic::transport::Server::builder()
            .add_service(WorkerRolloutsServer::new(device))
            .serve_with_incoming(incoming);
        tokio::spawn(async move { service.await.unwrap() });
        Self::register_as(server, endpoint, breaks, &[]).await
    }

    /// A worker that was started with labels, without a process that answers rollouts.
    pub(crate) async fn register_labelled(server: &Server, labels: &[&str]) -> Self {
        Self::register_as(server, "http://127.0.0.1:1".to_owned(), Arc::default(), labels).await
    }

    async fn register_as(
        server: &Server,
        endpoint: String,
        breaks: Arc<AtomicBool>,
        labels: &[&str],
    ) -> Self {
        let (key, id) = worker_key::generate();
        let mut link = link(server, &key);
        let registered = link
            .register(RegisterRequest {
                worker: id.to_string(),
                endpoint,
                backend: "cpu".into(),
                device: "fake".into(),
                build: "test".into(),
                lanes: 1,
                labels: labels.iter().map(|label| (*label).to_owned()).collect(),
            })
            .await
            .unwrap()
            .into_inner();
        assert!(
            registered.heartbeat_interval_s > 0.0
                && registered.lease_s > registered.heartbeat_interval_s
        );
        let rollout_limits = Limits::from(&registered.rollout_limits.unwrap());
        Self { id, key, link, rollout_limits, breaks }
    }

    /// Registers under its id, wherever it is.
    pub(crate) async fn register_again(&mut self) -> Result<(), Status> {
        let endpoint = "http://127.0.0.1:1".to_owned();
        let worker = self.id.to_string();
        let request = RegisterRequest { worker, endpoint, ..RegisterRequest::default() };
        self.link.register(request).await.map(drop)
    }

    /// From now on it calls this server.
    pub(crate) fn turn_to(&mut self, server: &Server) {
        self.link = link(server, &self.key);
    }

    /// From now on the endpoint breaks off, as that of a killed process does.
    pub(crate) fn kill_endpoint(&self) {
        self.breaks.store(true, Ordering::SeqCst);
    }

    pub(crate) async fn heartbeat(&mut self) -> Result<HeartbeatResponse, Status> {
        let request = HeartbeatRequest {
            worker: self.id.to_string(),
            memory_used_bytes: 3 << 30,
            memory_total_bytes: 80 << 30,
            fit_memory_bytes: 4 << 30,
            ..HeartbeatRequest::default()
        };
        self.link.heartbeat(request).await.map(Response::into_inner)
    }

    /// Leases a fit, after ingesting everything that waits for it.
    pub(crate) async fn lease(&mut self, wait: Duration) -> Option<Lease> {
        while let Some(lease) = self.lease_a(Kind::Ingest, Duration::ZERO).await {
            self.observe(&lease).await.unwrap();
        }
        self.lease_a(Kind::Fit, wait).await
    }

    pub(crate) async fn lease_a(&mut self, kind: Kind, wait: Duration) -> Option<Lease> {
        let (worker, wait_s) = (self.id.to_string(), wait.as_secs_f64());
        let request = LeaseJobRequest { worker, wait_s, kind: kind.into(), brief: false };
        self.link.lease_job(request).await.unwrap().into_inner().lease
    }

    pub(crate) async fn report(&mut self, lease: &Lease, fraction: f64) -> Result<bool, Status> {
        self.report_answered(lease, fraction).await.map(|answer| answer.cancel_requested)
    }

    pub(crate) async fn report_answered(
        &mut self,
        lease: &Lease,
        fraction: f64,
    ) -> Result<ReportJobResponse, Status> {
        let progress = Progress {
            stage: "search".into(),
            variant: "bending".into(),
            iteration: 1,
            iterations: 2,
            fraction,
            loss: Some(f64::NAN),
            ..Progress::default()
        };
        let request = ReportJobRequest {
            worker: self.id.to_string(),
            job: lease.job.clone(),
            epoch: lease.epoch,
            progress: Some(progress),
            ..ReportJobRequest::default()
        };
        self.link.report_job(request).await.map(Response::into_inner)
    }

    pub(crate) async fn report_losses(
        &mut self,
        lease: &Lease,
        losses: Vec<ModelLoss>,
    ) -> Result<bool, Status> {
        let request = ReportJobRequest {
            worker: self.id.to_string(),
            job: lease.job.clone(),
            epoch: lease.epoch,
            losses,
            ..ReportJobRequest::default()
        };
        self.link.report_job(request).await.map(|r| r.into_inner().cancel_requested)
    }

    pub(crate) async fn report_preview(
        &mut self,
        lease: &Lease,
        preview: FitPreview,
    ) -> Result<(), Status> {
        let request = ReportJobRequest {
            worker: self.id.to_string(),
            job: lease.job.clone(),
            epoch: lease.epoch,
            preview: Some(preview),
            ..ReportJobRequest::default()
        };
        self.link.report_job(request).await.map(drop)
    }

    pub(crate) async fn checkpoint(
        &mut self,
        lease: &Lease,
        content: &'static [u8],
    ) -> Result<(), Status> {
        use save_checkpoint_request::Part;
        let parts =
            [Part::Metadata(self.write(lease, content)), Part::Chunk(Bytes::from_static(content))];
        let parts = parts.map(|part| SaveCheckpointRequest { part: Some(part) });
        self.link.save_checkpoint(futures::stream::iter(parts)).await.map(drop)
    }

    /// Ends a fit with the twin of a label.
    pub(crate) async fn complete(
        &mut self,
        lease: &Lease,
        label: &'static [u8],
    ) -> Result<String, Status> {
        self.send_twin(lease, results::twin_file(label)).await
    }

    /// Ends a fit with this very content.
    pub(crate) async fn send_twin(
        &mut self,
        lease: &Lease,
        content: Vec<u8>,
    ) -> Result<String, Status> {
        use complete_fit_request::Part;
        let twin = TwinWrite {
            job: Some(self.write(lease, &content)),
            node_count: 5,
            spring_count: 4,
            triplet_count: 3,
            control_count: 1,
            fps: 30.0,
            substeps: 10,
            quality_json: r#"{"scores":[]}"#.into(),
        };
        let parts = [Part::Metadata(twin), Part::Chunk(content.into())];
        let parts = parts.map(|part| CompleteFitRequest { part: Some(part) });
        self.link.complete_fit(futures::stream::iter(parts)).await.map(|r| r.into_inner().twin)
    }

    /// An attempt that failed, but may succeed elsewhere.
    pub(crate) fn failure(&self, lease: &Lease) -> FailJobRequest {
        FailJobRequest {
            end: End::Failed.into(),
            worker: self.id.to_string(),
            job: lease.job.clone(),
            epoch: lease.epoch,
            ..FailJobRequest::default()
        }
    }

    pub(crate) async fn download(&mut self, name: &str) -> Result<Vec<u8>, Status> {
        let request = DownloadRequest { name: name.to_owned() };
        let mut chunks = self.link.download(request).await?.into_inner();
        let mut content = Vec::new();
        while let Some(chunk) = chunks.message().await? {
            content.extend(chunk.chunk);
        }
        Ok(content)
    }

    fn write(&self, lease: &Lease, content: &[u8]) -> JobWrite {
        JobWrite {
            worker: self.id.to_string(),
            job: lease.job.clone(),
            epoch: lease.epoch,
            digest: blake3::hash(content).to_hex().to_string(),
        }
    }
}

/// Rings when it is dropped before its work is done.
struct GivenUp(Option<Arc<Notify>>);

impl Drop for GivenUp {
    fn drop(&mut self) {
        if let Some(bell) = self.0.take() {
            bell.notify_one();
        }
    }
}

/// A correction that leaves its slot lost, in the state of the points.
fn corrected(correct: CorrectSessionRequest) -> ManageSessionResponse {
    let positions = correct.observation.and_then(|observation| observation.points);
    let state = GivenState { positions, ..GivenState::default() };
    let tracking = Tracking { lost: true, misfit: 1.25, unexplained: 3 };
    let slot = correct.slots.first().copied().unwrap_or_default();
    let (state, tracking) = (Some(state), Some(tracking));
    let (registered, moved_mm) = (true, 1.0);
    let correction =
        Correction { slot, moved_mm, state, tracking, registered, ..Correction::default() };
    let session = Session { name: correct.name, slots: 1, lost: vec![0], ..Session::default() };
    let corrected = CorrectedSession { session: Some(session), corrections: vec![correction] };
    ManageSessionResponse { corrected: Some(corrected), ..ManageSessionResponse::default() }
}

/// Black pictures of all slots that are asked for.
fn rendered(render: &RenderSessionRequest) -> ManageSessionResponse {
    let black = |camera: &PictureCamera| {
        let size = [render.slots.len(), camera.height as usize, camera.width as usize];
        let colors = vec![0_u8; 3 * size.iter().product::<usize>()];
        let colors = Some(Tensor::pack(&[size[0], size[1], size[2], 3], &colors));
        Pictures { colors, ..Pictures::default() }
    };
    let cameras = render.cameras.iter().map(black).collect();
    let rendered = Some(RenderedSession { cameras, slots: render.slots.clone() });
    ManageSessionResponse { rendered, ..ManageSessionResponse::default() }
}

#[tonic::async_trait]
impl WorkerRollouts for Device {
    type WatchStream = Pin<Box<dyn Stream<Item = Result<WatchResponse, Status>> + Send>>;

    /// The stream has nothing beside the heartbeats.
    async fn watch(&self, _: Request<WatchRequest>) -> Result<Response<Self::WatchStream>, Status> {
        Err(Status::unimplemented("an older worker"))
    }

    /// Every session exists; the first grasp of slot 1 is closed.
    async fn manage_session(
        &self,
        request: Request<ManageSessionRequest>,
    ) -> Result<Response<ManageSessionResponse>, Status> {
        let call = request.into_inner().call.unwrap();
        self.sessions.lock().unwrap().push(call.clone());
        let (name, slots) = match call {
            Call::Open(open) => (SessionId::generate().to_string(), open.slots),
            Call::Get(get) => (get.name, 1),
            Call::States(asked) => {
                let at = |place| Some(Tensor::pack_points(&[1, 1], &[place]));
                let (positions, controls) = (at([1.0, 2.0, 3.0]), at([0.5, 0.0, 0.0]));
                let phases = Some(Tensor::pack(&[1, 1], &[u32::from(asked.slots == [1])]));
                let grasping = Some(Grasping { phases, ..Grasping::default() });
                let states = GivenState { positions, controls, grasping, ..GivenState::default() };
                let (states, slots) = (Some(states), asked.slots);
                let states = Some(SessionStates { states, slots, frames: vec![0] });
                return Ok(Response::new(ManageSessionResponse { states, ..Default::default() }));
            }
            // What is seen far away is of something else, and farther away the object is lost.
            Call::Correct(correct) => {
                let points = correct.observation.clone().unwrap().points.unwrap();
                let reason = match points.unpack::<f32>("points").unwrap().1[0] {
                    x if x < 800.0 => None,
                    x if x < 900.0 => Some("OBSERVATION_NOT_EXPLAINED"),
                    _ => Some("OBJECT_LOST"),
                };
                return match reason.map(str::to_owned) {
                    None => Ok(Response::new(corrected(correct))),
                    Some(reason) => {
                        let (category, message) = (Category::FailedPrecondition, "far".to_owned());
                        let fault = bendtwin_core::Fault { category, reason, message };
                        Err(fault::status(&fault))
                    }
                };
            }
            Call::Render(render) => return Ok(Response::new(rendered(&render))),
            other => return Err(Status::unimplemented(format!("{other:?}"))),
        };
        let session = Some(Session { name, slots, ..Session::default() });
        Ok(Response::new(ManageSessionResponse { session, ..ManageSessionResponse::default() }))
    }

    /// The points are returned as the state.
    async fn register_state(
        &self,
        request: Request<ExecuteRegisterStateRequest>,
    ) -> Result<Response<ExecuteRegisterStateResponse>, Status> {
        self.begun.notify_one();
        let mut given_up = GivenUp(Some(self.given_up.clone()));
        if let Some(hold) = &self.hold {
            hold.notified().await;
        }
        given_up.0 = None;
        if self.breaks.load(Ordering::SeqCst) {
            return Err(Status::unavailable("gone"));
        }
        let observation = request.into_inner().request.unwrap().observation.unwrap();
        let state = GivenState { positions: observation.points, ..GivenState::default() };
        let registered = RegisteredState { state: Some(state), ..RegisteredState::default() };
        Ok(Response::new(ExecuteRegisterStateResponse { registered: Some(registered) }))
    }

    /// A table that says nothing, and a motion of one node.
    async fn evaluate_twin(
        &self,
        request: Request<ExecuteEvaluateTwinRequest>,
    ) -> Result<Response<ExecuteEvaluateTwinResponse>, Status> {
        let EvaluateTwinRequest { twin, capture, motion } = request.into_inner().request.unwrap();
        let quality_json = r#"{"scores":[]}"#.to_owned();
        let motion = motion.map(|asked| PredictedMotion {
            sequence: asked.sequence,
            train_frame_count: 1,
            positions: Some(Tensor::pack_points(&[1, 1], &[[1.0, 2.0, 3.0]])),
            track_m: Some(Tensor::pack(&[2], &[0.5_f32, f32::NAN])),
            ..PredictedMotion::default()
        });
        let evaluation = Evaluation { twin, capture, quality_json, worker: String::new(), motion };
        Ok(Response::new(ExecuteEvaluateTwinResponse { evaluation: Some(evaluation) }))
    }

    type RollOutStream = Pin<Box<dyn Stream<Item = Result<ExecuteRollOutResponse, Status>> + Send>>;

    /// Costs 0, 1, 2, ... in parts of the size that was asked for.
    async fn roll_out(
        &self,
        request: Request<ExecuteRollOutRequest>,
    ) -> Result<Response<Self::RollOutStream>, Status> {
        let token = request.metadata().get("authorization").unwrap().to_str().unwrap();
        assert_eq!(token, format!("Bearer {TOKEN}"));
        if self.is_busy.load(Ordering::SeqCst) {
            let (category, reason) = (Category::ResourceExhausted, "WORKER_BUSY".to_owned());
            let message = "64 rollouts are in flight".to_owned();
            return Err(fault::status(&bendtwin_core::Fault { category, reason, message }));
        }
        let execute = request.into_inner();
        self.time_left_s.lock().unwrap().push(execute.time_left_s);
        let advances = !execute.commit_slots.is_empty();
        if advances {
            self.advances.lock().unwrap().push(execute.clone());
        }
        let asked = execute.request.unwrap();
        let limit = asked.plausibility.and_then(|limits| limits.strain).unwrap_or(1.0);
        let returns = asked.returns.unwrap_or_default();
        let has_gradients = returns.action_gradients;
        let (rows, has_poses) = match asked.actions.unwrap() {
            Actions::Trajectories(t) => (t.positions, false),
            Actions::Poses(p) => (p.poses, true),
        };
        let (shape, positions) = rows.unwrap().unpack::<f32>("actions").unwrap();
        let batch = shape[0] as u32;
        let width = positions.len() / shape[0];
        let squares = |row: &[f32]| row.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
        let bowl = |row: &[f32]| Some(squares(row)).filter(|c| *c > 0.0).unwrap_or(f64::INFINITY);
        let cost_of: Vec<f64> = match self.echoes {
            _ if self.bowl => positions.chunks(width).map(bowl).collect(),
            true => positions.iter().step_by(width).copied().map(f64::from).collect(),
            false => (0..batch).map(f64::from).collect(),
        };
        self.begun.notify_one();
        let mut given_up = GivenUp(Some(self.given_up.clone()));
        if let Some(hold) = self.hold.as_ref().filter(|_| batch as usize > self.hold_above) {
            hold.notified().await;
        }
        given_up.0 = None;
        if self.breaks.load(Ordering::SeqCst) {
            return Err(Status::unavailable("gone"));
        }
        let size = if execute.part_instances == 0 { batch } else { execute.part_instances };
        let part_costs = self.part_costs;
        let strain = |row: &[f32]| {
            let far = row.iter().step_by(3).map(|x| (x - 0.5).abs()).fold(0.0, f32::max);
            f64::from(4.0 * far)
        };
        let strained = (0..).zip(positions.chunks(width)).filter(|_| self.strains);
        let strained = strained.map(|(instance, row)| (instance, strain(row)));
        let pulled = grasps::beyond(asked.plausibility, &positions, width);
        let pulled = pulled.into_iter().filter(|_| has_poses);
        let implausible: Vec<Implausible> = strained
            .filter(|(_, found)| *found > limit)
            .map(|(instance, found)| Implausible {
                instance,
                reason: "STRAIN".to_owned(),
                found,
                limit,
                ..Implausible::default()
            })
            .chain(pulled)
            .collect();
        let diverged =
            (advances && self.diverges).then_some(Divergence { instance: 0, frame: 1, node: 0 });
        let last = positions[positions.len() - 3..].to_vec();
        let end = returns.final_state.then(|| Tensor::pack(&[1, 1, 3], &last));
        let slopes: Vec<f32> = positions.iter().map(|x| 2.0 * x).collect();
        let slopes = has_gradients.then(|| Tensor::pack(&shape, &slopes));
        let parts = (0..batch).step_by(size as usize).map(move |first| {
            let of = first as usize..(first + size).min(batch) as usize;
            let mut costs: Vec<f64> = cost_of[of].to_vec();
            costs.resize(costs.len().max(part_costs), 0.0);
            let response = RollOutResponse {
                first_instance: first,
                costs: Some(Tensor::pack(&[costs.len()], &costs)),
                timing: Some(Timing { queue_s: 0.0, compute_s: 0.5 }),
                action_gradients: slopes.clone(),
                implausible: implausible.clone(),
                diverged: diverged.into_iter().collect(),
                final_positions: end.clone(),
                final_controls: end.clone(),
                ..RollOutResponse::default()
            };
            Ok(ExecuteRollOutResponse { response: Some(response) })
        });
        let parts: Vec<_> = match self.ends_after {
            None => parts.collect(),
            Some(count) => parts.take(count).chain([Err(Status::unavailable("gone"))]).collect(),
        };
        Ok(Response::new(futures::stream::iter(parts).boxed()))
    }
}
