//! Projects: sets of owners who share. `access` decides what a membership allows.

use bendtwin_core::ids::ProjectId;
use bendtwin_proto::v1::UpdateProjectRequest;
use bendtwin_store::{MemberChange, Page, PageRequest, Project, ProjectChange};

use super::{
    App, Error, Result,
    labels::{self, Mask},
};
use crate::{
    access::{Caller, Scope},
    audit,
    context::Context,
};

/// A requested project.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProjectOrder {
    pub(crate) display_name: String,
    pub(crate) members: Vec<String>,
}

impl App {
    pub(crate) async fn create_project(&self, order: ProjectOrder) -> Result<Project> {
        let done: Result<Project> = async {
            let (name, members) = (display_name(order.display_name)?, order.members);
            let members = self::members("members", members)?;
            self.require_room(0)?;
            let store = self.store.clone();
            let create = async move { store.projects().create(&name, &members).await };
            let project = self.change(create).await?;
            self.keys.forget();
            Ok(project)
        }
        .await;
        audit::made("CreateProject", &done, |project| project.id.to_string());
        done
    }

    /// A project, if it is the caller's or the caller administers all.
    pub(crate) async fn project(&self, name: &str) -> Result<Project> {
        let project = self.store.projects().get(super::name(name)?).await?;
        let Caller { owner, scopes, .. } = Context::current().caller;
        if scopes.has(Scope::Admin) || project.members.iter().any(|member| *member == *owner) {
            return Ok(project);
        }
        Err(Error::NotMember { name: project.id.to_string(), owner: owner.to_string() })
    }

    /// A page of the caller's projects, or of all that there are if the caller administers them.
    pub(crate) async fn projects(&self, page: &PageRequest) -> Result<Page<Project>> {
        let Caller { owner, scopes, .. } = Context::current().caller;
        let member = (!scopes.has(Scope::Admin)).then_some(&*owner);
        Ok(self.store.projects().list(page, member).await?)
    }

    pub(crate) async fn update_project(&self, request: UpdateProjectRequest) -> Result<Project> {
        let name = request.project.as_ref().map(|p| p.name.clone()).unwrap_or_default();
        let done: Result<Project> = async {
            let (id, change): (ProjectId, _) = (super::name(&name)?, change(request)?);
            self.require_room(0)?;
            let store = self.store.clone();
            let update = async move { store.projects().update(id, &change).await };
            let project = self.change(update).await?;
            self.keys.forget();
            Ok(project)
        }
        .await;
        audit::changed("UpdateProject", &name, &done);
        done
    }

    pub(crate) async fn delete_project(&self, name: &str) -> Result<()> {
        let done: Result<()> = async {
            let id: ProjectId = super::name(name)?;
            let store = self.store.clone();
            self.change(async move { store.projects().delete(id).await }).await?;
            self.keys.forget();
            Ok(())
        }
        .await;
        audit::changed("DeleteProject", name, &done);
        done
    }
}

/// The change that an update requests.
fn change(request: UpdateProjectRequest) -> Result<ProjectChange> {
    let UpdateProjectRequest { project, update_mask, add_members, remove_members } = request;
    let project = project.unwrap_or_default();
    let mut mask = Mask::new(update_mask);
    let name = mask.changed("display_name", project.display_name);
    let all = mask.changed("members", project.members);
    mask.finish()?;
    if all.is_some() && !(add_members.is_empty() && remove_members.is_empty()) {
        let fault = "replaces all members: leave add_members and remove_members out beside it";
        return Err(Error::invalid("members", fault));
    }
    let members = MemberChange {
        all: all.map(|all| members("members", all)).transpose()?,
        add: members("add_members", add_members)?,
        remove: members("remove_members", remove_members)?,
    };
    Ok(ProjectChange { display_name: name.map(display_name).transpose()?, members })
}

fn display_name(text: String) -> Result<String> {
    let text = labels::display_name(text)?;
    if text.trim().is_empty() {
        return Err(Error::invalid("display_name", "is empty: say what the project is about"));
    }
    Ok(text)
}

/// Checks names of owners.
fn members(field: &'static str, members: Vec<String>) -> Result<Vec<String>> {
    if members.len() > bendtwin_store::MAX_MEMBERS {
        let fault = format!("has more than {} names", bendtwin_store::MAX_MEMBERS);
        return Err(Error::invalid(field, fault));
    }
    if members.iter().any(String::is_empty) {
        return Err(Error::invalid(field, "has an empty name: give the owners of keys"));
    }
    members.into_iter().map(|member| labels::line(field, member)).collect()
}
