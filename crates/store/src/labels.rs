//! Labels that people give to captures, fits and twins: a name, a note and tags. Tags are in
//! each row, to be shown, and in the table `tags`, to be searched by.

use bendtwin_core::{Quality, quality::Measure};
use sqlx::AssertSqlSafe;

use crate::{
    Error, Result, Store,
    sql::{Transaction, query},
};

/// Most tags of a resource.
pub const MAX_TAGS: usize = 32;

/// Name, note and tags of a resource.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Labels {
    /// Display name.
    pub display_name: String,
    /// Text of people for people.
    pub note: String,
    /// Words, sorted, each once.
    pub tags: Vec<String>,
}

/// A change of labels; `None` keeps a value.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LabelChange {
    /// New display name.
    pub display_name: Option<String>,
    /// New note.
    pub note: Option<String>,
    /// New tags in place of those that there are.
    pub tags: Option<Vec<String>>,
    /// Tags to add.
    pub add_tags: Vec<String>,
    /// Tags to take away.
    pub remove_tags: Vec<String>,
}

/// The resources that have labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collection {
    /// Captures.
    Captures,
    /// Fits.
    Fits,
    /// Twins.
    Twins,
}

impl Collection {
    /// All collections.
    pub const ALL: [Self; 3] = [Self::Captures, Self::Fits, Self::Twins];

    /// Name of the collection, in resource names and in `tags`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Captures => "captures",
            Self::Fits => "fits",
            Self::Twins => "twins",
        }
    }

    /// Name of its table.
    pub(crate) fn table(self) -> &'static str {
        match self {
            Self::Captures => "captures",
            Self::Fits => "jobs",
            Self::Twins => "twins",
        }
    }
}

impl Labels {
    /// Labels as columns have them. Tags that are no list of words count as none.
    pub(crate) fn of_row(display_name: String, note: String, tags: &str) -> Self {
        Self { display_name, note, tags: serde_json::from_str(tags).unwrap_or_default() }
    }

    fn changed(&self, change: &LabelChange) -> Self {
        let mut tags = change.tags.clone().unwrap_or_else(|| self.tags.clone());
        tags.retain(|tag| !change.remove_tags.contains(tag));
        tags.extend(change.add_tags.iter().cloned());
        tags.sort();
        tags.dedup();
        let or = |new: &Option<String>, old: &String| new.as_ref().unwrap_or(old).clone();
        Self {
            display_name: or(&change.display_name, &self.display_name),
            note: or(&change.note, &self.note),
            tags,
        }
    }
}

/// The text that a name is sorted by.
pub(crate) fn name_key(display_name: &str) -> String {
    display_name.to_lowercase()
}

/// The text that a resource is searched in.
pub(crate) fn search_text(display_name: &str, note: &str) -> String {
    format!("{display_name}\n{note}").to_lowercase()
}

/// Changes the labels of a row within the caller's transaction. `before` are those that it has.
/// Returns false if nothing changes.
pub(crate) async fn change(
    tx: &mut Transaction,
    collection: Collection,
    id: &str,
    before: &Labels,
    change: &LabelChange,
) -> Result<bool> {
    let labels = before.changed(change);
    if labels.tags.len() > MAX_TAGS {
        let name = format!("{}/{id}", collection.name());
        return Err(Error::TooManyTags { name, limit: MAX_TAGS });
    }
    if labels == *before {
        return Ok(false);
    }
    let update = format!(
        "update {} set first_name = coalesce(first_name, display_name), display_name = $2,
             note = $3, tags = $4, name_key = $5, search_text = $6
         where id = $1",
        collection.table()
    );
    query(AssertSqlSafe(update))
        .bind(id)
        .bind(&labels.display_name)
        .bind(&labels.note)
        .bind(to_json(&labels.tags))
        .bind(name_key(&labels.display_name))
        .bind(search_text(&labels.display_name, &labels.note))
        .execute(&mut *tx)
        .await?;
    if labels.tags != before.tags {
        forget(tx, collection, id).await?;
        for tag in &labels.tags {
            query("insert into tags (kind, tag, resource) values ($1, $2, $3)")
                .bind(collection.name())
                .bind(tag)
                .bind(id)
                .execute(&mut *tx)
                .await?;
        }
    }
    Ok(true)
}

/// Forgets the tags of a resource within the caller's transaction.
pub(crate) async fn forget(tx: &mut Transaction, collection: Collection, id: &str) -> Result<()> {
    query("delete from tags where kind = $1 and resource = $2")
        .bind(collection.name())
        .bind(id)
        .execute(tx)
        .await?;
    Ok(())
}

fn to_json(tags: &[String]) -> String {
    // A list of strings always serialises.
    serde_json::to_string(tags).unwrap_or_default()
}

impl Store {
    /// Fills in what rows from before there were labels are searched and sorted by: texts in lower
    /// case, which SQL does differently everywhere, and errors, which are in documents.
    pub(crate) async fn label_old(&self) -> Result<()> {
        let mut tx = self.inner.database.write().await?;
        let mut count = 0;
        let unnamed = "update jobs set first_name = '', display_name = coalesce(
                 (select display_name from captures where captures.id = jobs.capture), '')
             where kind = 'fit' and search_text is null";
        query(unnamed).execute(&mut tx).await?;
        let twins: Vec<(String, String)> =
            query("select id, quality from twins where search_text is null")
                .fetch_all(&mut tx)
                .await?;
        for (id, quality) in twins {
            for statement in [
                "update twins set error_m = $2 where id = $1",
                "update jobs set error_m = $2 where twin = $1 and kind = 'fit'",
            ] {
                let query = query(statement).bind(&id).bind(error_key(&quality));
                query.execute(&mut tx).await?;
            }
        }
        for (table, filter) in [("captures", ""), ("twins", ""), ("jobs", " and kind = 'fit'")] {
            let old = format!(
                "select id, display_name, note from {table} where search_text is null{filter}"
            );
            let old: Vec<(String, String, String)> =
                query(AssertSqlSafe(old)).fetch_all(&mut tx).await?;
            count += old.len();
            let update =
                format!("update {table} set name_key = $2, search_text = $3 where id = $1");
            for (id, display_name, note) in old {
                query(AssertSqlSafe(update.clone()))
                    .bind(id)
                    .bind(name_key(&display_name))
                    .bind(search_text(&display_name, &note))
                    .execute(&mut tx)
                    .await?;
            }
        }
        let twins: Vec<(String, String)> =
            query("select id, quality from twins where level is null").fetch_all(&mut tx).await?;
        for (id, quality) in twins {
            let update = query("update twins set level = $2 where id = $1");
            update.bind(&id).bind(level(&quality)).execute(&mut tx).await?;
        }
        tx.commit().await?;
        if count > 0 {
            tracing::info!(rows = count, "rows from before there were labels can be searched now");
        }
        Ok(())
    }
}

/// Error [m] of rows without one, which sorts after all others.
const NO_ERROR: f64 = 1e300;

/// The error of a quality table as rows have it.
pub(crate) fn error_key(quality_json: &str) -> f64 {
    key_of(headline(quality_json).map(|(_, error_m)| error_m))
}

/// The error of a quality table with its kind [m].
pub(crate) fn headline(quality_json: &str) -> Option<(Measure, f64)> {
    read(quality_json)?.headline()
}

/// The level of trust of a quality table as rows have it; empty without an assessment.
pub(crate) fn level(quality_json: &str) -> &'static str {
    read(quality_json).and_then(|q| q.assessment).map_or("", |assessment| assessment.level.as_str())
}

fn read(quality_json: &str) -> Option<Quality> {
    serde_json::from_str(quality_json).ok()
}

/// The key of an error.
pub(crate) fn key_of(error_m: Option<f64>) -> f64 {
    error_m.unwrap_or(NO_ERROR)
}

/// The error of a row, if it has one.
pub(crate) fn error_of(key: f64) -> Option<f64> {
    (key < NO_ERROR).then_some(key)
}

#[cfg(test)]
mod tests;
