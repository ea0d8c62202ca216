//! Delivery of a finished twin to the server.

use bendtwin_core::Category;
use bendtwin_proto::worker::v1::TwinWrite;

use super::compute::Finished;
use crate::{
    job::{
        Attempt, LeasedJob,
        deliver::{Failure, Undelivered},
    },
    server_client::CallError,
};

/// Stores the twin, which ends the job. Sending it twice is safe: the second answer is the same, or
/// reports a stale lease.
pub(super) async fn deliver(attempt: &Attempt<'_>, finished: Finished) {
    match attempt.send_until_acknowledged("the twin", || send(&attempt.job, &finished)).await {
        Ok(twin) => tracing::info!(twin, bytes = finished.file.len(), "fit succeeded"),
        // Too large, for example: another attempt would make the same twin and be refused, too.
        Err(Undelivered::Refused(fault)) if fault.category == Category::InvalidArgument => {
            attempt.fail(fault, Failure::Permanent).await;
        }
        Err(_) => {}
    }
}

async fn send(job: &LeasedJob, finished: &Finished) -> Result<String, CallError> {
    let twin = TwinWrite {
        job: Some(job.write_of(&finished.file)),
        node_count: finished.node_count,
        spring_count: finished.spring_count,
        triplet_count: finished.triplet_count,
        control_count: finished.control_count,
        fps: finished.fps,
        substeps: finished.substeps,
        quality_json: finished.quality_json.clone(),
    };
    job.server().complete_fit(twin, finished.file.clone()).await
}
