"""A twin that answers rollouts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy.typing as npt

from bendtwin.actions import control_trajectories, gripper_poses, knot_times
from bendtwin.costs import Cost
from bendtwin.errors import translated
from bendtwin.geometry import Geometry
from bendtwin.interpolation import Interpolation
from bendtwin.resources import TwinInfo
from bendtwin.rollout import FIDELITIES, Fidelity, Returns, RolloutResult, warned
from bendtwin.state import InitialState, Rest
from bendtwin.v1 import rollout_pb2, twin_pb2
from bendtwin.world import (
    Ensemble,
    GradientOptions,
    Grasp,
    Plausibility,
    Surroundings,
    Vary,
    World,
)

if TYPE_CHECKING:
    from bendtwin.v1 import rollout_pb2_grpc, twin_pb2_grpc

_REST = Rest()
_COSTS_ONLY = Returns()


_Reply = TypeVar("_Reply")
_Parts = TypeVar("_Parts")


class Rollouts(Generic[_Reply, _Parts]):
    """Rollouts of a fitted twin, whatever the way to wait for a reply."""

    def __init__(
        self,
        info: TwinInfo,
        rollouts: rollout_pb2_grpc.RolloutServiceStub,
        twins: twin_pb2_grpc.TwinServiceStub,
    ) -> None:
        #: What the server says about it.
        self.info = info
        self._rollouts = rollouts
        self._twins = twins
        self._geometry: Geometry | None = None

    @property
    def name(self) -> str:
        """twins/{uuid}."""
        return self.info.name

    def rollout(
        self,
        *,
        trajectories: npt.ArrayLike | None = None,
        poses: npt.ArrayLike | None = None,
        gripper_of_control: npt.ArrayLike | None = None,
        interpolation: Interpolation = "linear",
        at_s: npt.ArrayLike | None = None,
        period_s: float | None = None,
        initial: InitialState = _REST,
        frames: int = 0,
        costs: Iterable[Cost] = (),
        returns: Returns = _COSTS_ONLY,
        fidelity: Fidelity = "exact",
        world: World | None = None,
        grasps: Sequence[Grasp] = (),
        vary: Vary | None = None,
        ensemble: Ensemble | None = None,
        gradient: GradientOptions | None = None,
        plausibility: Plausibility | None = None,
        timeout_s: float | None = None,
    ) -> _Reply:
        """Predicts what a batch of actions does.

        Args:
            trajectories: Positions [m] of every control point, [B, K, C, 3]. With `frames` left
                out K = F + 1: row 0 belongs to the initial state. Otherwise K >= 2 knots are
                spread evenly over the horizon.
            poses: Instead of trajectories, poses of grippers that carry their control points
                rigidly, [B, K, G, 7]: x, y, z, quaternion x, y, z, w.
            gripper_of_control: The gripper of each control point [C]; None means gripper 0.
            interpolation: Between knots: "linear", "cubic", or "zero", where each holds until the
                next; `bendtwin.interpolate` computes the same.
            at_s: Times of the knots [K], seconds from the start, rising from 0; the last holds
                until the end. Say `frames` too.
            period_s: Instead, seconds from knot to knot: a controller's period, whatever the
                twin's frame rate.
            initial: State to start from.
            frames: Horizon F; 0 means that of the dense actions.
            costs: Terms to be summed into `RolloutResult.costs`.
            returns: Arrays to return beside the costs.
            fidelity: "fast" follows the twin by its fast variant, with fewer substeps;
                `RolloutResult.deviation` says how far that strays.
            world: Ground, gravity and colliders, where they are not those of the twin.
            grasps: Holds of grippers on the object, which open and close; they need `poses`.
            vary: Parameters by instance, as factors of the twin's own.
            ensemble: Simulates every action under the sets of parameters of `vary`.
            gradient: Reach of gradients, and smoothing of the contact that they go through.
            plausibility: Limits of what is plausible. Instances beyond them are in
                `RolloutResult.implausible`, and one RuntimeWarning names the first.
            timeout_s: Deadline of the call.

        Raises:
            BendTwinError: With the server's reason.
            ValueError: If an array's shape or content is wrong before anything is sent.
        """
        request = self._request(
            trajectories,
            poses,
            gripper_of_control,
            interpolation,
            knot_times(at_s, period_s),
            initial,
            frames,
            costs,
            returns,
            fidelity,
            Surroundings(
                world=world,
                grasps=grasps,
                vary=vary,
                ensemble=ensemble,
                gradient=gradient,
                plausibility=plausibility,
            ),
        )
        return self._send(request, timeout_s)

    def stream_rollout(
        self,
        *,
        trajectories: npt.ArrayLike | None = None,
        poses: npt.ArrayLike | None = None,
        gripper_of_control: npt.ArrayLike | None = None,
        interpolation: Interpolation = "linear",
        at_s: npt.ArrayLike | None = None,
        period_s: float | None = None,
        initial: InitialState = _REST,
        frames: int = 0,
        costs: Iterable[Cost] = (),
        returns: Returns = _COSTS_ONLY,
        fidelity: Fidelity = "exact",
        world: World | None = None,
        grasps: Sequence[Grasp] = (),
        vary: Vary | None = None,
        ensemble: Ensemble | None = None,
        gradient: GradientOptions | None = None,
        plausibility: Plausibility | None = None,
        timeout_s: float | None = None,
    ) -> _Parts:
        """The same in parts, as instances finish; see `RolloutResult.first_instance`."""
        request = self._request(
            trajectories,
            poses,
            gripper_of_control,
            interpolation,
            knot_times(at_s, period_s),
            initial,
            frames,
            costs,
            returns,
            fidelity,
            Surroundings(
                world=world,
                grasps=grasps,
                vary=vary,
                ensemble=ensemble,
                gradient=gradient,
                plausibility=plausibility,
            ),
        )
        return self._send_for_parts(request, timeout_s)

    def rollout_request(
        self,
        *,
        trajectories: npt.ArrayLike | None = None,
        poses: npt.ArrayLike | None = None,
        gripper_of_control: npt.ArrayLike | None = None,
        interpolation: Interpolation = "linear",
        at_s: npt.ArrayLike | None = None,
        period_s: float | None = None,
        initial: InitialState = _REST,
        frames: int = 0,
        costs: Iterable[Cost] = (),
        returns: Returns = _COSTS_ONLY,
        fidelity: Fidelity = "exact",
        world: World | None = None,
        grasps: Sequence[Grasp] = (),
        vary: Vary | None = None,
        ensemble: Ensemble | None = None,
        gradient: GradientOptions | None = None,
        plausibility: Plausibility | None = None,
    ) -> rollout_pb2.RollOutRequest:
        """The message of `rollout` with the same arguments."""
        return self._request(
            trajectories,
            poses,
            gripper_of_control,
            interpolation,
            knot_times(at_s, period_s),
            initial,
            frames,
            costs,
            returns,
            fidelity,
            Surroundings(
                world=world,
                grasps=grasps,
                vary=vary,
                ensemble=ensemble,
                gradient=gradient,
                plausibility=plausibility,
            ),
        )

    def _request(
        self,
        trajectories: npt.ArrayLike | None,
        poses: npt.ArrayLike | None,
        gripper_of_control: npt.ArrayLike | None,
        interpolation: Interpolation,
        times: rollout_pb2.KnotTimes | None,
        initial: InitialState,
        frames: int,
        costs: Iterable[Cost],
        returns: Returns,
        fidelity: Fidelity,
        surroundings: Surroundings,
    ) -> rollout_pb2.RollOutRequest:
        if (trajectories is None) == (poses is None):
            raise ValueError("give either trajectories or poses")
        if trajectories is not None and gripper_of_control is not None:
            raise ValueError("gripper_of_control goes with poses, not with trajectories")
        if fidelity not in FIDELITIES:
            raise ValueError(f"give either of {sorted(FIDELITIES)} as fidelity, not {fidelity!r}")
        request = rollout_pb2.RollOutRequest(
            twin=self.name,
            initial=initial.to_proto(),
            frames=frames,
            costs=[cost.to_proto() for cost in costs],
            returns=returns.to_proto(),
            fidelity=FIDELITIES[fidelity],
        )
        surroundings.add_to(request)
        if times is not None:
            request.knot_times.CopyFrom(times)
        if trajectories is not None:
            request.trajectories.CopyFrom(control_trajectories(trajectories, interpolation))
        elif poses is not None:
            request.poses.CopyFrom(gripper_poses(poses, gripper_of_control, interpolation))
        return request

    def _send(self, request: rollout_pb2.RollOutRequest, timeout_s: float | None) -> _Reply:
        raise NotImplementedError

    def _send_for_parts(
        self, request: rollout_pb2.RollOutRequest, timeout_s: float | None
    ) -> _Parts:
        raise NotImplementedError


class Twin(Rollouts[RolloutResult, Iterator[RolloutResult]]):
    """A fitted twin at the server. Get one with `Client.twin`."""

    def geometry(self, *, timeout_s: float | None = None) -> Geometry:
        """Its nodes, springs and control points; asked for once, as twins never change."""
        if self._geometry is None:
            request = twin_pb2.GetTwinGeometryRequest(name=self.name)
            with translated():
                reply = self._twins.GetTwinGeometry(request, timeout=timeout_s)
            self._geometry = Geometry.from_proto(reply)
        return self._geometry

    def _send(self, request: rollout_pb2.RollOutRequest, timeout_s: float | None) -> RolloutResult:
        with translated():
            reply = self._rollouts.RollOut(request, timeout=timeout_s)
        return warned(RolloutResult.from_proto(reply))

    def _send_for_parts(
        self, request: rollout_pb2.RollOutRequest, timeout_s: float | None
    ) -> Iterator[RolloutResult]:
        is_warned = False
        with translated():
            for part in self._rollouts.StreamRollOut(request, timeout=timeout_s):
                result = RolloutResult.from_proto(part)
                yield result if is_warned else warned(result)
                is_warned = is_warned or bool(result.implausible)
