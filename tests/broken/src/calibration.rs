//! Wrong calibrations, units and axes: mistakes before the recording.

use bendtwin_capture::raw::Pose;

use crate::{
    Broken,
    Expected::{Found, Noticed, Refused},
    Make, broken,
    files::{FileMap, redescribe},
    footage::Footage,
};

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    let footage = |name, code, change| broken(name, Found(code), Make::Footage(change));
    let file = |name, reason, change| broken(name, Refused(reason), Make::Case(change));
    vec![
        footage("two cameras swapped", "CAMERAS_SWAPPED", |f| {
            let poses = f.about.cameras[0].poses.clone();
            f.about.cameras[0].poses = std::mem::replace(&mut f.about.cameras[2].poses, poses);
        }),
        footage("three cameras in a circle", "CAMERAS_SWAPPED", |f| {
            let poses: Vec<_> = f.about.cameras.iter().map(|c| c.poses.clone()).collect();
            for (i, camera) in f.about.cameras.iter_mut().enumerate() {
                camera.poses = poses[(i + 1) % 3].clone();
            }
        }),
        footage("images of two cameras swapped", "CAMERAS_SWAPPED", |f| f.reels.swap(0, 1)),
        footage("poses in centimetres", "EXTRINSICS_UNITS", |f| stretch(f, 100.0)),
        footage("poses in inches", "EXTRINSICS_UNITS", |f| stretch(f, 39.37)),
        footage("poses in millimetres", "EXTRINSICS_UNITS", |f| stretch(f, 1000.0)),
        footage("depth in centimetres", "DEPTH_UNITS", |f| {
            (0..3).for_each(|c| f.change_depth(c, |z| z * 100.0));
        }),
        footage("depth in kilometres", "DEPTH_UNITS", |f| {
            (0..3).for_each(|c| f.change_depth(c, |z| z * 0.001));
        }),
        footage("everything in centimetres", "SCALE_TOO_LARGE", |f| {
            stretch(f, 100.0);
            (0..3).for_each(|c| f.change_depth(c, |z| z * 100.0));
        }),
        footage("everything in kilometres", "SCALE_TOO_SMALL", |f| {
            stretch(f, 0.001);
            (0..3).for_each(|c| f.change_depth(c, |z| z * 0.001));
        }),
        footage("one camera's depth a fifth too large", "DEPTH_SCALE", |f| {
            f.change_depth(1, |z| z * 1.2);
        }),
        footage("one camera's depth in other units", "DEPTH_SCALE", |f| {
            f.change_depth(2, |z| z * 0.25);
        }),
        footage("world-to-camera for camera-to-world", "EXTRINSICS_INVERTED", |f| {
            each_pose(f, |p| {
                let back = std::array::from_fn(|i| std::array::from_fn(|j| p.rotation[j][i]));
                let t = p.translation;
                let dot = |row: [f64; 3]| -row.iter().zip(t).map(|(a, b)| a * b).sum::<f64>();
                Pose { rotation: back, translation: back.map(dot) }
            });
        }),
        footage("rotations transposed", "EXTRINSICS_INVERTED", |f| {
            each_pose(f, |p| {
                let back = std::array::from_fn(|i| std::array::from_fn(|j| p.rotation[j][i]));
                Pose { rotation: back, ..p }
            });
        }),
        footage("OpenGL's camera axes", "EXTRINSICS_AXES", |f| {
            each_pose(f, |p| Pose { rotation: p.rotation.map(|[x, y, z]| [x, -y, -z]), ..p });
        }),
        footage("the axes of a robot's body", "EXTRINSICS_AXES", |f| {
            each_pose(f, |p| Pose { rotation: p.rotation.map(|[x, y, z]| [z, -x, -y]), ..p });
        }),
        footage("a camera that looks the other way", "CAMERA_OFF", |f| {
            turn_camera(f, 2, std::f64::consts::PI);
        }),
        footage("a mirrored world", "EXTRINSICS_MIRRORED", |f| {
            each_pose(f, |p| {
                let [mut x, y, z] = p.rotation;
                x = x.map(|v| -v);
                let flip = |row: [f64; 3]| [-row[0], row[1], row[2]];
                let [a, b, c] = p.translation;
                Pose { rotation: [flip(x), flip(y), flip(z)], translation: [-a, b, c] }
            });
        }),
        footage("a world upside down", "UP_AXIS_WRONG", |f| {
            each_pose(f, |p| {
                let [x, y, z] = p.rotation;
                let [a, b, c] = p.translation;
                let turned = [x, y.map(|v| -v), z.map(|v| -v)];
                Pose { rotation: turned, translation: [a, -b, -c] }
            });
        }),
        footage("one pose for two cameras", "CAMERAS_COINCIDE", |f| {
            f.about.cameras[1].poses = f.about.cameras[0].poses.clone();
        }),
        footage("a camera that somebody turned by 3 degrees", "CAMERA_OFF", |f| {
            turn_camera(f, 1, 3.0_f64.to_radians());
        }),
        footage("a camera that somebody pushed by 3 cm", "CAMERA_OFF", |f| {
            f.about.cameras[2].poses[0].translation[0] += 0.03;
        }),
        footage("the intrinsics of twice the resolution", "INTRINSICS_IMPLAUSIBLE", |f| {
            for camera in &mut f.about.cameras {
                let i = &mut camera.intrinsics;
                (i.fx, i.fy, i.cx, i.cy) = (2.0 * i.fx, 2.0 * i.fy, 2.0 * i.cx, 2.0 * i.cy);
            }
        }),
        footage("the principal point in the corner", "INTRINSICS_IMPLAUSIBLE", |f| {
            f.about.cameras.iter_mut().for_each(|c| {
                (c.intrinsics.cx, c.intrinsics.cy) = (0.0, 0.0);
            });
        }),
        footage("a focal length in millimetres", "INTRINSICS_IMPLAUSIBLE", |f| {
            f.about.cameras.iter_mut().for_each(|c| {
                (c.intrinsics.fx, c.intrinsics.fy) = (3.6, 3.6);
            });
        }),
        footage("a focal length of NaN", "INTRINSICS_INVALID", |f| {
            f.about.cameras[0].intrinsics.fy = f64::NAN;
        }),
        footage("rotations of twice their length", "EXTRINSICS_INVALID", |f| {
            each_pose(f, |p| Pose { rotation: p.rotation.map(|r| r.map(|x| 2.0 * x)), ..p });
        }),
        footage("one camera's pose in millimetres", "EXTRINSICS_UNITS", |f| {
            let pose = &mut f.about.cameras[2].poses[0];
            pose.translation = pose.translation.map(|x| 1000.0 * x);
        }),
        footage("one coordinate of all places with the wrong sign", "EXTRINSICS_MIRRORED", |f| {
            each_pose(f, |p| {
                let [x, y, z] = p.translation;
                Pose { translation: [x, -y, z], ..p }
            });
        }),
        footage("a camera half a metre from where it stands", "CAMERA_OFF", |f| {
            f.about.cameras[0].poses[0].translation[1] += 0.5;
        }),
        footage("two cameras, one of them pushed", "CAMERAS_DISAGREE", |f| {
            // They look from different sides and have little in common.
            f.about.cameras.truncate(2);
            f.reels.truncate(2);
            f.about.cameras[1].poses[0].translation[0] += 0.15;
        }),
        footage("one pose for all cameras", "CAMERAS_COINCIDE", |f| {
            let poses = f.about.cameras[0].poses.clone();
            f.about.cameras.iter_mut().for_each(|c| c.poses = poses.clone());
        }),
        footage("a world whose y axis points up", "BELOW_GROUND", |f| {
            each_pose(f, |p| {
                let [x, y, z] = p.rotation;
                let [a, b, c] = p.translation;
                let back = y.map(|v| -v);
                Pose { rotation: [x, z, back], translation: [a, c, -b] }
            });
        }),
        footage("gravity that points up", "GRAVITY_DIRECTION", |f| {
            f.about.environment.gravity = f.about.environment.gravity.map(|g| -g);
        }),
        broken(
            "the ground a metre too low",
            Noticed("OBJECT_ABOVE_GROUND"),
            Make::Footage(|f| {
                if let Some(ground) = &mut f.about.environment.ground {
                    ground.offset_m -= 1.0;
                }
            }),
        ),
        footage("the ground 10 cm too high", "BELOW_GROUND", |f| {
            if let Some(ground) = &mut f.about.environment.ground {
                ground.offset_m += 0.1;
            }
        }),
        file("mirrored extrinsics", "MIRRORED_EXTRINSICS", |files| {
            redescribe(files, |about| {
                let rotation = &mut about.cameras[1].poses[0].rotation;
                *rotation = rotation.map(|[x, y, z]| [-x, y, z]);
            });
        }),
        file("extrinsics that are no rotation", "INVALID_CAMERA", |files| {
            redescribe(files, |about| about.cameras[0].poses[0].rotation[0] = [0.0; 3]);
        }),
        file("NaN in the extrinsics", "INVALID_CAMERA", |files| {
            redescribe(files, |about| about.cameras[0].poses[0].translation[1] = f64::NAN);
        }),
        file("a camera on the moon", "INVALID_CAMERA", |files| {
            redescribe(files, |about| about.cameras[0].poses[0].translation[2] = 3.8e8);
        }),
        file("a negative focal length", "INVALID_CAMERA", |files| {
            redescribe(files, |about| about.cameras[2].intrinsics.fx *= -1.0);
        }),
        file("one calibration too few", "LENGTH_MISMATCH", |files: &mut FileMap| {
            redescribe(files, |about| about.cameras.truncate(2));
            let two = files.remove("calibrate.pkl").unwrap_or_default();
            redescribe(files, |_| {});
            files.insert("calibrate.pkl".to_owned(), two);
        }),
    ]
}

fn each_pose(footage: &mut Footage, change: impl Fn(Pose) -> Pose) {
    for pose in footage.about.cameras.iter_mut().flat_map(|c| &mut c.poses) {
        *pose = change(*pose);
    }
}

fn stretch(footage: &mut Footage, factor: f64) {
    each_pose(footage, |p| Pose { translation: p.translation.map(|x| x * factor), ..p });
}

/// Turns a camera about the vertical through itself.
fn turn_camera(footage: &mut Footage, camera: usize, angle: f64) {
    let (s, c) = angle.sin_cos();
    let pose = &mut footage.about.cameras[camera].poses[0];
    let [x, y, z] = pose.rotation;
    let mix =
        |a: [f64; 3], b: [f64; 3], p: f64, q: f64| std::array::from_fn(|j| p * a[j] + q * b[j]);
    pose.rotation = [mix(x, y, c, -s), mix(x, y, s, c), z];
}
