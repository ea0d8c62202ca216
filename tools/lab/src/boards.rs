//! `bendtwin-lab boards`: errors of poses from boards that made cameras film.

use bendtwin_calibrate::board::{self, Board};
use bendtwin_capture::raw::{Camera, Distortion, Intrinsics, Pose};
use bendtwin_core::{
    CancelToken,
    geometry::{Vector, cross, sub, unit},
    settings::ingest::BoardSettings,
};
use bendtwin_synth::{Sheet, SheetFilm, film_sheet};
use bendtwin_terminal::{failure, global::Global, output, table::Table};
use clap::Args;
use serde_json::json;

#[derive(Debug, Args)]
pub(crate) struct Boards {
    /// Boards to film, as `bendtwin capture calibrate --board` names them
    #[arg(long, value_name = "BOARD", value_parser = board::parse, default_values = ["charuco:7x5:30mm:22mm:DICT_5X5_100", "apriltag:6x6:22mm:6.6mm"])]
    board: Vec<BoardSettings>,
    /// Distances of the cameras from the board [m]
    #[arg(long, value_name = "METRES", value_delimiter = ',', default_value = "0.6,0.9")]
    distance: Vec<f64>,
    /// Rigs of three cameras for each board and distance
    #[arg(long, value_name = "N", default_value_t = 5)]
    rigs: u64,
    /// Frames in which the board rests
    #[arg(long, value_name = "N", default_value_t = 3)]
    frames: usize,
    /// Deviation of the noise of images, of 255
    #[arg(long, value_name = "N", default_value_t = 5.0)]
    noise: f64,
    /// Deviation of the blur [px]
    #[arg(long, value_name = "PX", default_value_t = 0.8)]
    blur: f64,
}

/// Errors of all cameras of all rigs.
#[derive(Default)]
struct Errors {
    mm: Vec<f64>,
    degrees: Vec<f64>,
    /// Rigs that could not be calibrated.
    lost: usize,
}

pub(crate) async fn run(args: Boards, global: &Global) -> anyhow::Result<()> {
    let mut table =
        Table::new(["BOARD", "DISTANCE", "MEAN", "LARGEST", "MEAN", "LARGEST", "NOT CALIBRATED"]);
    let mut rows = Vec::new();
    for board in &args.board {
        for distance in &args.distance {
            let errors = tokio::task::block_in_place(|| measured(&args, board, *distance))?;
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
            let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
            let name = board::text(board);
            table.row([
                name.clone(),
                format!("{distance} m"),
                format!("{:.2} mm", mean(&errors.mm)),
                format!("{:.2} mm", largest(&errors.mm)),
                format!("{:.3} deg", mean(&errors.degrees)),
                format!("{:.3} deg", largest(&errors.degrees)),
                format!("{} of {}", errors.lost, args.rigs),
            ]);
            rows.push(json!({
                "board": name,
                "distance_m": distance,
                "errors_mm": errors.mm,
                "errors_deg": errors.degrees,
                "not_calibrated": errors.lost,
            }));
        }
    }
    output::print(global, &rows, || table.markdown())
}

fn measured(args: &Boards, settings: &BoardSettings, distance: f64) -> anyhow::Result<Errors> {
    let board = Board::new(settings).map_err(failure::failed)?;
    // A tenth of a millimetre.
    let (black, columns) = board.printed(10_000.0);
    let sheet = Sheet { size_m: board.size_m(), columns, black };
    let mut errors = Errors::default();
    for rig in 0..args.rigs {
        let cameras: Vec<Camera> = (0..3).map(|index| camera(rig, index, distance)).collect();
        let film = SheetFilm {
            seed: rig,
            noise: args.noise,
            blur_px: args.blur,
            ..SheetFilm::still(sheet.clone(), cameras.clone(), args.frames)
        };
        let mut recording = film_sheet(film);
        recording.cameras.iter_mut().for_each(|camera| camera.poses.clear());
        let found = board::calibrate(&recording, settings, &mut |_| {}, &CancelToken::default());
        let Some(calibration) = found.map_err(failure::failed)?.calibration else {
            errors.lost += 1;
            continue;
        };
        for (found, truth) in calibration.cameras.iter().zip(&cameras) {
            let apart = found.pose.unwrap_or(Pose::IDENTITY).inverse().after(truth.pose(0));
            let [x, y, z] = apart.translation;
            errors.mm.push(1e3 * (x * x + y * y + z * z).sqrt());
            let trace: f64 = (0..3).map(|i| apart.rotation[i][i]).sum();
            errors.degrees.push(((trace - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees());
        }
    }
    Ok(errors)
}

/// A camera of a rig, with another place and lens in each.
fn camera(rig: u64, index: u64, distance: f64) -> Camera {
    let vary = |k: u64| {
        let x = (rig * 31 + index * 7 + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (x >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let around = (120.0 * index as f64 + 60.0 * vary(1)).to_radians();
    let above = (45.0 + 30.0 * vary(2)).to_radians();
    let place = [
        distance * above.cos() * around.cos(),
        distance * above.cos() * around.sin(),
        distance * above.sin(),
    ];
    let target = [0.06 * vary(3), 0.06 * vary(4), 0.0];
    Camera {
        name: format!("cam{index}"),
        width: 848,
        height: 480,
        intrinsics: Intrinsics {
            fx: 605.0 + 10.0 * vary(5),
            fy: 605.0 + 10.0 * vary(6),
            cx: 423.5 + 10.0 * vary(7),
            cy: 239.5 + 10.0 * vary(8),
        },
        distortion: Distortion::BrownConrady([
            0.12 * vary(9),
            -0.2 * vary(10),
            0.002 * vary(11),
            0.002 * vary(12),
            0.05 * vary(13),
            0.0,
            0.0,
            0.0,
        ]),
        poses: vec![looking_at(place, target)],
        times_s: Vec::new(),
        fps: None,
    }
}

fn looking_at(place: Vector, target: Vector) -> Pose {
    let forward = unit(sub(target, place)).unwrap_or([0.0, 0.0, -1.0]);
    let right = unit([forward[1], -forward[0], 0.0]).unwrap_or([1.0, 0.0, 0.0]);
    let down = cross(forward, right);
    Pose { rotation: std::array::from_fn(|i| [right[i], down[i], forward[i]]), translation: place }
}
