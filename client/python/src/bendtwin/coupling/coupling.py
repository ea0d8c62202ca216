"""A MuJoCo model and a twin, simulated together frame by frame.

Within a frame of the twin the model takes as many steps as fit, under the wrenches of the frame
before (explicit coupling, `iterations=1`) or of this frame (implicit coupling); the twin then
follows the poses of the model's bodies through that frame, and answers with the wrenches.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from bendtwin.client import Client
from bendtwin.coupling.errors import CouplingError
from bendtwin.coupling.frame import Frame, Times
from bendtwin.coupling.gripper import Gripper
from bendtwin.coupling.interface import FixedPoint
from bendtwin.coupling.model import Control, Model, yields
from bendtwin.coupling.poses import IDENTITY, Change
from bendtwin.coupling.simulated import MOST_TRIALS, Simulated
from bendtwin.coupling.surroundings import Ground, Surroundings, surroundings
from bendtwin.session import Session
from bendtwin.simulation.rollout import Fidelity, Returns, RolloutResult
from bendtwin.simulation.state import Grasping, InitialState, State
from bendtwin.simulation.world import Grasp, Vary
from bendtwin.twin import Twin

FloatArray = npt.NDArray[np.float64]

_RETRY_S = 0.2
#: Displacement for which a turn by 1 rad counts, metres.
_TURN_M = 0.05


@dataclass(frozen=True)
class Snapshot:
    """The model and the twin between two frames, from `Coupling.save`."""

    number: int
    #: MuJoCo's integration state.
    model: FloatArray
    twin: State
    #: Last poses that were sent [G, 7], and wrenches [G, 6] along the twin's axes.
    poses: npt.NDArray[np.float32]
    wrenches: FloatArray
    #: Time that the model is behind the twin, seconds: less than one of its steps.
    behind_s: float
    #: Estimate of the response of the twin, for the iteration.
    inverse: FloatArray


class Coupling:
    """A MuJoCo model whose bodies hold and push a twin, and feel its wrenches.

    Close it, or use it in `with`. `step` advances both by one frame of the twin.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        client: Client,
        twin: Twin,
        *,
        grippers: Mapping[str, Gripper | Grasp] | None = None,
        colliders: Sequence[str] | None = None,
        ground: Ground = None,
        margin_m: float | None = None,
        world_in_twin: npt.ArrayLike = IDENTITY,
        initial: InitialState | None = None,
        held_hands: Sequence[int] = (),
        mass_kg: float | None = None,
        feedback: bool = True,
        iterations: int = 16,
        tolerance_m: float = 2e-5,
        relaxation: float = 1.0,
        max_speed_m_s: float = 5.0,
        fidelity: Fidelity = "exact",
        vary: Vary | None = None,
        patience_s: float = 10.0,
        idle_timeout_s: float = 0.0,
    ) -> None:
        """Opens a session of the twin in the surroundings that the model gives it.

        Args:
            model: MjModel. Its timestep is at most a frame of the twin.
            data: MjData, in the pose at which the simulation starts.
            client: The client of the twin's server.
            twin: The twin.
            grippers: Grippers by the name of their body or site; a `Grasp` is one that is always
                closed.
            colliders: Names of geoms, or of bodies whose geoms, collide with the twin; None: all
                that collide in the model. A plane is the ground.
            ground: The ground; None: the plane among the colliders, or else that of the twin.
            margin_m: Distance that nodes keep from colliders; None: half the node spacing.
            world_in_twin: Pose [7] of the model's world in the twin's.
            initial: First state of the twin; None: its rest shape.
            held_hands: Hands of the twin's capture that stay closed where they are. Others are
                open, unless a gripper has a `Grasp(hand=...)`.
            mass_kg: Mass of the object, if the twin's is unknown or wrong: scales the wrenches.
            feedback: Whether the model feels the twin.
            iterations: Most evaluations of a frame; 1 to 4 are usual, more are needed where a
                cable gets taut. With 1, coupling is explicit: the model feels the wrenches of the
                frame before, which is fast, but stable only for heavy, damped bodies
                (docs/use/mujoco.md).
            tolerance_m: Displacement of a body in a frame, by wrenches that do not agree, at which
                the iteration ends, metres; turning by 1 rad counts as 0.05 m.
            relaxation: Share of new wrenches, above 0 and at most 1; the rest are those before.
            max_speed_m_s: Speed of a body above which a frame is refused: a jump, usually.
            fidelity: Model of the twin that answers.
            vary: Factors of the twin's parameters, one each.
            patience_s: Time for which a lost session is opened again, if it is refused.
            idle_timeout_s: Time without frames after which the session ends (0: five minutes).

        Raises:
            ValueError: If the model or an argument cannot be used.
            BendTwinError: If the session cannot be opened.
        """
        geometry = twin.geometry()
        self.frame_s = 1.0 / geometry.fps
        _check(model, self.frame_s, iterations, relaxation, tolerance_m)
        self._newtons = _newtons(geometry.mass_kg, mass_kg, float(geometry.masses.sum()), feedback)
        #: The model and its data.
        self.model, self.data = model, data
        self._change = Change(world_in_twin)
        mujoco.mj_kinematics(model, data)
        self._around: Surroundings = surroundings(
            model,
            data,
            geometry,
            grippers or {},
            colliders=colliders,
            ground=ground,
            margin_m=geometry.spacing_m / 2 if margin_m is None else margin_m,
            held_hands=held_hands,
            change=self._change,
        )
        carriers = self._around.carriers
        self._model = Model(model, data, carriers, self._change)
        self._names = [carrier.name for carrier in carriers]
        self._grippers = list(grippers or {})
        # The motion of what has no joints does not depend on wrenches.
        self._feels = np.array([yields(model, carrier.body) for carrier in carriers], bool)
        self._iterations = iterations if feedback and self._feels.any() else 1
        self._tolerance_m = tolerance_m
        self._relaxation, self._feedback = relaxation, feedback
        self._max_speed_m_s, self._patience_s = max_speed_m_s, patience_s
        self._solver = FixedPoint(6 * int(self._feels.sum()), relaxation)
        session = client.open_session(
            twin,
            initial=initial,
            slots=1 if self._iterations == 1 else 1 + min(self._iterations, MOST_TRIALS),
            world=self._around.world,
            grasps=self._around.grasps,
            vary=vary,
            fidelity=fidelity,
            idle_timeout_s=idle_timeout_s,
        )
        try:
            returns = Returns(forces=feedback, final_state=True)
            self._twin = Simulated(session, self._around, returns)
        except BaseException:
            session.close()
            raise
        self._is_closed = False
        self._number, self._behind_s = 0, 0.0
        self._wrenches = np.zeros((len(carriers), 6))
        self._poses = self._rows(self._model.poses())
        self._first = self.save()

    def __enter__(self) -> Coupling:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def colliders(self) -> list[str]:
        """Names of the colliders in the twin's world, in the order of `Forces.colliders`."""
        return [collider.name for collider in self._around.world.colliders]

    @property
    def positions(self) -> FloatArray:
        """Positions of the twin's nodes [N, 3] in the model's world, metres."""
        return self._change.points_back(self.state.positions)

    @property
    def state(self) -> State:
        """The state of the twin, in its own coordinates."""
        return self._twin.state

    @property
    def session(self) -> Session:
        """The session of the twin."""
        return self._twin.session

    @property
    def slot(self) -> int:
        """The slot of the session in which the twin is after the last frame."""
        return self._twin.slot

    def step(self, control: Control | None = None) -> Frame:
        """Advances the model and the twin by one frame of the twin.

        `control` is called with model and data before each step of the model, and should set
        controls by their state alone: with `iterations` it is called again for the same times.
        Without it `data.ctrl` holds for the frame, unless MuJoCo's own callback sets it.

        Raises:
            CouplingError: If the model or the twin diverges, or a body is too fast. Both are as
                they were before.
            BendTwinError: If the server refuses the frame or cannot be reached. The model is as it
                was before, and so is the twin once a call succeeds; a lost session is opened again.
        """
        if self._is_closed:
            raise ValueError("the coupling is closed")
        deadline = time.monotonic() + self._patience_s
        while True:
            try:
                self._twin.agree()
                return self._frame(control)
            except BaseException as error:
                is_over = time.monotonic() + _RETRY_S > deadline
                if not self._twin.missed(error) or is_over:
                    raise
                time.sleep(_RETRY_S)

    def save(self) -> Snapshot:
        """The state of both, for `restore`."""
        return Snapshot(
            number=self._number,
            model=self._model.save(),
            twin=self.state,
            poses=self._poses,
            wrenches=self._wrenches,
            behind_s=self._behind_s,
            inverse=self._solver.inverse,
        )

    def restore(self, snapshot: Snapshot) -> None:
        """Sets the model and the twin to a state of this coupling: the same frames follow again,
        bit for bit.

        Raises:
            BendTwinError: If the twin cannot be reached; the model is in the state, and the twin
                will be before the next frame.
        """
        self._model.restore(snapshot.model)
        self._take(snapshot)
        self._twin.agree()

    def reset(self, *, model: bool = True) -> None:
        """Sets both to their first state; with `model=False` only the twin, around the model as the
        caller has set it."""
        if model:
            self.restore(self._first)
            return
        self._model.settle()
        self._take(self._first)
        self._poses = self._rows(self._model.poses())
        self._twin.agree()

    def close(self) -> None:
        """Ends the session; the model does not change. Closing twice is not an error."""
        self._is_closed = True
        self._twin.close()

    def _take(self, snapshot: Snapshot) -> None:
        """Everything of a state but the model."""
        self._number, self._behind_s = snapshot.number, snapshot.behind_s
        self._poses, self._wrenches = snapshot.poses, snapshot.wrenches
        self._solver.inverse = snapshot.inverse
        self._twin.set(snapshot.twin)

    def _frame(self, control: Control | None) -> Frame:
        model, started_at = self._model, time.monotonic()
        began, kept = model.save(), self._solver.inverse
        due_s, timestep = self._behind_s + self.frame_s, float(self.model.opt.timestep)
        steps = int(due_s / timestep + 1e-9)
        behind_s = max(0.0, due_s - steps * timestep)
        closed = tuple(bool(c(self.model, self.data)) for c in self._around.conditions)
        guess, model_s, twin_s, calls_s = self._wrenches, 0.0, 0.0, 0.0
        feels = self._feels
        self._solver.begin(self._units())
        try:
            for iteration in range(1, self._iterations + 1):
                begun_at = time.monotonic()
                if iteration > 1:
                    model.restore(began)
                model.run(steps, self._in_model(guess) if self._feedback else None, control)
                poses = self._rows(model.poses(behind_s))
                self._check_speeds(poses)
                called_at = time.monotonic()
                slot, result = self._twin.evaluate(self._poses, poses, closed)
                answered_at = time.monotonic()
                computed_s = result.timing.compute_s if result.timing else 0.0
                model_s += called_at - begun_at
                twin_s += computed_s
                calls_s += answered_at - called_at - computed_s
                response = self._responses(result)
                felt, back = guess[feels].ravel(), response[feels].ravel()
                residual_m = self._solver.displacement_m(back - felt)
                if residual_m <= self._tolerance_m or iteration == self._iterations:
                    break
                guess = self._guess(response, self._solver.next(felt, back))
        except BaseException:
            self._solver.inverse = kept
            model.restore(began)
            raise
        if self._iterations == 1:
            response = guess + self._relaxation * (response - guess)
        self._twin.take(slot, result)
        self._wrenches, self._poses, self._behind_s = response, poses, behind_s
        self._number += 1
        wrenches = self._in_model(response) if self._feedback else np.zeros((0, 6))
        return Frame(
            number=self._number,
            steps=steps,
            wrenches=dict(zip(self._names, wrenches, strict=False)),
            positions=self.positions,
            held=self._held(),
            state=self.state,
            iterations=iteration,
            residual_m=residual_m,
            result=result,
            times=Times(model_s, twin_s, calls_s, time.monotonic() - started_at),
        )

    def _rows(self, poses: FloatArray) -> npt.NDArray[np.float32]:
        """Poses of all grippers in the form of requests, [G + 1, 7]: the last stands still."""
        return np.concatenate([poses, [IDENTITY]]).astype(np.float32)

    def _check_speeds(self, poses: npt.NDArray[np.float32]) -> None:
        speeds = np.linalg.norm(poses[:, :3] - self._poses[:, :3], axis=1) / self.frame_s
        fastest = int(speeds.argmax())
        if not speeds[fastest] <= self._max_speed_m_s:
            raise CouplingError(
                "TOO_FAST",
                f"{self._names[fastest]} moved at {speeds[fastest]:.3g} m/s, above max_speed_m_s "
                f"{self._max_speed_m_s:g}: spread a jump of a mocap body over frames, or call "
                "reset(model=False) after setting the model",
            )

    def _responses(self, result: RolloutResult) -> FloatArray:
        """Wrenches on the carriers [G, 6], along the twin's axes."""
        total = np.zeros((len(self._names) + 1, 6))
        forces = result.forces
        if forces is not None:
            # What stands still is counted to the row that is left out.
            around = self._around
            if around.grasps:
                np.subtract.at(total, around.grasp_carriers, forces.grasps[0, 0])
            if around.collider_carriers:
                np.subtract.at(total, around.collider_carriers, forces.colliders[0, 0])
        return self._newtons * total[:-1]

    def _units(self) -> FloatArray:
        """Displacements of the bodies that feel wrenches, by each part of these, in a frame."""
        mobility = self._model.mobility(np.flatnonzero(self._feels))
        return (mobility * [1.0, _TURN_M]).repeat(3, axis=1).ravel() * self.frame_s**2 / 2

    def _guess(self, response: FloatArray, felt: FloatArray) -> FloatArray:
        """Guessed wrenches on bodies that feel them, and on the others those that came back."""
        guess = response.copy()
        guess[self._feels] = felt.reshape(-1, 6)
        return guess

    def _in_model(self, wrenches: FloatArray) -> FloatArray:
        """The same wrenches along the axes of the model's world."""
        return self._change.vectors_back(wrenches.reshape(-1, 2, 3)).reshape(-1, 6)

    def _held(self) -> dict[str, npt.NDArray[np.int64]]:
        held = {name: np.zeros(0, np.int64) for name in self._grippers}
        if isinstance(self.state.grasping, Grasping):
            holders = np.asarray(self.state.grasping.holders).astype(np.int64)
            carriers = np.array([-1, *self._around.grasp_carriers])[holders]
            for number, name in enumerate(self._grippers):
                held[name] = np.flatnonzero(carriers == number)
        return held


def _newtons(known_kg: float | None, given_kg: float | None, masses: float, asked: bool) -> float:
    """Newtons of a unit of the twin's forces."""
    if given_kg is not None:
        if not given_kg > 0.0:
            raise ValueError("mass_kg must be above 0")
        return given_kg / (masses if known_kg is None else known_kg)
    if known_kg is None and asked:
        raise ValueError(
            "the mass of the twin's object is unknown, and so are its forces: weigh it and give "
            "mass_kg=, or feedback=False, which moves the twin without feeling it"
        )
    return 1.0


def _check(
    model: Any, frame_s: float, iterations: int, relaxation: float, tolerance_m: float
) -> None:
    if not 0.0 < model.opt.timestep <= frame_s:
        raise ValueError(
            f"the model's timestep of {model.opt.timestep:g} s is above a frame of the twin, "
            f"{frame_s:.4g} s: lower model.opt.timestep"
        )
    if iterations < 1:
        raise ValueError("iterations must be at least 1")
    if not 0.0 < relaxation <= 1.0:
        raise ValueError("relaxation must be above 0 and at most 1")
    if not tolerance_m >= 0.0:
        raise ValueError("tolerance_m must not be negative")
