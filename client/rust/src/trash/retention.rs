//! Rules by which a server deletes captures, fits and twins. All calls take a key with the scope
//! `admin`, or the client token.

use bendtwin_core::ids::RetentionId;
use bendtwin_proto::v1::{
    self, CreateRetentionRuleRequest, DeleteRetentionRuleRequest, GetRetentionRuleRequest,
    ListRetentionRulesRequest, PreviewRetentionRequest,
    retention_service_client::RetentionServiceClient,
};
use jiff::Timestamp;
use serde::Serialize;

use crate::{Error, client::Channel, resources::resource};

resource! { v1::RetentionRule =>
/// A rule. It matches what fulfils all of its conditions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RetentionRule {
    /// Name of the rule; none of a rule of the server's configuration.
    pub name: Option<RetentionId>,
    /// Display name.
    pub display_name: String,
    /// `captures`, `fits` or `twins`.
    pub collection: String,
    /// Least age since the creation [days].
    pub min_age_days: f64,
    /// An owner; empty for any.
    pub owner: String,
    /// A tag; empty for any.
    pub tag: String,
    /// The verdict of a capture's report; empty for any.
    pub verdict: String,
    /// Time of creation; none of a rule of the server's configuration.
    pub create_time: Option<Timestamp>,
}
}

resource! { v1::RetentionOutcome =>
/// A capture, fit or twin that a rule matches.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RetentionOutcome {
    /// Name of the resource.
    pub name: String,
    /// Display name.
    pub display_name: String,
    /// Owner; empty if that is not known.
    pub owner: String,
    /// Time of creation.
    pub create_time: Timestamp,
    /// Size of the archive of a capture, or of a twin file; 0 for a fit [bytes].
    pub size_bytes: u64,
    /// Display name of the rule.
    pub rule: String,
    /// Why it is kept; none if it would be deleted.
    pub kept_because: Option<String>,
}
}

/// A preview of what the rules do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RetentionPreview {
    /// What the rules match, in the order of deletion.
    pub outcomes: Vec<RetentionOutcome>,
    /// True if there are more.
    pub truncated: bool,
}

/// A rule to be made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewRetentionRule {
    /// Display name.
    pub display_name: String,
    /// `captures`, `fits` or `twins`.
    pub collection: String,
    /// Least age since the creation [days].
    pub min_age_days: f64,
    /// An owner; empty for any.
    pub owner: String,
    /// A tag; empty for any.
    pub tag: String,
    /// The verdict of a capture's report; empty for any.
    pub verdict: String,
}

/// Calls about rules.
#[derive(Clone, Debug)]
pub struct Retention {
    service: RetentionServiceClient<Channel>,
}

impl Retention {
    pub(crate) fn new(service: RetentionServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Makes a rule.
    ///
    /// # Errors
    /// If it is refused, or the server cannot be asked.
    pub async fn create(&self, new: NewRetentionRule) -> Result<RetentionRule, Error> {
        let request = CreateRetentionRuleRequest {
            display_name: new.display_name,
            collection: new.collection,
            min_age_days: new.min_age_days,
            owner: new.owner,
            tag: new.tag,
            verdict: new.verdict,
        };
        self.service.clone().create_retention_rule(request).await?.into_inner().try_into()
    }

    /// Returns a rule.
    ///
    /// # Errors
    /// If the rule does not exist, or the server cannot be asked.
    pub async fn get(&self, name: RetentionId) -> Result<RetentionRule, Error> {
        let request = GetRetentionRuleRequest { name: name.to_string() };
        self.service.clone().get_retention_rule(request).await?.into_inner().try_into()
    }

    /// All rules, those of the server's configuration first.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn list(&self) -> Result<Vec<RetentionRule>, Error> {
        let request = ListRetentionRulesRequest {};
        let reply = self.service.clone().list_retention_rules(request).await?.into_inner();
        reply.rules.into_iter().map(RetentionRule::try_from).collect()
    }

    /// Deletes a rule.
    ///
    /// # Errors
    /// If the rule does not exist, or the server cannot be asked.
    pub async fn delete(&self, name: RetentionId) -> Result<(), Error> {
        let request = DeleteRetentionRuleRequest { name: name.to_string() };
        self.service.clone().delete_retention_rule(request).await?;
        Ok(())
    }

    /// What the rules would delete now, and what they match but is kept.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn preview(&self) -> Result<RetentionPreview, Error> {
        let request = PreviewRetentionRequest {};
        let reply = self.service.clone().preview_retention(request).await?.into_inner();
        let outcomes = reply.outcomes.into_iter().map(RetentionOutcome::try_from);
        Ok(RetentionPreview {
            outcomes: outcomes.collect::<Result<_, _>>()?,
            truncated: reply.truncated,
        })
    }
}
