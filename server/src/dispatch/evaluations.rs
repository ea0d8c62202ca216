//! The way of evaluations: as of registrations, to a worker that has the twin loaded and time for it.

use std::{sync::Arc, time::Duration};

use bendtwin_contract::registration;
use bendtwin_core::ids::TwinId;
use bendtwin_proto::{
    v1::{EvaluateTwinRequest, Evaluation},
    worker::v1::ExecuteEvaluateTwinRequest,
};
use tokio::time::Instant;

use super::{Dispatch, call, line::Ask, registry::Entry};
use crate::{
    context::Context,
    error::{Error, Result},
};

/// Longest time of an evaluation without a deadline.
const LONGEST: Duration = Duration::from_secs(600);

impl Dispatch {
    /// The quality table of a twin on a capture.
    pub(crate) async fn evaluate_twin(
        &self,
        twin: TwinId,
        request: EvaluateTwinRequest,
        timeout: Option<Duration>,
    ) -> Result<Evaluation> {
        let deadline = Instant::now() + timeout.unwrap_or(LONGEST).min(LONGEST);
        let known = self.twins.get(&self.store, twin).await?;
        let work = registration::evaluation_work(&known.shape) as f64;
        let ask = Ask::of_caller(work);
        let execute = ExecuteEvaluateTwinRequest {
            request: Some(request),
            request_id: Context::current().request_id,
        };
        let evaluated = self.at_a_worker(twin, &ask, None, |entry| {
            let (execute, ask) = (execute.clone(), ask.clone());
            async move { evaluate_at(&entry, &ask, execute, deadline).await }
        });
        tokio::time::timeout_at(deadline, evaluated).await.map_err(|_| Error::Deadline)?
    }
}

/// `None` if the worker cannot be reached, so that it has not taken the evaluation.
async fn evaluate_at(
    entry: &Arc<Entry>,
    ask: &Ask,
    execute: ExecuteEvaluateTwinRequest,
    deadline: Instant,
) -> Result<Option<Evaluation>> {
    let joined = entry.line.join(ask);
    let mut place = joined.map_err(|full| Error::Busy { retry_after: full.retry_after })?;
    place.turn().await;
    let sent = call::send(entry, execute, deadline, |mut client, request| async move {
        client.evaluate_twin(request).await
    });
    let Some((reply, mut taken)) = sent.await? else { return Ok(None) };
    taken.answered();
    let missing = || Error::Internal("a worker's reply has no evaluation".to_owned());
    let evaluation = reply.evaluation.ok_or_else(missing)?;
    Ok(Some(Evaluation { worker: entry.id().to_string(), ..evaluation }))
}
