//! Settings of the calibration: poses of the cameras and the ground, where the recording's own are
//! missing or not trusted.

use serde::{Deserialize, Serialize};

/// Poses of the cameras, and the ground.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CalibrationSettings {
    /// Board that all cameras see in the recording: their poses are measured with it, and z = 0 lies
    /// on it. Absent: the recording's own poses.
    pub board: Option<BoardSettings>,
    /// Moves the camera that contradicts the others by the correction that the report states
    /// (`CAMERA_OFF`).
    pub correct: bool,
    /// Origin of the ground.
    pub ground: GroundSource,
}

/// Origin of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroundSource {
    /// The recording states it.
    #[default]
    Recorded,
    /// The largest plane outside the masks in the depth of all cameras, which becomes z = 0.
    Detected,
}

/// A flat board for calibrating, printed to size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoardSettings {
    /// Kind of the board.
    pub pattern: BoardPattern,
    /// Squares in a row of a ChArUco board, or tags in a row of a grid.
    pub columns: u32,
    /// Rows of squares or tags.
    pub rows: u32,
    /// Side of a square of a ChArUco board, or distance between the centres of neighbouring tags of
    /// a grid [m].
    pub square_m: f64,
    /// Side of a marker or tag [m].
    pub marker_m: f64,
    /// Dictionary of the markers, as OpenCV names it: `DICT_5X5_100`, for example.
    pub dictionary: String,
    /// Layout of ChArUco boards as OpenCV drew them before version 4.6.
    #[serde(default)]
    pub legacy: bool,
}

/// Kind of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoardPattern {
    /// A chessboard with markers in its white squares.
    Charuco,
    /// A grid of AprilTags, as Kalibr draws it.
    AprilGrid,
}

impl CalibrationSettings {
    /// Adds what is impossible.
    pub(super) fn add_faults(&self, faults: &mut Vec<String>) {
        let Some(board) = &self.board else { return };
        let mut fault = |fault: String| faults.push(format!("calibration.board.{fault}"));
        for (name, value) in [("columns", board.columns), ("rows", board.rows)] {
            if !(2..=100).contains(&value) {
                fault(format!("{name} is {value}: it must lie in 2..=100"));
            }
        }
        for (name, value) in [("square_m", board.square_m), ("marker_m", board.marker_m)] {
            if !(1e-4..=10.0).contains(&value) {
                fault(format!("{name} is {value}: it must lie in 0.0001..=10 metres"));
            }
        }
        if board.marker_m >= board.square_m {
            fault(format!(
                "marker_m is {}: it must be less than square_m, {}",
                board.marker_m, board.square_m
            ));
        }
        if board.dictionary.is_empty() || board.dictionary.len() > 64 {
            fault("dictionary must name a dictionary, such as DICT_5X5_100".to_owned());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_boards_are_refused() {
        let board = BoardSettings {
            pattern: BoardPattern::Charuco,
            columns: 7,
            rows: 5,
            square_m: 0.03,
            marker_m: 0.022,
            dictionary: "DICT_5X5_100".to_owned(),
            legacy: false,
        };
        let faults = |board: &BoardSettings| {
            let mut faults = Vec::new();
            let settings = CalibrationSettings {
                board: Some(board.clone()),
                ..CalibrationSettings::default()
            };
            settings.add_faults(&mut faults);
            faults
        };
        assert!(faults(&board).is_empty());
        let millimetres = BoardSettings { square_m: 30.0, marker_m: 22.0, ..board.clone() };
        assert_eq!(faults(&millimetres).len(), 2);
        assert_eq!(faults(&BoardSettings { marker_m: 0.03, rows: 1, ..board }).len(), 2);
    }
}
