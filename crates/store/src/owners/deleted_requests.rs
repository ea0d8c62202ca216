//! Request ids of resources that have been deleted.
//!
//! A request may be under way more than once: its client gave it up and repeated it elsewhere, and
//! the first attempt continues in its server, or in the network. The resource of the repetition may
//! be deleted before that attempt ends. Then only the id shows that the request has been answered,
//! so the id outlives the row that it was in, with its owner: others may use the same id. A row without
//! an owner is that of a server of an earlier version, and counts for all.
//!
//! A resumable upload is different: clients derive its id from a file, and send the file again on
//! purpose. An upload that is begun after the deletion, by a request without content, is no late
//! attempt: that request has made nothing yet, and only a live client continues it. Its row is
//! noted beside the id.

use std::time::Duration;

use bendtwin_core::ids::UploadId;

use crate::{
    Error, Result, Store,
    owners::request_ids::{DIVIDER, RequestId},
    sql::{Transaction, query, query_scalar},
};

/// Time for which an id is kept; an attempt ends within minutes.
const KEPT: Duration = Duration::from_secs(86_400);

/// Tables whose rows have request ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Captures.
    Captures,
    /// Fits and ingests.
    Jobs,
    /// Twins.
    Twins,
}

impl Kind {
    fn as_str(self) -> &'static str {
        match self {
            Self::Captures => "captures",
            Self::Jobs => "jobs",
            Self::Twins => "twins",
        }
    }
}

/// Refuses a request whose resource has been deleted, unless it is the last one of an upload that
/// was begun after that.
///
/// # Errors
/// [`Error::DeletedSince`].
pub(crate) async fn refuse(
    tx: &mut Transaction,
    kind: Kind,
    request: Option<RequestId<'_>>,
    upload: Option<UploadId>,
) -> Result<()> {
    let Some(request) = request else { return Ok(()) };
    let rows: Vec<(String, Option<String>)> = query(
        "select name, upload from deleted_requests where kind = $1 and request_id in ($2, $3)",
    )
    .bind(kind.as_str())
    .bind(request.qualified())
    .bind(request.id)
    .fetch_all(tx)
    .await?;
    let upload = upload.map(|id| id.uuid().to_string());
    let late = rows.into_iter().find(|(_, begun)| begun.is_none() || *begun != upload);
    match late {
        Some((name, _)) => Err(Error::DeletedSince { request_id: request.id.to_owned(), name }),
        None => Ok(()),
    }
}

/// Lets an upload make a capture that was begun under the id of a deleted one.
pub(crate) async fn begin_again(
    tx: &mut Transaction,
    request: RequestId<'_>,
    upload: &str,
) -> Result<()> {
    query("update deleted_requests set upload = $4 where kind = $1 and request_id in ($2, $3)")
        .bind(Kind::Captures.as_str())
        .bind(request.qualified())
        .bind(request.id)
        .bind(upload)
        .execute(tx)
        .await?;
    Ok(())
}

/// Takes back the id of a resource that is restored; none if it had none, it has been forgotten, or
/// an upload was begun under it after the deletion.
pub(crate) async fn take_back(
    tx: &mut Transaction,
    kind: Kind,
    name: &str,
) -> Result<Option<String>> {
    query_scalar(
        "delete from deleted_requests where kind = $1 and name = $2 and upload is null
         returning request_id",
    )
    .bind(kind.as_str())
    .bind(name)
    .fetch_optional(tx)
    .await
}

impl Store {
    /// The error of a request that repeats one whose resource is no longer there.
    pub(crate) async fn vanished(&self, kind: Kind, request: RequestId<'_>) -> Error {
        let refused = async {
            let mut tx = self.inner.database.write().await?;
            refuse(&mut tx, kind, Some(request), None).await
        };
        // Without a trace of it the next attempt is no repetition.
        refused.await.err().unwrap_or(Error::ContentBusy)
    }

    /// Keeps the request id of a resource within the transaction that deletes it.
    pub(crate) async fn keep_request_id(
        &self,
        tx: &mut Transaction,
        kind: Kind,
        request: Option<RequestId<'_>>,
        name: &str,
    ) -> Result<()> {
        let Some(request) = request else { return Ok(()) };
        let until = self.lease_until(tx, KEPT);
        query(
            "insert into deleted_requests (kind, request_id, name, until_at)
             values ($1, $2, $3, $4)
             on conflict (kind, request_id) do update
             set name = excluded.name, until_at = excluded.until_at, upload = null",
        )
        .bind(kind.as_str())
        .bind(request.qualified())
        .bind(name)
        .bind(until)
        .execute(tx)
        .await?;
        Ok(())
    }

    /// Forgets ids that have been kept long enough. Uploads live longer than attempts: the id of one
    /// that is under way stays.
    pub(crate) async fn forget_deleted_requests(&self) -> Result<()> {
        let mut tx = self.inner.database.write().await?;
        let now = self.lease_until(&tx, Duration::ZERO);
        query(
            "delete from deleted_requests where until_at < $1 and not exists (
                 select 1 from uploads
                 where state = 'receiving' and deleted_requests.request_id in (
                     uploads.request_id, uploads.request_id || $2 || uploads.owner))",
        )
        .bind(now)
        .bind(DIVIDER.to_string())
        .execute(&mut tx)
        .await?;
        tx.commit().await
    }
}

#[cfg(test)]
mod tests;
