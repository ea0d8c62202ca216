//! Name, note and tags of captures, fits and twins on the command line, and the choice of a list.

use bendtwin_client::{ListQuery, Order, Update};
use clap::{Args, ValueEnum};

use crate::failure::Usage;

/// Changes of name, note and tags.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Changes {
    /// New display name
    #[arg(long = "name", value_name = "NAME")]
    display_name: Option<String>,
    /// New note; an empty one removes it
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
    /// Tag to add (+wet) or to take away (-wet); may be repeated
    #[arg(long = "tag", value_name = "+TAG|-TAG", allow_hyphen_values = true)]
    tags: Vec<String>,
}

impl From<Changes> for Update {
    fn from(Changes { display_name, note, tags }: Changes) -> Self {
        let mut update = Self { display_name, note, ..Self::default() };
        for tag in tags {
            match (tag.strip_prefix('+'), tag.strip_prefix('-')) {
                (Some(tag), _) => update.add_tags.push(tag.to_owned()),
                (_, Some(tag)) => update.remove_tags.push(tag.to_owned()),
                _ => update.add_tags.push(tag),
            }
        }
        update
    }
}

/// An update, refused if it changes nothing.
pub(crate) fn update(update: impl Into<Update>) -> anyhow::Result<Update> {
    let update = update.into();
    if update == Update::default() {
        return Err(Usage::error("name a change, for example --note TEXT or --tag +WORD"));
    }
    Ok(update)
}

/// Search and order of a list.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Choice {
    /// List only those whose name or note has this text
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true)]
    search: String,
    /// List only those with this tag
    #[arg(long, value_name = "TAG", default_value = "", hide_default_value = true)]
    tag: String,
    /// List only those of this owner: the owner of the key with which they were made
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    owner: String,
    /// Order of the list
    #[arg(long, value_name = "KEY", value_enum, default_value_t)]
    sort: Sort,
}

/// Orders of lists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Sort {
    /// The newest first
    #[default]
    Newest,
    /// The oldest first
    Oldest,
    /// Order by name
    Name,
    /// The smallest error on future frames first; for fits and twins
    Error,
}

impl Choice {
    /// The order in a request.
    pub(crate) fn query(self) -> ListQuery {
        let order = match self.sort {
            Sort::Newest => Order::Newest,
            Sort::Oldest => Order::Oldest,
            Sort::Name => Order::Name,
            Sort::Error => Order::Error,
        };
        let Self { search, tag, owner, .. } = self;
        ListQuery { search, tag, owner, order, ..ListQuery::default() }
    }
}

/// Note and tags as lines of what `show` prints; empty without any.
pub(crate) fn lines(note: &str, tags: &[String], width: usize) -> String {
    let mut lines = String::new();
    if !note.is_empty() {
        let indented = note.trim_end().replace('\n', &format!("\n  {:width$}", ""));
        lines += &format!("\n  {:width$}{indented}", "note");
    }
    if !tags.is_empty() {
        lines += &format!("\n  {:width$}{}", "tags", tags.join(", "));
    }
    lines
}

/// A name with its tags, for a column of a list.
pub(crate) fn what(display_name: &str, tags: &[String]) -> String {
    match tags {
        [] => display_name.to_owned(),
        tags => format!("{display_name} [{}]", tags.join(", ")),
    }
}

/// An error in millimetres, for a column of a list.
pub(crate) fn millimetres(error_m: Option<f64>) -> String {
    error_m.map(|e| format!("{:.1} mm", 1e3 * e)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_added_and_taken_away() {
        let tags = ["+wet", "-dry", "blue"].map(str::to_owned).into();
        let changes = Changes { tags, ..Changes::default() };
        assert_eq!(
            Update::from(changes),
            Update::default().add_tag("wet").remove_tag("dry").add_tag("blue")
        );
        assert!(update(Changes::default()).is_err());
        let emptied = Changes { note: Some(String::new()), ..Changes::default() };
        assert_eq!(update(emptied).unwrap().note.as_deref(), Some(""));
    }

    #[test]
    fn notes_stay_in_their_column() {
        let text = lines("one\ntwo\n", &["a".to_owned(), "b".to_owned()], 8);
        assert_eq!(text, "\n  note    one\n          two\n  tags    a, b");
        assert_eq!(lines("", &[], 8), "");
        assert_eq!(what("rope", &["a".to_owned()]), "rope [a]");
        assert_eq!(millimetres(Some(0.0123)), "12.3 mm");
    }
}
