//! Settings of lifting a raw recording to tracked points. Every field has a default, unknown fields
//! are refused, and [`IngestSettings::validate`] reports all faults together.

mod calibration;
mod strokes;

use std::ops::Range;

use serde::{Deserialize, Serialize};

pub use self::{
    calibration::{BoardPattern, BoardSettings, CalibrationSettings, GroundSource},
    strokes::{Part, Stage, Stroke},
};

/// Settings of the ingest of a raw recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IngestSettings {
    /// Stage after which the ingest ends.
    pub until: Stage,
    /// Poses of the cameras and the ground, where the recording's own are not used.
    pub calibration: CalibrationSettings,
    /// Strokes in the images from which masks are made; with none, masks come with the recording.
    pub strokes: Vec<Stroke>,
    /// Cleaning of masks.
    pub masks: MaskSettings,
    /// Lifting of pixels to points.
    pub lift: LiftSettings,
    /// Filtering of tracks.
    pub motion: MotionSettings,
    /// Least distance between two points of the capture at the first frame [m]: where several
    /// cameras track one spot, the track that is seen longest stays.
    pub spacing_m: f64,
    /// Construction of control points.
    pub controls: ControlSettings,
    /// Completion of the surface that no camera saw.
    pub completion: CompletionSettings,
    /// Source of points inside the object.
    pub interior: Interior,
}

/// Cleaning of a camera's masks, frame by frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaskSettings {
    /// Depth nearer than this counts as not measured [m].
    pub nearest_m: f64,
    /// Depth farther than this counts as not measured [m].
    pub farthest_m: f64,
    /// Neighbouring pixels whose depths differ by more than this lie on different surfaces [m]...
    pub edge_m: f64,
    /// ...plus this many times the width of a pixel at that depth, which lets steep surfaces pass.
    pub edge_slope: f64,
    /// Pixels of the mask on the same surface that a pixel needs among the 24 around it; those with
    /// fewer are flying pixels or outliers.
    pub min_neighbours: u32,
    /// Connected parts smaller than this fraction of the largest one are dropped...
    pub min_component: f64,
    /// ...if they are farther than this from larger ones: a finger may cut a small part off [m].
    pub speck_gap_m: f64,
    /// Radius [m] within which an object's pixel needs as many neighbours of the object as of the
    /// hand, and vice versa; 0 leaves out the test.
    pub contact_m: f64,
}

/// Lifting of 2D tracks through depth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LiftSettings {
    /// Pixels to each side through which a plane is fitted.
    pub window: u32,
    /// Fewest pixels for that; with fewer the point counts as not seen.
    pub min_support: u32,
}

/// Comparing each track with its neighbours, most of which move as the object does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionSettings {
    /// Largest distance of a neighbour at the first frame [m].
    pub radius_m: f64,
    /// Largest number of neighbours, the nearest.
    pub neighbours: u32,
    /// Least number of visible neighbours; with fewer a motion is invalid, since nothing confirms
    /// it.
    pub min_neighbours: u32,
    /// Largest difference of a valid motion from frame to frame from that of its neighbours [m].
    pub tolerance_m: f64,
    /// Largest distance of a point from the position that its neighbours predict since the first
    /// frame [m]; it counts as unseen in frames in which it is farther.
    pub drift_m: f64,
}

/// Control points from the tracks on hands or grippers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControlSettings {
    /// Control points of all hands together.
    pub count: u32,
    /// Largest number of hands.
    pub max_hands: u32,
    /// Largest distance between neighbouring tracks on one hand at the first frame [m].
    pub hand_gap_m: f64,
    /// Largest gap that is filled [frames]; a hand that is hidden longer is an error.
    pub max_gap_frames: u32,
    /// A hand whose tracks stay within this distance of a rigid motion is smoothed as a rigid body
    /// [m]; one that opens or closes is not.
    pub rigid_m: f64,
}

/// Completion of what no camera saw.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompletionSettings {
    /// Use of a mesh that comes with the recording.
    pub mesh: bool,
    /// Alignment of a mesh that comes without one; if off, such a mesh is an error.
    pub align: bool,
    /// Least distance of completed points from observed ones and from each other [m].
    pub spacing_m: f64,
    /// A mesh that is farther than this from the observed surface, in the median, does not fit and
    /// is not used [m].
    pub max_error_m: f64,
    /// Largest number of points on the completed surface, and inside.
    pub max_points: u32,
}

/// Source of points inside the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interior {
    /// Taken from the mesh, or else from the space that no camera sees through, which also
    /// completes the surface.
    #[default]
    Carved,
    /// Taken from the mesh, if there is one; otherwise omitted.
    Mesh,
    /// From the mesh, or else from the convex parts of the observed surface, which is a guess.
    Convex,
    /// Omitted.
    None,
}

impl Default for IngestSettings {
    fn default() -> Self {
        Self {
            until: Stage::Points,
            calibration: CalibrationSettings::default(),
            strokes: Vec::new(),
            masks: MaskSettings::default(),
            lift: LiftSettings::default(),
            motion: MotionSettings::default(),
            spacing_m: 0.002,
            controls: ControlSettings::default(),
            completion: CompletionSettings::default(),
            interior: Interior::Carved,
        }
    }
}

impl Default for MaskSettings {
    fn default() -> Self {
        Self {
            nearest_m: 0.05,
            farthest_m: 10.0,
            edge_m: 0.01,
            edge_slope: 3.0,
            min_neighbours: 7,
            min_component: 0.02,
            speck_gap_m: 0.03,
            contact_m: 0.004,
        }
    }
}

impl Default for LiftSettings {
    fn default() -> Self {
        Self { window: 2, min_support: 6 }
    }
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            radius_m: 0.03,
            neighbours: 16,
            min_neighbours: 4,
            tolerance_m: 0.004,
            drift_m: 0.01,
        }
    }
}

impl Default for ControlSettings {
    fn default() -> Self {
        Self { count: 30, max_hands: 2, hand_gap_m: 0.05, max_gap_frames: 5, rigid_m: 0.006 }
    }
}

impl Default for CompletionSettings {
    fn default() -> Self {
        Self { mesh: true, align: true, spacing_m: 0.006, max_error_m: 0.015, max_points: 20_000 }
    }
}

impl ControlSettings {
    /// Least pixels with depth, of all cameras together, by which a hand is seen in a frame.
    pub const MIN_PIXELS: usize = 20;

    /// The first frames without a visible hand that cannot be filled, given for each frame whether
    /// it is seen: those at the start, where control points need a place, and those of a gap longer
    /// than `max_gap_frames`. `None` if there are no such frames, or no hand anywhere.
    pub fn gap(&self, seen: &[bool]) -> Option<Range<usize>> {
        let mut from = 0;
        for hidden in seen.split_inclusive(|seen| *seen) {
            let count = hidden.iter().filter(|seen| !**seen).count();
            if count > self.max_gap_frames as usize || (from == 0 && count > 0) {
                return (count < seen.len()).then_some(from..from + count);
            }
            from += hidden.len();
        }
        None
    }
}

impl IngestSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// All faults found, one sentence each.
    pub fn validate(&self) -> Result<(), Vec<String>> {
        let mut faults = Vec::new();
        let mut within = |name: &str, value: f64, low: f64, high: f64| {
            if !(value >= low && value <= high) {
                faults.push(format!("{name} is {value}: it must lie in {low}..={high}"));
            }
        };
        let m = &self.masks;
        within("masks.nearest_m", m.nearest_m, 0.0, 100.0);
        within("masks.farthest_m", m.farthest_m, 0.01, 1000.0);
        within("masks.edge_m", m.edge_m, 1e-5, 10.0);
        within("masks.edge_slope", m.edge_slope, 0.0, 100.0);
        within("masks.min_neighbours", f64::from(m.min_neighbours), 0.0, 24.0);
        within("masks.min_component", m.min_component, 0.0, 1.0);
        within("masks.speck_gap_m", m.speck_gap_m, 1e-4, 10.0);
        within("masks.contact_m", m.contact_m, 0.0, 1.0);
        within("lift.window", f64::from(self.lift.window), 1.0, 8.0);
        within("lift.min_support", f64::from(self.lift.min_support), 1.0, 289.0);
        let v = &self.motion;
        within("motion.radius_m", v.radius_m, 1e-4, 10.0);
        within("motion.neighbours", f64::from(v.neighbours), 3.0, 128.0);
        within("motion.min_neighbours", f64::from(v.min_neighbours), 3.0, 128.0);
        within("motion.tolerance_m", v.tolerance_m, 1e-5, 10.0);
        within("motion.drift_m", v.drift_m, 1e-5, 10.0);
        within("spacing_m", self.spacing_m, 0.0, 1.0);
        let c = &self.controls;
        within("controls.count", f64::from(c.count), 1.0, 10_000.0);
        within("controls.max_hands", f64::from(c.max_hands), 1.0, 8.0);
        within("controls.hand_gap_m", c.hand_gap_m, 1e-4, 10.0);
        within("controls.max_gap_frames", f64::from(c.max_gap_frames), 0.0, 1_000_000.0);
        within("controls.rigid_m", c.rigid_m, 0.0, 1.0);
        let f = &self.completion;
        within("completion.spacing_m", f.spacing_m, 1e-4, 1.0);
        within("completion.max_error_m", f.max_error_m, 1e-5, 10.0);
        within("completion.max_points", f64::from(f.max_points), 0.0, 1_000_000.0);
        if m.nearest_m >= m.farthest_m {
            faults.push("masks.nearest_m must be less than masks.farthest_m".to_owned());
        }
        if v.min_neighbours > v.neighbours {
            faults.push("motion.min_neighbours must not exceed motion.neighbours".to_owned());
        }
        let side = 2 * self.lift.window.min(8) + 1;
        if self.lift.min_support > side * side {
            faults.push(format!(
                "lift.min_support is {}: a window of {} pixels to each side has {}",
                self.lift.min_support,
                self.lift.window,
                side * side
            ));
        }
        self.calibration.add_faults(&mut faults);
        strokes::add_faults(&self.strokes, &mut faults);
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_an_empty_object_is_complete() {
        IngestSettings::default().validate().unwrap();
        let read: IngestSettings = serde_json::from_str("{}").unwrap();
        assert_eq!(read, IngestSettings::default());
        assert!(serde_json::from_str::<IngestSettings>(r#"{"spacing": 1}"#).is_err());
    }

    #[test]
    fn all_faults_are_reported_together() {
        let settings = IngestSettings {
            spacing_m: f64::NAN,
            lift: LiftSettings { window: 1, min_support: 10 },
            motion: MotionSettings { min_neighbours: 20, ..MotionSettings::default() },
            ..IngestSettings::default()
        };
        let faults = settings.validate().unwrap_err();
        assert_eq!(faults.len(), 3, "{faults:?}");
    }

    #[test]
    fn hands_are_filled_for_a_few_frames() {
        let settings = ControlSettings { max_gap_frames: 2, ..ControlSettings::default() };
        let gap = |seen: &str| settings.gap(&seen.bytes().map(|b| b == b'x').collect::<Vec<_>>());
        assert_eq!(gap("xxxx"), None);
        assert_eq!(gap("x..x..x.."), None);
        assert_eq!(gap("x..xx...x"), Some(5..8));
        assert_eq!(gap("x..xx..."), Some(5..8));
        // Control points need a place at the start.
        assert_eq!(gap(".xxx"), Some(0..1));
        // Without any hand there is nothing to fill.
        assert_eq!((gap("...."), gap("")), (None, None));
    }
}
