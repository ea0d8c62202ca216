//! Retention: rules of the configuration and of the API, their preview, and the sweep that applies them.

use std::time::Duration;

use bendtwin_core::ids::RetentionId;
use bendtwin_store::{NewRule, Preview, Rule};

use crate::{
    app::{App, Error, Result},
    audit,
    options::RetentionRule,
};

/// Most resources that one sweep deletes; the next one continues.
const MOST_DELETED: usize = 1000;
/// Most resources of a preview that are deleted, and that are kept.
const MOST_SHOWN: usize = 1000;
/// Least time for which what a rule deletes stays in the trash, also where people have none.
const LEAST_KEPT: Duration = Duration::from_secs(86_400);

impl App {
    pub(crate) async fn create_retention_rule(&self, rule: RetentionRule) -> Result<Rule> {
        let done: Result<Rule> = async {
            let conditions =
                rule.conditions().map_err(|(field, fault)| Error::invalid(field, fault))?;
            self.require_room(0)?;
            let store = self.store.clone();
            self.change(async move { store.retention().create(conditions).await }).await
        }
        .await;
        audit::made("CreateRetentionRule", &done, |rule| rule.id.to_string());
        done
    }

    pub(crate) async fn retention_rule(&self, name: &str) -> Result<Rule> {
        Ok(self.store.retention().get(crate::app::name(name)?).await?)
    }

    /// The rules of the configuration, and those of the API.
    pub(crate) async fn retention_rules(&self) -> Result<(Vec<NewRule>, Vec<Rule>)> {
        Ok((self.options.retention_rules(), self.store.retention().list().await?))
    }

    pub(crate) async fn delete_retention_rule(&self, name: &str) -> Result<()> {
        let done: Result<()> = async {
            let id: RetentionId = crate::app::name(name)?;
            let store = self.store.clone();
            self.change(async move { store.retention().delete(id).await }).await
        }
        .await;
        audit::changed("DeleteRetentionRule", name, &done);
        done
    }

    /// What the rules would delete now, and what they match but is kept.
    pub(crate) async fn preview_retention(&self) -> Result<Preview> {
        let rules = self.rules_in_force().await?;
        Ok(self.store.retention().preview(&rules, MOST_SHOWN).await?)
    }

    /// Moves what the rules match to the trash.
    pub(crate) async fn sweep_retention(&self) -> Result<()> {
        let rules = self.rules_in_force().await?;
        let (store, kept) = (self.store.clone(), self.options.trash().max(LEAST_KEPT));
        let moved = self
            .change(async move { store.retention().apply(&rules, kept, MOST_DELETED).await })
            .await?;
        for found in &moved {
            tracing::info!(resource = %found.resource, rule = found.rule, "deleted by a rule");
            audit::by_server("Retention", found.resource, &found.rule);
            if let bendtwin_store::Resource::Twin(id) = found.resource {
                self.dispatch.forget_twin(id);
            }
        }
        Ok(())
    }

    async fn rules_in_force(&self) -> Result<Vec<NewRule>> {
        let (configured, stored) = self.retention_rules().await?;
        Ok(configured.into_iter().chain(stored.into_iter().map(|rule| rule.conditions)).collect())
    }
}
