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
}

impl ImplausibleReason {
    /// All of them, in the order of replies: each is there once for an instance at most.
    pub const ALL: [Self; 4] =
        [Self::StartGap, Self::ControlSpeed, Self::Strain, Self::ControlInObstacle];

    /// The reason, as replies name it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::StartGap => "START_GAP",
            Self::ControlSpeed => "CONTROL_SPEED",
            Self::Strain => "STRAIN",
            Self::ControlInObstacle => "CONTROL_IN_OBSTACLE",
        }
    }

    /// True if the frame in which it was found is known.
    pub fn names_frame(self) -> bool {
        matches!(self, Self::ControlSpeed | Self::ControlInObstacle)
    }

    /// The limit that a request sets, in the unit of the reason.
    pub fn limit(self, limits: &Plausibility) -> Option<f64> {
        match self {
            Self::StartGap => limits.start_gap_m,
            Self::ControlSpeed => limits.control_speed_m_s,
            Self::Strain => limits.strain,
            Self::ControlInObstacle => limits.control_depth_m,
        }
    }

    /// The limit where a request sets none.
    pub fn default_limit(self) -> f64 {
        match self {
            Self::StartGap | Self::ControlInObstacle => 0.005,
            Self::ControlSpeed => 5.0,
            Self::Strain => 1.0,
        }
    }

    /// Name of the limit's field in `plausibility`.
    pub fn field(self) -> &'static str {
        match self {
            Self::StartGap => "start_gap_m",
            Self::ControlSpeed => "control_speed_m_s",
            Self::Strain => "strain",
            Self::ControlInObstacle => "control_depth_m",
        }
    }
}
