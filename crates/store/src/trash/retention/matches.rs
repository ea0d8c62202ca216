//! The statement that finds what a rule matches, with the reason for which it is kept.

use bendtwin_core::ids::TwinId;

use super::{KEEP_TAG, Kept, Match, NewRule, Retention};
use crate::{
    Collection, Error, Resource, Result,
    sql::{Builder, Transaction, row, row::row},
    store::clock::from_micros,
};

row! {
    struct Row {
        id: String,
        display_name: String,
        owner: String,
        created_at: i64,
        size_bytes: i64,
        // A word, and the id of what keeps it.
        kept: Option<String>,
    }
}

impl Row {
    fn read(self, rule: &NewRule) -> Result<Match> {
        let id = row::id(rule.collection.name(), &self.id)?;
        let kept = self.kept.as_deref().map(|kept| read_kept(kept, &self.id)).transpose()?;
        Ok(Match {
            resource: Resource::new(rule.collection, id),
            display_name: self.display_name,
            owner: self.owner,
            created: from_micros(self.created_at),
            size_bytes: self.size_bytes.max(0) as u64,
            rule: rule.display_name.clone(),
            kept,
        })
    }
}

fn read_kept(text: &str, of: &str) -> Result<Kept> {
    let (word, id) = text.split_once(' ').unwrap_or((text, ""));
    Ok(match word {
        "tag" => Kept::Tagged,
        "self" => Kept::UnderWay,
        "ingest" => Kept::Ingest(row::id("ingests", id)?.into()),
        "fit" => Kept::Fit(row::id("fits", id)?.into()),
        "twin" => Kept::Twin(row::id("twins", id)?.into()),
        _ => {
            return Err(Error::CorruptRow {
                name: of.to_owned(),
                fault: format!("kept by {word}"),
            });
        }
    })
}

/// The reason for which a row `t` is kept, as a word and an id, or null. Twins that are `gone` keep
/// nothing.
fn push_kept(sql: &mut Builder, collection: Collection, gone: &[TwinId]) {
    const UNDER_WAY: &str = "state in ('queued', 'running')";
    sql.push("coalesce((select 'tag' from tags as g where g.resource = t.id and g.kind = ");
    sql.push_bind(collection.name()).push(" and g.tag = ").push_bind(KEEP_TAG).push("), ");
    match collection {
        Collection::Captures => {
            for kind in ["ingest", "fit"] {
                sql.push(format_args!(
                    "(select '{kind} ' || min(j.id) from jobs as j
                      where j.capture = t.id and j.kind = '{kind}' and j.{UNDER_WAY}), "
                ));
            }
            push_twin(sql, "capture", gone);
        }
        Collection::Fits => {
            sql.push(format_args!("case when t.{UNDER_WAY} then 'self' end, "));
            push_twin(sql, "fit", gone);
        }
        Collection::Twins => {
            // The settings name the twin that a fit starts from.
            sql.push(format_args!(
                "(select 'fit ' || min(j.id) from jobs as j where j.kind = 'fit' and j.{UNDER_WAY}
                  and j.settings like '%' || t.id || '%')"
            ));
        }
    }
    sql.push(")");
}

/// The first twin that was made from a row, and is kept.
fn push_twin(sql: &mut Builder, column: &str, gone: &[TwinId]) {
    sql.push(format_args!(
        "(select 'twin ' || min(w.id) from twins as w
          where w.{column} = t.id and w.trashed_at is null"
    ));
    if !gone.is_empty() {
        sql.push(" and w.id not in (");
        sql.push_list(gone.iter().map(|twin| twin.uuid().to_string())).push(")");
    }
    sql.push(")");
}

impl Retention<'_> {
    /// The beginning of a statement for what a rule matches, as `m`.
    fn select(&self, rule: &NewRule, gone: &[TwinId]) -> Builder {
        let collection = rule.collection;
        let size = match collection {
            Collection::Captures | Collection::Twins => "t.size_bytes",
            Collection::Fits => "cast(0 as bigint) as size_bytes",
        };
        let mut sql = Builder::new("select * from (select t.id, t.display_name, t.owner, ");
        sql.push(format_args!("t.created_at, {size}, "));
        push_kept(&mut sql, collection, gone);
        sql.push(format_args!(" as kept from {} as t", collection.table()));
        let age = i64::try_from(rule.min_age.as_micros()).unwrap_or(i64::MAX);
        let until = self.store.now_micros().saturating_sub(age);
        sql.push(" where t.trashed_at is null and t.created_at <= ").push_bind(until);
        if collection == Collection::Fits {
            sql.push(" and t.kind = 'fit'");
        }
        if !rule.owner.is_empty() {
            sql.push(" and t.owner = ").push_bind(&rule.owner);
        }
        if !rule.tag.is_empty() {
            sql.push(" and exists (select 1 from tags as h where h.resource = t.id and h.kind = ");
            sql.push_bind(collection.name()).push(" and h.tag = ").push_bind(&rule.tag).push(")");
        }
        if !rule.verdict.is_empty() {
            sql.push(" and exists (select 1 from reports as r where r.capture = t.id");
            sql.push(" and r.verdict = ").push_bind(&rule.verdict).push(")");
        }
        sql.push(") as m");
        sql
    }

    /// At most `limit` matches of a rule that are kept, or that are not, the oldest first. Twins that
    /// are `gone` keep nothing.
    pub(super) async fn matches(
        &self,
        rule: &NewRule,
        kept: bool,
        gone: &[TwinId],
        limit: usize,
    ) -> Result<Vec<Match>> {
        let mut sql = self.select(rule, gone);
        sql.push(if kept { " where kept is not null" } else { " where kept is null" });
        sql.push(" order by id limit ").push_bind(i64::try_from(limit).unwrap_or(i64::MAX));
        let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        rows.into_iter().map(|row| row.read(rule)).collect()
    }

    /// True if a rule still matches a resource that nothing keeps, within the transaction that
    /// deletes it.
    pub(super) async fn still_matches(
        &self,
        tx: &mut Transaction,
        rule: &NewRule,
        resource: Resource,
    ) -> Result<bool> {
        let mut sql = self.select(rule, &[]);
        sql.push(" where kept is null and id = ").push_bind(resource.key());
        let row: Option<Row> = sql.build().fetch_optional(tx).await?;
        Ok(row.is_some())
    }
}
