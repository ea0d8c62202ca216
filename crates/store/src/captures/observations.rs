//! Results of ingests: the observation that fits read, and the report. One row each for a capture,
//! replaced by the next ingest, as are playback and masks (`products`).

use bendtwin_core::ids::CaptureId;
use jiff::Timestamp;

use super::products::{self, Product};
use crate::{
    Captures, Content, Digest, Error, Result,
    keys::usage::settle,
    sql::{Builder, Transaction, query, row::row},
    store::clock::from_micros,
};

/// Observation of a capture, made by its last successful ingest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Time of storage.
    pub created: Timestamp,
    /// Size of the bundle [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of the bundle.
    pub digest: Digest,
}

/// Report of a capture, made by the last ingest that had one.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Time of storage.
    pub created: Timestamp,
    /// The verdict: one lower-case word.
    pub verdict: String,
    /// BLAKE3 of the document.
    pub json: Digest,
    /// BLAKE3 of the page.
    pub html: Digest,
}

/// Results to be stored.
pub(crate) struct NewResults {
    /// True if the ingest succeeded: its results replace all that were stored.
    pub(crate) succeeded: bool,
    /// Digests and sizes, in the order of [`Product::ALL`]; there is no observation after masks alone.
    pub(crate) products: [Option<(Digest, u64)>; 3],
    pub(crate) verdict: String,
    pub(crate) json: Digest,
    pub(crate) html: Digest,
    /// Size of document and page together [bytes].
    pub(crate) report_bytes: u64,
}

row! {
    struct ObservationRow {
        capture: String,
        created_at: i64,
        size_bytes: i64,
        digest: String,
    }
}

row! {
    struct ReportRow {
        capture: String,
        created_at: i64,
        verdict: String,
        json_digest: String,
        html_digest: String,
    }
}

fn digest(hex: &str, of: &str, capture: &str) -> Result<Digest> {
    Digest::from_hex(hex).map_err(|_| Error::CorruptRow {
        name: format!("{of} of captures/{capture}"),
        fault: "digest".to_owned(),
    })
}

impl TryFrom<ObservationRow> for Observation {
    type Error = Error;
    fn try_from(row: ObservationRow) -> Result<Self> {
        Ok(Self {
            created: from_micros(row.created_at),
            size_bytes: row.size_bytes.max(0) as u64,
            digest: digest(&row.digest, "observation", &row.capture)?,
        })
    }
}

impl TryFrom<ReportRow> for Report {
    type Error = Error;
    fn try_from(row: ReportRow) -> Result<Self> {
        Ok(Self {
            created: from_micros(row.created_at),
            json: digest(&row.json_digest, "report", &row.capture)?,
            html: digest(&row.html_digest, "report", &row.capture)?,
            verdict: row.verdict,
        })
    }
}

impl Captures<'_> {
    /// The observation of a capture, if there is one.
    ///
    /// # Errors
    /// Database errors.
    pub async fn observation(&self, id: CaptureId) -> Result<Option<Observation>> {
        let row: Option<ObservationRow> = query("select * from observations where capture = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.map(Observation::try_from).transpose()
    }

    /// The bundle of a capture's observation.
    ///
    /// # Errors
    /// [`Error::NotFound`] without an observation, [`Error::ContentLost`],
    /// [`Error::ContentDamaged`].
    pub async fn observation_content(&self, id: CaptureId) -> Result<(Observation, Content)> {
        let name = format!("the observation of {id}");
        self.require(id).await?;
        let found = self.observation(id).await?;
        let observation = found.ok_or_else(|| Error::NotFound { name: name.clone() })?;
        let content = self
            .store
            .blobs()
            .read(&observation.digest, Some(observation.size_bytes), &name)
            .await?;
        Ok((observation, content))
    }

    /// The report of a capture, if there is one.
    ///
    /// # Errors
    /// Database errors.
    pub async fn report(&self, id: CaptureId) -> Result<Option<Report>> {
        let key = id.uuid().to_string();
        Ok(self.reports_of(&[key]).await?.pop().map(|(_, report)| report))
    }

    /// The reports of these captures, in any order, by the captures' keys.
    pub(crate) async fn reports_of(&self, captures: &[String]) -> Result<Vec<(String, Report)>> {
        let mut sql = Builder::new("select * from reports where capture in (");
        sql.push_list(captures).push(")");
        let rows: Vec<ReportRow> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        rows.into_iter().map(|row| Ok((row.capture.clone(), row.try_into()?))).collect()
    }

    /// A capture's report, as a document or as a page.
    ///
    /// # Errors
    /// [`Error::NotFound`] without a report, [`Error::ContentLost`], [`Error::ContentDamaged`].
    pub async fn report_content(&self, id: CaptureId, page: bool) -> Result<Content> {
        let name = format!("the report of {id}");
        self.require(id).await?;
        let report = self.report(id).await?;
        let report = report.ok_or_else(|| Error::NotFound { name: name.clone() })?;
        let digest = if page { report.html } else { report.json };
        self.store.blobs().read(&digest, None, &name).await
    }
}

/// Replaces the rows of a capture. Returns the content that is obsolete afterwards.
pub(crate) async fn replace(
    tx: &mut Transaction,
    capture: &str,
    made: &NewResults,
    now: i64,
) -> Result<Vec<String>> {
    let mut obsolete = forget_report(tx, capture).await?;
    query(
        "insert into reports (capture, created_at, verdict, json_digest, html_digest, size_bytes)
         values ($1, $2, $3, $4, $5, $6)",
    )
    .bind(capture)
    .bind(now)
    .bind(&made.verdict)
    .bind(made.json.to_hex().as_str())
    .bind(made.html.to_hex().as_str())
    .bind(i64::try_from(made.report_bytes).unwrap_or(i64::MAX))
    .execute(&mut *tx)
    .await?;
    // An ingest that was refused leaves what it does not replace.
    for (product, made_now) in Product::ALL.into_iter().zip(made.products) {
        if made.succeeded || made_now.is_some() {
            obsolete.extend(products::replace(tx, product, capture, made_now, now).await?);
        }
    }
    settle::count_derived(tx, &[capture.to_owned()]).await?;
    Ok(obsolete)
}

/// Removes all rows of a capture. Returns the content that is obsolete afterwards.
pub(crate) async fn forget(tx: &mut Transaction, capture: &str) -> Result<Vec<String>> {
    let mut obsolete = forget_report(tx, capture).await?;
    for product in Product::ALL {
        obsolete.extend(products::forget(tx, product, capture).await?);
    }
    Ok(obsolete)
}

async fn forget_report(tx: &mut Transaction, capture: &str) -> Result<Vec<String>> {
    let digests: Option<(String, String)> =
        query("delete from reports where capture = $1 returning json_digest, html_digest")
            .bind(capture)
            .fetch_optional(&mut *tx)
            .await?;
    Ok(digests.into_iter().flat_map(|(json, html)| [json, html]).collect())
}
