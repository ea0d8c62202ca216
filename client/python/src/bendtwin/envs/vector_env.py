"""A vector environment of Gymnasium whose environments are slots of one session."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from bendtwin.client import Client
from bendtwin.envs.actions import Actions, Mover, Workspace
from bendtwin.envs.body import Array, Body, Indices, world_of
from bendtwin.envs.cameras import Camera, chosen, named
from bendtwin.envs.observations import Observations, Observed, Observer
from bendtwin.envs.pictures import Pictures, Pixels
from bendtwin.envs.randomisation import Look, Randomisation
from bendtwin.envs.simulation import Mask, SessionLost, Setup, Simulation
from bendtwin.envs.slots import Slots
from bendtwin.envs.tasks.task import Task, View, upright
from bendtwin.simulation.rollout import Fidelity
from bendtwin.twin import Twin

#: Tries to begin an episode while workers are lost.
_TRIES = 3
#: Size of pictures of `render`.
_RENDER = {"width": 320, "height": 240}
_INFO = ("is_success", "diverged", "implausible", "session_lost")


class TwinVectorEnv(Slots, VectorEnv):
    """Environments of a task on a twin, which move together in one call of the server.

    An action is described by `Actions`, an observation by `Observations`. The reward is the
    negative cost of the task after the step, between -1 and 0, and 1 more in a success. An episode
    terminates in a success, and where the object diverges, which costs 1 for each step that was
    left: no other end is worse. It is truncated after the time of the task, or with the session.

    `info` has `is_success`, `diverged`, `implausible` (motion beyond the default limits of
    `Plausibility`) and `session_lost`: the worker of the session was lost, and the episodes with
    it. With SAME_STEP, the default, a finished episode is followed by another one in the same step,
    and its own values are in `final_info` and `final_obs`. With NEXT_STEP the step after it begins
    another, and ignores the action. With DISABLED a finished slot stands still until
    `reset(options={"reset_mask": mask})`.

    Each slot has its own random numbers: an episode depends on the seed of its slot and on its
    actions, neither on other slots nor on their number; on the CPU bit for bit.
    """

    def __init__(
        self,
        twin: Twin | str,
        task: type[Task],
        *,
        num_envs: int = 1,
        address: str | None = None,
        task_options: Mapping[str, Any] | None = None,
        actions: Actions | None = None,
        observations: Observations | None = None,
        randomisation: Randomisation | None = None,
        horizon: int | None = None,
        body: Body | None = None,
        render_mode: Literal["rgb_array"] | None = None,
        render_camera: str | Camera = "front",
        autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP,
        fidelity: Fidelity = "exact",
    ) -> None:
        """Opens the session.

        Args:
            twin: The twin, or its name at the server of `address`, whose connection is then closed
                with the environment.
            task: The class of the task.
            num_envs: Number of environments.
            address: Server of a twin that is given by its name; None: the local one.
            task_options: Arguments of the task.
            actions: What an action means.
            observations: The parts of an observation.
            randomisation: What differs between episodes besides start and goal.
            horizon: Steps of an episode; None: the time of the task.
            body: The object at rest; None: it is dropped and simulated until it lies still.
            render_mode: "rgb_array" for pictures by `render`.
            render_camera: Their camera.
            autoreset_mode: When episodes begin again.
            fidelity: "exact", or "fast" for a twin with a fast variant.

        Raises:
            ValueError: If the object does not suit the task.
        """
        if num_envs < 1:
            raise ValueError(f"num_envs is {num_envs}: give at least 1")
        self._client: Client | None = None
        if isinstance(twin, str):
            self._client = Client(address) if address else Client()
            twin = self._client.twin(twin)
        self.twin: Twin = twin
        self.num_envs: int = num_envs
        self.render_mode: str | None = render_mode
        self.body: Body = body or Body.of(twin)
        self.task_on_body: Task = task(self.body, **(task_options or {}))
        self._randomisation = randomisation or Randomisation()
        self._mode = autoreset_mode
        settings = observations or Observations()
        self._settings = settings
        self._build(actions or Actions(), settings, render_camera, fidelity)
        fps = self.body.geometry.fps / self._mover.frames
        self.metadata: dict[str, Any] = {
            "autoreset_mode": autoreset_mode,
            "render_modes": ["rgb_array"],
            "render_fps": max(1, round(fps)),
        }
        self.horizon: int = horizon or max(1, round(self.task_on_body.horizon_s * fps))
        self.single_action_space: spaces.Box = spaces.Box(-1.0, 1.0, (self._mover.size,))
        self.single_observation_space: spaces.Dict = self._observer.space
        self.action_space: spaces.Space[Any] = batch_space(self.single_action_space, num_envs)
        self.observation_space: spaces.Space[Any] = batch_space(
            self.single_observation_space, num_envs
        )
        self._ended: Mask = np.zeros(num_envs, bool)
        self._begin_without_episodes()

    # The interface of Gymnasium

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observed, dict[str, Any]]:
        """Begins episodes in all slots, or in those of `options["reset_mask"]`, [B].

        Slot i has the seed `seed + i`, or `seed[i]`; without a seed its random numbers continue.
        """
        mask = (options or {}).get("reset_mask")
        slots = np.arange(self.num_envs) if mask is None else np.flatnonzero(mask)
        if isinstance(seed, int):
            self._np_random_seed = seed
        seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else seed
        if seeds is not None and len(seeds) != self.num_envs:
            raise ValueError(f"there are {len(seeds)} seeds for {self.num_envs} environments")
        for slot in slots.tolist():
            given = None if seeds is None else seeds[slot]
            if given is not None or slot not in self._randoms:
                self._randoms[slot] = _generators(given)
        self._restart(slots)
        self._draw_pixels(slots)
        nothing = np.zeros(self.num_envs, bool)
        return self._observation(), _info(dict.fromkeys(_INFO, nothing), ~nothing)

    def step(self, actions: npt.ArrayLike) -> tuple[Observed, Array, Mask, Mask, dict[str, Any]]:
        """Moves all slots that have an episode, in one call."""
        if len(self._randoms) < self.num_envs:
            raise RuntimeError("call reset before step")
        begun = self._ended.copy()
        if self._mode is AutoresetMode.NEXT_STEP and begun.any():
            self._restart(np.flatnonzero(begun))
        active = ~begun
        lost, diverged, implausible = self._advance(actions, active)
        moved = active & ~lost & ~diverged
        self._steps[active] += 1
        judged = self.task_on_body.judge(self.view)
        success = moved & judged.success
        left = self.horizon - self._steps + 1
        reward = np.where(moved, success - np.nan_to_num(judged.cost, nan=1.0), 0.0)
        reward[diverged] = -left[diverged].astype(float)
        terminated = success | diverged
        truncated = active & ~terminated & (lost | (self._steps >= self.horizon))
        ended = terminated | truncated
        values = {
            "is_success": success,
            "diverged": diverged,
            "implausible": implausible,
            "session_lost": lost,
        }
        self._ended = ended if self._mode is AutoresetMode.NEXT_STEP else begun | ended
        drawn = active if self._mode is AutoresetMode.DISABLED else np.ones_like(active)
        self._draw_pixels(np.flatnonzero(drawn))
        if self._mode is not AutoresetMode.SAME_STEP or not ended.any():
            everyone = np.ones(self.num_envs, bool)
            return self._observation(), reward, terminated, truncated, _info(values, everyone)
        info = _last(self._observation(), values, ended)
        self._restart(np.flatnonzero(ended))
        self._draw_pixels(np.flatnonzero(ended))
        return self._observation(), reward, terminated, truncated, info

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Pictures [height, width, 3] of all slots."""
        return self.render_slots(np.arange(self.num_envs))

    def close_extras(self, **_: Any) -> None:
        """Ends the session."""
        self._simulation.close()
        if self._client is not None:
            self._client.close()

    # Beside the interface

    @property
    def view(self) -> View:
        """What the task and its script see: the state of the slots without noise."""
        return View(
            points=self._points[:, self._rows_of_task],
            grippers=self._poses,
            closed=self._closed,
            goals=self._goals,
        )

    @property
    def steps(self) -> npt.NDArray[np.int64]:
        """Steps that the episodes have gone [B]."""
        return self._steps

    @property
    def largest_step(self) -> Array:
        """Largest change of the coordinates of a pose in a step [6], metres and radians."""
        return self._mover.largest * self._mover.settings.knots

    def actions_towards(self, poses: Array, closed: Mask) -> npt.NDArray[np.float32]:
        """The actions that bring grippers nearest to poses [B, G, 7], closed or open there."""
        return np.asarray(self._mover.towards(self._poses, poses, closed), np.float32)

    def render_slots(self, slots: Indices) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Pictures [height, width, 3] of slots."""
        if self._render is None:
            return None
        for _ in range(_TRIES):
            try:
                drawn = self._pictures(self._render, slots)
                return tuple(next(iter(drawn.values())))
            except SessionLost:
                self._lose()
        raise SessionLost("workers are lost again and again: look at the server")

    # Parts

    def _build(
        self,
        actions: Actions,
        settings: Observations,
        render_camera: str | Camera,
        fidelity: Fidelity,
    ) -> None:
        body, task = self.body, self.task_on_body
        at, radius = task.scene
        size = {"width": settings.width, "height": settings.height}
        cameras = chosen(settings.cameras, body, at, radius, **size)
        cloud = settings.point_cloud
        seen_by = (
            None
            if cloud is None or cloud.seen_by is None
            else named(cloud.seen_by, body, at, radius)
        )
        self._observer = Observer(settings, body, task.grippers, task.goal_size, cameras, seen_by)
        floor = min(float(body.positions[body.place(at), 2].mean()) for at in (0.0, 0.5, 1.0))
        self._mover = Mover(actions, body, task.grippers, Workspace.around(body, floor))
        wanted = np.concatenate([task.nodes, self._observer.nodes])
        count = len(body.positions)
        self._nodes = np.arange(count) if self._observer.needs_all else np.unique(wanted)
        self._rows_of_task = np.searchsorted(self._nodes, task.nodes)
        self._rows_of_keypoints = np.searchsorted(self._nodes, self._observer.nodes)
        self._simulation = Simulation(
            self.twin,
            Setup(
                world=world_of(body.geometry, colliders=task.colliders),
                grippers=task.grippers,
                radius_m=body.grasp_radius_m,
                frames=self._mover.frames,
                knots=actions.knots,
                nodes=None if len(self._nodes) == count else self._nodes,
                velocities=settings.velocities,
                slip_force_n=actions.slip_force_n,
                factors=self._randomisation.varied,
                fidelity=fidelity,
            ),
            self.num_envs,
        )
        self._shown = self._pictures_by(cameras)
        self._render = self._pictures_by(
            [] if self.render_mode is None else [named(render_camera, body, at, radius, **_RENDER)]
        )

    def _pictures_by(self, cameras: Sequence[Camera]) -> Pictures | None:
        if not cameras:
            return None
        return Pictures(self._simulation, self.task_on_body, cameras, self._settings.look)

    def _begin_without_episodes(self) -> None:
        slots, grippers, nodes = self.num_envs, self.task_on_body.grippers, len(self._nodes)
        self._randoms: dict[int, tuple[np.random.Generator, ...]] = {}
        self._poses = np.zeros((slots, grippers, 7))
        self._poses[..., 6] = 1.0
        self._closed = np.zeros((slots, grippers), bool)
        self._goals = np.zeros((slots, self.task_on_body.goal_size))
        self._points = np.zeros((slots, nodes, 3))
        self._velocities = np.zeros((slots, nodes, 3))
        self._steps = np.zeros(slots, np.int64)
        #: Slots whose states are lost with a session, although their episodes have not ended.
        self._stale = np.zeros(slots, bool)
        self._looks: dict[int, Look] = {}
        self._pixels: Pixels = {
            camera.name: np.zeros((slots, camera.height, camera.width, 3), np.uint8)
            for camera in (self._shown.cameras if self._shown else ())
        }

    def _advance(self, actions: npt.ArrayLike, active: Mask) -> tuple[Mask, Mask, Mask]:
        """Moves active slots; which were lost, which diverged, which are implausible."""
        nothing = np.zeros(self.num_envs, bool)
        lost = active & self._stale
        rows = np.flatnonzero(active & ~lost)
        way, closed = self._mover.moved(self._poses, actions)
        if not len(rows):
            return lost, nothing, nothing
        try:
            stepped = self._simulation.step(way, closed, rows)
        except SessionLost:
            self._lose()
            return active, nothing, nothing
        moved = np.zeros(self.num_envs, bool)
        moved[rows] = True
        moved &= ~stepped.diverged
        self._points[moved] = stepped.positions[moved]
        if stepped.velocities is not None:
            self._velocities[moved] = stepped.velocities[moved]
        self._poses[moved], self._closed[moved] = way[moved, -1], closed[moved, -1]
        return lost, stepped.diverged, stepped.implausible

    def _lose(self) -> None:
        self._simulation.reopen()
        self._stale[:] = True

    def _restart(self, slots: Indices) -> None:
        """Begins episodes in slots."""
        task, body = self.task_on_body, self.body
        draws = [task.draw(self._randoms[slot][0]) for slot in slots.tolist()]
        drawn = [self._randomisation.factors(self._randoms[slot][0]) for slot in slots.tolist()]
        factors = {
            name: np.array([one[name] for one in drawn]) for name in self._randomisation.varied
        }
        states = body.placed(
            np.array([draw.offset_m for draw in draws]).reshape(-1, 2),
            np.array([draw.yaw for draw in draws]),
        )
        for tries in range(_TRIES):
            try:
                self._simulation.reset(slots, states, factors)
                break
            except SessionLost:
                if tries == _TRIES - 1:
                    raise
                self._lose()
        self._stale[slots] = False
        self._points[slots] = np.asarray(states.positions)[:, self._nodes]
        self._velocities[slots] = 0.0
        self._goals[slots] = np.array([draw.goal for draw in draws])
        self._steps[slots], self._ended[slots], self._closed[slots] = 0, False, False
        places = task.places(self._points[slots][:, self._rows_of_task])
        begin = upright(places + np.array([draw.grippers for draw in draws]))
        begin[..., 2] += 0.15 * body.length_m
        self._poses[slots] = self._mover.inside(begin)
        if self._shown is not None or self._render is not None:
            self._dress(slots)

    def _dress(self, slots: Indices) -> None:
        """Draws what the pictures of new episodes look like."""
        cameras = max(len(one.cameras) for one in (self._shown, self._render) if one)
        obstacles = len(self.task_on_body.colliders)
        for slot in slots.tolist():
            self._looks[slot] = self._randomisation.look(self._randoms[slot][1], cameras, obstacles)

    def _draw_pixels(self, slots: Indices) -> None:
        if self._shown is None or not len(slots):
            return
        try:
            drawn = self._pictures(self._shown, slots)
        except SessionLost:
            # The pictures stay; the next step says that the session is lost.
            self._lose()
            return
        for name, pictures in drawn.items():
            self._pixels[name][slots] = pictures

    def _pictures(self, pictures: Pictures, slots: Indices) -> Pixels:
        return pictures.draw(
            slots,
            self._poses[slots],
            self._closed[slots],
            self._goals[slots],
            [self._looks[slot] for slot in slots.tolist()],
        )

    def _observation(self) -> Observed:
        observed = self._observer.states(
            self._points[:, self._rows_of_keypoints],
            self._velocities[:, self._rows_of_keypoints] if self._settings.velocities else None,
            self._points if self._observer.needs_all else None,
            self._poses,
            self._closed,
            self._goals,
            [self._randoms[slot][2] for slot in range(self.num_envs)],
        )
        if self._pixels:
            observed["pixels"] = {name: pixels.copy() for name, pixels in self._pixels.items()}
        return observed


def _generators(seed: int | None) -> tuple[np.random.Generator, ...]:
    """Random numbers of a slot: of episodes, of looks and of sensors, which do not shift others."""
    return tuple(np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(3))


def _info(values: Mapping[str, npt.NDArray[Any]], which: Mask) -> dict[str, Any]:
    """Values of the slots in a mask, beside which Gymnasium wants it."""
    chosen = {name: np.where(which, v, np.zeros_like(v)) for name, v in values.items()}
    return chosen | {f"_{name}": which.copy() for name in values}


def _last(
    observed: Observed, values: Mapping[str, npt.NDArray[Any]], ended: Mask
) -> dict[str, Any]:
    """Values of a step in which some episodes ended and others began in their places."""
    final = np.full(len(ended), None, object)
    for slot in np.flatnonzero(ended).tolist():
        final[slot] = _row(observed, slot)
    return {
        **_info(values, ~ended),
        **{f"_{name}": np.ones_like(ended) for name in values},
        "final_obs": final,
        "_final_obs": ended.copy(),
        "final_info": _info(values, ended),
        "_final_info": ended.copy(),
    }


def _row(observed: Observed, slot: int) -> Observed:
    """The observation of one slot."""
    return {
        name: _row(part, slot) if isinstance(part, dict) else part[slot].copy()
        for name, part in observed.items()
    }
