//! `grpc.health.v1.Health`: serving means ready in the sense of `/readyz`, for all services.

use std::{collections::HashSet, time::Duration};

use futures::{StreamExt, stream};
use tonic::{Request, Response, Status, server::NamedService};
use tonic_health::pb::{
    HealthCheckRequest, HealthCheckResponse, health_check_response::ServingStatus,
    health_server::Health,
};

use super::Reply;
use crate::app::App;

/// Interval at which watchers' states are checked again.
const WATCH_INTERVAL: Duration = Duration::from_secs(5);

/// The health of the server's services.
#[derive(Clone, Debug)]
pub(super) struct ServerHealth {
    app: App,
    services: HashSet<&'static str>,
}

impl ServerHealth {
    /// Health of the server as a whole, which has an empty name.
    pub(super) fn new(app: &App) -> Self {
        Self { app: app.clone(), services: HashSet::from([""]) }
    }

    /// Also of this service.
    pub(super) fn with<S: NamedService>(mut self) -> Self {
        self.services.insert(S::NAME);
        self
    }

    async fn status(&self) -> ServingStatus {
        match self.app.readiness().await.iter().all(|check| check.ok) {
            true => ServingStatus::Serving,
            false => ServingStatus::NotServing,
        }
    }
}

fn reply(status: ServingStatus) -> HealthCheckResponse {
    HealthCheckResponse { status: status.into() }
}

#[tonic::async_trait]
impl Health for ServerHealth {
    async fn check(
        &self,
        request: Request<HealthCheckRequest>,
    ) -> Result<Response<HealthCheckResponse>, Status> {
        if !self.services.contains(request.get_ref().service.as_str()) {
            return Err(Status::not_found("there is no such service"));
        }
        Ok(Response::new(reply(self.status().await)))
    }

    type WatchStream = Reply<HealthCheckResponse>;

    /// The status now and whenever it has changed, until the server stops.
    async fn watch(
        &self,
        request: Request<HealthCheckRequest>,
    ) -> Result<Response<Self::WatchStream>, Status> {
        if !self.services.contains(request.get_ref().service.as_str()) {
            let unknown = stream::iter([Ok(reply(ServingStatus::ServiceUnknown))]);
            return Ok(Response::new(unknown.chain(stream::pending()).boxed()));
        }
        let statuses = stream::unfold((self.clone(), None), |(health, before)| async move {
            loop {
                if before.is_some() {
                    if health.app.is_stopping() {
                        return None;
                    }
                    tokio::select! {
                        () = tokio::time::sleep(WATCH_INTERVAL) => {}
                        () = health.app.stopped() => {}
                    }
                }
                let status = health.status().await;
                if before != Some(status) {
                    return Some((Ok(reply(status)), (health, Some(status))));
                }
            }
        });
        Ok(Response::new(statuses.boxed()))
    }
}
