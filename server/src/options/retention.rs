//! A rule of retention, as the configuration and the API state it.

use std::time::Duration;

use bendtwin_store::{Collection, NewRule};
use serde::{Deserialize, Serialize};

/// Greatest least age [days].
const MOST_DAYS: f64 = 36_500.0;
/// Longest texts [characters].
const NAME_LENGTH: usize = 200;
const WORD_LENGTH: usize = 50;

/// A rule by which captures, fits or twins are moved to the trash. It matches what fulfils all of its
/// conditions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RetentionRule {
    /// Display name.
    pub display_name: String,
    /// `captures`, `fits` or `twins`.
    pub collection: String,
    /// Least age since the creation [days].
    pub min_age_days: f64,
    /// An owner; empty for any.
    #[serde(default)]
    pub owner: String,
    /// A tag; empty for any.
    #[serde(default)]
    pub tag: String,
    /// The verdict of a capture's report; empty for any.
    #[serde(default)]
    pub verdict: String,
}

impl RetentionRule {
    /// The conditions, checked.
    ///
    /// # Errors
    /// The field that is wrong, and its fault.
    pub(crate) fn conditions(&self) -> Result<NewRule, (&'static str, String)> {
        let collection = Collection::ALL.into_iter().find(|of| of.name() == self.collection);
        let collection = collection.ok_or_else(|| {
            let given: String = self.collection.chars().take(40).collect();
            ("collection", format!("is `{given}`: it must be captures, fits or twins"))
        })?;
        if !(self.min_age_days >= 0.0 && self.min_age_days <= MOST_DAYS) {
            let fault = format!("is {}: it must lie in 0..={MOST_DAYS}", self.min_age_days);
            return Err(("min_age_days", fault));
        }
        if self.display_name.trim().is_empty() {
            return Err(("display_name", "is empty: say what the rule is for".to_owned()));
        }
        for (field, text, most) in [
            ("display_name", &self.display_name, NAME_LENGTH),
            ("owner", &self.owner, NAME_LENGTH),
            ("tag", &self.tag, WORD_LENGTH),
            ("verdict", &self.verdict, WORD_LENGTH),
        ] {
            if text.chars().count() > most || text.chars().any(char::is_control) {
                let rule = format!("must be up to {most} characters without control characters");
                return Err((field, rule));
            }
        }
        if !self.verdict.is_empty() && collection != Collection::Captures {
            return Err(("verdict", "is only of captures: leave it out".to_owned()));
        }
        Ok(NewRule {
            display_name: self.display_name.clone(),
            collection,
            min_age: Duration::from_secs_f64(self.min_age_days * 86_400.0),
            owner: self.owner.clone(),
            tag: self.tag.clone(),
            verdict: self.verdict.clone(),
        })
    }
}
