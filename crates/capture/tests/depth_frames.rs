//! Depth that another camera measured, against what the colour camera itself would have measured: shapes
//! in closed form, filmed from both places.

use std::path::Path;

use bendtwin_capture::{
    Limits, npy,
    raw::{self, Camera, ColorImage, DepthImage, Distortion, Intrinsics, Pose},
};
use bendtwin_synth::analytic::{Bodies, Precision, Primitive};

const WIDTH: usize = 160;
const HEIGHT: usize = 120;

/// A camera 0.6 m above the ground that looks down at it; the world has z up.
fn camera(size: [usize; 2], focal: f64, distortion: Distortion, pose: Pose) -> Camera {
    let [width, height] = size;
    Camera {
        name: "0".to_owned(),
        width,
        height,
        intrinsics: Intrinsics {
            fx: focal,
            fy: focal,
            cx: (width as f64 - 1.0) / 2.0,
            cy: (height as f64 - 1.0) / 2.0,
        },
        distortion,
        poses: vec![pose],
        times_s: Vec::new(),
        fps: None,
    }
}

const COLOR_POSE: Pose = Pose {
    rotation: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
    translation: [0.0, 0.0, 0.6],
};

/// From the depth camera to the colour camera: beside it, and turned towards it.
fn to_color(angle: f64, place: [f64; 3]) -> Pose {
    let (sin, cos) = angle.sin_cos();
    Pose { rotation: [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], translation: place }
}

/// The pose in the world of a camera that stands so before the colour camera.
fn in_world(to_color: &Pose) -> Pose {
    let c = COLOR_POSE.rotation;
    let turn = |v: [f64; 3]| c.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    let columns: [[f64; 3]; 3] = std::array::from_fn(|j| turn(to_color.rotation.map(|row| row[j])));
    let moved = turn(to_color.translation);
    Pose {
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i])),
        translation: std::array::from_fn(|i| COLOR_POSE.translation[i] + moved[i]),
    }
}

/// A ball above the ground, another one behind it, and a slanted long one.
fn bodies() -> Bodies<u8> {
    let half_axes_m = [0.03, 0.12, 0.02];
    let (sin, cos) = 0.5_f64.sin_cos();
    let rotation = [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]];
    Bodies(vec![
        (1, Primitive::Sphere { center: [0.02, 0.0, 0.25], radius_m: 0.05 }),
        (2, Primitive::Sphere { center: [-0.06, 0.05, 0.1], radius_m: 0.06 }),
        (3, Primitive::Ellipsoid { center: [0.14, 0.0, 0.1], rotation, half_axes_m }),
        (4, Primitive::Ground),
    ])
}

fn filmed(camera: &Camera) -> DepthImage {
    let view = bodies().view(camera, 0, Precision::Double);
    view.image(|_, hit| hit.map_or(0.0, |hit| hit.depth_m as f32))
}

/// A case of one camera whose depth was measured by another.
fn write(folder: &Path, depth: &Camera, to_color: &Pose) {
    for kind in ["color/0", "depth/0"] {
        std::fs::create_dir_all(folder.join(kind)).unwrap();
    }
    let k =
        |i: &Intrinsics| format!("[[{}, 0, {}], [0, {}, {}], [0, 0, 1]]", i.fx, i.cx, i.fy, i.cy);
    let rows = |pose: &Pose| {
        let row = |i: usize| {
            format!(
                "[{:?}, {:?}, {:?}, {:?}]",
                pose.rotation[i][0], pose.rotation[i][1], pose.rotation[i][2], pose.translation[i]
            )
        };
        format!("[{}, {}, {}]", row(0), row(1), row(2))
    };
    let color = camera([WIDTH, HEIGHT], 150.0, Distortion::None, COLOR_POSE);
    let lens = match depth.distortion {
        Distortion::BrownConrady(k) => format!("{:?}", &k[..5]),
        _ => "[]".to_owned(),
    };
    let metadata = format!(
        "{{\"intrinsics\": [{}], \"WH\": [{WIDTH}, {HEIGHT}], \"fps\": 30, \"up_axis\": \"+z\", \"depth_intrinsics\": {}, \
         \"depth_size\": [{}, {}], \"depth_distortion\": [{lens}], \"depth_pose\": {}}}",
        k(&color.intrinsics),
        k(&depth.intrinsics),
        depth.width,
        depth.height,
        rows(to_color),
    );
    std::fs::write(folder.join("metadata.json"), metadata).unwrap();
    std::fs::write(folder.join("calibrate.json"), format!("[{}]", rows(&COLOR_POSE))).unwrap();
    let image = ColorImage::filled(WIDTH, HEIGHT, [90, 120, 60]);
    std::fs::write(folder.join("color/0/0.png"), image.encode().unwrap()).unwrap();
    let measured = filmed(depth);
    let bytes: Vec<u8> = measured.pixels.iter().flat_map(|m| m.to_le_bytes()).collect();
    let array = npy::write("<f4", &[depth.height, depth.width], &bytes);
    std::fs::write(folder.join("depth/0/0.npy"), array).unwrap();
}

/// Shares of the colour camera's pixels: seen by both cameras and filled, of those seen by both; farther
/// than the truth by more than 2 cm; nearer.
fn compare(depth: &Camera, to_color: &Pose) -> [f64; 3] {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), depth, to_color);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    let aligned = recording.source.frames(0).unwrap().depth(0).unwrap().unwrap();
    let color = &recording.cameras[0];
    let truth = filmed(&camera([WIDTH, HEIGHT], 150.0, Distortion::None, COLOR_POSE));
    let measured = filmed(depth);
    let (mut both, mut filled, mut farther, mut nearer) = (0, 0, 0, 0);
    for (i, (&found, &true_m)) in aligned.pixels.iter().zip(&truth.pixels).enumerate() {
        let pixel = [(i % WIDTH) as f64, (i / WIDTH) as f64];
        let point = color.unproject(pixel, f64::from(true_m), 0);
        // Whether the depth camera sees this point, and not something before it.
        let seen = depth.project(point, 0).and_then(|([x, y], z)| {
            let inside = x >= 0.0 && y >= 0.0;
            let there = measured.get(x.round() as usize, y.round() as usize).filter(|_| inside)?;
            Some((f64::from(there) - z).abs() < 0.01)
        });
        if seen == Some(true) {
            both += 1;
            filled += usize::from((found - true_m).abs() < 0.006);
        }
        farther += usize::from(found > true_m + 0.02);
        nearer += usize::from(found > 0.0 && found < true_m - 0.02);
    }
    assert!(both > WIDTH * HEIGHT / 2, "{both}");
    let all = (WIDTH * HEIGHT) as f64;
    [
        filled as f64 / f64::from(both as u32),
        f64::from(farther as u32) / all,
        f64::from(nearer as u32) / all,
    ]
}

#[test]
fn depth_of_another_camera_is_where_colour_sees_it() {
    let pose = to_color(0.08, [0.05, 0.004, -0.01]);
    let bent = Distortion::BrownConrady([0.08, -0.05, 0.001, -0.002, 0.0, 0.0, 0.0, 0.0]);
    for (name, depth) in [
        ("the same resolution", camera([WIDTH, HEIGHT], 150.0, Distortion::None, in_world(&pose))),
        (
            "a wider view of half the resolution",
            camera([96, 72], 70.0, Distortion::None, in_world(&pose)),
        ),
        ("twice the resolution", camera([320, 240], 300.0, Distortion::None, in_world(&pose))),
        ("a distorted lens", camera([200, 150], 170.0, bent, in_world(&pose))),
    ] {
        let [filled, farther, nearer] = compare(&depth, &pose);
        println!("{name}: filled {filled:.4}, farther {farther:.4}, nearer {nearer:.4}");
        assert!(filled > 0.97, "{name}: {filled}");
        // What is behind an edge does not show through what is before it, and edges do not grow.
        assert!(farther < 0.004 && nearer < 0.02, "{name}: {farther} {nearer}");
    }
}

/// The same files read as if depth were aligned are visibly wrong: the comparison can fail.
#[test]
fn without_its_place_depth_is_off() {
    let pose = to_color(0.08, [0.05, 0.004, -0.01]);
    let depth = camera([WIDTH, HEIGHT], 150.0, Distortion::None, in_world(&pose));
    let wrong = to_color(0.0, [0.0; 3]);
    let [filled, farther, nearer] = compare(&depth, &wrong);
    assert!(filled < 0.9 && farther + nearer > 0.02, "{filled} {farther} {nearer}");
}
