//! Projects: sets of owners who share what they have. Changes take a key with the scope `admin`, or
//! the client token.

use bendtwin_core::ids::ProjectId;
use bendtwin_proto::v1::{
    self, CreateProjectRequest, DeleteProjectRequest, GetProjectRequest, ListProjectsRequest,
    UpdateProjectRequest, project_service_client::ProjectServiceClient,
};
use jiff::Timestamp;
use serde::Serialize;

use crate::{
    Error,
    client::Channel,
    page::{self, Page, PageRequest},
    resources::resource,
};

resource! { v1::Project =>
/// A project.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Project {
    /// Name of the project.
    pub name: ProjectId,
    /// Display name.
    pub display_name: String,
    /// Owners who share, sorted.
    pub members: Vec<String>,
    /// Time of creation.
    pub create_time: Timestamp,
}
}

/// A change of a project.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProjectChange {
    /// New display name; empty keeps it.
    pub display_name: String,
    /// Members to add.
    pub add_members: Vec<String>,
    /// Members to take away.
    pub remove_members: Vec<String>,
}

/// Calls about projects.
#[derive(Clone, Debug)]
pub struct Projects {
    service: ProjectServiceClient<Channel>,
}

impl Projects {
    pub(crate) fn new(service: ProjectServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Makes a project of these owners.
    ///
    /// # Errors
    /// If it is refused, or the server cannot be asked.
    pub async fn create(
        &self,
        display_name: impl Into<String>,
        members: Vec<String>,
    ) -> Result<Project, Error> {
        let request = CreateProjectRequest { display_name: display_name.into(), members };
        self.service.clone().create_project(request).await?.into_inner().try_into()
    }

    /// Returns a project.
    ///
    /// # Errors
    /// If the project does not exist, is not the caller's, or the server cannot be asked.
    pub async fn get(&self, name: ProjectId) -> Result<Project, Error> {
        let request = GetProjectRequest { name: name.to_string() };
        self.service.clone().get_project(request).await?.into_inner().try_into()
    }

    /// A page of the caller's projects, newest first; with the scope `admin`, of all projects.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn list(&self, page: PageRequest) -> Result<Page<Project>, Error> {
        let request = ListProjectsRequest { page_size: page.size, page_token: page.token };
        let reply = self.service.clone().list_projects(request).await?.into_inner();
        Page::new(reply.projects, reply.next_page_token, Project::try_from)
    }

    /// All pages of [`Projects::list`].
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn all(&self) -> Result<Vec<Project>, Error> {
        page::all(|page| self.list(page)).await
    }

    /// Changes a project: after 30 s all servers follow it.
    ///
    /// # Errors
    /// If the project does not exist, the change is refused, or the server cannot be asked.
    pub async fn update(&self, name: ProjectId, change: ProjectChange) -> Result<Project, Error> {
        let ProjectChange { display_name, add_members, remove_members } = change;
        let project =
            v1::Project { name: name.to_string(), display_name, ..v1::Project::default() };
        let request = UpdateProjectRequest {
            project: Some(project),
            update_mask: None,
            add_members,
            remove_members,
        };
        self.service.clone().update_project(request).await?.into_inner().try_into()
    }

    /// Deletes a project; its members keep what they have.
    ///
    /// # Errors
    /// If the project does not exist, or the server cannot be asked.
    pub async fn delete(&self, name: ProjectId) -> Result<(), Error> {
        let request = DeleteProjectRequest { name: name.to_string() };
        self.service.clone().delete_project(request).await?;
        Ok(())
    }
}
