"""Parts of MCAP recordings as captures: the time of an episode, and the robot's grippers.

The server reads MCAP itself (docs/formats/capture.md, section 8). What a recording lacks is cut and
stated here: the time in which the object is held, and which frames and joints are grippers.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from bendtwin.captures.robots.episode import EpisodeFault, McapGripper
from bendtwin.captures.robots.images import needed

_SECOND = 1_000_000_000
#: Schemas of messages that hold for all times, and may come before the part.
_LASTING = ("sensor_msgs/msg/CameraInfo", "sensor_msgs/CameraInfo", "foxglove.CameraCalibration")


def from_mcap(
    recording: str | PathLike[str],
    out: str | PathLike[str],
    *,
    grippers: Sequence[McapGripper],
    start_s: float = 0.0,
    end_s: float | None = None,
) -> Path:
    """Writes a part of an MCAP recording with its grippers, and returns its folder.

    Args:
        recording: The `.mcap` file.
        out: Folder to write, which must not exist yet.
        grippers: Grippers that move the object, by frames of TF and joints.
        start_s: Time since the first message at which the part starts: the object is then held.
        end_s: Time at which it ends; None: the end of the recording.

    Raises:
        EpisodeFault: If something is missing; the message says what to do.
    """
    folder, source = Path(out), Path(recording)
    if folder.exists():
        raise EpisodeFault(f"{folder} is there already: name another folder, or remove it")
    if not source.is_file():
        raise EpisodeFault(f"{source} is no file: name an .mcap file (`mcap merge` joins several)")
    if not grippers:
        raise EpisodeFault("give at least one gripper")
    entries = [_entry(gripper) for gripper in grippers]
    folder.mkdir(parents=True)
    try:
        _cut(source, folder / "recording.mcap", start_s, end_s)
    except BaseException:
        (folder / "recording.mcap").unlink(missing_ok=True)
        folder.rmdir()
        raise
    document = {"format": "bendtwin-grippers", "version": 1, "grippers": entries}
    (folder / "grippers.json").write_text(json.dumps(document, indent=1))
    return folder


def _entry(gripper: McapGripper) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "name": gripper.name,
        "poses": {"frame": gripper.frame},
        "axes": {"approach": gripper.approach, "opening": gripper.opening},
        "pad": {"length_m": gripper.pad[0], "breadth_m": gripper.pad[1]},
    }
    if gripper.joints:
        entry["widths"] = {
            "joints": list(gripper.joints),
            "scale": gripper.width_scale,
            "offset_m": gripper.width_offset_m,
        }
        if gripper.topic is not None:
            entry["widths"]["topic"] = gripper.topic
    return entry


def _cut(source: Path, target: Path, start_s: float, end_s: float | None) -> None:
    """Copies the messages of a part, with static transforms and calibrations from before, and
    everything that is attached."""
    reading, writing = needed("mcap.reader"), needed("mcap.writer")
    faults = needed("mcap.exceptions")
    try:
        with source.open("rb") as stream, target.open("wb") as out:
            reader = reading.make_reader(stream)
            writer = writing.Writer(out)
            header = reader.get_header()
            writer.start(header.profile, header.library)
            count = _copy(reader, writer, start_s, end_s)
            for attachment in reader.iter_attachments():
                writer.add_attachment(
                    attachment.create_time,
                    attachment.log_time,
                    attachment.name,
                    attachment.media_type,
                    attachment.data,
                )
            for record in reader.iter_metadata():
                writer.add_metadata(record.name, record.metadata)
            writer.finish()
    except faults.McapError as error:
        raise EpisodeFault(f"{source} cannot be read ({error}): try `mcap recover`") from error
    if count == 0:
        raise EpisodeFault(f"{source} has no messages between {start_s} and {end_s} s")


def _copy(reader: Any, writer: Any, start_s: float, end_s: float | None) -> int:
    """Copies messages; returns the number of those within the part that do not last."""
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    first_ns, count = None, 0
    for schema, channel, message in reader.iter_messages(log_time_order=True):
        first_ns = message.log_time if first_ns is None else first_ns
        since_s = (message.log_time - first_ns) / _SECOND
        is_lasting = channel.topic.endswith("tf_static") or (
            schema is not None and schema.name in _LASTING
        )
        is_within = start_s <= since_s and (end_s is None or since_s <= end_s)
        if not is_lasting and not is_within:
            continue
        if channel.schema_id not in schemas:
            made = writer.register_schema(schema.name, schema.encoding, schema.data)
            schemas[channel.schema_id] = made
        if channel.id not in channels:
            channels[channel.id] = writer.register_channel(
                channel.topic,
                channel.message_encoding,
                schemas[channel.schema_id],
                channel.metadata,
            )
        writer.add_message(
            channel_id=channels[channel.id],
            log_time=message.log_time,
            data=message.data,
            publish_time=message.publish_time,
            sequence=message.sequence,
        )
        count += not is_lasting
    return count
