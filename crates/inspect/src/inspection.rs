//! The result of an inspection: measurements and findings.

use bendtwin_capture::{
    Sources,
    raw::{Calibration, Camera, Pose, Recording},
};
use bendtwin_core::Point;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{Code, Finding, Verdict, alike, consequences, finding, picture_inputs::PictureInputs};

/// The kind of capture that was inspected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Images of cameras, not lifted yet.
    Recording,
    /// Points that were lifted elsewhere.
    Observed,
}

/// Everything that was measured and found. Lists over frames have one entry per frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Inspection {
    /// A person's name for the recording.
    pub name: String,
    /// The kind of capture that was inspected.
    pub kind: Kind,
    /// Frames per second, as declared; absent if it is no finite number.
    pub fps: Option<f64>,
    /// Number of frames T.
    pub frame_count: usize,
    /// Frames `0..train_frame_count` are for fitting.
    pub train_frame_count: usize,
    /// The judgement of all findings together.
    pub verdict: Verdict,
    /// Findings, the worst first, and in the order of repair.
    pub findings: Vec<Finding>,
    /// What was taken as what, and what was left out.
    #[serde(default)]
    pub sources: Sources,
    /// The calibration in use as its document (docs/formats/capture.md, section 14), if it is not the
    /// recording's own.
    #[serde(default)]
    pub calibration: Option<Value>,
    /// A ground that depth shows, where the recording states none or another one.
    #[serde(default)]
    pub ground_detected: Option<DetectedGround>,
    /// The scene as a whole.
    pub scene: Scene,
    /// The cameras of a recording.
    pub cameras: Vec<CameraReport>,
    /// Pairs of cameras that saw something in common.
    pub pairs: Vec<PairReport>,
    /// The points of an observed capture.
    pub observed: Option<ObservedReport>,
    /// Corrections of cameras that are off; not part of the document.
    #[serde(skip)]
    pub(crate) corrections: Vec<(usize, Pose)>,
    /// Material for pictures; not part of the document.
    #[serde(skip)]
    pub(crate) picture_inputs: PictureInputs,
}

/// A plane that the cameras see, and that things may lie on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DetectedGround {
    /// Unit normal, towards the cameras.
    pub normal: Point,
    /// Distance from the origin along the normal [m].
    pub offset_m: f32,
    /// Share of what is seen outside the masks that lies on it, 0..=1.
    pub share: f64,
}

/// Size, height, motion and contact; absent where they could not be measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Largest extent of the object across a view [m].
    pub object_size_m: Option<f64>,
    /// Largest extent of the hand or gripper across a view [m].
    pub manipulator_size_m: Option<f64>,
    /// Height of the object's lowest points over the ground, at its lowest [m].
    pub lowest_m: Option<f64>,
    /// Largest distance of the object's middle from its start [m].
    pub travel_m: Option<f64>,
    /// Largest distance of the hand's or gripper's middle from its start [m].
    pub manipulator_travel_m: Option<f64>,
    /// Fastest motion of the object's middle [m/s].
    pub fastest_m_s: Option<f64>,
    /// Smallest distance between hand and object in each frame [m]; null where one was not seen.
    pub gap_m: Vec<Option<f64>>,
}

/// Report of a camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraReport {
    /// A person's name for it.
    pub name: String,
    /// Columns of its images.
    pub width: usize,
    /// Rows of its images.
    pub height: usize,
    /// Frames without colour or without depth.
    pub missing_frames: Vec<usize>,
    /// Frames with the same content as the one before, while something should have moved.
    pub repeated_frames: Vec<usize>,
    /// Frames that came late by their times.
    pub late_frames: Vec<usize>,
    /// Files that could not be decoded.
    pub damaged_files: usize,
    /// Frames whose object mask is empty or absent although there is a colour image.
    pub empty_masks: Vec<usize>,
    /// Frames in which the area of the object's mask jumps.
    pub mask_jumps: Vec<usize>,
    /// Pixels of the object's mask; null where there is no mask.
    pub object_px: Vec<Option<usize>>,
    /// Pixels of the hand's mask; null where there is no mask.
    pub manipulator_px: Vec<Option<usize>>,
    /// Share of the object's pixels that have depth, 0..=1; null where there is no object.
    pub coverage: Vec<Option<f64>>,
    /// Median of the coverage.
    pub median_coverage: Option<f64>,
    /// Skew by motion [ms]: positive if this camera shows things later than the median of the
    /// cameras.
    pub skew_ms: Option<f64>,
    /// Skew by the frames' times [ms].
    pub skew_by_times_ms: Option<f64>,
    /// Growth of the skew from the first half to the second [ms].
    pub drift_ms: Option<f64>,
    /// 2D tracks of the camera.
    pub tracks: Option<TrackReport>,
    /// Agreement with the other cameras.
    pub agreement: Option<Agreement>,
}

impl CameraReport {
    /// The report of a camera whose frames were not looked at.
    pub(crate) fn of(camera: &Camera) -> Self {
        let Camera { name, width, height, .. } = camera;
        Self { name: name.clone(), width: *width, height: *height, ..Self::default() }
    }
}

/// 2D tracks of one camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackReport {
    /// Number of tracks N.
    pub count: usize,
    /// Tracks that the tracker saw.
    pub visible: Vec<usize>,
    /// Tracks that could be lifted: visible, on a mask, with depth.
    pub liftable: Vec<usize>,
    /// Share of visible tracks that lie on a mask, 0..=1.
    pub inside: Option<f64>,
}

/// Agreement of a camera with the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// Median distance along the view between its surface and the others' [mm].
    pub disagreement_mm: Option<f64>,
    /// Disagreement among the others, without this camera [mm].
    pub others_mm: Option<f64>,
    /// The rotation that would fit it to the others [degrees]; absent if nothing would be gained.
    pub correction_deg: Option<f64>,
    /// Distance by which that correction would move what it sees of the object [mm].
    pub correction_mm: Option<f64>,
}

/// Two cameras that saw something in common.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairReport {
    /// The first camera.
    pub a: usize,
    /// The second camera.
    pub b: usize,
    /// Surfels that face both cameras and were measured by both.
    pub compared: usize,
    /// Median distance between the two surfaces along the view [mm].
    pub disagreement_mm: Option<f64>,
    /// Median signed distance [mm]: positive if the second camera measures less depth than the
    /// first predicts.
    pub offset_mm: Option<f64>,
    /// Share of one camera's points that contradict the other's masks or depth, 0..=1.
    pub conflict: f64,
    /// Misfit: degree to which they contradict each other in all, 0..=1.
    pub misfit: Option<f64>,
    /// Skew by motion [ms]: positive if the first shows things later than the second.
    pub skew_ms: Option<f64>,
}

/// The points of an observed capture, first sequence.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObservedReport {
    /// Number of tracked points P.
    pub point_count: usize,
    /// Number of control points C.
    pub control_count: usize,
    /// Points that are visible.
    pub visible: Vec<usize>,
    /// Points whose motion since the frame before is trusted.
    pub motion_valid: Vec<usize>,
    /// Points of the completed surface.
    pub completed_count: usize,
    /// Points inside.
    pub interior_count: usize,
    /// Lower corner of the box around the points at the start [m].
    pub low: Option<Point>,
    /// Upper corner.
    pub high: Option<Point>,
}

impl Inspection {
    /// The inspection of a capture that was not read: nothing is known, and nothing found yet.
    pub fn unread(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind: Kind::Observed,
            fps: None,
            frame_count: 0,
            train_frame_count: 0,
            verdict: Verdict::Good,
            findings: Vec::new(),
            sources: Sources::default(),
            calibration: None,
            ground_detected: None,
            scene: Scene::default(),
            cameras: Vec::new(),
            pairs: Vec::new(),
            observed: None,
            corrections: Vec::new(),
            picture_inputs: PictureInputs::default(),
        }
    }

    /// Adds findings that are not known yet, leaves out those that merely follow from others, joins
    /// those that say the same of several cameras, gives each the advice of its code, sorts them and
    /// judges again.
    pub fn add(&mut self, findings: impl IntoIterator<Item = Finding>) {
        for finding in findings {
            let known = |f: &Finding| f.code == finding.code && f.message == finding.message;
            if !self.findings.iter().any(known) {
                self.findings.push(finding);
            }
        }
        consequences::leave_out(&mut self.findings);
        let names: Vec<String> = self.cameras.iter().map(|camera| camera.name.clone()).collect();
        alike::join(&mut self.findings, &names);
        self.settle();
    }

    /// Adds findings about another recording: nothing here follows from them, nor they from anything
    /// here.
    pub(crate) fn add_unrelated(&mut self, findings: impl IntoIterator<Item = Finding>) {
        self.findings.extend(findings);
        self.settle();
    }

    fn settle(&mut self) {
        finding::advise(&mut self.findings);
        finding::sort(&mut self.findings);
        self.verdict = Verdict::of(&self.findings);
    }

    /// The calibration in which every camera that is off ([`Code::CameraOff`]) stands where it agrees
    /// with the others; `None` if no camera is off, or only so far that no motion was found.
    pub fn correction(&self, recording: &Recording) -> Option<Calibration> {
        let is_off = |camera: &usize| {
            let named =
                |f: &Finding| f.code == Code::CameraOff.name() && f.cameras.contains(camera);
            self.findings.iter().any(named)
        };
        let mut calibration = Calibration::of(recording, "correction");
        let mut corrected = false;
        for (camera, motion) in self.corrections.iter().filter(|(camera, _)| is_off(camera)) {
            let Some(pose) = calibration.cameras.get_mut(*camera).and_then(|c| c.pose.as_mut())
            else {
                continue;
            };
            *pose = motion.after(pose);
            corrected = true;
        }
        corrected.then_some(calibration)
    }

    /// The finding to deal with first, if anything has to be done.
    pub fn first_step(&self) -> Option<&Finding> {
        self.findings.first().filter(|f| f.severity != bendtwin_core::Severity::Info)
    }

    /// True if a code was found.
    pub fn has(&self, code: &str) -> bool {
        self.findings.iter().any(|f| f.code == code)
    }

    /// The findings as a check of the capture gives them.
    pub fn check_report(&self) -> bendtwin_capture::CheckReport {
        bendtwin_capture::CheckReport {
            findings: self.findings.clone(),
            sources: self.sources.clone(),
        }
    }
}
