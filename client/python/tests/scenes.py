"""Twins by hand, each with a motion of its control points: files as docs/formats/twin.md says."""

from __future__ import annotations

import numpy as np
from numpy_twin import NONE, TwinFile, norm

FRAMES = 30


def twin_file(nodes, springs, controls, *, triplets=(), pins=(), rod=None, objects=None, **about):
    """A twin at rest in these positions."""
    n, all_points = len(nodes), np.concatenate([nodes, controls])
    springs = np.array(springs, "<u4").reshape(-1, 2)
    triplets = np.array(triplets, "<u4").reshape(-1, 3)
    pins = np.array(pins, "<u4").reshape(-1, 2)
    random = np.random.default_rng(len(nodes))
    i, j, k = triplets.T
    u, w = all_points[i] - all_points[j], all_points[k] - all_points[j]
    angles = np.arctan2(norm(np.cross(u, w)), np.einsum("ti,ti->t", u, w))
    lengths = norm(all_points[springs[:, 1]] - all_points[springs[:, 0]])
    tensors = {
        "nodes.rest_position": nodes,
        "nodes.kind": np.zeros(n, "u1"),
        "nodes.mass": random.uniform(0.5, 2, n),
        "nodes.object_id": np.zeros(n, "<u4") if objects is None else np.array(objects, "<u4"),
        "nodes.observed_point": np.full(n, NONE, "<u4"),
        "controls.rest_position": controls,
        "springs.ends": springs,
        "springs.rest_length": lengths,
        "springs.stiffness": random.uniform(500, 1500, len(springs)),
        "springs.dashpot": random.uniform(0.5, 2, len(springs)),
        "triplets.ends": triplets,
        "triplets.rest_angle": angles,
        "triplets.bend_stiffness": random.uniform(0.02, 0.06, len(triplets)),
        "triplets.bend_damping": random.uniform(1e-4, 1e-3, len(triplets)),
        "pins.ends": pins,
        "pins.offset": nodes[pins[:, 0]] - controls[pins[:, 1]],
    }
    rods = [] if rod is None else [rod]
    tensors |= {
        "rods.lengths": np.array([len(rod) for rod in rods], "<u4"),
        "rods.nodes": np.array(rod or [], "<u4"),
        "rods.twist_stiffness": np.full(len(rods), 0.02),
        "rods.twist_damping": np.full(len(rods), 1e-3),
        "rods.rest_twist": np.full(len(rods), 4.0),
        # A point beside three nodes, and one beside a node along the world's axes.
        "skin.observed_point": np.full(2, NONE, "<u4"),
        "skin.weight_count": np.array([3, 1], "<u4"),
        "skin.weight_node": np.array([0, 1, n - 1, 2], "<u4"),
        "skin.weight": np.array([0.25, 0.25, 0.5, 1]),
        "skin.frame": np.array([[0, 1, n - 1], [NONE] * 3], "<u4"),
        "skin.offset": np.array([[0.01, 0.02, 0.03], [0, 0.01, 0]]),
    }
    narrow = {k: v.astype("<f4") if v.dtype.kind == "f" else v for k, v in tensors.items()}
    contact = {
        "ground_restitution": 0.3,
        "ground_friction": 0.4,
        "object_restitution": 0.2,
        "object_friction": 0.3,
        "collision_distance_m": 0.02,
        "between_objects": True,
        "within_object": False,
    }
    provenance = {"capture_digest": "", "capture_name": "", "settings": None, "build": "by hand"}
    provenance |= {"backend": "", "source_to_world": np.eye(3).tolist()}
    document = {
        "version": 3,
        "environment": {
            "gravity": [0, 0, -9.81],
            "ground": {"normal": [0, 0, 1], "offset_m": 0.0},
        },
        "timing": {"fps": 30, "substeps": 60},
        "control_velocity": "true",
        "drag": 1.5,
        "contact": contact | about.pop("contact", {}),
        "provenance": provenance,
        "quality": {"scores": []},
    }
    return TwinFile(document | about, narrow)


def sheet(rows, columns, spacing, at):
    """Points of a slightly uneven sheet, its springs, and its rows' and columns' triplets."""
    r, c = np.divmod(np.arange(rows * columns), columns)
    uneven = 0.004 * np.sin(2 * r + 3 * c)
    points = np.stack([spacing * r, spacing * c, uneven], axis=1) + at
    springs = [[a, b] for a in range(len(points)) for b in range(a) if near(points, a, b, spacing)]
    lines = [[a, a + 1, a + 2] for a in range(len(points)) if a % columns < columns - 2]
    lines += [[a, a + columns, a + 2 * columns] for a in range(columns * (rows - 2))]
    return points, springs, lines


def near(points, a, b, spacing):
    return norm(points[a] - points[b]) < 1.6 * spacing


def dragged():
    """A sheet whose edge is dragged over the ground, by springs that know velocities."""
    nodes, springs, triplets = sheet(5, 4, 0.03, [0, 0, 0.03])
    controls = np.array([[-0.02, 0.02, 0.05], [-0.02, 0.07, 0.05]])
    springs += [[e, 20 + c] for c in range(2) for e in range(4)]
    path = np.linspace(0, 1, FRAMES + 1)[:, None, None] * np.array([-0.25, 0.05, 0.0])
    return twin_file(nodes, springs, controls, triplets=triplets), controls + path


def borne():
    """The same again, whose skin meets the ground."""
    file, path = dragged()
    file.about["version"] = 6
    file.about["contact"]["skin"] = True
    # Nodes at the sheet's corners, and points below them.
    weights = [0.6, 0.3, 0.1, 1, 0.8, 0.4, -0.2, 1, 1.3, -0.3, 1]
    skin = {
        "skin.observed_point": np.full(6, NONE, "<u4"),
        "skin.weight_count": np.array([3, 1, 3, 1, 2, 1], "<u4"),
        "skin.weight_node": np.array([0, 1, 4, 3, 10, 9, 6, 12, 19, 18, 16], "<u4"),
        "skin.weight": np.array(weights, "<f4"),
        "skin.frame": np.array([[0, 1, 4], *[[NONE] * 3] * 5], "<u4"),
        "skin.offset": np.array([[0, 0, 0.006], *[[0, 0, -0.008]] * 5], "<f4"),
    }
    file.tensors.update(skin)
    return file, path


def ignored():
    """The same, whose control points have no velocity."""
    file, path = dragged()
    file.about["control_velocity"] = "ignored"
    return file, path


def dropped():
    """A sheet between two pins onto which another object falls; the ground leans."""
    nodes, springs, triplets = sheet(5, 4, 0.03, [0, 0, 0.2])
    ball = np.random.default_rng(3).normal(0, 0.011, (5, 3)) + np.array([0.055, 0.045, 0.26])
    springs += [[20 + a, 20 + b] for a in range(5) for b in range(a)]
    controls = np.array([[0.0, 0.0, 0.2], [0.12, 0.0, 0.2]])
    pins = [[n, 0] for n in range(4)] + [[n, 1] for n in range(16, 20)]
    lean = np.array([0.0, np.sin(0.2), np.cos(0.2)])
    file = twin_file(
        np.concatenate([nodes, ball]),
        springs,
        controls,
        triplets=triplets,
        pins=pins,
        objects=[0] * 20 + [7] * 5,
        environment={
            "gravity": [0, 0, -9.81],
            "ground": {"normal": lean.tolist(), "offset_m": 0.05},
        },
    )
    path = np.sin(np.linspace(0, 3, FRAMES + 1))[:, None, None] * np.array([0, 0.02, 0.04])
    return file, controls + path


def folded():
    """A strip that is folded onto itself; nodes of one object collide."""
    nodes, springs, triplets = sheet(9, 2, 0.025, [0, 0, 0.15])
    controls = np.array([nodes[:2].mean(axis=0), nodes[-2:].mean(axis=0)])
    pins = [[0, 0], [1, 0], [16, 1], [17, 1]]
    contact = {"within_object": True, "collision_distance_m": 0.015}
    file = twin_file(nodes, springs, controls, triplets=triplets, pins=pins, contact=contact)
    t = np.linspace(0, 1, FRAMES + 1)[:, None]
    path = np.repeat(controls[None], FRAMES + 1, axis=0)
    path[:, 1] += t * np.array([-0.2, 0.0, 0.012]) + np.sin(np.pi * t) * [0, 0, 0.06]
    return file, path


def twisted():
    """A cable between two clamps, with a rod of which the rest twist is not zero."""
    s = np.linspace(0, 1, 12)
    nodes = np.stack([0.25 * s, 0.05 * np.sin(6 * s), 0.3 + 0.02 * np.cos(9 * s)], axis=1)
    springs = [[a, a + 1] for a in range(11)]
    triplets = [[a, a + 1, a + 2] for a in range(10)]
    controls = nodes[[0, -1]]
    pins = [[0, 0], [1, 0], [10, 1], [11, 1]]
    rod = list(range(12))
    file = twin_file(nodes, springs, controls, triplets=triplets, pins=pins, rod=rod)
    path = np.linspace(0, 1, FRAMES + 1)[:, None, None] * np.array([[0, 0, 0], [-0.1, 0.05, 0.02]])
    return file, controls + path


def hanging(nodes=7, *, newtons_per_strain=300.0, drag=1.5):
    """A cable of 0.3 m and 0.1 kg that hangs straight down from the hand at its first node, 1 m
    high, without a ground. No motion."""
    down = np.linspace(0, 0.3, nodes)[:, None] * [0, 0, -1] + [0, 0, 1.0]
    file = twin_file(
        down,
        [[i, i + 1] for i in range(nodes - 1)],
        down[:1],
        triplets=[[i, i + 1, i + 2] for i in range(nodes - 2)],
        pins=[[0, 0]],
        mass_kg=0.1,
        drag=drag,
        timing={"fps": 30, "substeps": 100},
        environment={"gravity": [0, 0, -9.81], "ground": None},
        contact={"between_objects": False},
    )
    newtons = 0.1 / nodes  # Of the file's unit of force.
    file.tensors["nodes.mass"] = np.ones(nodes, "<f4")
    file.tensors["springs.stiffness"] = np.full(nodes - 1, newtons_per_strain / newtons, "<f4")
    file.tensors["springs.dashpot"] = np.full(nodes - 1, 40.0, "<f4")
    return file
