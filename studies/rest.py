"""Contact at rest, measured over the public API on any binary.

python -m studies.rest --bin target/debug/bendtwin
python -m studies.rest --parts settled --captures DIR/*.zip

Three tables, of drafts of the made scenes: (a) a hand that is lowered and held, (b) slopes below
the angle of friction, (c) `Settled()`, also for captures that are given.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bendtwin import BendTwinError, Grasp, Returns, Settled, Twin, World
from studies.lab import at_rest, binary, open_lab
from studies.loops.report import rows_table

#: Coarse twins of planners, and what `effort` makes of a draft.
SETTINGS: dict[str, dict[str, Any]] = {
    "planning": {
        "graph": {"max_nodes": 60, "max_neighbours": 8},
        "search": {"generations": 6, "starts": 3},
        "refine": {"passes": 0},
    },
    "draft": {"effort": "draft"},
}
SCENES = ("rope", "bar", "toy")
LOWERED_MM = (0, 10, 20, 60)
LOWERING_FRAMES = 10
HELD_FRAMES = 10
SLOPES_RAD = (0.15, 0.255)
CREEP_S = 12.0
#: Before the slope: what was held comes to lie.
FALL_S = 2.0
RETURNS = Returns(final_state=True, diagnostics=True, forces=True)

Row = dict[str, Any]


def lowered(name: str, twin: Twin) -> list[Row]:
    """(a) The state after the hand was lowered and held, by depth."""
    geometry, state = twin.geometry(), at_rest(twin)
    rows = []
    for depth_mm in LOWERED_MM:
        frames = LOWERING_FRAMES + HELD_FRAMES
        down = np.minimum(np.arange(frames + 1) / LOWERING_FRAMES, 1.0) * depth_mm * 1e-3
        path = np.repeat(np.asarray(state.controls)[None], frames + 1, axis=0)
        path[..., 2] -= down[:, None]
        done = twin.rollout(trajectories=path[None], initial=state, returns=RETURNS)
        about = done.diagnostics[0]
        forces = done.forces.controls[0].sum(axis=1) if done.forces else np.zeros((1, 3))
        rows.append(
            {
                "object": name,
                "lowered by, mm": depth_mm,
                "largest speed in the state, m/s": speed(done.final_velocities),
                "kinetic energy": kinetic_energy(done.final_velocities[0], geometry.masses),
                "max_speed_m_s": about.max_speed_m_s,
                "largest force of the hand": float(np.linalg.norm(forces, axis=-1).max()),
                "says": ", ".join(i.reason for i in done.implausible) or "-",
            }
        )
    return rows


def crept(name: str, twin: Twin) -> list[Row]:
    """(b) Displacement on slopes below the angle of friction, with nobody's hand on it."""
    geometry = twin.geometry()
    gravity = float(np.linalg.norm(geometry.gravity))
    poses = np.zeros((1, 2, geometry.hand_count, 7))
    poses[..., 6] = 1.0
    for hand in hands(twin):
        poses[..., hand, :3] = geometry.controls[geometry.hands == hand].mean(axis=0)
    free: Any = {
        "poses": poses,
        "gripper_of_control": geometry.hands,
        "grasps": [Grasp(gripper=h, hand=h, closed=[0, 0]) for h in hands(twin)],
        "returns": Returns(final_state=True, every_frames=round(geometry.fps)),
    }
    rows = []
    for slope in SLOPES_RAD:
        contact: Any = {"ground_friction": 0.3, "ground_restitution": 0.8}
        lying = twin.rollout(
            initial=at_rest(twin),
            frames=round(FALL_S * geometry.fps),
            world=World(**contact),
            **free,
        )
        down = gravity * np.array([np.sin(slope), 0.0, -np.cos(slope)])
        slid = twin.rollout(
            initial=lying.state(0),
            frames=round(CREEP_S * geometry.fps),
            world=World(gravity=down, **contact),
            **free,
        )
        ways = slid.positions[0] - lying.final_positions[0]
        rows.append(
            {
                "object": name,
                "slope, rad": slope,
                "moved in 12 s, mm": 1e3 * np.linalg.norm(ways[-1].mean(axis=0)),
                "farthest node, mm": 1e3 * np.linalg.norm(ways[-1], axis=-1).max(),
                "of that in the last 6 s, mm": 1e3
                * np.linalg.norm((ways[-1] - ways[len(ways) // 2 - 1]).mean(axis=0)),
                "largest speed in the state, m/s": speed(slid.final_velocities),
            }
        )
    return rows


def settled(name: str, twin: Twin) -> list[Row]:
    """(c) Whether `Settled()` is answered, and when a twin that lies there is at rest without its
    additional drag: no node moves farther than 0.25 mm in a quarter of a second."""
    geometry = twin.geometry()
    hold = np.stack([geometry.controls] * 2)[None]
    row: Row = {"object": name, "nodes": len(geometry.rest_positions), "Settled()": "yes"}
    began = time.monotonic()
    try:
        found = twin.rollout(
            trajectories=hold, frames=30, initial=Settled(), returns=Returns(final_state=True)
        )
        row["speed a second later, m/s"] = speed(found.final_velocities)
    except BendTwinError as error:
        row["Settled()"] = error.reason
        row["speed a second later, m/s"] = float("nan")
    row["took, s"] = time.monotonic() - began
    quarter = max(round(geometry.fps / 4), 1)
    lying = twin.rollout(
        trajectories=hold, frames=40 * quarter, returns=Returns(every_frames=quarter)
    )
    moved = np.linalg.norm(np.diff(lying.positions[0], axis=0), axis=-1).max(axis=1)
    awake = np.flatnonzero(moved > 0.25e-3)
    row["at rest without more drag after, s"] = 0.25 * (awake[-1] + 3) if awake.size else 0.25
    if awake.size and awake[-1] == len(moved) - 1:
        row["at rest without more drag after, s"] = float("inf")
    return [row]


PARTS: dict[str, Callable[[str, Twin], list[Row]]] = {
    "lowered": lowered,
    "creep": crept,
    "settled": settled,
}


def hands(twin: Twin) -> range:
    """The hands of a twin."""
    return range(twin.geometry().hand_count)


def speed(velocities: Any) -> float:
    """Largest speed of a node."""
    return float(np.linalg.norm(velocities, axis=-1).max())


def kinetic_energy(velocities: Any, masses: Any) -> float:
    """Joules, or units of a node's mass where the object's is not known."""
    return float(0.5 * np.sum(masses[:, None] * np.asarray(velocities, dtype=float) ** 2))


def main() -> None:
    """Measures and prints."""
    parser = argparse.ArgumentParser(prog="python -m studies.rest", description=__doc__)
    parser.add_argument("--bin", help="the program [default: BENDTWIN_BIN, or that on the path]")
    parser.add_argument("--parts", default=",".join(PARTS), help="of lowered, creep, settled")
    parser.add_argument("--scenes", default=",".join(SCENES), help="made scenes")
    parser.add_argument("--fit", choices=SETTINGS, default="planning", help="kind of the twins")
    parser.add_argument("--tiny", action="store_true", help="of the scenes, coarse recordings")
    parser.add_argument("--captures", nargs="*", type=Path, default=[], help="for `settled`")
    parser.add_argument("--twins", type=Path, help="folder in which twins are kept")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    options = parser.parse_args()
    warnings.filterwarnings("ignore", message="implausible motion")
    found: dict[str, list[Row]] = {}
    with open_lab(binary(options.bin), kept=options.twins) as lab:
        made = {
            scene: partial(lab.made, scene, tiny=options.tiny)
            for scene in options.scenes.split(",")
            if scene
        }
        given = {file.stem: partial(Path, file) for file in options.captures}
        for part in options.parts.split(","):
            found[part] = []
            for name, capture in (made | (given if part == "settled" else {})).items():
                try:
                    twin = lab.twin(f"{name}-{options.fit}", SETTINGS[options.fit], capture)
                    found[part] += PARTS[part](name, twin)
                except BendTwinError as error:
                    print(f"{part} of {name}: {error}", file=sys.stderr)
            if not options.json and found[part]:
                print(f"\n{part}\n\n{rows_table(found[part])}", flush=True)
    if options.json:
        print(json.dumps(found, indent=1, default=float))


if __name__ == "__main__":
    main()
