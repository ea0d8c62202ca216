//! Names, notes and tags that people give, and the lists that are searched and sorted by them.

use bendtwin_core::{
    ids::{CaptureId, FitId},
    quality::Level,
};
use bendtwin_proto::v1::{self, Fit, UpdateFitRequest, UpdateTwinRequest};
use bendtwin_store::{
    Job, LabelChange, ListQuery, MAX_TAGS, Order, OrderKey, PageRequest, State, Twin,
};
use prost_types::FieldMask;

use super::{App, Error, Result, rights};
use crate::{access::Scope, audit};

/// Longest text of one line, such as a display name [characters].
const LINE_LENGTH: usize = 200;
/// Longest note [bytes].
const NOTE_BYTES: usize = 10_000;
/// Longest tag [characters].
const TAG_LENGTH: usize = 50;
/// Longest text to search for [characters].
const SEARCH_LENGTH: usize = 200;

/// Labels in a request that updates a resource.
#[derive(Clone, Debug, Default)]
pub(crate) struct GivenLabels {
    pub(crate) display_name: String,
    pub(crate) note: String,
    pub(crate) tags: Vec<String>,
    pub(crate) add_tags: Vec<String>,
    pub(crate) remove_tags: Vec<String>,
}

/// The fields that an update changes (AIP-134): those of its mask, or, without one, those that are
/// not empty.
pub(super) struct Mask {
    given: Option<FieldMask>,
    /// Fields that were asked for.
    known: Vec<&'static str>,
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
    pub(crate) level: String,
}

impl Mask {
    pub(super) fn new(given: Option<FieldMask>) -> Self {
        Self { given, known: Vec::new() }
    }

    /// The value of a field, if the update changes it.
    pub(super) fn changed<T: Default + PartialEq>(
        &mut self,
        field: &'static str,
        value: T,
    ) -> Option<T> {
        self.known.push(field);
        let is_changed = match &self.given {
            Some(mask) => is_whole(mask) || mask.paths.iter().any(|path| path == field),
            None => value != T::default(),
        };
        is_changed.then_some(value)
    }

    /// Refuses paths of other fields than those that were asked for.
    pub(super) fn finish(self) -> Result<()> {
        let Self { given, known } = self;
        let is_known = |path: &String| known.contains(&path.as_str());
        match given {
            Some(mask) if !is_whole(&mask) && !mask.paths.iter().all(is_known) => {
                let fault = format!("has a path other than {}", known.join(", "));
                Err(Error::invalid("update_mask", fault))
            }
            _ => Ok(()),
        }
    }
}

fn is_whole(mask: &FieldMask) -> bool {
    mask.paths == ["*"]
}

impl GivenLabels {
    /// The change, if it may be made.
    pub(super) fn change(self, mask: &mut Mask) -> Result<LabelChange> {
        let Self { display_name, note, tags, add_tags, remove_tags } = self;
        let display_name = mask.changed("display_name", display_name);
        let (note, tags) = (mask.changed("note", note), mask.changed("tags", tags));
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

    /// The change of a resource that has nothing else to change.
    fn whole_change(self, mask: Option<FieldMask>) -> Result<LabelChange> {
        let mut mask = Mask::new(mask);
        let change = self.change(&mut mask)?;
        mask.finish()?;
        Ok(change)
    }
}

impl Listing {
    /// The query, confined to what the caller reaches with a scope and ordered by one of these keys.
    pub(super) fn query(self, scope: Scope, keys: &[(&str, OrderKey)]) -> Result<ListQuery> {
        let Self { page, search, tag, capture, state, owner, order_by, level } = self;
        if search.chars().count() > SEARCH_LENGTH {
            let fault = format!("is longer than {SEARCH_LENGTH} characters");
            return Err(Error::invalid("search", fault));
        }
        let capture: Option<CaptureId> = super::optional_name(&capture)?;
        let (owner, order) = (self::owner(owner)?, order(&order_by, keys)?);
        let (level, shared_with) = (self::level(&level)?, rights::confined(scope));
        let query = ListQuery { search, tag, capture, state, owner, order, level, ..page.into() };
        Ok(ListQuery { shared_with, ..query })
    }
}

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

/// The level of trust of a word; empty means any.
fn level(word: &str) -> Result<Option<Level>> {
    if word.is_empty() {
        return Ok(None);
    }
    let level = Level::ALL.into_iter().find(|level| level.as_str() == word);
    let words = || Level::ALL.map(Level::as_str).join(", ");
    let fault = || Error::invalid("level", format!("must be one of {}", words()));
    level.map(Some).ok_or_else(fault)
}

/// Checks a display name.
pub(super) fn display_name(text: String) -> Result<String> {
    line("display_name", text)
}

/// Checks the name of an owner.
pub(super) fn owner(text: String) -> Result<String> {
    line("owner", text)
}

/// Checks a text of one line.
pub(super) fn line(field: &'static str, text: String) -> Result<String> {
    if text.chars().count() > LINE_LENGTH {
        return Err(Error::invalid(field, format!("is longer than {LINE_LENGTH} characters")));
    }
    if text.chars().any(char::is_control) {
        return Err(Error::invalid(field, "has control characters"));
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
    pub(crate) async fn update_fit(&self, request: UpdateFitRequest) -> Result<Job> {
        let UpdateFitRequest { fit, update_mask, add_tags, remove_tags } = request;
        let Fit { name, display_name, note, tags, .. } = fit.unwrap_or_default();
        let given = GivenLabels { display_name, note, tags, add_tags, remove_tags };
        let done: Result<Job> = async {
            let id: FitId = self.reach(Scope::FitsWrite, &name).await?;
            let change = given.whole_change(update_mask)?;
            self.require_room(0)?;
            let store = self.store.clone();
            self.change(async move { store.jobs().update_fit(id, &change).await }).await
        }
        .await;
        audit::changed("UpdateFit", &name, &done);
        done
    }

    pub(crate) async fn update_twin(&self, request: UpdateTwinRequest) -> Result<Twin> {
        let UpdateTwinRequest { twin, update_mask, add_tags, remove_tags } = request;
        let v1::Twin { name, display_name, note, tags, .. } = twin.unwrap_or_default();
        let given = GivenLabels { display_name, note, tags, add_tags, remove_tags };
        let done: Result<Twin> = async {
            let id = self.reach(Scope::TwinsWrite, &name).await?;
            let change = given.whole_change(update_mask)?;
            self.require_room(0)?;
            let store = self.store.clone();
            self.change(async move { store.twins().update(id, &change).await }).await
        }
        .await;
        audit::changed("UpdateTwin", &name, &done);
        done
    }
}
