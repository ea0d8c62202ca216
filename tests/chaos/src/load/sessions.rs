//! A client that advances a session step by step, and whenever the session is lost opens it again
//! from the last state that it received: the end has to be that of one undisturbed rollout, to the
//! bit.

use std::{sync::Arc, time::Duration};

use bendtwin_proto::v1::{
    AdvanceSessionRequest, CloseSessionRequest, InitialState, OpenSessionRequest, RollOutRequest,
    RollOutResponse, initial_state::GivenState, initial_state::State,
    session_service_client::SessionServiceClient,
};
use rand::RngExt as _;
use tokio::time::sleep;
use tonic::transport::Channel;

use crate::{honest::Answer, reference::end, run::Run};

const PROMISE: &str = "a session resumes bit for bit from its last state";

pub(super) async fn client(run: Arc<Run>, number: u64) {
    let mut random = run.chance(number);
    while run.is_under_load() {
        walk(&run).await;
        sleep(Duration::from_millis(random.random_range(50..400))).await;
    }
}

/// Walks once and compares the end.
pub(crate) async fn walk(run: &Run) {
    let mut walker = Walker {
        service: run.api().sessions(),
        twin: run.twin(),
        slots: run.references.walk.slots,
        session: None,
        last: None,
        opened: 0,
    };
    for step in &run.references.walk.steps {
        let reply = run.expect("a step of a session", async || walker.step(step).await).await;
        let Some(reply) = reply else { return };
        walker.last = Some(end(reply));
    }
    run.tally.count("acknowledged: walks of sessions");
    if walker.opened > 1 {
        run.tally.count("sessions that were opened again");
    }
    if walker.last.as_ref() != Some(&run.references.walk.end) {
        run.tally.broken(PROMISE, format_args!("opened {} times", walker.opened));
    }
    // One that is left ends by itself.
    walker.leave().await;
}

/// A walk under way.
struct Walker {
    service: SessionServiceClient<Channel>,
    twin: String,
    slots: u32,
    session: Option<String>,
    /// The last state that a reply brought; none: the rest shape.
    last: Option<GivenState>,
    opened: usize,
}

impl Walker {
    /// Advances by a step. A failed step may have been carried out, so the session is not used
    /// again.
    async fn step(&mut self, step: &RollOutRequest) -> Answer<RollOutResponse> {
        let name = match self.session.take() {
            Some(name) => name,
            None => self.open().await?,
        };
        let request = AdvanceSessionRequest {
            name: name.clone(),
            slots: (0..self.slots).collect(),
            rollout: Some(step.clone()),
        };
        let reply = self.service.advance_session(request).await?.into_inner();
        self.session = Some(name);
        Ok(reply)
    }

    async fn open(&mut self) -> Answer<String> {
        let initial = self.last.clone().map(|s| InitialState { state: Some(State::Given(s)) });
        let request = OpenSessionRequest {
            twin: self.twin.clone(),
            slots: self.slots,
            initial,
            idle_timeout_s: 30.0,
            ..OpenSessionRequest::default()
        };
        let session = self.service.open_session(request).await?.into_inner();
        self.opened += 1;
        Ok(session.name)
    }

    async fn leave(&mut self) {
        if let Some(name) = self.session.take() {
            let _ = self.service.close_session(CloseSessionRequest { name }).await;
        }
    }
}
