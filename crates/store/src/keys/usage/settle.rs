//! Sizes that rows have for their owner's usage, and that rows of older versions lack: of reports, of
//! checkpoints, and of what was made of a capture. The sizes themselves are known where content is;
//! asking for all of them takes long in a bucket, so a running server does so in small steps.

use crate::{
    Result, Store,
    sql::{Builder, Transaction, query, query_scalar},
};

/// The turn to settle sizes: `sizes` in ASCII.
const TURN: i64 = 0x0073_697a_6573;
/// Rows of one step.
const STEP: i64 = 200;

/// Size of what was made of a capture, in SQL.
const DERIVED: &str = "
    coalesce((select size_bytes from observations where capture = captures.id), 0)
    + coalesce((select size_bytes from playbacks where capture = captures.id), 0)
    + coalesce((select size_bytes from masks where capture = captures.id), 0)
    + coalesce((select size_bytes from reports where capture = captures.id), 0)";

/// Writes the size of what was made of captures into their rows.
pub(crate) async fn count_derived(tx: &mut Transaction, captures: &[String]) -> Result<()> {
    let mut sql = Builder::new("update captures set derived_bytes = ");
    sql.push(DERIVED).push(" where id in (").push_list(captures).push(")");
    sql.build().execute(tx).await?;
    Ok(())
}

impl Store {
    /// Fills in sizes that rows lack, in small steps. Safe at any time, also beside other servers, of
    /// which one at a time does it. Returns the number of rows that changed.
    ///
    /// # Errors
    /// Database and file errors; [`Error::ObjectsUnavailable`](crate::Error::ObjectsUnavailable).
    pub async fn settle_sizes(&self) -> Result<usize> {
        let Some(turn) = self.inner.database.turn(TURN).await? else { return Ok(0) };
        let settled: Result<usize> = async {
            let measured = self.measure_reports().await? + self.measure_checkpoints().await?;
            Ok(measured + self.settle_derived().await?)
        }
        .await;
        let ended = turn.end().await;
        let settled = settled?;
        ended.map(|()| settled)
    }

    async fn measure_reports(&self) -> Result<usize> {
        let mut count = 0;
        let mut last = String::new();
        loop {
            let rows: Vec<(String, String, String)> = query(
                "select capture, json_digest, html_digest from reports
                 where size_bytes is null and capture > $1 order by capture limit $2",
            )
            .bind(&last)
            .bind(STEP)
            .fetch_all(self.inner.database.read())
            .await?;
            let Some((capture, ..)) = rows.last() else { return Ok(count) };
            last.clone_from(capture);
            let mut sizes = Vec::with_capacity(rows.len());
            for (_, json, html) in &rows {
                sizes.push(self.measure(json).await?.saturating_add(self.measure(html).await?));
            }
            let mut tx = self.inner.database.write().await?;
            for ((capture, json, _), size) in rows.iter().zip(sizes) {
                // Unless it has been replaced meanwhile.
                query(
                    "update reports set size_bytes = $3
                     where capture = $1 and json_digest = $2 and size_bytes is null",
                )
                .bind(capture)
                .bind(json)
                .bind(size)
                .execute(&mut tx)
                .await?;
            }
            tx.commit().await?;
            count += rows.len();
        }
    }

    async fn measure_checkpoints(&self) -> Result<usize> {
        let rows: Vec<(String, String)> = query(
            "select id, checkpoint from jobs
             where checkpoint is not null and checkpoint_bytes is null",
        )
        .fetch_all(self.inner.database.read())
        .await?;
        for (job, checkpoint) in &rows {
            let size = self.measure(checkpoint).await?;
            let mut tx = self.inner.database.write().await?;
            query("update jobs set checkpoint_bytes = $3 where id = $1 and checkpoint = $2")
                .bind(job)
                .bind(checkpoint)
                .bind(size)
                .execute(&mut tx)
                .await?;
            tx.commit().await?;
        }
        Ok(rows.len())
    }

    /// Counts again what was made of captures whose rows have another size of it.
    async fn settle_derived(&self) -> Result<usize> {
        let different = format!("select id from captures where derived_bytes <> ({DERIVED})");
        let different: Vec<String> = query_scalar(sqlx::AssertSqlSafe(different))
            .fetch_all(self.inner.database.read())
            .await?;
        for captures in different.chunks(STEP as usize) {
            let mut tx = self.inner.database.write().await?;
            count_derived(&mut tx, captures).await?;
            tx.commit().await?;
        }
        Ok(different.len())
    }

    /// Size of content [bytes]; 0 if it is lost.
    async fn measure(&self, digest: &str) -> Result<i64> {
        let size = self.blobs().size(digest).await?.unwrap_or_default();
        Ok(i64::try_from(size).unwrap_or(i64::MAX))
    }
}
