//! Measurements of a store: how many jobs a second its queue hands out and takes back, and what a
//! page of a long list costs. They fill the store that they are given.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use bendtwin_core::ids::{CaptureId, FitId, IngestId, WorkerId};
use serde::Serialize;

use crate::{
    DatabaseUrl, Error, Kind, Lease, ListQuery, Options, Page, PageRequest, Result, Store,
    TwinFacts,
    labels::Collection,
    sql::{Builder, query, query_scalar},
    store::clock::micros,
};

/// Rows of one statement.
const BATCH: usize = 500;
/// Time of a lease, far beyond that of a measurement.
const LEASE: Duration = Duration::from_secs(3600);
/// Pages that are read at each place of a list.
const REPEATS: usize = 20;

/// Speed of the queue.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QueueSpeed {
    /// Clients that claimed and completed at the same time.
    pub clients: usize,
    /// Jobs that waited at the beginning.
    pub queued: usize,
    /// Jobs that were claimed and completed.
    pub completed: u64,
    /// Claims, and as many completions, a second.
    pub jobs_per_s: f64,
    /// Jobs that were completed and are not, or twice.
    pub lost: u64,
}

/// Time of a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageTime {
    /// Rows before the page.
    pub depth: usize,
    /// Median time of a page of 50 captures with their ingests and reports [ms].
    pub median_ms: f64,
    /// Longest time of one [ms].
    pub longest_ms: f64,
}

/// Opens a store to be filled: in a folder, with SQLite in it unless a database is named.
///
/// # Errors
/// Those of [`Store::open`].
pub async fn open(folder: &Path, database: Option<DatabaseUrl>) -> Result<Store> {
    Store::open(Options { database, ..Options::new(folder) }).await
}

/// Fills the queue, and lets clients claim and complete fits for some time. A completion has the row
/// of its twin; the twin's file is left out.
///
/// # Errors
/// Database and file errors.
pub async fn queue(
    store: &Store,
    clients: usize,
    queued: usize,
    time: Duration,
) -> Result<QueueSpeed> {
    let mut upload = store.blobs().upload(16).await?;
    upload.write(bytes::Bytes::from_static(b"twin")).await?;
    let content = upload.finish(None).await?;
    let (digest, size_bytes) = (content.digest(), content.size_bytes());
    drop(store.publish(content).await?);
    let now = micros(store.now());
    let capture = CaptureId::generate().uuid().to_string();
    let columns = "jobs (id, kind, capture, state, priority, settings, created_at, due_at)";
    fill(store, columns, queued, |row, nth| {
        row.push_bind(FitId::generate().uuid().to_string()).push(", 'fit', ").push_bind(&capture);
        let at = now + nth as i64;
        row.push(", 'queued', 0, '{}', ").push_bind(at).push(", ").push_bind(at);
    })
    .await?;
    let began = Instant::now();
    let facts = TwinFacts { quality: "{}".to_owned(), ..TwinFacts::default() };
    let client = || async {
        let (worker, mut completed) = (WorkerId::generate(), 0_u64);
        while began.elapsed() < time {
            let Some(job) = store.jobs().claim(Kind::Fit, worker, LEASE).await? else { break };
            let lease = Lease { job: job.id, epoch: job.lease_epoch, worker };
            store.jobs().complete_published(lease, &facts, digest, size_bytes).await?;
            completed += 1;
        }
        Ok::<_, Error>(completed)
    };
    let done = futures::future::try_join_all((0..clients).map(|_| client())).await?;
    let elapsed = began.elapsed();
    let completed: u64 = done.iter().sum();
    let stored: i64 = query_scalar(
        "select count(*) from jobs join twins on twins.fit = jobs.id and twins.id = jobs.twin
         where jobs.state = 'succeeded'",
    )
    .fetch_one(store.inner.database.read())
    .await?;
    Ok(QueueSpeed {
        clients,
        queued,
        completed,
        jobs_per_s: completed as f64 / elapsed.as_secs_f64(),
        lost: completed.abs_diff(stored.max(0) as u64),
    })
}

/// Fills the list of captures, and reads pages of it at several depths.
///
/// # Errors
/// Database errors.
pub async fn pages(store: &Store, captures: usize) -> Result<Vec<PageTime>> {
    let now = micros(store.now());
    let ids: Vec<String> =
        (0..captures).map(|_| CaptureId::generate().uuid().to_string()).collect();
    let digest = blake3::hash(b"").to_hex();
    let columns = "captures (id, display_name, created_at, size_bytes, digest, name_key,
         search_text)";
    fill(store, columns, captures, |row, nth| {
        let name = format!("rope {nth}");
        row.push_bind(&ids[nth]).push(", ").push_bind(&name).push(", ").push_bind(now);
        row.push(", 1, ").push_bind(digest.as_str()).push(", ").push_bind(&name);
        row.push(", ").push_bind(&name);
    })
    .await?;
    let columns = "jobs (id, kind, capture, state, priority, settings, created_at)";
    fill(store, columns, captures, |row, nth| {
        row.push_bind(IngestId::generate().uuid().to_string()).push(", 'ingest', ");
        row.push_bind(&ids[nth]).push(", 'succeeded', 0, '{}', ").push_bind(now);
    })
    .await?;
    let mut times = Vec::new();
    for depth in [0, captures / 2, captures.saturating_sub(2 * 50)] {
        let mut list = ListQuery::default();
        list.page.token = token(store, &list, depth).await?;
        let mut of_page = Vec::with_capacity(REPEATS);
        for _ in 0..REPEATS {
            let began = Instant::now();
            store.captures().overviews(&list).await?;
            of_page.push(1e3 * began.elapsed().as_secs_f64());
        }
        of_page.sort_by(f64::total_cmp);
        let (median_ms, longest_ms) = (of_page[REPEATS / 2], of_page[REPEATS - 1]);
        times.push(PageTime { depth, median_ms, longest_ms });
    }
    Ok(times)
}

/// Token of the page that follows the first `depth` rows.
async fn token(store: &Store, list: &ListQuery, depth: usize) -> Result<String> {
    if depth == 0 {
        return Ok(String::new());
    }
    let last: String = query_scalar("select id from captures order by id desc limit 1 offset $1")
        .bind(depth as i64 - 1)
        .fetch_one(store.inner.database.read())
        .await?;
    let id = uuid::Uuid::try_parse(&last).map_err(|_| Error::InvalidPageToken)?;
    let page = PageRequest { size: 1, token: String::new() };
    let rows = vec![(), ()];
    let listing = list.listing(Collection::Captures);
    Ok(Page::cut(rows, &page, &listing, |()| (id, String::new())).next_token)
}

/// Inserts rows; `values` writes those of one.
async fn fill(
    store: &Store,
    columns: &str,
    count: usize,
    values: impl Fn(&mut Builder, usize),
) -> Result<()> {
    let all: Vec<usize> = (0..count).collect();
    let mut tx = store.inner.database.write().await?;
    for batch in all.chunks(BATCH) {
        let mut sql = Builder::new("insert into ");
        sql.push(columns).push(" values ");
        for (place, nth) in batch.iter().enumerate() {
            sql.push(if place == 0 { "(" } else { ", (" });
            values(&mut sql, *nth);
            sql.push(")");
        }
        sql.build().execute(&mut tx).await?;
    }
    if store.inner.database.is_remote() {
        // As its own maintenance does within a minute: plans follow statistics.
        query("analyze").execute(&mut tx).await?;
    }
    tx.commit().await
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        database::testing::{On, on_both},
        store::tests::Bench,
    };

    on_both! { nothing_is_lost_and_pages_are_where_they_should_be }

    async fn nothing_is_lost_and_pages_are_where_they_should_be(on: On) {
        let bench = Bench::new(on).await;
        let speed = queue(&bench.store, 4, 30, LEASE).await.unwrap();
        assert_eq!((speed.completed, speed.lost), (30, 0));
        let times = pages(&bench.store, 600).await.unwrap();
        assert_eq!(times.iter().map(|time| time.depth).collect::<Vec<_>>(), [0, 300, 500]);
        let mut list = ListQuery::default();
        list.page.token = token(&bench.store, &list, 300).await.unwrap();
        let page = bench.store.captures().overviews(&list).await.unwrap();
        assert_eq!(page.items[0].capture.labels.display_name, "rope 299");
    }
}
