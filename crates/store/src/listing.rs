//! Lists of captures, fits and twins: searched, filtered and ordered.
//!
//! A page begins after the last row of the page before, by its place in the order, so rows that come
//! and go in between neither repeat nor hide others. Every order is that of an index: a page deep in
//! a list costs what the first one does. A search for text reads the rows in that order until the
//! page is full.

pub(crate) mod page;

use bendtwin_core::{ids::CaptureId, quality::Level};

use self::page::Place;
use crate::{
    Error, PageRequest, Result, State, Store, labels::Collection, owners::projects, sql::Builder,
};

/// Rows up to which a list is counted: a count reads every one of them.
const MOST_COUNTED: i64 = 10_000;

/// Key by which a list is ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OrderKey {
    /// Time of creation.
    #[default]
    CreateTime,
    /// Display name, ignoring case.
    Name,
    /// Error of a twin; those without one come last in ascending order. Captures have none.
    Error,
}

/// Order of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// Sort key; rows of equal keys are in the order of their creation.
    pub key: OrderKey,
    /// True if the largest comes first.
    pub descending: bool,
}

impl Default for Order {
    /// Newest first.
    fn default() -> Self {
        Self { key: OrderKey::CreateTime, descending: true }
    }
}

/// Selection of a list; the default is all, newest first.
#[derive(Clone, Debug, Default)]
pub struct ListQuery {
    /// The page.
    pub page: PageRequest,
    /// The order.
    pub order: Order,
    /// Text in display name or note, ignoring case; empty means any.
    pub search: String,
    /// A tag; empty means any.
    pub tag: String,
    /// A capture; captures themselves cannot be filtered by it.
    pub capture: Option<CaptureId>,
    /// A state of the job; fits alone can be filtered by it.
    pub state: Option<State>,
    /// An owner; empty means any.
    pub owner: String,
    /// Who recorded it, of captures; empty means any.
    pub recorded_by: String,
    /// The level of trust in a twin; twins alone can be filtered by it.
    pub level: Option<Level>,
    /// An owner to whom the list is confined, with the owners who share a project with it; `None`
    /// for no bound. It is no part of the selection: a page token stays good when projects change.
    pub shared_with: Option<String>,
}

impl From<PageRequest> for ListQuery {
    fn from(page: PageRequest) -> Self {
        Self { page, ..Self::default() }
    }
}

impl ListQuery {
    /// Identity of the listing that tokens belong to: all but the page.
    pub(crate) fn listing(&self, collection: Collection) -> String {
        let Self {
            page: _,
            order,
            search,
            tag,
            capture,
            state,
            owner,
            recorded_by,
            level,
            shared_with: _,
        } = self;
        let selection = (order, search, tag, capture, state, owner, recorded_by, level);
        format!("{} {selection:?}", collection.name())
    }

    /// The statement for a page, `select *` and one row more than the page.
    pub(crate) fn select(&self, collection: Collection) -> Result<Builder> {
        let place = self.page.place(&self.listing(collection))?;
        let mut sql = Builder::new("select t.* from ");
        self.push_matching(&mut sql, collection);
        // Tags have the ids in their order, too.
        let id = if self.tag.is_empty() { "t.id" } else { "g.resource" };
        self.resume_after(&mut sql, id, place)?;
        let (direction, key) = (if self.order.descending { "desc" } else { "asc" }, self.column());
        sql.push(" order by ");
        if let Some(key) = key {
            sql.push(format_args!("{key} {direction}, "));
        }
        sql.push(format_args!("{id} {direction} limit ")).push_bind(self.page.fetch());
        Ok(sql)
    }

    /// The number of rows of all pages, up to [`MOST_COUNTED`]; `None` behind the first page, whose reader knows it.
    pub(crate) async fn total(&self, store: &Store, collection: Collection) -> Result<Option<u32>> {
        if !self.page.token.is_empty() {
            return Ok(None);
        }
        let mut sql = Builder::new("select count(*) from (select 1 as found from ");
        self.push_matching(&mut sql, collection);
        sql.push(" limit ").push_bind(MOST_COUNTED).push(") as matching");
        let (count,): (i64,) = sql.build().fetch_one(store.inner.database.read()).await?;
        Ok(Some(u32::try_from(count).unwrap_or(u32::MAX)))
    }

    /// The table of a collection and the conditions on its rows.
    fn push_matching(&self, sql: &mut Builder, collection: Collection) {
        let table = collection.table();
        if self.tag.is_empty() {
            sql.push(format_args!("{table} as t where "));
        } else {
            sql.push(format_args!("tags as g join {table} as t on t.id = g.resource"));
            sql.push(" where g.kind = ").push_bind(collection.name());
            sql.push(" and g.tag = ").push_bind(self.tag.clone()).push(" and ");
        }
        // Rows with a tag of fits are fits: an index of kinds would be the worse way to them.
        let all_kinds = collection != Collection::Fits || !self.tag.is_empty();
        sql.push(if all_kinds { "" } else { "t.kind = 'fit' and " });
        sql.push("t.trashed_at is null");
        if let Some(capture) = self.capture {
            sql.push(" and t.capture = ").push_bind(capture.uuid().to_string());
        }
        if let Some(state) = self.state {
            sql.push(" and t.state = ").push_bind(state.as_str());
        }
        if let Some(level) = self.level {
            sql.push(" and t.level = ").push_bind(level.as_str());
        }
        if !self.owner.is_empty() {
            sql.push(" and t.owner = ").push_bind(self.owner.clone());
        }
        if let Some(owner) = &self.shared_with {
            projects::push_shared_with(sql, "t.owner", owner);
        }
        if !self.recorded_by.is_empty() {
            sql.push(" and t.recorded_by = ").push_bind(self.recorded_by.clone());
        }
        if !self.search.is_empty() {
            sql.push(" and t.search_text like ").push_bind(pattern(&self.search));
            sql.push(" escape '\\'");
        }
    }

    /// Leaves out the rows up to a place in the order.
    fn resume_after(&self, sql: &mut Builder, id: &str, place: Option<Place>) -> Result<()> {
        let Some(Place { id: last, key }) = place else { return Ok(()) };
        let than = if self.order.descending { '<' } else { '>' };
        match self.column() {
            None => sql.push(format_args!(" and {id} {than} ")).push_bind(last),
            Some(column) => {
                sql.push(format_args!(" and ({column}, {id}) {than} ("));
                match self.order.key {
                    OrderKey::Error => sql.push_bind(error_of_key(&key)?),
                    _ => sql.push_bind(key),
                };
                sql.push(", ").push_bind(last).push(")")
            }
        };
        Ok(())
    }

    /// The column of the order before the id, whose order is that of creation.
    fn column(&self) -> Option<&'static str> {
        match self.order.key {
            OrderKey::CreateTime => None,
            OrderKey::Name => Some("t.name_key"),
            OrderKey::Error => Some("t.error_m"),
        }
    }

    /// The key of a row in this order as text.
    pub(crate) fn key(&self, name_key: &str, error_m: f64) -> String {
        match self.order.key {
            OrderKey::CreateTime => String::new(),
            OrderKey::Name => name_key.to_owned(),
            // All digits: it is compared with.
            OrderKey::Error => format!("{:016x}", error_m.to_bits()),
        }
    }
}

fn error_of_key(key: &str) -> Result<f64> {
    u64::from_str_radix(key, 16).map(f64::from_bits).map_err(|_| Error::InvalidPageToken)
}

/// A pattern for texts that contain this one.
fn pattern(text: &str) -> String {
    let mut pattern = String::from("%");
    for letter in text.to_lowercase().chars() {
        if matches!(letter, '%' | '_' | '\\') {
            pattern.push('\\');
        }
        pattern.push(letter);
    }
    pattern + "%"
}

#[cfg(test)]
mod tests;
