"""Lets a robot arm in MuJoCo take a cable from a table, feel its weight, and draws what happens."""

import os
from typing import Any

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import numpy.typing as npt
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from bendtwin import Client, Grasp, Settled, Sphere
from bendtwin.coupling import ClosedWhen, Coupling, Gripper

# A small arm with six joints and two fingers; of its geoms only the fingers and the table collide.
ARM = """
<mujoco model="arm">
  <compiler angle="radian"/>
  <option timestep="0.002"/>
  <default>
    <geom type="capsule" size="0.03" density="1500" contype="0" conaffinity="0"/>
    <joint axis="0 1 0" damping="5" armature="0.2"/>
    <position kp="3000" kv="120"/>
    <default class="finger">
      <geom type="box" size="0.006 0.01 0.03" pos="0 0 0.03" contype="1" conaffinity="1"/>
      <joint type="slide" range="0 0.04" damping="10" armature="0.1"/>
      <position kp="400" kv="20" ctrlrange="0 0.04"/>
    </default>
  </default>
  <worldbody>
    <geom name="table" type="plane" size="1 1 0.1" contype="1" conaffinity="1"/>
    <body name="base" pos="0 0 0.1">
      <geom type="cylinder" size="0.06 0.1"/>
      <body name="shoulder" pos="0 0 0.12" gravcomp="1">
        <joint name="yaw" axis="0 0 1"/>
        <geom fromto="0 0 0 0 0 0.08"/>
        <body name="upper" pos="0 0 0.08" gravcomp="1">
          <joint name="lift"/>
          <geom fromto="0 0 0 0 0 0.32"/>
          <body name="lower" pos="0 0 0.32" gravcomp="1">
            <joint name="elbow"/>
            <geom fromto="0 0 0 0 0 0.3" size="0.025"/>
            <body name="wrist" pos="0 0 0.3" gravcomp="1">
              <joint name="pitch"/>
              <geom fromto="0 0 0 0 0 0.06" size="0.022"/>
              <body name="turn" pos="0 0 0.06" gravcomp="1">
                <joint name="roll" axis="1 0 0"/>
                <geom fromto="0 0 0 0 0 0.05" size="0.022"/>
                <body name="hand" pos="0 0 0.05" gravcomp="1">
                  <joint name="spin" axis="0 0 1"/>
                  <geom type="box" size="0.06 0.02 0.012"/>
                  <site name="pinch" pos="0 0 0.06"/>
                  <body name="left" pos="0.008 0 0.01" gravcomp="1" childclass="finger">
                    <joint name="left" axis="1 0 0"/>
                    <geom/>
                  </body>
                  <body name="right" pos="-0.008 0 0.01" gravcomp="1" childclass="finger">
                    <joint name="right" axis="-1 0 0"/>
                    <geom/>
                  </body>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="yaw"/><position joint="lift"/><position joint="elbow"/>
    <position joint="pitch"/><position joint="roll"/><position joint="spin"/>
    <position class="finger" joint="left"/><position class="finger" joint="right"/>
  </actuator>
</mujoco>
"""
HOME = np.array([0.0, 0.3, 1.6, 1.2, 0.0, 0.0])
DOWN = np.diag([1.0, -1.0, -1.0])  # The hand points downwards.
OPEN, CLOSED = 0.04, 0.0


def joints_for(model: Any, start: npt.ArrayLike, goal: npt.ArrayLike) -> Any:
    """Positions of the six joints at which the fingers meet at a place, from nearby ones."""
    data, pinch = mujoco.MjData(model), model.site("pinch").id
    data.qpos[:6] = start
    jacobian, turn = np.zeros((6, model.nv)), np.zeros(4)
    for _ in range(50):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], pinch)
        mujoco.mju_mat2Quat(turn, (DOWN @ data.site_xmat[pinch].reshape(3, 3).T).ravel())
        away = np.concatenate([np.asarray(goal) - data.site_xpos[pinch], np.zeros(3)])
        mujoco.mju_quat2Vel(away[3:], turn, 1.0)
        j = jacobian[:, :6]
        data.qpos[:6] += 0.5 * j.T @ np.linalg.solve(j @ j.T + 1e-4 * np.eye(6), away)
    return data.qpos[:6].copy()


def draw(axes: Any, model: Any, data: Any, nodes: npt.NDArray[np.float64], color: str) -> None:
    """Draws links as lines, boxes by their sides, and the nodes of the twin."""
    sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    for geom in range(model.ngeom):
        kind, size = model.geom_type[geom], model.geom_size[geom]
        place, axes_of = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
        if kind == mujoco.mjtGeom.mjGEOM_BOX:
            box = place + (corners * size) @ axes_of.T
            axes.add_collection3d(Poly3DCollection(box[sides], facecolor=color, alpha=0.6))
        elif kind != mujoco.mjtGeom.mjGEOM_PLANE:
            line = place + np.outer([-size[1], size[1]], axes_of[:, 2])
            axes.plot(*line.T, color=color, linewidth=150 * size[0], solid_capstyle="round")
    axes.scatter(*nodes.T, s=6, color="tab:orange", depthshade=False)


model = mujoco.MjModel.from_xml_string(ARM)
data = mujoco.MjData(model)
with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    geometry = twin.geometry()
    # The arm stands so that it looks across the middle of the object, which is 42 cm away.
    middle = geometry.rest_positions.mean(axis=0)
    along = np.linalg.svd(geometry.rest_positions[:, :2] - middle[:2])[2][0]
    yaw = np.arctan2(along[1], along[0]) - np.pi / 2
    table = geometry.ground.offset_m if geometry.ground else 0.0
    base = [*middle[:2] - 0.42 * np.array([np.cos(yaw), np.sin(yaw)]), table]
    world_in_twin = [*base, 0, 0, np.sin(yaw / 2), np.cos(yaw / 2)]

    data.qpos[:6] = data.ctrl[:6] = joints_for(model, HOME, [0.42, 0.0, 0.25])
    data.qpos[6:] = data.ctrl[6:] = OPEN
    hand = Gripper(Grasp(region=Sphere(0.03)), closed=ClosedWhen(joint="left", below=0.03))
    with Coupling(
        model,
        data,
        client,
        twin,
        grippers={"pinch": hand},
        margin_m=0.004,
        world_in_twin=world_in_twin,
        initial=Settled(),
        mass_kg=geometry.mass_kg or 0.1,
    ) as coupling:
        figure = plt.figure(figsize=(12, 4.5), layout="constrained")
        scenes = [
            ("above the cable", 0.25, OPEN),
            ("around it", 0.02, OPEN),
            ("closed", 0.02, CLOSED),
            ("lifted", 0.3, CLOSED),
        ]
        start, frames, felt = 0.25, round(1.0 / coupling.frame_s), []
        for number, (name, height, fingers) in enumerate(scenes):
            for frame in range(frames):
                share = min(1.0, 2.0 * (frame + 1) / frames)
                goal = [0.42, 0.0, start + share * (height - start)]
                data.ctrl[:6] = joints_for(model, data.ctrl[:6], goal)
                data.ctrl[6:] = fingers
                done = coupling.step()
                felt.append(-done.wrenches["pinch"][2])
            start = height
            if name != "around it":
                axes = figure.add_subplot(1, 3, max(1, number), projection="3d")
                draw(axes, model, data, done.positions, "0.5")
                axes.set(xlim=(-0.05, 0.55), ylim=(-0.3, 0.3), zlim=(0, 0.6), title=name)
                axes.view_init(12, -50)
        weight = (geometry.mass_kg or 0.1) * 9.81
        print(f"the fingers hold {len(done.held['pinch'])} of {len(done.positions)} nodes,")
        print(f"the highest of them {1000 * done.positions[:, 2].max():.0f} mm above the table,")
        force = np.mean(felt[-frames // 2 :])
        print(f"and the arm feels {force:.2f} N of the {weight:.2f} N that the cable weighs")
        figure.savefig("mujoco_arm.png", dpi=70)
