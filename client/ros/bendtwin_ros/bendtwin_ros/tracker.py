"""Tracking: the session follows the object, by clouds and by the poses of the grippers.

The session's time is that of the stamps of the clouds, in frames of the twin from the first one. A
cloud advances the session to its stamp, with the grippers where TF has them at every frame, and
corrects it. Without clouds it coasts: it follows the grippers alone, some time behind the clock.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bendtwin import (
    BendTwinError,
    Geometry,
    Registration,
    Rest,
    Returns,
    RolloutResult,
    Settled,
    State,
)
from bendtwin_ros import clouds
from bendtwin_ros.frames import Frames, MissingTransform
from bendtwin_ros.grippers import Gripper, Hands
from bendtwin_ros.link import PLANNED, TRACKED, Link
from bendtwin_ros.messages.basic import PointCloud2
from bendtwin_ros.parameters import Settings
from bendtwin_ros.poses import SECOND, Array, applied, nanoseconds
from bendtwin_ros.status import Status

#: Least pause after a registration that failed, seconds.
_PAUSE_S = 0.5
_NOT_THE_OBJECT = ("OBSERVATION_NOT_EXPLAINED", "OBJECT_LOST", "INVALID_OBSERVATION")


@dataclass(frozen=True)
class Estimate:
    """The object at a time."""

    at_ns: int
    state: State
    #: Poses of the grippers [G, 7].
    poses: Array
    #: Forces on the object [G, 6] over the last frame, of all grasps of each gripper; None without
    #: an advance, or without a known mass.
    wrenches: Array | None


@dataclass(frozen=True)
class Seen:
    """A cloud in the twin's frame."""

    at_ns: int
    points: Array
    #: Position of the camera [3].
    camera: Array


class Tracker:
    """The session, kept where the object is."""

    def __init__(
        self,
        settings: Settings,
        link: Link,
        grippers: list[Gripper],
        frames: Frames,
        status: Status,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._settings = settings
        self._link = link
        self._grippers = grippers
        self._frames = frames
        self._status = status
        self._clock = clock
        self._timeout_s: float = settings["server.timeout_s"]
        #: Stamp of the state in which the session began, and frames since.
        self._origin_ns = 0
        self._frames_done = 0
        #: Stamps of the last cloud that was used, and of the last one that was tried.
        self._last_ns: int | None = None
        self._tried_ns: int | None = None
        #: When the next registration may begin: those that fail take long.
        self._next_registration = -float("inf")
        self.hands: Hands | None = None
        #: The object now; None before it was found.
        self.estimate: Estimate | None = None

    def reset(self) -> None:
        """Forgets the object: the next cloud finds it anew, wherever it is."""
        self._forget()
        self._link.drop_session()

    def observe(self, cloud: PointCloud2, now_ns: int) -> bool:
        """Takes a cloud; False if it was left out, which the status counts with the reason.

        Raises:
            Unavailable: If the server cannot be used now.
        """
        seen = self._seen(cloud, now_ns)
        if seen is None:
            return False
        began, self._tried_ns = self._clock(), seen.at_ns
        took = self._found(seen) if not self._follows() else self._followed(seen)
        self._status.compute_s = self._clock() - began
        if took:
            self._last_ns = self._status.seen_ns = seen.at_ns
            self._status.latency_s = max(now_ns - seen.at_ns, 0) / SECOND + self._status.compute_s
        return took

    def coast(self, now_ns: int) -> bool:
        """Advances without a cloud, if none came for `clock.coast_after_s`; True if it did.

        Raises:
            Unavailable: If the server cannot be used now.
        """
        if not self._follows() or self._last_ns is None:
            return False
        behind_ns = int(self._settings["clock.coast_after_s"] * SECOND)
        silent_ns = now_ns - self._last_ns
        if silent_ns <= behind_ns:
            return False
        if silent_ns > self._settings["clock.max_gap_s"] * SECOND:
            self._status.count("no clouds", f"for more than {self._settings['clock.max_gap_s']} s")
            return False
        frames = self._frames_to(now_ns - behind_ns)
        return frames > 0 and self._advance(frames)

    def register(self, cloud: PointCloud2, near: bool, now_ns: int) -> Registration | None:
        """Finds the object in a cloud, and lets the session begin there; None if the cloud was
        left out, which the status counts with the reason.

        Raises:
            Unavailable: If the server cannot be used now.
            BendTwinError: If the cloud does not show the object.
        """
        seen = self._seen(cloud, now_ns)
        if seen is None:
            return None
        start = self.estimate.state if near and self.estimate is not None else None
        return self._registered(seen, start)

    def ready_to_plan(self) -> tuple[Any, Geometry, Hands, Estimate]:
        """The session, whose slot `PLANNED` has the current state and rest shape.

        Raises:
            Unavailable: If the object was not found, or the server cannot be used now.
        """
        session, behind = self._link.session()
        self._frames_done -= behind
        self._link.run(lambda: session.fork(TRACKED, [PLANNED]))
        assert self.hands is not None
        assert self.estimate is not None
        return session, self._link.twin().geometry(), self.hands, self.estimate

    def _follows(self) -> bool:
        return self._link.is_open and self.estimate is not None

    def _forget(self) -> None:
        self.estimate, self._last_ns, self._tried_ns = None, None, None
        self._next_registration = -float("inf")
        self._status.follows = self._status.lost = False

    def _seen(self, cloud: PointCloud2, now_ns: int) -> Seen | None:
        """The points of the object's surroundings, in the twin's frame."""
        at_ns = nanoseconds(cloud.header.stamp)
        if at_ns <= 0:
            return self._left_out("cloud without stamp", "let the driver of the camera set it")
        if at_ns - now_ns > self._settings["clock.future_s"] * SECOND:
            ahead = (at_ns - now_ns) / SECOND
            message = (
                f"{ahead:.1f} s ahead of the node's clock: synchronize clocks, or use_sim_time"
            )
            return self._left_out("cloud from the future", message)
        if at_ns == self._tried_ns:
            return self._left_out("cloud repeated", "two of the same stamp")
        try:
            points = clouds.positions(cloud)
            frame = cloud.header.frame_id
            pose = self._frames.pose(self._settings["twin_frame"], frame, at_ns)
        except clouds.CloudFault as fault:
            return self._left_out("cloud invalid", str(fault))
        except MissingTransform as missing:
            return self._left_out("transform missing", str(missing))
        placed = applied(pose, points.astype(np.float64))
        low, high = self._settings["cloud.low"], self._settings["cloud.high"]
        placed = placed[((placed >= low) & (placed <= high)).all(axis=1)]
        most = int(self._settings["cloud.max_points"])
        placed = clouds.thinned(placed, self._settings["cloud.cell_m"], most)
        least = self._settings["cloud.min_points"]
        if len(placed) < least:
            message = f"{len(placed)} of {least} between cloud.low and cloud.high"
            return self._left_out("cloud with too few points", message)
        return Seen(at_ns, placed, pose[:3])

    def _left_out(self, reason: str, message: str) -> Seen | None:
        self._status.count(reason, message)
        return None

    def _found(self, seen: Seen) -> bool:
        """Starts the session with the first cloud."""
        start = self._settings["start"]
        if start == "register":
            return self._try_registration(seen, None)
        self._begin(seen.at_ns, Settled() if start == "settled" else Rest())
        return self._corrected(seen)

    def _followed(self, seen: Seen) -> bool:
        """Advances the session to a cloud, and corrects it."""
        gap_s = self._settings["clock.max_gap_s"]
        frames = self._frames_to(seen.at_ns)
        late_s = -frames / self._fps
        if late_s > gap_s:
            # A bag that begins anew, or a simulation that was reset.
            self._status.count("clock went back", f"by {late_s:.1f} s: registering again")
            self.reset()
            for gripper in self._grippers:
                gripper.forget()
            return self._try_registration(seen, None)
        if frames < 0:
            self._left_out("cloud late", f"{late_s:.2f} s behind the twin")
            return False
        assert self.estimate is not None
        if frames / self._fps > gap_s:
            self._status.count("gap", f"{frames / self._fps:.1f} s without clouds: registering")
            return self._try_registration(seen, self.estimate.state)
        if frames > 0 and not self._advance(frames):
            return self._try_registration(seen, self.estimate.state)
        return self._corrected(seen)

    @property
    def _fps(self) -> float:
        return self._link.twin().geometry().fps

    def _frames_to(self, at_ns: int) -> int:
        return round((at_ns - self._origin_ns) * self._fps / SECOND) - self._frames_done

    def _advance(self, frames: int) -> bool:
        """Advances with the grippers as they were; False if the twin diverged."""
        assert self.hands is not None
        assert self.estimate is not None
        session, behind = self._link.session()
        self._frames_done -= behind
        frames += behind
        times = [self._time_of(self._frames_done + k) for k in range(frames + 1)]
        frame = self._settings["twin_frame"]
        unseen = [gripper.pose is None for gripper in self._grippers]
        poses, holds = [self.hands.poses()], [self.hands.holds()]
        # A look-up that fails has waited for its time limit: later times are not tried.
        known = list(self._grippers)
        for at_ns in times[1:]:
            known = [
                gripper
                for gripper in known
                if gripper.moved_to(frame, at_ns, self._frames, self._status)
            ]
            holds.append([gripper.closes_at(at_ns) for gripper in self._grippers])
            poses.append(self.hands.poses())
        path = np.stack(poses)
        for i, was_unseen in enumerate(unseen):
            # From nowhere it has not moved: what it carries stays.
            moved = np.flatnonzero((path[:, i] != path[0, i]).any(axis=1))
            if was_unseen and len(moved):
                path[: moved[0], i] = path[moved[0], i]
        result = self._link.run(lambda: self._rolled(session, path, holds))
        if result.diverged:
            self._status.count("diverged", "the motion of the grippers tore the twin")
            return False
        for one in result.implausible:
            self._status.count("implausible motion", f"{one.reason}: {one.found:.3g}")
        self._frames_done += frames
        wrenches = self._wrenches(result)
        self.estimate = Estimate(times[-1], result.state(0), path[-1], wrenches)
        return True

    def _rolled(self, session: Any, path: Array, holds: list[Any]) -> RolloutResult:
        assert self.hands is not None
        with warnings.catch_warnings():
            # They are counted.
            warnings.simplefilter("ignore", RuntimeWarning)
            result: RolloutResult = session.advance(
                slots=[TRACKED],
                poses=path[None],
                gripper_of_control=self.hands.gripper_of_control,
                grasps=self.hands.grasps(holds),
                returns=Returns(final_state=True, forces=True),
                timeout_s=self._timeout_s,
            )
        return result

    def _time_of(self, frame: int) -> int:
        return self._origin_ns + round(frame * SECOND / self._fps)

    def _wrenches(self, result: RolloutResult) -> Array | None:
        """Forces [G, 6] on the object over the last frame; None if the mass is unknown."""
        assert self.hands is not None
        if result.forces is None:
            return None
        scale = 1.0
        own_kg, geometry = self._settings["mass_kg"], self._link.twin().geometry()
        if own_kg > 0.0:
            scale = own_kg / float(geometry.masses.sum())
        elif result.mass_kg is None:
            return None
        last = np.asarray(result.forces.grasps[0, -1], dtype=np.float64)
        sums = [last[self.hands.grasps_of(i)].sum(axis=0) for i in range(len(self._grippers))]
        return scale * np.array(sums).reshape(-1, 6)

    def _corrected(self, seen: Seen) -> bool:
        """Corrects the session by a cloud."""
        assert self.estimate is not None
        session, behind = self._link.session()
        self._frames_done -= behind
        try:
            [correction] = self._link.run(
                lambda: session.correct(
                    seen.points,
                    slots=[TRACKED],
                    cameras=[seen.camera],
                    noise_m=self._settings["cloud.noise_m"],
                    register_if_lost=True,
                    timeout_s=self._timeout_s,
                )
            )
        except BendTwinError as error:
            if error.reason not in _NOT_THE_OBJECT:
                raise
            self._status.count("cloud not explained", str(error))
            self._status.lost = error.reason == "OBJECT_LOST"
            return False
        if correction.registered:
            self._status.count("registered again", "the object had been lost")
        self._status.follows = True
        self._status.lost = correction.lost
        self._status.misfit = correction.tracking.misfit
        self._status.median_mm = correction.after.median_mm
        assert correction.state is not None
        last = self.estimate
        self.estimate = Estimate(last.at_ns, correction.state, last.poses, last.wrenches)
        return True

    def _try_registration(self, seen: Seen, near: State | None) -> bool:
        """Registers near a state, or else anywhere; False if the cloud does not show the object."""
        began = self._clock()
        if began < self._next_registration:
            self._left_out("waiting to register", "after one that failed")
            return False
        for start in [near] if near is None else [near, None]:
            try:
                self._registered(seen, start)
            except BendTwinError as error:
                if error.reason not in _NOT_THE_OBJECT:
                    raise
                self._status.count("object not found", str(error))
            else:
                return True
        ended = self._clock()
        self._next_registration = ended + max(_PAUSE_S, 2.0 * (ended - began))
        self._status.lost = near is not None
        return False

    def _registered(self, seen: Seen, near: State | None) -> Registration:
        twin = self._link.twin()
        # Far longer than a correction.
        timeout_s = 10.0 * self._timeout_s
        arguments: dict[str, Any] = {"controls": self._held_at(seen.at_ns)}
        if near is not None:
            arguments |= {"initial": near, "near": True}
        found = self._link.run(
            lambda: twin.register(
                seen.points, cameras=[seen.camera], timeout_s=timeout_s, **arguments
            )
        )
        self._begin(seen.at_ns, found.state)
        self._status.follows, self._status.lost = True, False
        self._status.misfit, self._status.median_mm = 0.0, found.after.median_mm
        return found

    def _held_at(self, at_ns: int) -> Array | None:
        """Positions of the control points [C, 3], if all are in grippers whose poses are known:
        arranged around the frame of their gripper as in the rest shape. They tell one end of a
        cable from the other, and where along it the grippers are."""
        geometry = self._link.twin().geometry()
        frame = self._settings["twin_frame"]
        controls = np.full((len(geometry.controls), 3), np.nan)
        for gripper in self._grippers:
            gripper.moved_to(frame, at_ns, self._frames, self._status)
            mine, pose = geometry.hands == gripper.settings.hand, gripper.pose
            if pose is not None and gripper.closes_at(at_ns).hand and mine.any():
                own = geometry.controls[mine]
                controls[mine] = own - own.mean(axis=0) + pose[:3]
        return controls if len(controls) and np.isfinite(controls).all() else None

    def _begin(self, at_ns: int, start: State | Rest | Settled) -> None:
        """Starts the session in a state, with the grippers where they are then."""
        geometry = self._link.twin().geometry()
        session = self._link.open(start)
        [state] = self._link.run(lambda: session.states([TRACKED]))
        self._origin_ns, self._frames_done = at_ns, 0
        self._last_ns = at_ns
        self.hands = Hands(self._grippers, geometry)
        frame = self._settings["twin_frame"]
        for gripper in self._grippers:
            gripper.moved_to(frame, at_ns, self._frames, self._status)
            gripper.closes_at(at_ns)
        self.estimate = Estimate(at_ns, state, self.hands.poses(), None)
