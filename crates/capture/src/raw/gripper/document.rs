//! Content of `grippers.json`.

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub(super) format: String,
    pub(super) version: u32,
    pub(super) grippers: Vec<Entry>,
}

/// A gripper.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Entry {
    #[serde(default)]
    pub(super) name: String,
    pub(super) poses: Poses,
    pub(super) widths: Option<Widths>,
    /// Pose in the cameras' world of what the poses refer to.
    pub(super) base: Option<Numbers>,
    #[serde(default)]
    pub(super) axes: Axes,
    #[serde(default)]
    pub(super) pad: PadEntry,
}

impl Entry {
    /// What it is read from beside numbers, and whether its opening is known.
    pub(super) fn in_words(&self) -> String {
        let short = |text: &str| text.chars().take(80).collect::<String>();
        let of_table = |t: &Table| format!("`{}` of `{}`", short(&t.column), short(&t.file));
        let poses = match &self.poses {
            Poses::Numbers(_) => String::new(),
            Poses::Frame(source) => format!("frame `{}`", short(&source.frame)),
            Poses::LeRobot(pose) => of_table(&pose.lerobot),
        };
        let widths = match &self.widths {
            None => "without its opening".to_owned(),
            Some(Widths::Numbers(_)) => String::new(),
            Some(Widths::Joints(source)) => format!("joints {}", short(&source.joints.join(", "))),
            Some(Widths::LeRobot(width)) => format!("opening {}", of_table(&width.lerobot)),
        };
        [poses, widths].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ")
    }
}

/// Numbers in a file, or in the document itself.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum Numbers {
    File(String),
    Rows(Vec<Vec<Option<f64>>>),
    Row(Vec<Option<f64>>),
}

/// Where poses are.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "`poses` are a file, rows of numbers, {\"frame\": NAME} or {\"lerobot\": {...}, \"rotation\": ...} \
                 (docs/formats/capture.md, section 15)"
)]
pub(super) enum Poses {
    Numbers(Numbers),
    Frame(FrameSource),
    LeRobot(PoseElements),
}

/// A coordinate frame of the recording's transforms.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameSource {
    pub(super) frame: String,
}

/// Elements of a dataset that are a pose.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseElements {
    pub(super) lerobot: Table,
    pub(super) rotation: Rotation,
}

/// Where distances between the fingers are; those computed are `offset_m + scale * sum`.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "`widths` are a file, numbers, {\"joints\": [NAME, ...]} or {\"lerobot\": {...}}, the latter two with `scale` \
                 and `offset_m` (docs/formats/capture.md, section 15)"
)]
pub(super) enum Widths {
    Numbers(Numbers),
    Joints(JointSource),
    LeRobot(WidthElements),
}

/// Joints whose positions add up.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointSource {
    pub(super) joints: Vec<String>,
    /// Topic of them, needed if several have joints of these names.
    pub(super) topic: Option<String>,
    #[serde(default = "one")]
    pub(super) scale: f64,
    #[serde(default)]
    pub(super) offset_m: f64,
}

/// Elements of a dataset that add up.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WidthElements {
    pub(super) lerobot: Table,
    #[serde(default = "one")]
    pub(super) scale: f64,
    #[serde(default)]
    pub(super) offset_m: f64,
}

/// Elements of a column of a LeRobot dataset.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Table {
    /// A Parquet file.
    pub(super) file: String,
    /// Not needed if the file has one episode.
    pub(super) episode: Option<i64>,
    #[serde(default = "state")]
    pub(super) column: String,
    /// Their numbers in each row, from 0.
    pub(super) elements: Vec<usize>,
    /// Time of the recording's first frame after that of the episode [s].
    #[serde(default)]
    pub(super) start_s: f64,
}

/// How a row gives a rotation, after x, y, z.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Rotation {
    /// Quaternion x, y, z, w.
    QuaternionXyzw,
    /// Quaternion w, x, y, z.
    QuaternionWxyz,
    /// Axis times angle [rad].
    #[serde(rename = "rotation_vector")]
    Vector,
    /// Roll, pitch and yaw about the fixed axes x, y and z [rad].
    RollPitchYaw,
}

fn one() -> f64 {
    1.0
}

fn state() -> String {
    "observation.state".to_owned()
}

/// Axes of the recorded poses: which of them is which.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Axes {
    pub(super) approach: String,
    pub(super) opening: String,
}

impl Default for Axes {
    fn default() -> Self {
        Self { approach: "+z".to_owned(), opening: "+y".to_owned() }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct PadEntry {
    pub(super) length_m: f64,
    pub(super) breadth_m: f64,
}

impl Default for PadEntry {
    fn default() -> Self {
        Self { length_m: 0.02, breadth_m: 0.02 }
    }
}
