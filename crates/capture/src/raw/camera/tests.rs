use super::*;

/// Rotation by the vector (0.3, -0.5, 0.2), as OpenCV's `Rodrigues` gives it.
const ROTATION: [[f64; 3]; 3] = [
    [0.8595338985586632, -0.26022671404809444, -0.43986763295823095],
    [0.11491695393636675, 0.937032437284918, -0.3297943376922551],
    [0.497991537002922, 0.23292116428443663, 0.8353156052067086],
];
const POINTS: [Point; 4] =
    [[0.35, 0.15, 1.6], [-0.2, 0.4, 1.1], [0.0, 0.0, 1.4], [0.5, -0.45, 1.3]];

/// Each model with the pixels that OpenCV 5.0 (`projectPoints`, `fisheye.projectPoints`) gives for
/// [`POINTS`].
const MODELS: [(Distortion, [[f64; 2]; 4]); 4] = [
    (
        Distortion::None,
        [
            [1093.6634195551717, 663.8995600012631],
            [610.1612421098962, 1182.4322236545563],
            [749.1922432667876, 572.848800576807],
            [1131.6568076515937, 118.96101825302817],
        ],
    ),
    (
        Distortion::BrownConrady([-0.28, 0.09, 0.0012, -0.0007, -0.012, 0.0, 0.0, 0.0]),
        [
            [908.7742476869753, 548.4666014340162],
            [548.5413325227379, 880.8789463834282],
            [704.6467064787978, 528.0167382937611],
            [954.3565057563176, 149.6512779496091],
        ],
    ),
    (
        Distortion::BrownConrady([0.4, -0.3, 0.0008, -0.0005, 0.05, 0.6, -0.2, 0.02]),
        [
            [883.9554392649554, 532.1996021363316],
            [530.790307303605, 789.8052746325457],
            [712.0221531829704, 535.3366349616725],
            [946.3671977564288, 150.68428198259926],
        ],
    ),
    (
        Distortion::KannalaBrandt([0.03, -0.012, 0.004, -0.001]),
        [
            [903.3800198784211, 543.3519867843161],
            [544.3544021811828, 852.7254993333029],
            [704.1833371356379, 526.8563327802701],
            [953.5505499433048, 148.87439971935834],
        ],
    ),
];

fn camera(distortion: Distortion) -> Camera {
    Camera {
        name: "test".to_owned(),
        width: 848,
        height: 480,
        intrinsics: Intrinsics { fx: 612.3, fy: 609.8, cx: 421.7, cy: 238.2 },
        distortion,
        poses: vec![Pose { rotation: ROTATION, translation: [0.1, -0.2, 0.4] }],
        times_s: Vec::new(),
        fps: None,
    }
}

#[test]
fn points_appear_where_opencv_sees_them() {
    for (distortion, pixels) in MODELS {
        let camera = camera(distortion);
        for (point, expected) in POINTS.into_iter().zip(pixels) {
            let (pixel, depth) = camera.project(point, 0).unwrap();
            // Points are in single precision.
            let off = (pixel[0] - expected[0]).hypot(pixel[1] - expected[1]);
            assert!(off < 1e-3, "{distortion:?}: {pixel:?} {expected:?}");
            assert!(depth > 0.5);
        }
    }
}

#[test]
fn pixels_lead_back_to_their_points() {
    for (distortion, _) in MODELS {
        let camera = camera(distortion);
        for row in (0..480).step_by(60) {
            for column in (0..848).step_by(53) {
                let pixel = [f64::from(column), f64::from(row)];
                let point = camera.unproject(pixel, 0.8, 0);
                let (back, depth) = camera.project(point, 0).unwrap();
                let off = (pixel[0] - back[0]).hypot(pixel[1] - back[1]);
                assert!(off < 1e-3, "{distortion:?}: {pixel:?} {back:?}");
                assert!((depth - 0.8).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn undistortion_is_exact_to_nanometres() {
    for (distortion, _) in MODELS {
        for i in 0..400 {
            let at = [f64::from(i % 20 - 10) * 0.07, f64::from(i / 20 - 10) * 0.04];
            let back = distortion.undistort(distortion.distort(at));
            let off = (at[0] - back[0]).hypot(at[1] - back[1]);
            assert!(off < 1e-9, "{distortion:?}: {at:?} {back:?}");
        }
    }
}

#[test]
fn nothing_behind_a_camera_is_seen() {
    let camera = camera(Distortion::None);
    // The optical axis is the rotation's last column.
    let behind: Point =
        std::array::from_fn(|i| (camera.poses[0].translation[i] - ROTATION[i][2]) as f32);
    assert!(camera.project(behind, 0).is_none());
    assert!(camera.project([0.1, -0.2, 0.4], 0).is_none());
}

#[test]
fn a_moving_camera_has_a_pose_for_each_frame() {
    let mut camera = camera(Distortion::None);
    let first = camera.poses[0];
    camera.poses.push(Pose { translation: [5.0, 0.0, 0.0], ..first });
    assert_eq!(camera.pose(1).translation[0], 5.0);
    let shift =
        camera.unproject([10.0, 20.0], 1.0, 1)[0] - camera.unproject([10.0, 20.0], 1.0, 0)[0];
    assert!((shift - 4.9).abs() < 1e-6);
}

#[test]
fn coefficients_are_in_opencvs_order() {
    let of = Distortion::brown_conrady;
    assert_eq!(of(&[]), Some(Distortion::None));
    assert_eq!(of(&[0.0; 5]), Some(Distortion::None));
    let five = [1.0, 2.0, 3.0, 4.0, 5.0, 0.0, 0.0, 0.0];
    assert_eq!(of(&five[..5]), Some(Distortion::BrownConrady(five)));
    assert_eq!(of(&[1.0; 3]), None);
    assert_eq!(of(&[1.0; 14]), None);
}

#[test]
fn axes_and_units_turn_poses() {
    let frame = Frame { metres: 0.001, ..Frame::from_up("+y").unwrap() };
    let pose = Pose { rotation: ROTATION, translation: [100.0, 200.0, 300.0] }.turned(&frame);
    assert!((0..3).all(|i| (pose.translation[i] - [0.1, -0.3, 0.2][i]).abs() < 1e-12));
    // y up becomes z: rows go from x, y, z to x, -z, y.
    assert_eq!(pose.rotation, [ROTATION[0], ROTATION[2].map(|x| -x), ROTATION[1]]);
}
