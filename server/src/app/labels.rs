//! Names, notes and tags that people give, and the lists that are searched and sorted by them.

use bendtwin_core::ids::{CaptureId, FitId};
use bendtwin_store::{
    Job, LabelChange, ListQuery, MAX_TAGS, Order, OrderKey, Overview, PageRequest, State, Twin,
};

use super::{App, Error, Result};
use crate::audit;

/// Longest display name [characters].
const NAME_LENGTH: usize = 200;
/// Longest note [bytes].
const NOTE_BYTES: usize = 10_000;
/// Longest tag [characters].
const TAG_LENGTH: usize = 50;
/// Longest text to search for [characters].
const SEARCH_LENGTH: usize = 200;

/// A requested change of name, note and tags; `None` keeps a value.
#[derive(Clone, Debug, Default)]
pub(crate) struct Change {
    pub(crate) display_name: Option<String>,
    pub(crate) note: Option<String>,
    pub(crate) tags: Option<Vec<String>>,
    pub(crate) add_tags: Vec<String>,
    pub(crate) remove_tags: Vec<String>,
}

/// A requested list; empty fields mean no filter, and newest first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Listing {
    pub(crate) page: PageRequest,
    pub(crate) search: String,
    pub(crate) tag: String,
    pub(crate) capture: String,
    pub(crate) state: Option<State>,
    pub(crate) owner: String,
    pub(crate) order_by: String,
}

impl Change {
    /// The change, if it is one that may be made.
    fn check(self) -> Result<LabelChange> {
        let Self { display_name, note, tags, add_tags, remove_tags } = self;
        if tags.is_some() && !(add_tags.is_empty() && remove_tags.is_empty()) {
            let fault = "replaces all tags: leave add_tags and remove_tags out beside it";
            return Err(Error::invalid("tags", fault));
        }
        Ok(LabelChange {
            display_name: display_name.map(self::display_name).transpose()?,
            note: note.map(self::note).transpose()?,
            tags: tags.map(|tags| self::tags("tags", tags)).transpose()?,
            add_tags: self::tags("add_tags", add_tags)?,
            remove_tags: self::tags("remove_tags", remove_tags)?,
        })
    }
}

impl Listing {
    /// The query, ordered by one of these keys.
    pub(super) fn query(self, keys: &[(&str, OrderKey)]) -> Result<ListQuery> {
        let Self { page, search, tag, capture, state, owner, order_by } = self;
        if search.chars().count() > SEARCH_LENGTH {
            let fault = format!("is longer than {SEARCH_LENGTH} characters");
            return Err(Error::invalid("search", fault));
        }
        let capture: Option<CaptureId> = super::optional_name(&capture)?;
        let (owner, order) = (self::owner(owner)?, order(&order_by, keys)?);
        Ok(ListQuery { page, search, tag, capture, state, owner, order })
    }
}

/// Orders of captures.
pub(super) const CAPTURE_ORDERS: [(&str, OrderKey); 2] =
    [("create_time", OrderKey::CreateTime), ("name", OrderKey::Name)];
/// Orders of fits and twins.
pub(super) const ORDERS: [(&str, OrderKey); 3] =
    [("create_time", OrderKey::CreateTime), ("name", OrderKey::Name), ("error", OrderKey::Error)];

/// Reads `key` or `key desc`; empty means newest first.
fn order(text: &str, keys: &[(&str, OrderKey)]) -> Result<Order> {
    let mut words = text.split_whitespace();
    let Some(word) = words.next() else { return Ok(Order::default()) };
    let descending = match (words.next(), words.next()) {
        (None | Some("asc"), None) => Some(false),
        (Some("desc"), None) => Some(true),
        _ => None,
    };
    let key = keys.iter().find(|(name, _)| *name == word).map(|(_, key)| *key);
    match (key, descending) {
        (Some(key), Some(descending)) => Ok(Order { key, descending }),
        _ => {
            let names: Vec<&str> = keys.iter().map(|(name, _)| *name).collect();
            let fault =
                format!("must be one of {}, alone or followed by ` desc`", names.join(", "));
            Err(Error::invalid("order_by", fault))
        }
    }
}

/// Checks a display name.
pub(super) fn display_name(text: String) -> Result<String> {
    if text.chars().count() > NAME_LENGTH {
        let fault = format!("is longer than {NAME_LENGTH} characters");
        return Err(Error::invalid("display_name", fault));
    }
    if text.chars().any(char::is_control) {
        return Err(Error::invalid("display_name", "has control characters"));
    }
    Ok(text)
}

/// Checks the name of an owner.
pub(super) fn owner(text: String) -> Result<String> {
    if text.chars().count() > NAME_LENGTH || text.chars().any(char::is_control) {
        let fault = format!("must be up to {NAME_LENGTH} characters without control characters");
        return Err(Error::invalid("owner", fault));
    }
    Ok(text)
}

fn note(text: String) -> Result<String> {
    if text.len() > NOTE_BYTES {
        return Err(Error::invalid("note", format!("is longer than {NOTE_BYTES} bytes")));
    }
    if text.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\t')) {
        return Err(Error::invalid("note", "has control characters other than tabs and line ends"));
    }
    Ok(text)
}

fn tags(field: &'static str, tags: Vec<String>) -> Result<Vec<String>> {
    if tags.len() > MAX_TAGS {
        return Err(Error::invalid(field, format!("has more than {MAX_TAGS} words")));
    }
    let allowed = |c: char| c.is_alphanumeric() || "-_.:/".contains(c);
    let is_word = |tag: &String| {
        tag.starts_with(char::is_alphanumeric)
            && tag.chars().count() <= TAG_LENGTH
            && tag.chars().all(allowed)
    };
    match tags.iter().find(|tag| !is_word(tag)) {
        None => Ok(tags),
        Some(_) => {
            let fault = format!(
                "has a tag that is not a word of 1 to {TAG_LENGTH} letters, digits and -_.:/ that \
                 begins with a letter or digit"
            );
            Err(Error::invalid(field, fault))
        }
    }
}

impl App {
    pub(crate) async fn update_capture(&self, name: &str, change: Change) -> Result<Overview> {
        let done: Result<Overview> = async {
            let (id, change) = (super::name(name)?, change.check()?);
            self.require_room(0)?;
            let store = self.store.clone();
            self.change(async move { store.captures().update(id, &change).await }).await?;
            Ok(self.store.captures().overview(id).await?)
        }
        .await;
        audit::changed("UpdateCapture", name, &done);
        done
    }

    pub(crate) async fn update_fit(&self, name: &str, change: Change) -> Result<Job> {
        let done: Result<Job> = async {
            let (id, change): (FitId, _) = (super::name(name)?, change.check()?);
            self.require_room(0)?;
            let store = self.store.clone();
            self.change(async move { store.jobs().update_fit(id, &change).await }).await
        }
        .await;
        audit::changed("UpdateFit", name, &done);
        done
    }

    pub(crate) async fn update_twin(&self, name: &str, change: Change) -> Result<Twin> {
        let done: Result<Twin> = async {
            let (id, change) = (super::name(name)?, change.check()?);
            self.require_room(0)?;
            let store = self.store.clone();
            self.change(async move { store.twins().update(id, &change).await }).await
        }
        .await;
        audit::changed("UpdateTwin", name, &done);
        done
    }
}
