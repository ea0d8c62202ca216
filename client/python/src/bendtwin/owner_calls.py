"""Calls about owners as values: their projects, and what they have."""

from __future__ import annotations

from collections.abc import Sequence

from bendtwin.calls import Call, Pages
from bendtwin.resources import OwnerUsage, Project
from bendtwin.v1 import project_pb2, usage_pb2


def create_project(display_name: str, members: Sequence[str]) -> Call[Project]:
    """Makes a project."""
    return Call(
        lambda s: s.projects.CreateProject,
        project_pb2.CreateProjectRequest(display_name=display_name, members=members),
        Project.from_proto,
    )


def get_project(name: str) -> Call[Project]:
    """A project."""
    return Call(
        lambda s: s.projects.GetProject,
        project_pb2.GetProjectRequest(name=name),
        Project.from_proto,
    )


def list_projects() -> Pages[Project]:
    """The projects that the caller may see."""
    return Pages(
        lambda s: s.projects.ListProjects,
        project_pb2.ListProjectsRequest(),
        lambda page: [Project.from_proto(project) for project in page.projects],
    )


def update_project(
    name: str, display_name: str | None, add: Sequence[str], remove: Sequence[str]
) -> Call[Project]:
    """Changes a project."""
    return Call(
        lambda s: s.projects.UpdateProject,
        project_pb2.UpdateProjectRequest(
            project=project_pb2.Project(name=name, display_name=display_name or ""),
            add_members=add,
            remove_members=remove,
        ),
        Project.from_proto,
    )


def delete_project(name: str) -> Call[None]:
    """Deletes a project."""
    request = project_pb2.DeleteProjectRequest(name=name)
    return Call(lambda s: s.projects.DeleteProject, request, lambda _: None)


def get_usage() -> Call[OwnerUsage]:
    """Usage of the owner of the key that is used."""
    return Call(lambda s: s.usage.GetUsage, usage_pb2.GetUsageRequest(), OwnerUsage.from_proto)


def list_owner_usage() -> Pages[OwnerUsage]:
    """Usage of all owners."""
    return Pages(
        lambda s: s.usage.ListOwnerUsage,
        usage_pb2.ListOwnerUsageRequest(),
        lambda page: [OwnerUsage.from_proto(owner) for owner in page.owners],
    )
