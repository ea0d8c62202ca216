//! Poses of cameras from a board in their images: z = 0 lies on the board, z points out of its
//! printed side, x and y run along it as a person reads it, and the origin is its middle.
//!
//! Where the board rests, all images of that time count as one view of it; cameras that see it at
//! different times are then joined by the poses that it had.

mod adjust;
mod advice;
mod cells;
mod corners;
mod decode;
mod dictionary;
mod homography;
mod join;
mod label;
mod layout;
mod pnp;
mod size;
mod spec;
mod views;

use bendtwin_capture::raw::{CalibratedCamera, Calibration, Recording, called};
use bendtwin_core::{CancelToken, Finding, settings::ingest::BoardSettings};

pub(crate) use self::views::spread;
use self::{adjust::Observation, join::Joined, views::Views};
pub use self::{
    dictionary::Dictionary,
    layout::{Board, Marker},
    spec::{FORMS, parse, text},
};
use crate::{Error, lens::Lens, place, statistics::median};

/// Fewer corners of the board than this in a camera's usual image, and its pose is shaky.
const FEW_CORNERS: usize = 8;
/// Distance between corners and where the calibration has them that a good calibration keeps [px].
const GOOD_PX: f64 = 0.6;

/// What was learnt from the board.
#[derive(Clone, Debug)]
pub struct BoardCalibration {
    /// Poses of all cameras; absent if one of them could not be placed.
    pub calibration: Option<Calibration>,
    /// What each camera saw of the board.
    pub cameras: Vec<BoardView>,
    /// Frames that were looked at.
    pub frames: usize,
    /// Faults of the board or of its images; an error if there is no calibration.
    pub findings: Vec<Finding>,
}

/// What a camera saw of the board.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardView {
    /// The camera's name.
    pub name: String,
    /// Frames in which it saw the board.
    pub frames: usize,
    /// Median number of corners in these.
    pub corners: usize,
    /// Root mean square distance of corners from where the calibration has them [px].
    pub reprojection_px: Option<f64>,
}

/// Calibrates the cameras of a recording by a board. Progress is a share, 0..=1.
///
/// # Errors
/// If the board is impossible, a frame cannot be read for a reason other than damage, or on
/// cancellation. A board that is not seen is a finding.
pub fn calibrate(
    recording: &Recording,
    settings: &BoardSettings,
    observer: &mut dyn FnMut(f64),
    cancel: &CancelToken,
) -> Result<BoardCalibration, Error> {
    let board = Board::new(settings)?;
    let views = Views::look(recording, &board, &mut |share| observer(0.9 * share), cancel)?;
    let mut result = BoardCalibration {
        calibration: None,
        cameras: described(recording, &views),
        frames: views.frames.len(),
        findings: Vec::new(),
    };
    let unseen: Vec<usize> =
        (0..recording.cameras.len()).filter(|camera| views.count(*camera) == 0).collect();
    if !unseen.is_empty() {
        let finding = advice::not_seen(recording, &board, &views, &unseen, cancel)?;
        result.findings.push(finding);
        return Ok(result);
    }
    let lenses: Vec<Lens> = recording.cameras.iter().map(Lens::of).collect();
    let joined = match join::join(&board, &lenses, &views) {
        Ok(joined) => joined,
        Err(apart) => {
            result.findings.push(advice::apart(recording, &apart));
            return Ok(result);
        }
    };
    for (view, px) in result.cameras.iter_mut().zip(&joined.reprojection_px) {
        view.reprojection_px = Some(*px);
    }
    let cameras = recording.cameras.iter().zip(&joined.poses.cameras).zip(&joined.reprojection_px);
    let cameras = cameras.map(|((camera, motion), px)| CalibratedCamera {
        name: camera.name.clone(),
        size: [camera.width, camera.height],
        intrinsics: Some(camera.intrinsics),
        distortion: Some(camera.distortion),
        pose: Some(place::pose(&motion.inverse())),
        reprojection_px: Some(*px),
    });
    let ground = bendtwin_core::Environment::Z_UP.ground;
    let calibration =
        Calibration { cameras: cameras.collect(), ground, source: "board".to_owned() };
    judge(recording, &board, &joined, &mut result);
    result.findings.extend(size::check(recording, &board, &joined, cancel)?);
    result.findings.extend(tilt(recording, &calibration, cancel)?);
    result.calibration = Some(calibration);
    observer(1.0);
    Ok(result)
}

fn described(recording: &Recording, views: &Views) -> Vec<BoardView> {
    let view = |(index, camera): (usize, &bendtwin_capture::raw::Camera)| {
        let counts = views.sightings.iter().map(|row| row[index].seen.len()).filter(|n| *n > 0);
        BoardView {
            name: camera.name.clone(),
            frames: views.count(index),
            corners: median(counts.map(|n| n as f64)).unwrap_or_default() as usize,
            reprojection_px: None,
        }
    };
    recording.cameras.iter().enumerate().map(view).collect()
}

fn judge(recording: &Recording, board: &Board, joined: &Joined, result: &mut BoardCalibration) {
    let few = FEW_CORNERS.max(board.corners.len() / 8);
    let views = &result.cameras;
    let shaky: Vec<usize> = (0..views.len()).filter(|c| views[*c].corners < few).collect();
    let mut findings = Vec::new();
    if !shaky.is_empty() {
        let seen = shaky.iter().map(|c| {
            format!("{} {} of {}", named(recording, *c), views[*c].corners, board.corners.len())
        });
        let message = format!(
            "few corners of the board are seen: {}: move the board nearer or turn it towards these cameras \
             ({GUIDE})",
            seen.collect::<Vec<_>>().join(", ")
        );
        let finding =
            Finding::from_sentence(bendtwin_core::Severity::Warning, "BOARD_FEW_CORNERS", message);
        findings.push(finding.cameras(shaky));
    }
    let bent: Vec<usize> = (0..views.len())
        .filter(|c| views[*c].reprojection_px.is_some_and(|px| px > GOOD_PX))
        .collect();
    if !bent.is_empty() {
        let seen = bent.iter().map(|c| {
            format!(
                "{} by {:.1} px",
                named(recording, *c),
                views[*c].reprojection_px.unwrap_or_default()
            )
        });
        let message = format!(
            "corners of the board are not where its pose has them (limit {GOOD_PX} px), {}: check that the board is \
             flat, and give the lens and the intrinsics of this resolution ({GUIDE})",
            seen.collect::<Vec<_>>().join(", ")
        );
        let finding =
            Finding::from_sentence(bendtwin_core::Severity::Warning, "BOARD_MISFIT", message);
        findings.push(finding.cameras(bent));
    }
    if !joined.rests {
        let message = format!(
            "the board never rests while all cameras see it, so that poses are only as exact as the cameras are \
             simultaneous: lay it down for a second where all cameras see it ({GUIDE})"
        );
        let finding =
            Finding::from_sentence(bendtwin_core::Severity::Warning, "BOARD_MOVES", message);
        findings.push(finding.frames(joined.frames.first().copied()));
    }
    result.findings.extend(findings);
}

/// A board that does not lie as the largest plane does: up would not be up.
fn tilt(
    recording: &Recording,
    calibration: &Calibration,
    cancel: &CancelToken,
) -> Result<Option<Finding>, Error> {
    const MOST_DEGREES: f64 = 5.0;
    let mut calibrated = recording.clone();
    calibration.apply(&mut calibrated)?;
    let Some(ground) = crate::ground::detect(&calibrated, cancel)? else { return Ok(None) };
    let degrees = f64::from(ground.normal[2]).clamp(-1.0, 1.0).acos().to_degrees();
    if degrees < MOST_DEGREES || ground.share < crate::ground::LARGE_SHARE {
        return Ok(None);
    }
    let message = format!(
        "the board leans by {degrees:.0} degrees against the largest plane that the cameras see, and up is taken from the \
         board: lay it flat on the table, or take the ground from depth (`--ground detected`; {GUIDE})"
    );
    let finding = Finding::from_sentence(bendtwin_core::Severity::Warning, "BOARD_TILTED", message);
    Ok(Some(finding.number("angle_deg", degrees)))
}

/// Section of the guide about calibration.
const GUIDE: &str = "docs/use/cameras.md#calibration";

/// `camera 2 (front)`, or `camera 2` if its name is its number.
fn named(recording: &Recording, index: usize) -> String {
    called(index, recording.cameras.get(index).map_or("", |camera| &camera.name))
}

#[cfg(test)]
mod tests;
