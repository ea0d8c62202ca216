//! Boards that are filmed by made cameras.

mod accuracy;
mod faults;
mod motion;

use bendtwin_capture::raw::{Camera, Distortion, Intrinsics, Pose, Recording};
use bendtwin_core::settings::ingest::BoardPattern;
use bendtwin_synth::{Sheet, SheetFilm, film_sheet};

use super::*;

pub(super) fn charuco() -> BoardSettings {
    BoardSettings {
        pattern: BoardPattern::Charuco,
        columns: 7,
        rows: 5,
        square_m: 0.03,
        marker_m: 0.022,
        dictionary: "DICT_5X5_100".to_owned(),
        legacy: false,
    }
}

pub(super) fn april_grid() -> BoardSettings {
    BoardSettings {
        pattern: BoardPattern::AprilGrid,
        columns: 6,
        rows: 6,
        square_m: 0.0286,
        marker_m: 0.022,
        dictionary: "tag36h11".to_owned(),
        legacy: false,
    }
}

pub(super) fn sheet(settings: &BoardSettings) -> Sheet {
    let board = Board::new(settings).unwrap();
    let (black, columns) = board.printed(10_000.0);
    Sheet { size_m: board.size_m(), columns, black }
}

/// Three cameras about 0.6 m from the origin, with the lens of a wide camera.
pub(super) fn cameras() -> Vec<Camera> {
    let places = [[0.42, -0.1, 0.42], [-0.28, 0.3, 0.45], [-0.2, -0.38, 0.4]];
    places.iter().enumerate().map(|(index, place)| camera(index, *place)).collect()
}

pub(super) fn camera(index: usize, place: [f64; 3]) -> Camera {
    Camera {
        name: format!("cam{index}"),
        width: 848,
        height: 480,
        intrinsics: Intrinsics { fx: 605.0, fy: 604.0, cx: 421.0, cy: 243.5 },
        distortion: Distortion::BrownConrady([0.06, -0.12, 0.001, -0.0005, 0.02, 0.0, 0.0, 0.0]),
        poses: vec![looking_at(place, [0.02, 0.01, 0.0])],
        times_s: Vec::new(),
        fps: None,
    }
}

pub(super) fn looking_at(place: [f64; 3], target: [f64; 3]) -> Pose {
    use bendtwin_core::geometry::{cross, sub, unit};
    let forward = unit(sub(target, place)).unwrap();
    let right = unit([forward[1], -forward[0], 0.0]).unwrap();
    let down = cross(forward, right);
    Pose { rotation: std::array::from_fn(|i| [right[i], down[i], forward[i]]), translation: place }
}

pub(super) fn run(recording: &Recording, settings: &BoardSettings) -> BoardCalibration {
    calibrate(recording, settings, &mut |_| {}, &CancelToken::default()).unwrap()
}

/// The recording without poses.
pub(super) fn uncalibrated(mut recording: Recording) -> Recording {
    recording.cameras.iter_mut().for_each(|camera| camera.poses.clear());
    recording
}

/// Largest distance [m] and angle [degrees] of poses from the true ones.
pub(super) fn errors(found: &BoardCalibration, truth: &[Camera]) -> [f64; 2] {
    let cameras = &found.calibration.as_ref().unwrap().cameras;
    let mut worst = [0.0_f64; 2];
    for (camera, truth) in cameras.iter().zip(truth) {
        let apart = place::motion(&camera.pose.unwrap()).inverse() * place::motion(truth.pose(0));
        worst[0] = worst[0].max(apart.translation.vector.norm());
        worst[1] = worst[1].max(apart.rotation.angle().to_degrees());
    }
    worst
}
