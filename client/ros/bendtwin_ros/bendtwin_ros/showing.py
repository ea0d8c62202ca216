"""Messages that show an estimate: markers, the skin as a cloud, and wrenches."""

from __future__ import annotations

import numpy as np

from bendtwin import Geometry, Surface
from bendtwin.rotations import matrices
from bendtwin_ros.clouds import cloud_of
from bendtwin_ros.grippers import Gripper
from bendtwin_ros.messages.basic import (
    ColorRGBA,
    Header,
    PointCloud2,
    Pose,
    Vector3,
    Wrench,
    WrenchStamped,
)
from bendtwin_ros.messages.shown import Marker, MarkerArray
from bendtwin_ros.parameters import Settings
from bendtwin_ros.poses import time_of, to_points
from bendtwin_ros.tracker import Estimate


def header_of(settings: Settings, estimate: Estimate) -> Header:
    """Time and frame of an estimate."""
    return Header(time_of(estimate.at_ns), settings["twin_frame"])


def markers(
    settings: Settings, geometry: Geometry, surface: Surface, estimate: Estimate
) -> MarkerArray:
    """The surface: a line along each cable, triangles around a body, or its nodes as spheres if
    the triangles are more than `publish.max_triangles`."""
    header = header_of(settings, estimate)
    color = ColorRGBA(*(float(part) for part in settings["publish.color"]))
    nodes = np.asarray(estimate.state.positions, dtype=np.float64)
    shown = []
    for i, tube in enumerate(surface.tubes):
        line = _marker(header, "cable", i, Marker.LINE_STRIP, color)
        line.scale = Vector3(2.0 * tube.radius, 0.0, 0.0)
        line.points = to_points(nodes[tube.nodes])
        shown.append(line)
    if 0 < len(surface.triangles) <= settings["publish.max_triangles"]:
        body = _marker(header, "surface", 0, Marker.TRIANGLE_LIST, color)
        body.scale = Vector3(1.0, 1.0, 1.0)
        corners = surface.triangles.reshape(-1)
        body.points = to_points(surface.positions(nodes)[corners])
        if surface.colors is not None:
            rgba = np.column_stack([surface.colors / 255.0, np.full(len(surface.colors), color.a)])
            body.colors = [ColorRGBA(*one) for one in rgba[corners].tolist()]
        shown.append(body)
    if not shown:
        spheres = _marker(header, "nodes", 0, Marker.SPHERE_LIST, color)
        spheres.scale = Vector3(*[float(geometry.spacing_m)] * 3)
        spheres.points = to_points(nodes)
        shown.append(spheres)
    return MarkerArray(shown)


def _marker(header: Header, ns: str, number: int, kind: int, color: ColorRGBA) -> Marker:
    return Marker(header=header, ns=ns, id=number, type=kind, pose=Pose(), color=color)


def no_markers(settings: Settings) -> MarkerArray:
    """Removes all markers, when the object is no longer followed."""
    header = Header(frame_id=settings["twin_frame"])
    return MarkerArray([Marker(header=header, action=Marker.DELETEALL)])


def skin(settings: Settings, geometry: Geometry, estimate: Estimate) -> PointCloud2:
    """The points of the surface."""
    points = geometry.skin.positions(estimate.state.positions)
    return cloud_of(points, header_of(settings, estimate))


def wrenches(grippers: list[Gripper], estimate: Estimate) -> list[WrenchStamped]:
    """What the object does to each gripper, in the gripper's frame, as a sensor at its wrist feels
    it: of a hanging object the force points down. None if forces are not known."""
    if estimate.wrenches is None:
        return []
    messages = []
    for gripper, on_object, pose in zip(grippers, estimate.wrenches, estimate.poses, strict=False):
        to_gripper = matrices(pose[3:]).T
        force, torque = to_gripper @ -on_object[:3], to_gripper @ -on_object[3:]
        header = Header(time_of(estimate.at_ns), gripper.settings.frame)
        wrench = Wrench(Vector3(*force.tolist()), Vector3(*torque.tolist()))
        messages.append(WrenchStamped(header, wrench))
    return messages
