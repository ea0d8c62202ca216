//! RollOutRequest and RollOutResponse as JSON: the same fields, shapes and units.

use bendtwin_proto::v1::{
    self, ControlTrajectories, Cost, Fidelity, GripperPoses, InitialState, Interpolation, Returns,
    RollOutRequest, RollOutResponse, Tensor, cost, initial_state, returns,
    roll_out_request::Actions, tensor::Dtype,
};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::{
    app::{Error, Result},
    http::tensors::{JsonTensor, TensorFormat},
};

/// B instances of one twin, F frames each.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RollOutDocument {
    /// Either this or `poses`.
    trajectories: Option<Trajectories>,
    poses: Option<Poses>,
    /// Default: the twin's rest shape, not moving.
    initial: Option<Initial>,
    /// Horizon; 0 means that of the dense actions.
    #[serde(default)]
    frames: u32,
    #[serde(default)]
    costs: Vec<CostDocument>,
    returns: Option<ReturnsDocument>,
    #[serde(default)]
    fidelity: FidelityWord,
}

/// How finely the twin is followed: as fitted, or by its fast variant.
#[derive(Clone, Copy, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
enum FidelityWord {
    #[default]
    Exact,
    Fast,
}

/// Positions of every control point.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct Trajectories {
    /// [B, K, C, 3], metres.
    positions: JsonTensor,
    #[serde(default)]
    interpolation: InterpolationWord,
}

/// Poses of rigid grippers that carry control points.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct Poses {
    /// [B, K, G, 7]: x, y, z in metres, quaternion x, y, z, w.
    poses: JsonTensor,
    /// [C]: the gripper of each control point; default 0 for all.
    gripper_of_control: Option<JsonTensor>,
    #[serde(default)]
    interpolation: InterpolationWord,
}

#[derive(Clone, Copy, Default, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
enum InterpolationWord {
    #[default]
    Linear,
    Cubic,
}

impl InterpolationWord {
    fn code(self) -> i32 {
        match self {
            Self::Linear => Interpolation::Linear.into(),
            Self::Cubic => Interpolation::Cubic.into(),
        }
    }
}

/// Where instances start.
#[derive(Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Initial {
    /// The rest shape: `{"rest": {}}`.
    Rest {},
    /// Where the twin is after following the capture's controls up to a frame.
    CaptureFrame {
        /// `captures/{uuid}`; default: the twin's own.
        #[serde(default)]
        capture: String,
        #[serde(default)]
        sequence: u32,
        frame: u32,
    },
    /// A state: `{"given": {"positions": ...}}`.
    Given(Box<GivenDocument>),
}

/// Positions, and velocities and twists unless they are zero.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct GivenDocument {
    /// [N, 3] or [B, N, 3], metres.
    positions: JsonTensor,
    /// Likewise, m/s.
    velocities: Option<JsonTensor>,
    /// Of rods, [rods] or [B, rods], rad.
    twists: Option<JsonTensor>,
}

/// A weighted term of the cost; exactly one of target_cloud, keypoints, smoothness.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct CostDocument {
    #[serde(default)]
    name: String,
    weight: f64,
    #[serde(default)]
    when: WhenWord,
    target_cloud: Option<TargetCloud>,
    keypoints: Option<Keypoints>,
    smoothness: Option<Smoothness>,
}

#[derive(Clone, Copy, Default, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
enum WhenWord {
    #[default]
    LastFrame,
    EveryFrame,
}

/// Mean squared distance of the points to the nearest surface node.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct TargetCloud {
    /// [M, 3], metres.
    points: JsonTensor,
}

/// Mean distance between nodes and their targets.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct Keypoints {
    /// [M]
    nodes: JsonTensor,
    /// [M, 3], metres.
    targets: JsonTensor,
    #[serde(default)]
    squared: bool,
}

/// Mean squared second difference of node positions.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct Smoothness {}

/// What to return beside the costs.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ReturnsDocument {
    /// Record the positions of every k-th frame; 0 records none.
    #[serde(default)]
    every_frames: u32,
    /// Nodes to record; default all.
    nodes: Option<JsonTensor>,
    #[serde(default)]
    encoding: EncodingWord,
    /// Only the best k instances by cost; 0 means all.
    #[serde(default)]
    best: u32,
    #[serde(default)]
    final_state: bool,
    #[serde(default)]
    diagnostics: bool,
    #[serde(default)]
    control_gradients: bool,
}

#[derive(Clone, Copy, Default, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
enum EncodingWord {
    #[default]
    Float32,
    Int16,
}

impl RollOutDocument {
    /// The message; its twin is left to the caller.
    pub(super) fn read(self) -> Result<RollOutRequest> {
        let actions = match (self.trajectories, self.poses) {
            (Some(t), None) => Actions::Trajectories(ControlTrajectories {
                positions: Some(t.positions.read("trajectories.positions", Dtype::Float32)?),
                interpolation: t.interpolation.code(),
            }),
            (None, Some(p)) => Actions::Poses(GripperPoses {
                poses: Some(p.poses.read("poses.poses", Dtype::Float32)?),
                gripper_of_control: indices(p.gripper_of_control, "poses.gripper_of_control")?,
                interpolation: p.interpolation.code(),
            }),
            _ => return Err(Error::invalid("body", "needs either trajectories or poses")),
        };
        Ok(RollOutRequest {
            twin: String::new(),
            actions: Some(actions),
            initial: self.initial.map(Initial::read).transpose()?,
            frames: self.frames,
            costs: self.costs.into_iter().map(CostDocument::read).collect::<Result<_>>()?,
            returns: self.returns.map(ReturnsDocument::read).transpose()?,
            fidelity: match self.fidelity {
                FidelityWord::Exact => Fidelity::Exact.into(),
                FidelityWord::Fast => Fidelity::Fast.into(),
            },
        })
    }
}

impl Initial {
    fn read(self) -> Result<InitialState> {
        let state = match self {
            Self::Rest {} => initial_state::State::Rest(initial_state::Rest {}),
            Self::CaptureFrame { capture, sequence, frame } => {
                let state = initial_state::CaptureFrame { capture, sequence, frame };
                initial_state::State::CaptureFrame(state)
            }
            Self::Given(given) => {
                let GivenDocument { positions, velocities, twists } = *given;
                let floats = |t: JsonTensor, name| t.read(name, Dtype::Float32);
                initial_state::State::Given(initial_state::GivenState {
                    positions: Some(floats(positions, "initial.given.positions")?),
                    velocities: velocities
                        .map(|v| floats(v, "initial.given.velocities"))
                        .transpose()?,
                    twists: twists.map(|t| floats(t, "initial.given.twists")).transpose()?,
                })
            }
        };
        Ok(InitialState { state: Some(state) })
    }
}

impl CostDocument {
    fn read(self) -> Result<Cost> {
        let kind = match (self.target_cloud, self.keypoints, self.smoothness) {
            (Some(c), None, None) => cost::Kind::TargetCloud(cost::TargetCloud {
                points: Some(c.points.read("costs.target_cloud.points", Dtype::Float32)?),
            }),
            (None, Some(k), None) => cost::Kind::Keypoints(cost::Keypoints {
                nodes: indices(Some(k.nodes), "costs.keypoints.nodes")?,
                targets: Some(k.targets.read("costs.keypoints.targets", Dtype::Float32)?),
                squared: k.squared,
            }),
            (None, None, Some(_)) => cost::Kind::Smoothness(cost::Smoothness {}),
            _ => {
                let fault = "needs exactly one of target_cloud, keypoints, smoothness";
                return Err(Error::invalid("costs", fault));
            }
        };
        let when = match self.when {
            WhenWord::LastFrame => cost::When::LastFrame,
            WhenWord::EveryFrame => cost::When::EveryFrame,
        };
        Ok(Cost { name: self.name, weight: Some(self.weight), when: when.into(), kind: Some(kind) })
    }
}

impl ReturnsDocument {
    fn read(self) -> Result<Returns> {
        let encoding = match self.encoding {
            EncodingWord::Float32 => returns::Encoding::Float32,
            EncodingWord::Int16 => returns::Encoding::Int16,
        };
        Ok(Returns {
            every_frames: self.every_frames,
            nodes: indices(self.nodes, "returns.nodes")?,
            encoding: encoding.into(),
            best: self.best,
            final_state: self.final_state,
            diagnostics: self.diagnostics,
            control_gradients: self.control_gradients,
        })
    }
}

fn indices(tensor: Option<JsonTensor>, name: &'static str) -> Result<Option<Tensor>> {
    tensor.map(|t| t.read(name, Dtype::Uint32)).transpose()
}

/// What came of a rollout.
#[derive(Serialize, ToSchema)]
pub(super) struct RollOutResult {
    /// [B], weighted sums; null where an instance diverged.
    costs: Option<JsonTensor>,
    cost_names: Vec<String>,
    /// [B, terms], weighted.
    cost_terms: Option<JsonTensor>,
    /// [R]: the instances that the following fields are of.
    instances: Option<JsonTensor>,
    /// [T']: recorded frames, 1-based.
    frames: Option<JsonTensor>,
    /// [R, T', K, 3], metres.
    positions: Option<JsonTensor>,
    /// [R, N, 3], metres.
    final_positions: Option<JsonTensor>,
    /// [R, N, 3], metres per second.
    final_velocities: Option<JsonTensor>,
    /// [R, rods], radians; absent if the twin has no rods.
    final_twists: Option<JsonTensor>,
    /// [R, F + 1, C, 3]
    control_gradients: Option<JsonTensor>,
    diagnostics: Vec<Diagnostics>,
    diverged: Vec<Divergence>,
    /// Seconds that the request waited.
    queue_s: f64,
    /// Seconds that it was computed.
    compute_s: f64,
    /// `workers/{uuid}`
    worker: String,
    /// What answered.
    fidelity: FidelityWord,
    /// Substeps per frame that were simulated.
    substeps: u32,
    /// With FAST: how far the variant strays; null otherwise.
    deviation: Option<Deviation>,
}

/// Between the fast variant and the exact twin when both follow the twin's own capture.
#[derive(Serialize, ToSchema)]
struct Deviation {
    /// Between a node here and there, over nodes and frames, metres.
    mean_m: f64,
    max_m: f64,
    /// To compare with: of the exact twin's nodes from where they started, metres.
    mean_travel_m: f64,
    /// Frames of each recording, at most.
    frames: u32,
}

/// Of one instance, over the whole rollout.
#[derive(Serialize, ToSchema)]
struct Diagnostics {
    max_strain: f32,
    max_speed_m_s: f32,
    /// Joules per unit mass scale.
    kinetic_energy: f32,
    elastic_energy: f32,
    ground_contacts: u32,
}

/// Where an instance left what is physical.
#[derive(Serialize, ToSchema)]
struct Divergence {
    instance: u32,
    /// 1-based.
    frame: u32,
    node: u32,
}

impl RollOutResult {
    pub(super) fn new(response: &RollOutResponse, format: TensorFormat) -> Self {
        let tensor = |t: &Option<v1::Tensor>| {
            t.as_ref().filter(|t| !t.is_absent()).map(|t| JsonTensor::write(t, format))
        };
        let timing = response.timing.unwrap_or_default();
        Self {
            costs: tensor(&response.costs),
            cost_names: response.cost_names.clone(),
            cost_terms: tensor(&response.cost_terms),
            instances: tensor(&response.instances),
            frames: tensor(&response.frames),
            positions: tensor(&response.positions),
            final_positions: tensor(&response.final_positions),
            final_velocities: tensor(&response.final_velocities),
            final_twists: tensor(&response.final_twists),
            control_gradients: tensor(&response.control_gradients),
            diagnostics: response
                .diagnostics
                .iter()
                .map(|d| Diagnostics {
                    max_strain: d.max_strain,
                    max_speed_m_s: d.max_speed_m_s,
                    kinetic_energy: d.kinetic_energy,
                    elastic_energy: d.elastic_energy,
                    ground_contacts: d.ground_contacts,
                })
                .collect(),
            diverged: response
                .diverged
                .iter()
                .map(|d| Divergence { instance: d.instance, frame: d.frame, node: d.node })
                .collect(),
            queue_s: timing.queue_s,
            compute_s: timing.compute_s,
            worker: response.worker.clone(),
            fidelity: match response.fidelity() {
                Fidelity::Fast => FidelityWord::Fast,
                Fidelity::Exact | Fidelity::Unspecified => FidelityWord::Exact,
            },
            substeps: response.substeps,
            deviation: response.deviation.map(|d| Deviation {
                mean_m: d.mean_m,
                max_m: d.max_m,
                mean_travel_m: d.mean_travel_m,
                frames: d.frames,
            }),
        }
    }
}
