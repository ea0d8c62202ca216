//! Quality of a twin: the table that an evaluation computes and a twin carries.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{FastVariant, Identifiability, PlannerQuality};

/// Errors over a span of frames, averaged over its frames. All in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// Chamfer distance in the L1 norm, from observed points to the nearest points of the surface.
    pub chamfer_l1_m: Option<f64>,
    /// Chamfer distance with Euclidean distances.
    pub chamfer_l2_m: Option<f64>,
    /// Mean Euclidean distance between ground-truth tracks and their surface points.
    pub track_m: Option<f64>,
    /// Mean absolute coordinate difference over all points (motion capture's metric).
    pub coordinate_m: Option<f64>,
    /// Root mean square difference per coordinate over the branches of a cable, filled up with
    /// zeros to the longest (DEFT's metric; motion capture of cables with branches).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub padded_rms_m: Option<f64>,
}

/// The kinds of error that a predictor may be judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// [`ErrorSummary::track_m`].
    Track,
    /// [`ErrorSummary::coordinate_m`].
    Coordinate,
    /// [`ErrorSummary::chamfer_l1_m`].
    Chamfer,
}

impl Measure {
    /// All of them; a predictor is judged by the first that its summary has.
    pub const ALL: [Self; 3] = [Self::Track, Self::Coordinate, Self::Chamfer];

    /// The error of this kind in a summary [m].
    pub fn of(self, errors: &ErrorSummary) -> Option<f64> {
        match self {
            Self::Track => errors.track_m,
            Self::Coordinate => errors.coordinate_m,
            Self::Chamfer => errors.chamfer_l1_m,
        }
    }

    /// Name in documents, for example `track`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Track => "track",
            Self::Coordinate => "coordinate",
            Self::Chamfer => "chamfer",
        }
    }

    /// The measure of a name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|measure| measure.as_str() == name)
    }
}

impl ErrorSummary {
    /// The error that a predictor is judged by: of tracks, else of coordinates, else the Chamfer
    /// distance.
    pub fn headline(&self) -> Option<(Measure, f64)> {
        Measure::ALL.into_iter().find_map(|measure| Some((measure, measure.of(self)?)))
    }
}

/// The predictor that a row of the table is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Predictor {
    /// The fitted twin, with bending.
    Bending,
    /// The axial-only fit of the same nodes.
    Axial,
    /// The mean of the predictions of the twin and its members, weighted by loss
    /// ([`Twin::fit_weights`](crate::Twin::fit_weights)).
    MeanOfFits,
    /// Nothing moves.
    StandingStill,
    /// The twin's prediction plus its error in the last training frame.
    LastResidual,
    /// Free points interpolated between clamped ones (motion capture).
    ClampInterpolation,
}

/// Errors of nodes, where those of the skin are the predictor's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NodeErrors {
    /// Over the training frames.
    pub train: ErrorSummary,
    /// Over the frames after the training split, or the held-out sequences.
    pub future: ErrorSummary,
}

/// Likeness of renderings to what cameras saw, averaged over views. The object stands over black in
/// both, and pixels that show a hand are black in both. None where it cannot be measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Likeness {
    /// Intersection over union of the silhouettes, 0..=1; pixels of hands do not count.
    pub iou: Option<f64>,
    /// Peak signal-to-noise ratio of whole images [dB].
    pub psnr_db: Option<f64>,
    /// Structural similarity of whole images, 1 for equal ones.
    pub ssim: Option<f64>,
    /// FLIP of whole images, the difference that people see when one follows the other, 0 for equal ones.
    pub flip: Option<f64>,
    /// LPIPS, 0 for equal images; in twins of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lpips: Option<f64>,
}

/// Likeness of the renderings into one camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraScore {
    /// Name of the camera.
    pub name: String,
    /// True if Gaussians or colours were made without it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held_out: bool,
    /// Over the training frames.
    pub train: Likeness,
    /// Over the frames after them.
    pub future: Likeness,
}

/// Likeness of a predictor's renderings to the recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RenderedScore {
    /// Number of the Gaussians that were drawn.
    pub gaussians: u32,
    /// Over the training frames of all cameras that were not held out.
    pub train: Likeness,
    /// Over the frames after them.
    pub future: Likeness,
    /// Likeness of each camera.
    pub cameras: Vec<CameraScore>,
    /// Per frame, over these cameras; empty if not asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub per_frame: Vec<Likeness>,
}

/// Errors of a predictor, at the twin's skin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Predictor of this row.
    pub predictor: Predictor,
    /// Over the training frames ("reconstruction").
    pub train: ErrorSummary,
    /// Over the frames after the training split, or the held-out sequences ("future").
    pub future: ErrorSummary,
    /// Per frame over all sequences' frames, NaN-free; empty if not asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub per_frame: Vec<ErrorSummary>,
    /// Errors at the nodes; `None` where these are the skin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_nodes: Option<NodeErrors>,
    /// Likeness of its renderings; none if no images are at hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rendered: Option<RenderedScore>,
}

/// The degree to which predictions are to be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Predicts the motion closely.
    Good,
    /// Predicts the motion, with an error that planning has to allow for.
    Fair,
    /// Does not predict the motion.
    Poor,
    /// No frames are left to judge it by.
    Unknown,
}

/// A twin's quality table in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Assessment {
    /// The whole in a word.
    pub level: Level,
    /// The reason, as a sentence.
    pub why: String,
    /// Advice, as a sentence.
    pub next: String,
}

impl Level {
    /// All levels, the best first.
    pub const ALL: [Self; 4] = [Self::Good, Self::Fair, Self::Poor, Self::Unknown];

    /// The word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Poor => "poor",
            Self::Unknown => "unknown",
        }
    }
}

impl fmt::Display for Assessment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Verdict: {}. {} {}", self.level.as_str(), self.why, self.next)
    }
}

/// The choice of one of several starts of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The start that was kept, from 0.
    pub start: u32,
    /// Training frames that were held back from all starts and decided; 0 if the loss over the
    /// training frames themselves did.
    pub held_back_frames: u32,
    /// Loss of each start over these frames; `None` where it diverged or found nothing.
    pub losses: Vec<Option<f64>>,
}

/// Errors of a twin in one recording of its object, beside those of others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordingScore {
    /// Name of the recording.
    pub name: String,
    /// The registration that brought the twin to this recording; none where it was not needed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registered: Option<RegistrationScore>,
    /// The twin's errors over its training frames.
    pub train: ErrorSummary,
    /// The twin's errors over its other frames.
    pub future: ErrorSummary,
}

/// Distances of a recording's first frame from the twin that was registered to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegistrationScore {
    /// Median distance of the observed points from the twin's surface [mm].
    pub median_mm: f64,
    /// 95th percentile of these distances [mm].
    pub p95_mm: f64,
    /// Share of the observed points within reach of the twin, 0..=1.
    pub explained: f64,
}

/// The distance between the predictions of several fits of one object, beside the twin's error: over
/// tracked points in the frames that the twin was not fitted to, or in its training frames if there are
/// no others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpreadScore {
    /// Number of fits: the twin and its members.
    pub fits: u32,
    /// Mean spread of the points: root mean square distance of the members' predictions from the
    /// twin's [m].
    pub mean_m: f64,
    /// The twin's mean error at these points [m].
    pub error_m: f64,
    /// Share of the points whose error is at most twice what the spread lets expect: it times
    /// [`SpreadScore::factor`].
    pub within: f64,
    /// Correlation of spread and error by rank, -1..=1; none if one of them is the same everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rank_correlation: Option<f64>,
}

impl SpreadScore {
    /// The error to expect at a point, over its spread; none if the fits agree everywhere.
    pub fn factor(&self) -> Option<f64> {
        Some(self.error_m / self.mean_m).filter(|f| f.is_finite())
    }
}

/// The quality table of a twin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// A row per predictor, the twin first.
    pub scores: Vec<Score>,
    /// The twin's errors by recording, where there are several, or the twin was registered to the
    /// only one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<RecordingScore>,
    /// Warnings for the user about the fit or the data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The choice of the start that was kept; none if there was a single one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<Choice>,
    /// The table in words; none in tables that no fit made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assessment: Option<Assessment>,
    /// The twin's fast variant with its deviation; none if that could not be measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fast: Option<FastVariant>,
    /// Figures of the twin's planner's twin; none if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planner: Option<PlannerQuality>,
    /// The spread of the predictions of several fits; none if the twin has no members.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<SpreadScore>,
    /// Report of what the recordings leave open of the twin; none in tables that no fit made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identifiability: Option<Identifiability>,
}

impl Quality {
    /// The error that the twin is judged by over frames that it was not fitted to, with its kind [m].
    pub fn headline(&self) -> Option<(Measure, f64)> {
        self.scores.first()?.future.headline().filter(|(_, error_m)| error_m.is_finite())
    }

    /// The row of a predictor.
    pub fn score(&self, predictor: Predictor) -> Option<&Score> {
        self.scores.iter().find(|s| s.predictor == predictor)
    }
}
