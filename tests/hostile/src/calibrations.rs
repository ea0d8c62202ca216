//! Calibrations: `calibration.json`, files of Kalibr, OpenCV and ROS, and models of COLMAP, with
//! wrong numbers and counts, and texts that unfold.

use rand::RngExt as _;

use crate::{Fault, Rng, archives, damage, documents, samples};

/// Faults of files of calibrations.
pub const FAULTS: &[Fault] = &[
    Fault {
        what: "a calibration with damage",
        make: |rng| {
            let text = TEXTS[rng.random_range(0..TEXTS.len())];
            damage::any(rng, text.as_bytes())
        },
    },
    Fault {
        what: "a calibration with other numbers",
        make: |rng| {
            let text = TEXTS[rng.random_range(0..TEXTS.len())];
            documents::numbers(rng, text.as_bytes())
        },
    },
    Fault { what: "a calibration of aliases", make: aliases },
    Fault { what: "a calibration of entities", make: entities },
    Fault {
        what: "a calibration of nested brackets",
        make: |rng| {
            let open = ["[", "{a: ", "- ", "<a>"][rng.random_range(0..4)];
            open.repeat(rng.random_range(100..100_000)).into_bytes()
        },
    },
];

/// Faults of binary models of COLMAP.
pub const MODELS: &[Fault] = &[
    Fault {
        what: "a model with damage",
        make: |rng| {
            let part = parts()[rng.random_range(0..3)].clone();
            damage::any(rng, &part)
        },
    },
    Fault {
        what: "a model that claims counts",
        make: |rng| {
            let mut part = parts()[rng.random_range(0..3)].clone();
            let claimed = [u64::MAX, 1 << 40, 1 << 20, 2][rng.random_range(0..4)];
            part[..8].copy_from_slice(&claimed.to_le_bytes());
            part
        },
    },
];

/// Cases with a faulty `calibration.json`.
pub const IN_CAPTURES: &[Fault] = &[Fault {
    what: "a capture with a faulty calibration",
    make: |rng| {
        let text = if rng.random() {
            documents::numbers(rng, JSON.as_bytes())
        } else {
            damage::any(rng, JSON.as_bytes())
        };
        archives::with(samples::case(), "calibration.json", text)
    },
}];

/// A calibration of one camera.
pub const JSON: &str = r#"{"format": "bendtwin-calibration", "version": 1, "cameras": [{"name": "0", "size": [8, 6],
"intrinsics": {"fx": 10.0, "fy": 11.0, "cx": 3.5, "cy": 2.5},
"distortion": {"model": "brown_conrady", "coefficients": [0.1, 0.0, 0.0, 0.0]},
"pose": {"rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "translation": [0, 0, 1]}, "reprojection_px": 0.2}],
"ground": {"normal": [0, 0, 1], "offset": 0}, "source": "board"}"#;

/// A chain of Kalibr.
pub const KALIBR: &str = "cam0:
  camera_model: pinhole
  intrinsics: [461.5, 460.8, 211.5, 119.5]
  distortion_model: radtan
  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]
  resolution: [424, 240]
  rostopic: /left/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, 0.1]
  - [0.0, 1.0, 0.0, 0.2]
  - [0.0, 0.0, 1.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  intrinsics: [461.5, 460.8, 211.5, 119.5]
  distortion_model: equidistant
  distortion_coeffs: [0.1, 0.2, 0.3, 0.4]
  resolution: [424, 240]
";

/// OpenCV's file storage as YAML.
pub const OPENCV: &str = "%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 6.0e+02, 0., 3.195e+02, 0., 6.01e+02, 2.395e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 1.0e-01, -2.0e-01, 0., 0., 5.0e-02 ]
rvec: [0.1, 0.2, 0.3]
tvec: [1, 2, 3]
";

/// OpenCV's file storage as XML.
pub const XML: &str = r#"<?xml version="1.0"?>
<opencv_storage>
<left><camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
<data>600. 0. 319.5 0. 601. 239.5 0. 0. 1.</data></camera_matrix></left>
<list><_>1</_><_>2</_></list>
</opencv_storage>
"#;

const TEXTS: [&str; 4] = [JSON, KALIBR, OPENCV, XML];

fn aliases(rng: &mut Rng) -> Vec<u8> {
    let mut text = "a0: &a0 [1, 1, 1]\n".to_owned();
    for n in 1..rng.random_range(5..60) {
        let before = n - 1;
        text += &format!("a{n}: &a{n} [*a{before}, *a{before}, *a{before}]\n");
    }
    text.into_bytes()
}

fn entities(rng: &mut Rng) -> Vec<u8> {
    let mut text = "<!DOCTYPE a [<!ENTITY e0 \"1 1 1\">".to_owned();
    for n in 1..rng.random_range(5..60) {
        let before = n - 1;
        text += &format!("<!ENTITY e{n} \"&e{before};&e{before};&e{before};\">");
    }
    (text + "]><a>&e4;</a>").into_bytes()
}

/// Cameras, images and points of a model of one image.
pub fn parts() -> [Vec<u8>; 3] {
    let mut cameras = 1_u64.to_le_bytes().to_vec();
    cameras.extend([1_u32, 1].iter().flat_map(|n| n.to_le_bytes()));
    cameras.extend([640_u64, 480].iter().flat_map(|n| n.to_le_bytes()));
    cameras.extend([600.0_f64, 600.0, 320.0, 240.0].iter().flat_map(|x| x.to_le_bytes()));
    let mut images = 1_u64.to_le_bytes().to_vec();
    images.extend(1_u32.to_le_bytes());
    images.extend([1.0_f64, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3].iter().flat_map(|x| x.to_le_bytes()));
    images.extend(1_u32.to_le_bytes());
    images.extend(b"0/0.png\0");
    images.extend(1_u64.to_le_bytes());
    images.extend([1.0_f64, 2.0].iter().flat_map(|x| x.to_le_bytes()));
    images.extend(1_u64.to_le_bytes());
    let mut points = 1_u64.to_le_bytes().to_vec();
    points.extend(1_u64.to_le_bytes());
    points.extend([0.0_f64, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()));
    points.extend([1, 2, 3]);
    points.extend(0.5_f64.to_le_bytes());
    points.extend(0_u64.to_le_bytes());
    [cameras, images, points]
}
