//! A document of any format as a tree.

/// Most values in a document.
pub(super) const MAX_VALUES: usize = 200_000;
/// Deepest nesting.
pub(super) const MAX_DEPTH: usize = 24;

/// A value of a document.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A text or number as it was written.
    Text(String),
    /// A list.
    List(Vec<Value>),
    /// Keys and values in their order.
    Map(Vec<(String, Value)>),
}

impl Value {
    /// The value of the first of some keys that is there, in any case.
    pub(super) fn get(&self, keys: &[&str]) -> Option<&Value> {
        let Self::Map(entries) = self else { return None };
        keys.iter().find_map(|key| {
            entries.iter().find(|(name, _)| name.eq_ignore_ascii_case(key)).map(|(_, value)| value)
        })
    }

    /// Entries of a map.
    pub(super) fn entries(&self) -> &[(String, Value)] {
        match self {
            Self::Map(entries) => entries,
            _ => &[],
        }
    }

    /// A text.
    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// All numbers of a list of lists, row by row, or of a text with spaces between; `None` if there
    /// is anything else.
    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::Text(text) => text
                .split_ascii_whitespace()
                .map(|n| n.parse().ok().filter(|x: &f64| x.is_finite()))
                .collect(),
            Self::List(list) => {
                let parts: Option<Vec<Vec<f64>>> = list.iter().map(Self::numbers).collect();
                Some(parts?.concat())
            }
            Self::Map(_) => None,
        }
    }
}
