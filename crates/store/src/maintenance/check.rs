//! Check of a whole store. It changes nothing.

use std::{collections::BTreeSet, io, path::Path};

use serde::Serialize;

use super::{
    integrity, rows,
    survey::{self, Damage, Depth},
};
use crate::{
    Error, Result,
    blobs::{
        files,
        references::{self, Reference},
    },
    database,
    sql::query,
};

/// Advice where content is not in the folder.
const NOT_CHECKED: &str = "its storage checks it, and every reader compares the digest";

/// Findings of a check.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CheckReport {
    /// Faults of the database file.
    pub database: Vec<String>,
    /// True if database and blobs have different identities.
    pub mismatch: bool,
    /// Number of references of rows to blobs.
    pub references: usize,
    /// Number of blobs.
    pub blobs: usize,
    /// Sizes of the blobs together [bytes].
    pub blobs_bytes: u64,
    /// Content of rows that is missing or damaged.
    pub damaged: Vec<Damage>,
    /// Blobs that no row refers to: harmless, the server moves them to the trash.
    pub unreferenced: Vec<Unreferenced>,
}

/// A blob without a row.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unreferenced {
    /// BLAKE3 in its name.
    pub digest: String,
    /// Size [bytes].
    pub size_bytes: u64,
}

impl CheckReport {
    /// True if nothing is damaged or missing.
    pub fn is_sound(&self) -> bool {
        self.database.is_empty() && !self.mismatch && self.damaged.is_empty()
    }
}

/// Checks a store, beside a running server or without one, or a backup.
///
/// # Errors
/// [`Error::NotFound`] if there is no database; [`Error::StoreNewer`], [`Error::StoreOlder`]; database and file errors other than damage.
pub async fn check(data_dir: &Path, depth: Depth) -> Result<CheckReport> {
    database::require_none(data_dir)?;
    database::require_local_objects(data_dir, NOT_CHECKED)?;
    let mut report = CheckReport::default();
    let blobs = data_dir.join("blobs");
    let mut connection = match integrity::read_only(data_dir).await {
        Err(Error::DatabaseDamaged { fault }) => {
            report.database.push(fault);
            return Ok(report);
        }
        connection => connection?,
    };
    report.database = integrity::faults(&mut connection).await?;
    if report.database.is_empty() {
        rows::require_current(&mut connection).await?;
    }
    let survey = async {
        let mine = integrity::identity(&mut connection).await?;
        let theirs = files::identity(&blobs)?;
        report.mismatch = theirs.is_some() && mine != theirs;
        let references = all(&mut connection).await?;
        report.references = references.len();
        let inspected = tokio::task::spawn_blocking(move || inspect(&blobs, &references, depth));
        let (there, damaged) = inspected.await.map_err(io::Error::other)??;
        report.blobs = there.len();
        report.blobs_bytes = there.iter().map(|(_, size_bytes)| size_bytes).sum();
        // Rows came and went beside a running server: what counts is what is true before and after.
        let after: BTreeSet<String> =
            all(&mut connection).await?.into_iter().map(|reference| reference.digest).collect();
        report.damaged = damaged.into_iter().filter(|d| after.contains(&d.digest)).collect();
        let strangers = there.into_iter().filter(|(digest, _)| !after.contains(digest));
        report.unreferenced =
            strangers.map(|(digest, size_bytes)| Unreferenced { digest, size_bytes }).collect();
        Ok(())
    };
    match survey.await {
        Err(Error::DatabaseDamaged { fault }) => report.database.push(fault),
        surveyed => surveyed?,
    }
    Ok(report)
}

/// All references of rows to blobs.
pub(super) async fn all(connection: &mut sqlx::SqliteConnection) -> Result<Vec<Reference>> {
    query(references::ALL).fetch_all(connection).await
}

type Inspected = (Vec<(String, u64)>, Vec<Damage>);

fn inspect(blobs: &Path, references: &[Reference], depth: Depth) -> io::Result<Inspected> {
    let there = files::all(blobs)?;
    let mut damaged = Vec::new();
    for reference in references {
        damaged.extend(survey::inspect(blobs, reference, depth)?);
    }
    Ok((there, damaged))
}
