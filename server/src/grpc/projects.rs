//! `bendtwin.v1.ProjectService`.

use bendtwin_proto::v1::{
    CreateProjectRequest, DeleteProjectRequest, DeleteProjectResponse, GetProjectRequest,
    ListProjectsRequest, ListProjectsResponse, Project, UpdateProjectRequest,
    project_service_server::ProjectService,
};
use tonic::{Request, Response, Status};

use super::{Api, convert};
use crate::app::ProjectOrder;

#[tonic::async_trait]
impl ProjectService for Api {
    async fn create_project(
        &self,
        request: Request<CreateProjectRequest>,
    ) -> Result<Response<Project>, Status> {
        let CreateProjectRequest { display_name, members } = request.into_inner();
        let project = self.app.create_project(ProjectOrder { display_name, members }).await?;
        Ok(Response::new(convert::project(project)))
    }

    async fn get_project(
        &self,
        request: Request<GetProjectRequest>,
    ) -> Result<Response<Project>, Status> {
        let project = self.app.project(&request.get_ref().name).await?;
        Ok(Response::new(convert::project(project)))
    }

    async fn list_projects(
        &self,
        request: Request<ListProjectsRequest>,
    ) -> Result<Response<ListProjectsResponse>, Status> {
        let r = request.into_inner();
        let page = self.app.projects(&convert::page(r.page_size, r.page_token)).await?;
        Ok(Response::new(ListProjectsResponse {
            projects: page.items.into_iter().map(convert::project).collect(),
            next_page_token: page.next_token,
        }))
    }

    async fn update_project(
        &self,
        request: Request<UpdateProjectRequest>,
    ) -> Result<Response<Project>, Status> {
        let project = self.app.update_project(request.into_inner()).await?;
        Ok(Response::new(convert::project(project)))
    }

    async fn delete_project(
        &self,
        request: Request<DeleteProjectRequest>,
    ) -> Result<Response<DeleteProjectResponse>, Status> {
        self.app.delete_project(&request.get_ref().name).await?;
        Ok(Response::new(DeleteProjectResponse {}))
    }
}
