//! Rows whose content is gone. Results of an ingest are made again from the capture; a checkpoint
//! is forgotten, so that its job starts again. Captures, their supplements and twins are left
//! unchanged: uploading the same content again completes them.

use std::collections::BTreeSet;

use super::survey::{Damage, UPLOAD};
use crate::{
    Result,
    database::Database,
    sql::{Transaction, query},
};

/// Changes the rows of lost content. Returns what stays lost.
pub(super) async fn rows(
    database: &Database,
    damages: Vec<Damage>,
    now: i64,
    actions: &mut Vec<String>,
) -> Result<Vec<Damage>> {
    let without_archive: BTreeSet<String> =
        damages.iter().filter(|d| d.part == "archive").map(|d| d.name.clone()).collect();
    let mut read_again = BTreeSet::new();
    let mut lost = Vec::new();
    let mut tx = database.write().await?;
    for damage in damages {
        let id = damage.name.rsplit('/').next().unwrap_or_default();
        match damage.part.as_str() {
            "checkpoint" => {
                query("update jobs set checkpoint = null where id = $1")
                    .bind(id)
                    .execute(&mut tx)
                    .await?;
                actions.push(format!("{} starts anew: its checkpoint is gone", damage.name));
            }
            UPLOAD => {
                give_up(&mut tx, id, now).await?;
                actions.push(format!("gave {} up: what had arrived of it is gone", damage.name));
            }
            "observation" | "playback" | "masks" | "report" | "report page"
                if !without_archive.contains(&damage.name) =>
            {
                if read_again.insert(damage.name.clone()) {
                    queue_ingest(&mut tx, id).await?;
                    let Damage { name, part, .. } = damage;
                    actions.push(format!("{name} is read again: its {part} is gone"));
                }
            }
            _ => lost.push(damage),
        }
    }
    tx.commit().await?;
    Ok(lost)
}

/// Ends an upload.
async fn give_up(tx: &mut Transaction, id: &str, now: i64) -> Result<()> {
    query(
        "update uploads set state = 'gone', why = 'what had arrived of it is gone: begin a new one',
             digest = null, request_id = null, expires_at = $2 where id = $1",
    )
    .bind(id)
    .bind(now.saturating_add(86_400_000_000))
    .execute(&mut *tx)
    .await?;
    Ok(())
}

/// Forgets the results of an ingest and queues it once more.
async fn queue_ingest(tx: &mut Transaction, capture: &str) -> Result<()> {
    for statement in [
        "delete from observations where capture = $1",
        "delete from playbacks where capture = $1",
        "delete from masks where capture = $1",
        "delete from reports where capture = $1",
        // In the trash it is queued once it is restored.
        "update jobs set restored_state = case when trashed_at is null then null else 'queued' end,
             state = case when trashed_at is null then 'queued' else 'cancelled' end, attempts = 0, stalled = 0, furthest = 0,
             checkpoint = null, fault = null, attempt_faults = '[]', progress = null,
             ended_at = null, worker = null, lease_until = null, cancel_requested = false,
             masks_only = false, revision = revision + 1
         where capture = $1 and kind = 'ingest'",
    ] {
        query(statement).bind(capture).execute(&mut *tx).await?;
    }
    Ok(())
}
