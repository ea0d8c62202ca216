//! Retention: rules by which captures, fits and twins are moved to the trash, and what is kept from
//! them and why. Rules of a server's configuration come with each call, those of the API are rows.
//!
//! A statement finds what a rule matches, with the reason for which it is kept, so that the preview and
//! the sweep cannot differ. Twins go first, then fits, then captures: what only depended on a twin
//! that goes is not kept.

mod matches;
mod rules;

use std::{collections::BTreeSet, fmt, time::Duration};

use bendtwin_core::ids::{FitId, IngestId, RetentionId, TwinId};
use jiff::Timestamp;

use crate::{Collection, Deletion, Error, Resource, Result, Store};

/// Tag of what no rule deletes.
pub const KEEP_TAG: &str = "keep";
/// The turn to apply rules: `retains` in ASCII.
const TURN: i64 = 0x0072_6574_6169_6e73;
/// Order in which rules of the collections are applied.
const ORDER: [Collection; 3] = [Collection::Twins, Collection::Fits, Collection::Captures];

/// A rule to be stored, or one of a server's configuration. It matches what fulfils all of its
/// conditions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewRule {
    /// Display name.
    pub display_name: String,
    /// The collection whose resources it matches.
    pub collection: Collection,
    /// Least age since the creation of a resource.
    pub min_age: Duration,
    /// An owner; empty for any.
    pub owner: String,
    /// A tag; empty for any.
    pub tag: String,
    /// The verdict of a capture's report; empty for any. Fits and twins have none.
    pub verdict: String,
}

/// A stored rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rule {
    /// Id of the rule.
    pub id: RetentionId,
    /// Conditions of the rule.
    pub conditions: NewRule,
    /// Time of creation.
    pub created: Timestamp,
}

/// The reason for which a resource is kept that a rule matches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// The tag [`KEEP_TAG`].
    Tagged,
    /// The fit itself is queued or running.
    UnderWay,
    /// The ingest of a capture is queued or running.
    Ingest(IngestId),
    /// A fit that needs it is queued or running.
    Fit(FitId),
    /// A twin that was made from a capture, or by a fit, is kept.
    Twin(TwinId),
}

impl fmt::Display for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tagged => write!(f, "it has the tag `{KEEP_TAG}`"),
            Self::UnderWay => f.write_str("it is queued or running"),
            Self::Ingest(_) => f.write_str("its ingest is queued or running"),
            Self::Fit(fit) => write!(f, "{fit}, which needs it, is queued or running"),
            Self::Twin(twin) => write!(f, "{twin}, which was made from it, is kept"),
        }
    }
}

/// A resource that a rule matches.
#[derive(Clone, Debug, PartialEq)]
pub struct Match {
    /// Name of the resource.
    pub resource: Resource,
    /// Display name.
    pub display_name: String,
    /// Owner; empty if that is not known.
    pub owner: String,
    /// Time of its creation.
    pub created: Timestamp,
    /// Size of the archive of a capture, or of a twin file; 0 of a fit [bytes].
    pub size_bytes: u64,
    /// Display name of the rule.
    pub rule: String,
    /// The reason for which it is kept; none if it is deleted.
    pub kept: Option<Kept>,
}

/// Matches of rules.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preview {
    /// The matches, in the order of deletion.
    pub matches: Vec<Match>,
    /// True if there are more.
    pub truncated: bool,
}

/// The retention of a store.
#[derive(Clone, Copy, Debug)]
pub struct Retention<'a> {
    pub(crate) store: &'a Store,
}

/// The rules of the collections in their order.
fn ordered(rules: &[NewRule]) -> impl Iterator<Item = &NewRule> {
    ORDER.into_iter().flat_map(|of| rules.iter().filter(move |rule| rule.collection == of))
}

impl Retention<'_> {
    /// What these rules would delete now, and what matches one but is kept: at most `most` of either.
    ///
    /// # Errors
    /// Database errors.
    pub async fn preview(&self, rules: &[NewRule], most: usize) -> Result<Preview> {
        let (mut preview, mut seen) = (Preview::default(), BTreeSet::new());
        let (mut deleted, mut kept) = (0, 0);
        let mut gone = Vec::new();
        for rule in ordered(rules) {
            for (keeps, count) in [(false, &mut deleted), (true, &mut kept)] {
                // What an earlier rule matched may come once more.
                let limit = most - *count + seen.len() + 1;
                let found = self.matches(rule, keeps, &gone, limit).await?;
                for found in found {
                    if !seen.insert(found.resource) {
                        continue;
                    }
                    if *count == most {
                        preview.truncated = true;
                        break;
                    }
                    *count += 1;
                    if let (Resource::Twin(twin), None) = (found.resource, found.kept) {
                        gone.push(twin);
                    }
                    preview.matches.push(found);
                }
            }
        }
        Ok(preview)
    }

    /// Moves at most `most` of what these rules match to the trash, for `kept` each. Of servers that
    /// share the database, one at a time does it. Returns what it moved.
    ///
    /// # Errors
    /// Database errors.
    pub async fn apply(
        &self,
        rules: &[NewRule],
        kept: Duration,
        most: usize,
    ) -> Result<Vec<Match>> {
        if rules.is_empty() {
            return Ok(Vec::new());
        }
        let Some(turn) = self.store.inner.database.turn(TURN).await? else {
            return Ok(Vec::new());
        };
        let applied = self.apply_in_turn(rules, kept, most).await;
        let ended = turn.end().await;
        let applied = applied?;
        ended?;
        Ok(applied)
    }

    async fn apply_in_turn(
        &self,
        rules: &[NewRule],
        kept: Duration,
        most: usize,
    ) -> Result<Vec<Match>> {
        let mut moved = Vec::new();
        for rule in ordered(rules) {
            let found = self.matches(rule, false, &[], most - moved.len()).await?;
            let deletion = Deletion { kept, by: format!("retention: {}", rule.display_name) };
            for found in found {
                let mut tx = self.store.inner.database.write().await?;
                // The resource may have been changed, deleted or used since it was found.
                if !self.still_matches(&mut tx, rule, found.resource).await? {
                    continue;
                }
                match self.store.trash().put_within(tx, found.resource, &deletion).await {
                    Ok(_) => moved.push(found),
                    Err(Error::CaptureInUse { .. } | Error::FitRunning { .. }) => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(moved)
    }
}

#[cfg(test)]
mod tests;
