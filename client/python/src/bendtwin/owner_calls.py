"""Calls about owners as values: their projects, the links that they send, and what they have."""

from __future__ import annotations

from collections.abc import Sequence

from bendtwin.calls import Call, Pages
from bendtwin.resources import MadeShare, OwnerUsage, Project, Share
from bendtwin.v1 import key_pb2, project_pb2, usage_pb2


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


def share_twin(
    address: str, twin: str, display_name: str, days: float, allow_export: bool
) -> Call[MadeShare]:
    """Makes a link to a twin."""
    request = key_pb2.ShareTwinRequest(
        twin=twin,
        display_name=display_name,
        ttl_s=max(1, round(days * 86_400)),
        allow_export=allow_export,
    )
    page = f"{address}/#/shared/{twin.rpartition('/')[2]}"
    return Call(
        lambda s: s.shares.ShareTwin,
        request,
        lambda reply: MadeShare(Share.from_proto(reply.share), f"{page}?key={reply.secret_key}"),
    )


def list_shares(twin: str) -> Pages[Share]:
    """The links of a twin."""
    return Pages(
        lambda s: s.shares.ListShares,
        key_pb2.ListSharesRequest(twin=twin),
        lambda page: [Share.from_proto(share) for share in page.shares],
    )


def delete_share(name: str) -> Call[None]:
    """Revokes a link."""
    request = key_pb2.DeleteShareRequest(name=name)
    return Call(lambda s: s.shares.DeleteShare, request, lambda _: None)


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
