//! A batch on several workers. A batch that takes a while is cut into contiguous parts by instance,
//! one for each idle worker, and the reply is put together from theirs. The bits are those of one
//! worker: on the CPU for any cut; on a GPU, where the last bits depend on how many instances are
//! simulated together, it is cut where a worker would cut it.

use std::sync::Arc;

use bendtwin_contract::rollout::{self, split};
use bendtwin_proto::{
    v1::{RollOutRequest, RollOutResponse},
    worker::v1::ExecuteRollOutRequest,
};
use futures::future::try_join_all;

use super::{
    Dispatch,
    line::Ask,
    registry::Entry,
    rollout::{CheckedRollOut, ReplyHold, Whole},
    route,
};
use crate::error::{Error, Result};

/// Least time of a part at a worker that has the twin loaded, and at one that has to load it [s].
const WARM_PART_S: f64 = 0.05;
const COLD_PART_S: f64 = 0.25;
/// Largest reply that is put together here [bytes]: its parts and the whole are in memory together.
const MOST_JOINED: u64 = 64 << 20;
/// Memory of prepared instances up to which a GPU's worker cuts a batch by work alone [bytes].
const MOST_PREPARED: u64 = 128 << 20;

impl Dispatch {
    /// The workers to share a batch: none or one if it is not to be split. All of them are
    /// equivalent, so that any worker may simulate any part.
    pub(super) fn sharers(&self, checked: &CheckedRollOut) -> Vec<Arc<Entry>> {
        let Some(request) = &checked.execute.request else { return Vec::new() };
        if checked.session.is_some()
            || checked.reply_bytes > MOST_JOINED
            || !split::can_split(request)
        {
            return Vec::new();
        }
        let entries: Vec<Arc<Entry>> = self.lock().values().cloned().collect();
        let (fresh, now) = (self.fresh(), self.store.lease_time());
        let candidates: Vec<route::Candidate> = entries
            .iter()
            .map(|e| e.candidate(checked.twin, &checked.ask, e.silence(now) <= fresh))
            .collect();
        let idle = route::idle(checked.twin, &candidates);
        let Some(first) = idle.first().and_then(|i| entries.get(*i)) else { return Vec::new() };
        let seconds = checked.ask.work / first.line.per_second();
        let Some(unit) = checked.unit(first, request) else { return Vec::new() };
        let most_by_instances = match checked.batch.instances / u64::from(first.lanes().max(1)) {
            0 => 1,
            rounds => rounds.min(checked.batch.instances.div_ceil(unit)),
        };
        let mut sharers: Vec<Arc<Entry>> = Vec::new();
        for i in idle {
            let (Some(entry), Some(candidate)) = (entries.get(i), candidates.get(i)) else { break };
            let parts = sharers.len() as u64 + 1;
            let least_s = if candidate.warm { WARM_PART_S } else { COLD_PART_S };
            let is_worth_it = seconds / parts as f64 >= least_s && parts <= most_by_instances;
            if parts > 1 && !is_worth_it {
                break;
            }
            if entry.is_like(first) {
                sharers.push(Arc::clone(entry));
            }
        }
        sharers
    }

    /// The reply of several workers, each with a part of the batch. If one fails, so does the whole,
    /// and the others stop.
    pub(super) async fn spread(
        &self,
        checked: CheckedRollOut,
        sharers: Vec<Arc<Entry>>,
    ) -> Result<Whole> {
        let request = checked.execute.request.as_ref();
        let unit = request.zip(sharers.first()).and_then(|(r, first)| checked.unit(first, r));
        let CheckedRollOut { twin, batch, ask, execute, ends, reply_bytes, memory, .. } = checked;
        let deadline = ends.deadline;
        let (Some(request), Some(unit)) = (&execute.request, unit) else {
            return Err(Error::Internal("a rollout that cannot be shared".to_owned()));
        };
        // The parts, and the whole made of them.
        let share = self.memory.reply(reply_bytes.saturating_mul(2));
        let share =
            tokio::time::timeout_at(deadline, share).await.map_err(|_| Error::Deadline)??;
        let runs = split::runs(batch.instances, sharers.len() as u64, unit);
        let parts = runs.zip(sharers).map(|(run, worker)| {
            let share = (run.end - run.start) as f64 / batch.instances.max(1) as f64;
            let ask = Ask { work: ask.work * share, ..ask.clone() };
            let request = Some(split::part(request, &batch, run));
            let execute = ExecuteRollOutRequest { request, ..execute.clone() };
            async move {
                let started = self.start(twin, &ask, execute, ends, Some(worker));
                let (reply, mut rest) = tokio::time::timeout_at(deadline, started)
                    .await
                    .map_err(|_| Error::Deadline)??;
                match rest.next().await? {
                    None => Ok::<RollOutResponse, Error>(reply),
                    Some(_) => Err(Error::Internal("the worker split a reply".to_owned())),
                }
            }
        });
        let replies = try_join_all(parts).await?;
        drop(memory);
        let join = move || split::join(replies).map_err(|e| Error::Internal(e.to_string()));
        let joined = tokio::task::spawn_blocking(join).await;
        let response = joined.map_err(|e| Error::Internal(format!("joining replies: {e}")))??;
        Ok(Whole { response, held: ReplyHold::of(share) })
    }
}

impl CheckedRollOut {
    /// Number of instances at whose multiples the batch may be cut for workers like this one; none
    /// if it may not be cut.
    fn unit(&self, worker: &Entry, request: &RollOutRequest) -> Option<u64> {
        if worker.is_cpu() {
            return Some(1);
        }
        let bytes = rollout::memory(request, &self.batch, &self.shape, 0).prepared;
        let all = bytes.saturating_mul(self.batch.instances);
        let lanes = worker.lanes().into();
        // Beyond that a worker cuts by memory, which is not known here.
        (all <= MOST_PREPARED)
            .then(|| split::slice_instances(request, &self.batch, &self.shape, lanes))
    }
}
