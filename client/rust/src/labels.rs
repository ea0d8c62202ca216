//! Labels of captures, fits and twins, and lists that are searched and ordered by them.

use bendtwin_core::ids::CaptureId;
use prost_types::FieldMask;

use crate::{JobState, PageRequest};

/// A change of name, note and tags; what is not set stays.
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

/// Selection of a list; the default is everything, newest first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ListQuery {
    /// Text in display name or note, ignoring case; empty means any.
    pub search: String,
    /// A tag; empty means any.
    pub tag: String,
    /// An owner; empty means any.
    pub owner: String,
    /// A capture, of fits and twins.
    pub capture: Option<CaptureId>,
    /// A state, of fits.
    pub state: Option<JobState>,
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
}
