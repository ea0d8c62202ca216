//! Request ids, by which requests are repeatable. Each owner has its own: two owners may use the same
//! id, and neither learns of the other's resource.
//!
//! The columns `request_id` are unique, and servers of earlier versions, which run beside this one
//! during an upgrade, look for the id alone. So the first owner's id is stored as it was given, and
//! that of a second owner with the owner behind it (docs/adr/0049). Ids and owners have no control
//! characters, so the two parts are distinct.

use std::fmt::Display;

use sqlx::AssertSqlSafe;

use crate::{
    Error, Result,
    sql::{Record, Target, Transaction, query, query_scalar},
};

/// Divides the id from its owner.
pub(crate) const DIVIDER: char = '\u{1f}';

/// A request id of an owner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RequestId<'a> {
    pub(crate) owner: &'a str,
    /// The id as the client gave it.
    pub(crate) id: &'a str,
}

impl<'a> RequestId<'a> {
    /// The id of a request of an owner, if it has one.
    pub(crate) fn of(owner: &'a str, id: Option<&'a str>) -> Option<Self> {
        id.map(|id| Self { owner, id })
    }

    /// The id of a row with this text in its column.
    pub(crate) fn of_row(stored: &'a str, owner: &'a str) -> Self {
        Self { owner, id: given(stored) }
    }

    /// The id with its owner.
    pub(crate) fn qualified(self) -> String {
        format!("{}{DIVIDER}{}", self.id, self.owner)
    }

    /// The row of a table that the request made.
    pub(crate) async fn find<'t, T: Record>(
        self,
        target: impl Into<Target<'t>>,
        columns: &str,
        table: &str,
    ) -> Result<Option<T>> {
        let find = format!(
            "select {columns} from {table}
             where (request_id = $1 and owner = $2) or request_id = $3"
        );
        query(AssertSqlSafe(find))
            .bind(self.id)
            .bind(self.owner)
            .bind(self.qualified())
            .fetch_optional(target)
            .await
    }

    /// Refuses a repetition whose first request made something else, the resource of this name.
    ///
    /// # Errors
    /// [`Error::RequestIdTaken`].
    pub(crate) fn require_same(self, is_same: bool, name: impl Display) -> Result<()> {
        let (request_id, name) = (self.id.to_owned(), name.to_string());
        if is_same { Ok(()) } else { Err(Error::RequestIdTaken { request_id, name }) }
    }

    /// The text for a new row of a table.
    async fn text_in(self, tx: &mut Transaction, table: &str) -> Result<String> {
        let taken = format!("select exists (select 1 from {table} where request_id = $1)");
        let taken: bool = query_scalar(AssertSqlSafe(taken)).bind(self.id).fetch_one(tx).await?;
        Ok(if taken { self.qualified() } else { self.id.to_owned() })
    }
}

/// The text for a new row of a table, null for a request without an id.
pub(crate) async fn text_in(
    request: Option<RequestId<'_>>,
    tx: &mut Transaction,
    table: &str,
) -> Result<Option<String>> {
    match request {
        Some(request) => request.text_in(tx, table).await.map(Some),
        None => Ok(None),
    }
}

/// The id in the text of a column, as the client gave it.
pub(crate) fn given(stored: &str) -> &str {
    stored.split(DIVIDER).next().unwrap_or_default()
}

#[cfg(test)]
mod tests;
