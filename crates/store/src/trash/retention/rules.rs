//! The rules that were made by the API.

use std::time::Duration;

use bendtwin_core::ids::RetentionId;

use super::{NewRule, Retention, Rule};
use crate::{
    Collection, Error, Result,
    sql::{query, query_scalar, row, row::row},
    store::clock::from_micros,
};

/// Most stored rules.
pub(super) const MOST: i64 = 100;

row! {
    struct Row {
        id: String,
        display_name: String,
        collection: String,
        min_age: i64,
        owner: String,
        tag: String,
        verdict: String,
        created_at: i64,
    }
}

impl TryFrom<Row> for Rule {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let collection = Collection::ALL.into_iter().find(|c| c.name() == row.collection);
        let collection = collection.ok_or_else(|| Error::CorruptRow {
            name: format!("retention/{}", row.id),
            fault: "collection".to_owned(),
        })?;
        let min_age = Duration::from_micros(row.min_age.max(0) as u64);
        Ok(Self {
            id: row::id("retention", &row.id)?.into(),
            conditions: NewRule {
                display_name: row.display_name,
                collection,
                min_age,
                owner: row.owner,
                tag: row.tag,
                verdict: row.verdict,
            },
            created: from_micros(row.created_at),
        })
    }
}

impl Retention<'_> {
    /// Stores a rule.
    ///
    /// # Errors
    /// [`Error::TooManyRules`].
    pub async fn create(&self, rule: NewRule) -> Result<Rule> {
        let mut tx = self.store.inner.database.write().await?;
        let count: i64 =
            query_scalar("select count(*) from retention_rules").fetch_one(&mut tx).await?;
        if count >= MOST {
            return Err(Error::TooManyRules { limit: MOST as u64 });
        }
        let row: Row = query(
            "insert into retention_rules (id, display_name, collection, min_age, owner, tag,
                 verdict, created_at)
             values ($1, $2, $3, $4, $5, $6, $7, $8) returning *",
        )
        .bind(RetentionId::generate().uuid().to_string())
        .bind(&rule.display_name)
        .bind(rule.collection.name())
        .bind(i64::try_from(rule.min_age.as_micros()).unwrap_or(i64::MAX))
        .bind(&rule.owner)
        .bind(&rule.tag)
        .bind(&rule.verdict)
        .bind(self.store.now_micros())
        .fetch_one(&mut tx)
        .await?;
        tx.commit().await?;
        row.try_into()
    }

    /// Returns a stored rule.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: RetentionId) -> Result<Rule> {
        let row: Option<Row> = query("select * from retention_rules where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// All stored rules, the oldest first.
    ///
    /// # Errors
    /// Database errors.
    pub async fn list(&self) -> Result<Vec<Rule>> {
        let rows: Vec<Row> = query("select * from retention_rules order by id")
            .fetch_all(self.store.inner.database.read())
            .await?;
        rows.into_iter().map(Rule::try_from).collect()
    }

    /// Deletes a stored rule.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn delete(&self, id: RetentionId) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        let deleted = query("delete from retention_rules where id = $1")
            .bind(id.uuid().to_string())
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        if deleted == 0 { Err(Error::NotFound { name: id.to_string() }) } else { Ok(()) }
    }
}
