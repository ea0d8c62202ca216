"""A simulated recording of a robot as MCAP of ROS 2: images, calibration, transforms and joints."""

from __future__ import annotations

import numpy as np

SECOND = 1_000_000_000
BEGIN = 1_700_000_000 * SECOND

HEADER = "std_msgs/Header header\n"
TIME = f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
PARTS = f"{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{TIME}"
ROI = "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"
XYZ = "float64 x\nfloat64 y\nfloat64 z\n"

SCHEMAS = {
    "sensor_msgs/msg/Image": HEADER
    + "uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n"
    + f"uint8[] data\n{PARTS}",
    "sensor_msgs/msg/CameraInfo": HEADER
    + "uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n"
    + "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n"
    + f"sensor_msgs/RegionOfInterest roi\n{PARTS}{'=' * 80}\n"
    + f"MSG: sensor_msgs/RegionOfInterest\n{ROI}",
    "sensor_msgs/msg/JointState": HEADER
    + f"string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n{PARTS}",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n"
    + f"{'=' * 80}\nMSG: geometry_msgs/TransformStamped\n{HEADER}string child_frame_id\n"
    + f"geometry_msgs/Transform transform\n{PARTS}"
    + f"{'=' * 80}\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
    + f"geometry_msgs/Quaternion rotation\n{'=' * 80}\nMSG: geometry_msgs/Vector3\n{XYZ}"
    + f"{'=' * 80}\nMSG: geometry_msgs/Quaternion\n{XYZ}float64 w\n",
}


def header(at_ns, frame):
    return {"stamp": {"sec": at_ns // SECOND, "nanosec": at_ns % SECOND}, "frame_id": frame}


def transform(at_ns, frame, pose):
    """A message with the pose of a frame in the world."""
    numbers = [float(x) for x in pose]
    moved = {
        "translation": dict(zip("xyz", numbers[:3], strict=True)),
        "rotation": dict(zip("xyzw", numbers[3:], strict=True)),
    }
    stamped = {"header": header(at_ns, "world"), "child_frame_id": frame, "transform": moved}
    return {"transforms": [stamped]}


def quaternion(matrix):
    """The quaternion x, y, z, w of a rotation."""
    w = np.sqrt(max(0.0, 1.0 + np.trace(matrix))) / 2.0
    if w > 0.1:
        m = matrix
        return [
            *(np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]) / (4 * w)),
            w,
        ]
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return [*vectors[:, values.argmax()], 0.0]


def write_mcap(made, path, wait):
    """The recording, after `wait` frames in which nothing happens."""
    from mcap_ros2.writer import Writer

    with path.open("wb") as out:
        writer = Writer(out)
        schemas = {n: writer.register_msgdef(n, text) for n, text in SCHEMAS.items()}

        def send(topic, kind, message, at_ns):
            writer.write_message(topic, schemas[kind], message, at_ns, at_ns)

        for i, camera in enumerate(made.cameras):
            pose = [
                *camera["pose"]["translation"],
                *quaternion(np.array(camera["pose"]["rotation"])),
            ]
            message = transform(BEGIN, f"cam{i}", pose)
            send("/tf_static", "tf2_msgs/msg/TFMessage", message, BEGIN)
            send(f"/cam{i}/color/camera_info", "sensor_msgs/msg/CameraInfo", info(camera, i), BEGIN)
        for frame in range(-wait, len(made)):
            at = BEGIN + round((frame + wait) * SECOND / made.fps)
            row = max(frame, 0)
            message = transform(at, "tcp", made.poses[row])
            send("/tf", "tf2_msgs/msg/TFMessage", message, at)
            joints = {"header": header(at, ""), "name": ["finger"], "position": [0.02]}
            joints |= {"velocity": [], "effort": []}
            send("/joint_states", "sensor_msgs/msg/JointState", joints, at)
            for i, camera in enumerate(made.cameras):
                images = (
                    ("color", "rgb8", camera["color"][row], 3),
                    ("depth", "16UC1", camera["depth"][row].astype("<u2"), 2),
                )
                for kind, encoding, image, step in images:
                    message = {"header": header(at, f"cam{i}"), "encoding": encoding}
                    message |= {"height": image.shape[0], "width": image.shape[1]}
                    message |= {"is_bigendian": 0, "step": step * image.shape[1]}
                    message["data"] = image.tobytes()
                    send(f"/cam{i}/{kind}/image_raw", "sensor_msgs/msg/Image", message, at)
        writer.finish()


def info(camera, number):
    """The calibration of a camera."""
    lens, (columns, rows) = camera["intrinsics"], camera["size"]
    k = [lens["fx"], 0.0, lens["cx"], 0.0, lens["fy"], lens["cy"], 0.0, 0.0, 1.0]
    return {
        "header": header(BEGIN, f"cam{number}"),
        "height": rows,
        "width": columns,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": k,
        "r": np.eye(3).ravel().tolist(),
        "p": [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0],
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }
