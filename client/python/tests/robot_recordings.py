"""Recordings of a robot, made of a simulated one: LeRobot datasets and MCAP, with what is true."""

from __future__ import annotations

import io
import json
import subprocess
import zipfile
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from server import BINARY

COLOR, DEPTH = "observation.images.cam{}", "observation.images.cam{}_depth"
#: Range and steps of LeRobot's videos of depth.
LOW_M, HIGH_M, SHIFT_M, LAST = 0.01, 10.0, 3.5, 4095


@dataclass
class Simulated:
    """A filmed rope: images by camera, and the pose of what holds it."""

    cameras: list
    fps: float
    #: [T, 7].
    poses: np.ndarray
    folder: Path

    def __len__(self):
        return len(self.poses)


def simulated(folder):
    """Films a rope, with the place of the hand by its mask and its depth."""
    import av

    path = folder / "rope.zip"
    subprocess.run([BINARY, "capture", "make", "rope", path, "--raw", "--tiny"], check=True)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder / "rope")

    def images(pattern, count, kind):
        files = [folder / "rope" / pattern.replace("{frame:06}", f"{i:06}") for i in range(count)]
        opened = [next(av.open(io.BytesIO(f.read_bytes())).decode(video=0)) for f in files]
        return np.stack([frame.to_ndarray(format=kind) for frame in opened])

    document = json.loads((folder / "rope" / "capture.json").read_text())
    count, cameras = document["raw"]["frame_count"], []
    for camera in document["raw"]["cameras"]:
        made = dict(camera)
        made["color"] = images(camera["color"], count, "rgb24")
        made["depth"] = images(camera["depth"]["files"], count, "gray16le")
        [hand], [thing] = (camera["masks"][name] for name in ("manipulator", "object"))
        made["hand"], made["object"] = images(hand, count, "gray"), images(thing, count, "gray")
        tracks = camera["tracks"]
        made["tracks"] = [np.load(folder / "rope" / tracks[n]) for n in ("points", "visible")]
        cameras.append(made)
    places = np.array([place_of(cameras, i) for i in range(count)])
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))  # It points down.
    poses = np.concatenate([places, turns], axis=1)
    return Simulated(cameras, document["fps"], poses, folder)


def first(made, count):
    """The first frames of a recording."""
    images = ("color", "depth", "hand", "object")
    cut = [{**c, **{name: c[name][:count] for name in images}} for c in made.cameras]
    for camera in cut:
        camera["tracks"] = [array[:count] for array in camera["tracks"]]
    return Simulated(cut, made.fps, made.poses[:count], made.folder)


def place_of(cameras, frame):
    """The place in the world where the hand holds the object: its surface near the object's."""
    hand, thing = (surface(cameras, name, frame) for name in ("hand", "object"))
    away = np.linalg.norm(hand[:, None] - thing, axis=2).min(axis=1)
    return hand[away < 0.02].mean(axis=0)


def surface(cameras, name, frame):
    """The points of a mask, in the world."""
    seen = []
    for camera in cameras:
        v, u = np.nonzero((camera[name][frame] > 0) & (camera["depth"][frame] > 0))
        z = camera["depth"][frame][v, u] * 0.001
        lens, pose = camera["intrinsics"], camera["pose"]
        x, y = (u - lens["cx"]) / lens["fx"] * z, (v - lens["cy"]) / lens["fy"] * z
        seen.append(np.stack([x, y, z], 1) @ np.array(pose["rotation"]).T + pose["translation"])
    return np.concatenate(seen)


def video(path, images, fps, codec, kind, **options):
    """Writes a video; images of depth are given as codes."""
    import av

    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=Fraction(fps), options=options)
        stream.height, stream.width = images.shape[1:3]
        stream.pix_fmt = kind
        given = "rgb24" if images.ndim == 4 else kind
        for image in images:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format=given)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def png(image):
    """The bytes of an image file."""
    from bendtwin.captures.robots.images import PngWriter

    class Kept:
        name = "image"

        def write_bytes(self, content):
            self.content = content

    file = Kept()
    PngWriter().write(file, image)
    return file.content


def quantized(depth_mm):
    """Codes of 12 bits as LeRobot writes them: even steps of a logarithm."""
    with np.errstate(divide="ignore"):
        share = np.log(depth_mm * 0.001 + SHIFT_M) - np.log(LOW_M + SHIFT_M)
    share /= np.log(HIGH_M + SHIFT_M) - np.log(LOW_M + SHIFT_M)
    return np.rint(np.clip(share, 0, 1) * LAST).astype(np.uint16)


def features_of(made, depth):
    """What `meta/info.json` says about columns."""
    rows, columns = made.cameras[0]["depth"].shape[1:]
    names = {"motors": ["x", "y", "z", "rx", "ry", "rz", "width"]}
    features = {
        "observation.state": {"dtype": "float32", "shape": [7], "names": names},
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
        "episode_index": {"dtype": "int64", "shape": [1], "names": None},
    }
    for i in range(len(made.cameras)):
        kind = "video" if depth == "video" else "image"
        features[COLOR.format(i)] = {"dtype": kind, "shape": [rows, columns, 3], "names": None}
        if depth is None:
            continue
        info = {"is_depth_map": True, "depth_unit": "mm"}
        if depth == "video":
            info |= {"video.depth_min": LOW_M, "video.depth_max": HIGH_M}
            info |= {"video.shift": SHIFT_M, "video.use_log": True}
        kinds = {"video": "video", "image": "image", "array": "uint16"}
        features[DEPTH.format(i)] = {
            "dtype": kinds[depth],
            "shape": [rows, columns, 1],
            "names": None,
            "info": info,
        }
    return features


def states(made):
    """Rows of x, y, z, a rotation vector and the width of a gripper."""
    half_turn = np.tile([np.pi, 0.0, 0.0], (len(made), 1))
    return np.concatenate([made.poses[:, :3], half_turn, np.full((len(made), 1), 0.02)], axis=1)


def write_lerobot(made, folder, *, version="v3.0", depth="video"):
    """A dataset of two episodes, the second of which is the rope; the first has no motion.

    `depth` is "video", "image", "array" or None.
    """
    import pyarrow as pa
    from pyarrow import parquet

    count, is_new = len(made), version.startswith("v3")
    folder.mkdir()
    info = {
        "codebase_version": version,
        "fps": made.fps,
        "total_episodes": 2,
        "chunks_size": 1000,
        "features": features_of(made, depth),
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
        if is_new
        else "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mkv"
        if is_new
        else "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mkv",
    }
    (folder / "meta").mkdir()
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    still = 2

    def table(episode):
        state = states(made) if episode else np.zeros((still, 7))
        rows = len(state)
        content = {
            "observation.state": pa.array(state.astype("f4").tolist()),
            "timestamp": pa.array((np.arange(rows) / made.fps).astype("f4")),
            "episode_index": pa.array([episode] * rows),
        }
        for i, camera in enumerate(made.cameras if depth != "video" else []):
            color, depths = camera["color"][:rows], camera["depth"][:rows]
            files = [{"bytes": png(image), "path": None} for image in color]
            content[COLOR.format(i)] = pa.array(files)
            if depth == "image":
                files = [{"bytes": png(image), "path": None} for image in depths]
                content[DEPTH.format(i)] = pa.array(files)
            elif depth == "array":
                content[DEPTH.format(i)] = pa.array(depths[..., None].tolist())
        return pa.table(content)

    def put(rows, name):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(rows, folder / name)

    if is_new:
        put(pa.concat_tables([table(0), table(1)]), "data/chunk-000/file-000.parquet")
        put(episodes_of(made, still, depth), "meta/episodes/chunk-000/file-000.parquet")
    else:
        for episode in (0, 1):
            put(table(episode), f"data/chunk-000/episode_{episode:06d}.parquet")
    for i, camera in enumerate(made.cameras if depth == "video" else []):
        color, codes = camera["color"], quantized(camera["depth"].astype(float))
        if is_new:
            color, codes = (np.concatenate([part[:still], part]) for part in (color, codes))
        for feature, images, kind in ((COLOR, color, "gbrp"), (DEPTH, codes, "gray12le")):
            name = info["video_path"].format(
                video_key=feature.format(i),
                chunk_index=0,
                file_index=0,
                episode_chunk=0,
                episode_index=1,
            )
            if kind == "gbrp":
                video(folder / name, images, made.fps, "libx264", "yuv444p", crf="8")
            else:
                video(folder / name, images, made.fps, "ffv1", kind)
    assert count == len(made)


def episodes_of(made, still, depth):
    """What version 3 says about where its episodes are."""
    import pyarrow as pa

    columns = {"episode_index": [0, 1], "length": [still, len(made)]}
    columns |= {"data/chunk_index": [0, 0], "data/file_index": [0, 0]}
    for i in range(len(made.cameras) if depth == "video" else 0):
        for feature in (COLOR.format(i), DEPTH.format(i)):
            columns |= {f"videos/{feature}/{name}_index": [0, 0] for name in ("chunk", "file")}
            columns[f"videos/{feature}/from_timestamp"] = [0.0, still / made.fps]
            columns[f"videos/{feature}/to_timestamp"] = [
                still / made.fps,
                (still + len(made)) / made.fps,
            ]
    return pa.table(columns)


def cameras_of(made, masks=None, **more):
    """The cameras as people state them, with masks in a folder for each."""
    from bendtwin.captures.robots import EpisodeCamera

    stated = []
    for i, camera in enumerate(made.cameras):
        pose = np.eye(4)
        pose[:3, :3] = camera["pose"]["rotation"]
        pose[:3, 3] = camera["pose"]["translation"]
        lens = camera["intrinsics"]
        own = {} if masks is None else {"masks": masks / str(i), "tracks": camera["tracks"]}
        stated.append(
            EpisodeCamera(
                color=COLOR.format(i),
                intrinsics=[lens[name] for name in ("fx", "fy", "cx", "cy")],
                pose=pose,
                **own,
                **more,
            )
        )
    return stated


def write_masks(made, folder):
    """Masks of the object, as a program that follows it in the images writes them."""
    for i, camera in enumerate(made.cameras):
        (folder / str(i)).mkdir(parents=True)
        for frame, mask in enumerate(camera["object"]):
            wide = np.where(mask > 0, 65535, 0).astype(np.uint16)
            (folder / str(i) / f"{frame:05}.png").write_bytes(png(wide))
