//! Reasons why the motion of an instance is held to be impossible.

use bendtwin_proto::v1::Plausibility;

/// A reason of an `Implausible`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImplausibleReason {
    /// The actions begin away from the control points of the initial state [m].
    StartGap,
    /// A control point is too fast [m/s].
    ControlSpeed,
    /// The material is strained too much.
    Strain,
    /// Prescribed points go into the ground or a collider that stands still [m].
    ControlInObstacle,
    /// A grasp pulls or pushes too hard [N].
    GraspForce,
}

impl ImplausibleReason {
    /// All of them, in the order of replies: each is there once for an instance at most, that of grasps once
    /// for each grasp.
    pub const ALL: [Self; 5] = [
        Self::StartGap,
        Self::ControlSpeed,
        Self::Strain,
        Self::ControlInObstacle,
        Self::GraspForce,
    ];

    /// The reason, as replies name it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::StartGap => "START_GAP",
            Self::ControlSpeed => "CONTROL_SPEED",
            Self::Strain => "STRAIN",
            Self::ControlInObstacle => "CONTROL_IN_OBSTACLE",
            Self::GraspForce => "GRASP_FORCE",
        }
    }

    /// True if the frame in which it was found is known.
    pub fn names_frame(self) -> bool {
        matches!(self, Self::ControlSpeed | Self::ControlInObstacle | Self::GraspForce)
    }

    /// The limit that a request sets, in the unit of the reason.
    pub fn limit(self, limits: &Plausibility) -> Option<f64> {
        match self {
            Self::StartGap => limits.start_gap_m,
            Self::ControlSpeed => limits.control_speed_m_s,
            Self::Strain => limits.strain,
            Self::ControlInObstacle => limits.control_depth_m,
            Self::GraspForce => limits.grasp_force_n,
        }
    }

    /// The limit where a request sets none; infinite for no limit.
    pub fn default_limit(self) -> f64 {
        match self {
            Self::StartGap | Self::ControlInObstacle => 0.005,
            Self::ControlSpeed => 5.0,
            Self::Strain => 1.0,
            Self::GraspForce => f64::INFINITY,
        }
    }

    /// The limit of a request: its own, or the default.
    pub fn limit_or_default(self, limits: &Plausibility) -> f64 {
        self.limit(limits).unwrap_or_else(|| self.default_limit())
    }

    /// Name of the limit's field in `plausibility`.
    pub fn field(self) -> &'static str {
        match self {
            Self::StartGap => "start_gap_m",
            Self::ControlSpeed => "control_speed_m_s",
            Self::Strain => "strain",
            Self::ControlInObstacle => "control_depth_m",
            Self::GraspForce => "grasp_force_n",
        }
    }
}
