"""The connection to a server."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from bendtwin import calls, owner_calls, session_calls
from bendtwin.captures.archive import archive_of, masks_of
from bendtwin.captures.motion import Motion, bundle, bundle_file
from bendtwin.captures.playback import playback_cameras
from bendtwin.captures.uploads import Sender
from bendtwin.connection.caller import Caller
from bendtwin.connection.download import downloaded
from bendtwin.connection.token import shown_token
from bendtwin.connection.transport import transport
from bendtwin.errors import FitFailed, IngestFailed
from bendtwin.labels import (
    CaptureArguments,
    CaptureLabelArguments,
    CaptureListArguments,
    LabelArguments,
    ListArguments,
    named,
)
from bendtwin.resources import (
    Capture,
    Fit,
    FitPreview,
    JobState,
    LossCurve,
    MadeShare,
    OwnerUsage,
    Project,
    Requirements,
    Share,
    Trashed,
    TwinInfo,
    Worker,
)
from bendtwin.session import Session
from bendtwin.simulation.pictures import PictureCamera
from bendtwin.simulation.rollout import Fidelity
from bendtwin.simulation.state import InitialState
from bendtwin.simulation.world import Grasp, Vary, World
from bendtwin.twin import Twin

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Client:
    """Client of a BendTwin server, `host:port` or a URL. Thread-safe; close it or use it in `with`.

    `token` is a key or the token of the server, `token_file` a file with either, which other users
    must not be able to read. By default the token comes from `BENDTWIN_TOKEN`, from the file named
    in `BENDTWIN_TOKEN_FILE`, from `bendtwin login`, or from a server of the same user on the same
    machine.

    For `https://host:port`, `ca` is the file with the certificate of the server's authority (PEM).
    The default is the file named in `BENDTWIN_CA`, or the authorities of the system.

    `timeout_s` is the deadline of calls that get none themselves, except those that answer in
    parts: without it they wait for a server that does not answer.
    """

    def __init__(
        self,
        address: str = "127.0.0.1:7070",
        *,
        token: str | None = None,
        token_file: str | PathLike[str] | None = None,
        ca: str | PathLike[str] | None = None,
        timeout_s: float | None = None,
    ) -> None:
        self._transport = transport(address, ca)
        self._address = self._transport.target
        is_https = self._transport.is_https
        self._url = f"{'https' if is_https else 'http'}://{self._address}"
        self._token = shown_token(self._address, token, token_file, is_https)
        self._caller = Caller(self._transport, self._token, timeout_s)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the connection."""
        self._caller.close()

    # Captures

    def upload_capture(
        self, path: str | PathLike[str], **facts: Unpack[CaptureArguments]
    ) -> Capture:
        """Uploads a capture: an archive, or a folder that is packed first.

        Motion capture (`.npz`, `.c3d`, `.csv`, `.trc`) is packed with the `.json` beside it. The
        same content with the same `request_id` returns the existing capture. `facts` are those of
        `CaptureArguments`: `display_name`, `request_id`, `ingest`, `ingest_requirements`,
        `recorded_by`.
        """
        path = Path(path)
        stated = named(facts, path.stem)
        with self._caller.packed(path) as archive:
            return self._caller.run(calls.create_capture(archive, stated))

    def upload_motion(
        self,
        motions: Motion | Sequence[Motion],
        *,
        fps: float,
        units: str = "m",
        up_axis: str = "+z",
        ground: float | None = 0.0,
        edges: ArrayLike | None = None,
        rest_points: ArrayLike | None = None,
        pins: ArrayLike | None = None,
        **facts: Unpack[CaptureArguments],
    ) -> Capture:
        """Uploads motion capture: tracked points, as one or several motions.

        `ground` is the ground's height along `up_axis`, in `units`; None means no ground. `edges`
        [E, 2] are pairs of joined points, `rest_points` [P, 3] the undeformed shape, `pins` [H, 2]
        pairs of a point and the control point that holds it. The default `display_name` is
        `motion`; `facts` are those of `CaptureArguments`: `display_name`, `request_id`, `ingest`,
        `ingest_requirements`, `recorded_by`.
        """
        stated = named(facts, "motion")
        content = bundle(
            motions,
            fps=fps,
            name=stated["display_name"] or "",
            units=units,
            up_axis=up_axis,
            ground=ground,
            edges=edges,
            rest_points=rest_points,
            pins=pins,
        )
        with bundle_file(content) as path:
            return self.upload_capture(path, **stated)

    def push_capture(
        self,
        path: str | PathLike[str],
        *,
        on_progress: Callable[[int, int], None] | None = None,
        **facts: Unpack[CaptureArguments],
    ) -> Capture:
        """Uploads a capture resumably (tus 1.0.0): an archive, or a folder that is packed first.

        Motion capture (`.npz`, `.c3d`, `.csv`, `.trc`) is packed with the `.json` beside it.
        The upload survives broken connections and restarts of the server and, if called again, of
        the calling process. The same content with the same facts is one capture and is not sent
        twice. `on_progress` gets the bytes that the server has, and the total. `facts` are those of
        `CaptureArguments`: `display_name`, `request_id`, `ingest`, `ingest_requirements`,
        `recorded_by`.
        """
        file = Path(path)
        stated = named(facts, file.resolve().name if file.is_dir() else file.stem)

        def send() -> str:
            with archive_of(file) as archive:
                return Sender(self._transport, archive, stated, token=self._token).send(on_progress)

        return self.capture(self._caller.blocking(send))

    def capture(self, name: str) -> Capture:
        """The capture with a name."""
        return self._caller.run(calls.get_capture(name))

    def captures(self, **choice: Unpack[CaptureListArguments]) -> Iterator[Capture]:
        """All captures, newest first, or those with a text or a tag, in another order."""
        return self._caller.pages(calls.list_captures(choice))

    def update_capture(self, name: str, **change: Unpack[CaptureLabelArguments]) -> Capture:
        """Changes what is stated about a capture; omitted facts stay."""
        return self._caller.run(calls.update_capture(name, change))

    def delete_capture(self, name: str, *, purge: bool = False) -> None:
        """Moves a capture to the trash, or deletes it for good; its twins are kept."""
        self._caller.run(calls.delete_capture(name, purge))

    # Adding to captures

    def add_masks(self, name: str, masks: str | PathLike[str] | bytes) -> Capture:
        """Adds masks to a capture, or replaces those that were added: an archive with a folder
        `mask` (docs/formats/capture.md), its bytes, or a folder that is packed first.

        The next ingest reads them in place of those of the recording. Refused while an ingest or a
        fit of the capture is queued or running.
        """
        if isinstance(masks, bytes):
            return self._caller.run(calls.add_supplement(name, "masks", masks))
        with self._caller.packed(Path(masks), masks_of) as archive:
            return self._caller.run(calls.add_supplement(name, "masks", archive))

    def add_calibration(
        self, name: str, calibration: str | PathLike[str] | bytes | dict[str, Any]
    ) -> Capture:
        """Adds a calibration document to a capture, or replaces the one that was added: a file,
        its bytes, or what it says.

        The next ingest reads it in place of the recording's own. Refused while an ingest or a fit
        of the capture is queued or running.
        """
        if isinstance(calibration, dict):
            content = json.dumps(calibration).encode()
        elif isinstance(calibration, bytes):
            content = calibration
        else:
            content = Path(calibration).read_bytes()
        return self._caller.run(calls.add_supplement(name, "calibration", content))

    def download_supplement(self, name: str, kind: str, path: str | PathLike[str]) -> None:
        """Writes a file that was added to a capture: its `masks` or its `calibration`."""
        self._caller.save(calls.export_supplement(name, kind), path)

    def delete_supplement(self, name: str, kind: str) -> None:
        """Removes a file that was added to a capture: its `masks` or its `calibration`."""
        self._caller.run(calls.delete_supplement(name, kind))

    # Reading captures

    def ingest_capture(
        self,
        name: str,
        settings: dict[str, Any] | None = None,
        *,
        request_id: str | None = None,
        requirements: Requirements | None = None,
    ) -> Capture:
        """Reads a capture again, for example with other settings (docs/use/settings.md).

        Without `requirements` any worker will do.
        """
        return self._caller.run(calls.ingest_capture(name, settings, request_id, requirements))

    def cancel_ingest(self, name: str) -> Capture:
        """Asks the ingest of a capture to stop; an ended ingest does not change."""
        return self._caller.run(calls.cancel_ingest(name))

    def watch_capture(self, name: str, *, timeout_s: float | None = None) -> Iterator[Capture]:
        """The capture now and after every change of its ingest, until the ingest has ended.

        Survives restarts of the server. Raises BendTwinError (DEADLINE_EXCEEDED) after
        `timeout_s`.
        """
        return self._caller.follow(calls.watch_capture(name), timeout_s)

    def wait_for_capture(
        self,
        capture: Capture | str,
        *,
        timeout_s: float | None = None,
        on_progress: Callable[[Capture], None] | None = None,
    ) -> Capture:
        """Waits until a capture has been read. Raises IngestFailed if it cannot be fitted."""
        name = capture if isinstance(capture, str) else capture.name
        last: Capture | None = None
        for last in self.watch_capture(name, timeout_s=timeout_s):
            if on_progress is not None:
                on_progress(last)
        ended = last if last is not None else self.capture(name)
        if ended.ingest is not None and ended.ingest.state is not JobState.SUCCEEDED:
            raise IngestFailed(ended)
        return ended

    def capture_report(self, name: str) -> dict[str, Any]:
        """Report on a capture: verdict, findings and measurements."""
        content = self._caller.content(calls.capture_report(name, html=False))
        report: dict[str, Any] = json.loads(content)
        return report

    def save_capture_report(self, name: str, path: str | PathLike[str]) -> None:
        """Writes the report of a capture as a page with pictures, to be opened in a browser."""
        self._caller.save(calls.capture_report(name, html=True), path)

    def export_observation(self, name: str, path: str | PathLike[str]) -> None:
        """Writes the observation that fits of a capture work on: tracked points as a bundle
        (ZIP)."""
        self._caller.save(calls.export_observation(name), path)

    def download_masks(self, name: str, path: str | PathLike[str]) -> None:
        """Writes the masks that the last ingest of a capture made of strokes (ZIP)."""
        self._caller.save(calls.export_masks(name), path)

    def download_playback(self, name: str, path: str | PathLike[str]) -> None:
        """Writes the playback of a capture: small images of its cameras, their calibration, and
        tracked points (docs/formats/playback.md)."""
        Path(path).write_bytes(self._playback(name))

    def capture_cameras(
        self,
        name: str,
        *,
        width: int,
        height: int,
        sequence: int = 0,
        backgrounds: bool = True,
    ) -> list[PictureCamera]:
        """Cameras of another size at the places of those that recorded a capture, for
        `Session.render`: the middle of their images, as large as fits.

        The background of each is the median of its images over time, without what their masks
        label, so that object and hands vanish as far as possible. It needs Pillow:
        `pip install "bendtwin[pictures]"`. Cameras that are not calibrated are left out.

        `sequence` is the index among the sequences of all recordings of the capture.
        """
        content = self._playback(name)
        return [
            camera.picture_camera(width, height, background=backgrounds)
            for camera in playback_cameras(content, sequence)
            if len(camera.poses)
        ]

    def _playback(self, name: str) -> bytes:
        def load() -> bytes:
            return downloaded(self._transport, f"/v1/{name}/playback", self._token)

        return self._caller.blocking(load)

    # Fits

    def fit(
        self,
        capture: str,
        settings: dict[str, Any] | None = None,
        *,
        priority: int = 0,
        request_id: str | None = None,
        display_name: str = "",
        requirements: Requirements | None = None,
    ) -> Fit:
        """Starts a fit of a capture. docs/use/settings.md lists the `settings`.

        The default `display_name` is that of the capture; without `requirements` any worker can run
        the fit.
        """
        return self._caller.run(
            calls.create_fit(capture, settings, priority, request_id, display_name, requirements)
        )

    def get_fit(self, name: str) -> Fit:
        """The fit with a name, in its current state."""
        return self._caller.run(calls.get_fit(name))

    def fits(
        self, capture: str = "", *, state: JobState | None = None, **choice: Unpack[ListArguments]
    ) -> Iterator[Fit]:
        """All fits, newest first, or those of a capture, in a state, with a text or a tag."""
        return self._caller.pages(calls.list_fits(capture, state, choice))

    def update_fit(self, name: str, **change: Unpack[LabelArguments]) -> Fit:
        """Changes display name, note and tags of a fit; omitted ones stay."""
        return self._caller.run(calls.update_fit(name, change))

    def fit_losses(self, fit: Fit | str) -> list[LossCurve]:
        """The losses of a fit, by stage and model. They are kept until the fit is deleted."""
        name = fit if isinstance(fit, str) else fit.name
        return self._caller.run(calls.fit_losses(name))

    def fit_preview(self, fit: Fit | str) -> FitPreview:
        """What a running fit has so far; raises NotFound before there is something, and once the
        fit has a twin."""
        name = fit if isinstance(fit, str) else fit.name
        return self._caller.run(calls.fit_preview(name))

    def cancel_fit(self, name: str) -> Fit:
        """Asks a fit to stop; an ended fit is returned unchanged."""
        return self._caller.run(calls.cancel_fit(name))

    def delete_fit(self, name: str, *, purge: bool = False) -> None:
        """Moves a fit that does not run to the trash, or deletes it for good; its twin is kept."""
        self._caller.run(calls.delete_fit(name, purge))

    def watch(self, name: str, *, timeout_s: float | None = None) -> Iterator[Fit]:
        """The fit now and after every change, until it has ended.

        Survives restarts of the server. Raises BendTwinError (DEADLINE_EXCEEDED) after
        `timeout_s`.
        """
        return self._caller.follow(calls.watch_fit(name), timeout_s)

    def wait(
        self,
        fit: Fit | str,
        *,
        timeout_s: float | None = None,
        on_progress: Callable[[Fit], None] | None = None,
    ) -> Fit:
        """Waits for a fit to succeed. Raises FitFailed if it ends without a twin."""
        name = fit if isinstance(fit, str) else fit.name
        last: Fit | None = None
        for last in self.watch(name, timeout_s=timeout_s):
            if on_progress is not None:
                on_progress(last)
        ended = last if last is not None else self.get_fit(name)
        if ended.state is not JobState.SUCCEEDED:
            raise FitFailed(ended)
        return ended

    # Twins

    def twin(self, name: str) -> Twin:
        """A twin, ready for rollouts."""
        return self._twin(self._caller.run(calls.get_twin(name)))

    def open_session(
        self,
        twin: Twin | str,
        *,
        initial: InitialState | None = None,
        slots: int = 1,
        world: World | None = None,
        grasps: Sequence[Grasp] = (),
        vary: Vary | None = None,
        fidelity: Fidelity = "exact",
        idle_timeout_s: float = 0.0,
    ) -> Session:
        """Opens simulations of a twin that a worker keeps between calls.

        They start from `initial` (default: at rest; a batch of given states has one state for each
        slot). `world` and `grasps` apply to every rollout of the session that gives none; `vary`
        too, with a factor for all slots or one for each, but only in calls of this object. The
        session ends after `idle_timeout_s` without calls (0: five minutes).
        """
        of = self.twin(twin) if isinstance(twin, str) else twin
        request = session_calls.open_request(
            of.name, initial, slots, world, grasps, vary, fidelity, idle_timeout_s
        )
        info = self._caller.run(session_calls.open_session(request))
        return Session(self._caller, of, request, info, vary)

    def twins(
        self, capture: str = "", *, level: str = "", **choice: Unpack[ListArguments]
    ) -> Iterator[Twin]:
        """All twins, newest first, or those of a capture, with a text or a tag, or of a level of
        trust: good, fair, poor or unknown."""
        call = calls.list_twins(capture, level, choice)
        return (self._twin(info) for info in self._caller.pages(call))

    def update_twin(self, name: str, **change: Unpack[LabelArguments]) -> Twin:
        """Changes display name, note and tags of a twin; omitted ones stay."""
        return self._twin(self._caller.run(calls.update_twin(name, change)))

    def export_twin(self, name: str, path: str | PathLike[str]) -> None:
        """Writes a twin's file (safetensors, docs/formats/twin.md)."""
        self._caller.save(calls.export_twin(name), path)

    def import_twin(
        self,
        path: str | PathLike[str],
        *,
        display_name: str | None = None,
        request_id: str | None = None,
    ) -> Twin:
        """Stores a twin file that another server exported."""
        return self._twin(self._caller.run(calls.create_twin(path, display_name, request_id)))

    def delete_twin(self, name: str, *, purge: bool = False) -> None:
        """Moves a twin to the trash, or deletes it for good."""
        self._caller.run(calls.delete_twin(name, purge))

    # Trash

    def trashed_captures(self, owner: str = "") -> Iterator[Trashed]:
        """Deleted captures that can be restored, the last one first."""
        return self._caller.pages(calls.list_trashed_captures(owner))

    def trashed_fits(self, owner: str = "") -> Iterator[Trashed]:
        """Deleted fits that can be restored, the last one first."""
        return self._caller.pages(calls.list_trashed_fits(owner))

    def trashed_twins(self, owner: str = "") -> Iterator[Trashed]:
        """Deleted twins that can be restored, the last one first."""
        return self._caller.pages(calls.list_trashed_twins(owner))

    def restore_capture(self, name: str) -> Capture:
        """Restores a deleted capture; an ingest that was queued or running is queued again."""
        return self._caller.run(calls.restore_capture(name))

    def restore_fit(self, name: str) -> Fit:
        """Restores a deleted fit; one that was queued is queued again."""
        return self._caller.run(calls.restore_fit(name))

    def restore_twin(self, name: str) -> Twin:
        """Restores a deleted twin."""
        return self._twin(self._caller.run(calls.restore_twin(name)))

    # Links to twins

    def share_twin(
        self, name: str, *, display_name: str = "", days: float = 7, allow_export: bool = False
    ) -> MadeShare:
        """Makes a link by which people without a token look at a twin and play with it, for up to
        90 days. `display_name` is for whom it is; `allow_export` lets them download the twin. A
        server that requires no token refuses with the reason `SHARE_NOT_NEEDED`."""
        made = owner_calls.share_twin(self._url, name, display_name, days, allow_export)
        return self._caller.run(made)

    def shares(self, twin: str) -> Iterator[Share]:
        """The links of a twin, newest first, revoked and expired ones included."""
        return self._caller.pages(owner_calls.list_shares(twin))

    def delete_share(self, name: str) -> None:
        """Revokes a link; plays through it end."""
        self._caller.run(owner_calls.delete_share(name))

    # Workers

    def workers(self) -> Iterator[Worker]:
        """Workers that are registered with the server."""
        return self._caller.pages(calls.list_workers())

    def drain_worker(self, name: str) -> Worker:
        """Asks a worker to take no more work, hand back its job, and end after its rollouts."""
        return self._caller.run(calls.drain_worker(name))

    # Projects

    def create_project(self, display_name: str, members: Sequence[str] = ()) -> Project:
        """Makes a project of owners who share what they have. Takes the scope `admin`, as all
        changes of projects do."""
        return self._caller.run(owner_calls.create_project(display_name, members))

    def project(self, name: str) -> Project:
        """Returns a project."""
        return self._caller.run(owner_calls.get_project(name))

    def projects(self) -> Iterator[Project]:
        """Projects of the key's owner, newest first; with the scope `admin` all projects."""
        return self._caller.pages(owner_calls.list_projects())

    def update_project(
        self,
        name: str,
        *,
        display_name: str | None = None,
        add_members: Sequence[str] = (),
        remove_members: Sequence[str] = (),
    ) -> Project:
        """Renames a project, and adds and removes members."""
        change = owner_calls.update_project(name, display_name, add_members, remove_members)
        return self._caller.run(change)

    def delete_project(self, name: str) -> None:
        """Deletes a project. Its members keep what they have, and no longer share it."""
        self._caller.run(owner_calls.delete_project(name))

    # Usage

    def usage(self) -> OwnerUsage:
        """What is stored for the owner of the key that is used, its jobs, and its quotas."""
        return self._caller.run(owner_calls.get_usage())

    def owner_usage(self) -> Iterator[OwnerUsage]:
        """The same of all owners, by name; it takes the scope `admin`."""
        return self._caller.pages(owner_calls.list_owner_usage())

    def _twin(self, info: TwinInfo) -> Twin:
        return Twin(info, self._caller)
