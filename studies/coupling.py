"""Speed and stability of coupled simulation with MuJoCo, over the public API on any binary.

python -m studies.coupling --bin target/release/bendtwin
python -m studies.coupling --quick

Two tables, of a rope of 100 g that bodies of a MuJoCo model hold: (a) frames a second and where
their time goes, with a gantry whose two fingers lift the rope; (b) what becomes of a plug at the
end of the hanging rope, by its mass and by method: explicit coupling, with relaxation, implicit.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from bendtwin import Grasp, Sphere, Twin
from bendtwin.coupling import Coupling, CouplingError, Frame, Gripper
from studies.lab import Lab, binary, open_lab
from studies.loops.report import rows_table

MASS_KG = 0.1
METHODS: dict[str, dict[str, Any]] = {
    "explicit": {"iterations": 1},
    "relaxation 0.3": {"iterations": 1, "relaxation": 0.3},
    "implicit": {},
}
PLUGS_KG = (10.0, 2.0, 0.5, 0.1, 0.02)
GANTRY = """
<mujoco>
  <option timestep="0.002"/>
  <default>
    <joint type="slide" damping="20" armature="1"/><position kp="2000" kv="100"/>
    <default class="finger"><geom type="box" size="0.02 0.004 0.02"/></default>
  </default>
  <worldbody>
    <geom name="table" type="plane" size="1 1 1"/>
    <body name="hand" pos="0 0 0.02" gravcomp="1">
      <joint name="x" axis="1 0 0"/><joint name="y" axis="0 1 0"/><joint name="z" axis="0 0 1"/>
      <geom class="finger" pos="0 0.04 0"/><geom class="finger" pos="0 -0.04 0"/>
    </body>
  </worldbody>
  <actuator><position joint="x"/><position joint="y"/><position joint="z"/></actuator>
</mujoco>
"""
PLUG = """
<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <body name="plug">
      <freejoint/><geom type="box" size="0.02 0.02 0.02" mass="{}" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
</mujoco>
"""

Row = dict[str, Any]


def speed(twin: Twin, lab: Lab, quick: bool) -> list[Row]:
    """(a) Frames a second, of fingers that lift the middle of the rope and move it about."""
    rows = []
    model = mujoco.MjModel.from_xml_string(GANTRY)
    geometry = twin.geometry()
    middle = geometry.rest_positions.mean(axis=0)
    cases: list[tuple[str, Sequence[str] | None]] = [
        ("explicit", ()),
        ("explicit", None),
        ("implicit", None),
    ]
    for name, colliders in cases:
        data = mujoco.MjData(model)
        with Coupling(
            model,
            data,
            lab.client,
            twin,
            grippers={"hand": Grasp(region=Sphere(0.03))},
            world_in_twin=[*middle[:2], 0, 0, 0, 0, 1],
            colliders=colliders,
            margin_m=0.004,
            **METHODS[name],
        ) as coupling:
            done = []
            for i in range(10 if quick else 300):
                t = i * coupling.frame_s
                data.ctrl[:] = [0.05 * np.sin(3 * t), 0, 0.15 - 0.15 * np.cos(3 * t)]
                done.append(coupling.step())
            row = _speed_row(twin, done)
            rows.append({"coupling": name, "colliders": len(coupling.colliders), **row})
    return rows


def _speed_row(twin: Twin, done: list[Frame]) -> Row:
    """Medians over frames: others use the machine as well."""
    times_ms = {
        part: 1e3 * np.array([getattr(frame.times, part) for frame in done])
        for part in ("model_s", "twin_s", "calls_s", "total_s")
    }
    frame_ms = float(np.median(times_ms["total_s"]))
    geometry = twin.geometry()
    return {
        "nodes": len(geometry.rest_positions),
        "substeps": done[-1].result.substeps,
        "frames a second": 1e3 / frame_ms,
        "times real time": 1e3 / frame_ms / geometry.fps,
        "evaluations a frame": float(np.mean([frame.iterations for frame in done])),
        "model, ms": float(np.median(times_ms["model_s"])),
        "physics of the twin, ms": float(np.median(times_ms["twin_s"])),
        "calls, ms": float(np.median(times_ms["calls_s"])),
        "frame, ms": frame_ms,
        "p99, ms": float(np.quantile(times_ms["total_s"], 0.99)),
    }


def stability(twin: Twin, lab: Lab, quick: bool) -> list[Row]:
    """(b) Speeds of a plug that the end of the rope holds after a drop, by mass and method."""
    geometry = twin.geometry()
    away = np.linalg.norm(geometry.rest_positions - geometry.controls.mean(axis=0), axis=1)
    end = np.argsort(away)[-3:]
    rows = []
    for mass_kg in PLUGS_KG[:1] if quick else PLUGS_KG:
        for name, options in METHODS.items():
            model = mujoco.MjModel.from_xml_string(PLUG.format(mass_kg))
            data = mujoco.MjData(model)
            data.qpos[:3] = geometry.rest_positions[end].mean(axis=0)
            speeds, evaluations, worst = [], 0, 0.0
            ended = "simulated"
            with Coupling(
                model,
                data,
                lab.client,
                twin,
                grippers={"plug": Gripper(Grasp(nodes=end))},
                held_hands=range(geometry.hand_count),
                ground="none",
                max_speed_m_s=20.0,
                **options,
            ) as coupling:
                for _ in range(6 if quick else round(5.0 / coupling.frame_s)):
                    try:
                        frame = coupling.step()
                    except CouplingError as error:
                        ended = error.reason
                        break
                    speeds.append(float(np.linalg.norm(data.qvel[:3])))
                    evaluations += frame.iterations
                    worst = max(worst, float(np.linalg.norm(frame.wrenches["plug"][:3])))
            second = max(1, round(geometry.fps))
            rows.append(
                {
                    "plug, kg": mass_kg,
                    "coupling": name,
                    "ended": f"{ended} after {len(speeds) * coupling.frame_s:.1f} s",
                    "fastest, m/s": max(speeds, default=0.0),
                    "in the last second, m/s": max(speeds[-second:], default=0.0),
                    "largest force over weight": worst / (9.81 * (mass_kg + MASS_KG)),
                    "evaluations a frame": evaluations / max(1, len(speeds)),
                }
            )
    return rows


PARTS = {"speed": speed, "stability": stability}


def main() -> int:
    """Measures and prints the tables."""
    options = _options()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: options.cores])
    settings = {
        "graph": {"max_nodes": 120, "max_neighbours": 8},
        "search": {"generations": 2 if options.quick else 6},
        "refine": {"passes": 0},
    }
    with open_lab(binary(options.bin), kept=options.twins, cores=options.cores) as lab:
        twin = lab.twin(
            f"coupling-rope{'-tiny' * options.quick}",
            settings,
            partial(lab.made, "rope", tiny=options.quick, mass_kg=MASS_KG),
        )
        found = {}
        for part in options.parts.split(","):
            found[part] = PARTS[part](twin, lab, options.quick)
            if not options.json:
                print(f"\n{rows_table(found[part])}", flush=True)
    if options.json:
        print(json.dumps(found, indent=1))
    return 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m studies.coupling",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--bin", help="the program [default: BENDTWIN_BIN, or that on the path]")
    parser.add_argument("--cores", type=int, default=2, help="for everything [default: 2]")
    parser.add_argument("--twins", type=Path, help="folder in which the twin is kept between runs")
    parser.add_argument("--parts", default=",".join(PARTS), help="[default: %(default)s]")
    parser.add_argument("--quick", action="store_true", help="a tiny rope and few frames")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
