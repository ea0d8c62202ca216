//! What people state about captures, fits and twins, and lists that are searched and ordered by it.

use bendtwin_core::{ids::CaptureId, quality::Level, settings::ingest::IngestSettings};
use bendtwin_proto::v1::{ListCapturesRequest, UpdateCaptureRequest};
use prost_types::FieldMask;
use serde::Serialize;
use serde_json::Value;

use crate::{Error, JobState, PageRequest, Requirements, resources::are_none};

/// Facts about a capture that accompany its upload; those that are empty are not stated. A text
/// alone is the display name.
///
/// ```
/// use bendtwin_client::CaptureFacts;
///
/// let facts = CaptureFacts::from("rope");
/// # let _ = facts;
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct CaptureFacts {
    /// Display name; none leaves the capture without one
    #[cfg_attr(
        feature = "clap",
        arg(long = "name", value_name = "NAME", help = "Display name [default: the file's name]")
    )]
    pub display_name: Option<String>,
    /// Who recorded the capture
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub recorded_by: Option<String>,
    /// Settings of the ingest; none means the defaults
    #[cfg_attr(feature = "clap", arg(skip))]
    pub ingest: Option<IngestSettings>,
    /// Worker that the ingest asks for
    #[serde(skip_serializing_if = "are_none")]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub ingest_requirements: Requirements,
}

impl From<&str> for CaptureFacts {
    fn from(display_name: &str) -> Self {
        Self { display_name: Some(display_name.to_owned()), ..Self::default() }
    }
}

impl CaptureFacts {
    /// The facts by name: texts unchanged, others as JSON.
    pub(crate) fn pairs(&self) -> Result<Vec<(String, String)>, Error> {
        let facts = serde_json::to_value(self).map_err(Error::malformed)?;
        let pairs = facts.as_object().into_iter().flatten();
        Ok(pairs
            .filter_map(|(name, value)| match value {
                Value::Null => None,
                Value::String(text) => Some((name.clone(), text.clone())),
                value => Some((name.clone(), value.to_string())),
            })
            .collect())
    }
}

/// A change of what is stated about a resource; what is not set stays.
///
/// ```
/// use bendtwin_client::Update;
///
/// let update = Update::default().note("left hand, slow").add_tag("wet").remove_tag("dry");
/// # let _ = update;
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// New display name.
    pub display_name: Option<String>,
    /// New note.
    pub note: Option<String>,
    /// New tags in place of all; not beside those below.
    pub tags: Option<Vec<String>>,
    /// Tags to add to those that there are.
    pub add_tags: Vec<String>,
    /// Tags to take from those that there are.
    pub remove_tags: Vec<String>,
    /// New name of who recorded it, of captures; refused for fits and twins.
    pub recorded_by: Option<String>,
}

impl Update {
    /// A new display name.
    pub fn display_name(mut self, name: impl Into<String>) -> Self {
        self.display_name = Some(name.into());
        self
    }

    /// A new note.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = Some(note.into());
        self
    }

    /// Adds a tag.
    pub fn add_tag(mut self, tag: impl Into<String>) -> Self {
        self.add_tags.push(tag.into());
        self
    }

    /// A new name of who recorded a capture.
    pub fn recorded_by(mut self, name: impl Into<String>) -> Self {
        self.recorded_by = Some(name.into());
        self
    }

    /// Removes a tag.
    pub fn remove_tag(mut self, tag: impl Into<String>) -> Self {
        self.remove_tags.push(tag.into());
        self
    }

    /// The fields that it sets.
    pub(crate) fn mask(&self) -> Option<FieldMask> {
        let set = [
            ("display_name", self.display_name.is_some()),
            ("note", self.note.is_some()),
            ("tags", self.tags.is_some()),
            ("recorded_by", self.recorded_by.is_some()),
        ];
        let paths = set.into_iter().filter(|(_, set)| *set).map(|(field, _)| field.to_owned());
        Some(FieldMask { paths: paths.collect() })
    }
}

/// Order of a list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Newest first.
    #[default]
    Newest,
    /// Oldest first.
    Oldest,
    /// Display name.
    Name,
    /// Error of the twin, the smallest first; captures have no error.
    Error,
}

impl Order {
    /// The order in a request.
    pub(crate) fn order_by(self) -> String {
        match self {
            Self::Newest => "create_time desc",
            Self::Oldest => "create_time",
            Self::Name => "name",
            Self::Error => "error",
        }
        .to_owned()
    }
}

/// The message that changes the labels of a resource.
macro_rules! update_request {
    ($request:ident { $field:ident: $message:ident }, $name:expr, $update:expr) => {{
        let update: &$crate::Update = $update;
        let changed = bendtwin_proto::v1::$message {
            name: $name.to_string(),
            display_name: update.display_name.clone().unwrap_or_default(),
            note: update.note.clone().unwrap_or_default(),
            tags: update.tags.clone().unwrap_or_default(),
            ..Default::default()
        };
        $request {
            $field: Some(changed),
            update_mask: update.mask(),
            add_tags: update.add_tags.clone(),
            remove_tags: update.remove_tags.clone(),
        }
    }};
}

/// The message that asks for a page of a list, with what only this list can be asked for.
macro_rules! list_request {
    ($request:ident { $($field:ident),* }, $query:expr) => {{
        let query: $crate::ListQuery = $query;
        $request {
            $($field,)*
            order_by: query.order.order_by(),
            page_size: query.page.size,
            page_token: query.page.token,
            search: query.search,
            tag: query.tag,
            owner: query.owner,
        }
    }};
}

pub(crate) use {list_request, update_request};

/// The message that changes what is stated about a capture.
pub(crate) fn capture_update(name: CaptureId, update: &Update) -> UpdateCaptureRequest {
    let mut request = update_request!(UpdateCaptureRequest { capture: Capture }, name, update);
    let capture = request.capture.get_or_insert_default();
    capture.recorded_by = update.recorded_by.clone().unwrap_or_default();
    request
}

/// The message that asks for a page of captures.
pub(crate) fn capture_list(query: ListQuery) -> ListCapturesRequest {
    let recorded_by = query.recorded_by.clone();
    list_request!(ListCapturesRequest { recorded_by }, query)
}

/// Selection of a list; the default is everything, newest first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ListQuery {
    /// Text in display name or note, ignoring case; empty means any.
    pub search: String,
    /// A tag; empty means any.
    pub tag: String,
    /// An owner; empty means any.
    pub owner: String,
    /// Who recorded it, of captures; empty means any. Lists of fits and twins ignore it.
    pub recorded_by: String,
    /// A capture, of fits and twins.
    pub capture: Option<CaptureId>,
    /// A state, of fits.
    pub state: Option<JobState>,
    /// A level of trust, of twins.
    pub level: Option<Level>,
    /// The order.
    pub order: Order,
    /// The page; calls for all pages ignore it.
    pub page: PageRequest,
}

impl ListQuery {
    /// The fits and twins of a capture; without a capture, of all.
    pub fn of_capture(capture: Option<CaptureId>) -> Self {
        Self { capture, ..Self::default() }
    }

    pub(crate) fn capture_name(&self) -> String {
        self.capture.map(|c| c.to_string()).unwrap_or_default()
    }

    pub(crate) fn level_word(&self) -> String {
        self.level.map(Level::as_str).unwrap_or_default().to_owned()
    }
}

#[cfg(test)]
mod tests;
