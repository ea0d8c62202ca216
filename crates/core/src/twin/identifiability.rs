//! Identifiability of a twin: the groups of its parameters that the recordings determine, what the
//! others mean in millimetres for motions of the object, and the most informative recording to make
//! next. `crates/identify` computes it, and its documentation has the method.

use serde::{Deserialize, Serialize};

/// Most regions that an object is cut into.
pub const MOST_REGIONS: usize = 12;

/// The degree to which recordings determine a group of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Certainty {
    /// Less than a third of its plausible range is left.
    Determined,
    /// Up to three quarters of it are left.
    Partly,
    /// The recordings hardly say anything about it.
    Undetermined,
}

impl Certainty {
    /// Certainty for a standard deviation, relative to the one before anything was recorded.
    pub fn of(relative_sd: f64) -> Self {
        match relative_sd {
            r if r < 1.0 / 3.0 => Self::Determined,
            r if r < 0.75 => Self::Partly,
            _ => Self::Undetermined,
        }
    }

    /// The word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Determined => "determined",
            Self::Partly => "partly",
            Self::Undetermined => "undetermined",
        }
    }
}

/// Kind of the parameters of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Stiffness of springs, in logarithms.
    Stiffness,
    /// Rest length of springs, in logarithms.
    RestLength,
    /// Stiffness of bending, in logarithms.
    BendStiffness,
    /// Stiffness of the springs by which a hand holds, in logarithms.
    Grip,
    /// Stiffness of the twist of rods, in logarithms.
    TwistStiffness,
    /// Dashpots of springs, in logarithms.
    Dashpot,
    /// Damping of bending, in logarithms.
    BendDamping,
    /// Decay rate of velocity, in logarithms.
    Drag,
    /// Friction on the ground.
    GroundFriction,
    /// Restitution on the ground.
    GroundRestitution,
}

impl Quantity {
    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stiffness => "stiffness",
            Self::RestLength => "rest length",
            Self::BendStiffness => "bending stiffness",
            Self::Grip => "grip",
            Self::TwistStiffness => "twist stiffness",
            Self::Dashpot => "damping of springs",
            Self::BendDamping => "damping of bending",
            Self::Drag => "drag",
            Self::GroundFriction => "friction on the ground",
            Self::GroundRestitution => "restitution on the ground",
        }
    }
}

/// A part of the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Name for people, by where it is: `near the hand`, `free end`.
    pub name: String,
    /// Centre at rest [m].
    pub center: [f64; 3],
    /// Number of nodes.
    pub nodes: u32,
}

/// Parameters that change together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// Kind of the parameters.
    pub quantity: Quantity,
    /// Index of their region; none for those of the whole object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<u32>,
    /// Hand whose grip it is, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hand: Option<u32>,
    /// Standard deviation before anything was recorded: of the logarithm, or of the number itself.
    pub prior_sd: f64,
    /// Standard deviation that the recordings leave, over `prior_sd`; 0..=1.
    pub relative_sd: f64,
    /// Certainty of the group in a word.
    pub certainty: Certainty,
}

/// A motion with what the recordings leave open of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionUncertainty {
    /// The motion: `future`, `hang`, `shake` or `push`.
    pub motion: String,
    /// Standard deviation of a point of the skin that the recordings leave, mean over points and
    /// frames [m].
    pub sd_m: f64,
    /// Standard deviation before anything was recorded [m].
    pub prior_sd_m: f64,
    /// Part of the variance that would go if a group were known, shape [groups], 0..=1. Groups that
    /// the recordings confuse share the same part.
    pub shares: Vec<f64>,
}

/// A recording that could be made next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextRecording {
    /// The motion: `shake`, `hang`, `push`, `far_shake`, `bend`, `pull` or `region_shake`.
    pub motion: String,
    /// Instruction, as a sentence.
    pub action: String,
    /// Standard deviation that would be left, mean over all motions of the report [m].
    pub sd_m: f64,
}

/// Identifiability of a twin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Identifiability {
    /// The report in sentences.
    pub summary: Vec<String>,
    /// Parts of the object, shape [R].
    pub regions: Vec<Region>,
    /// Groups of parameters.
    pub groups: Vec<Group>,
    /// Motions, the frames after the training frames first.
    pub motions: Vec<MotionUncertainty>,
    /// Recordings that could be made next, the most informative first.
    pub next: Vec<NextRecording>,
    /// Standard deviation of a coordinate of a tracked point from the twin in the training frames [m].
    pub noise_m: f64,
    /// Number of independent observations that the tracked points of the training frames amount to;
    /// errors last and are shared by neighbours.
    pub observations: f64,
    /// Error to expect of the frames after the training frames: what is left open, and the error in
    /// training, which lasts [m]; none without such frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_error_m: Option<f64>,
    /// Region of each node, shape [N]; a tensor of twin files, left out of tables.
    #[serde(skip)]
    pub node_regions: Vec<u8>,
    /// Standard deviation of each skin point that the recordings leave, root mean square over the
    /// motions [m], shape [M]; a tensor of twin files, left out of tables.
    #[serde(skip)]
    pub point_sd_m: Vec<f32>,
}

impl Identifiability {
    /// Standard deviation that the recordings leave, mean over the motions [m]; 0 without motions.
    pub fn sd_m(&self) -> f64 {
        self.motions.iter().map(|m| m.sd_m).sum::<f64>() / self.motions.len().max(1) as f64
    }

    /// Name of a group for people.
    pub fn name(&self, group: &Group) -> String {
        let quantity = group.quantity.name();
        let region = group.region.and_then(|r| self.regions.get(r as usize));
        let hands = self.groups.iter().filter(|g| g.hand.is_some()).count();
        match (region, group.hand) {
            (Some(region), _) => format!("{quantity}, {}", region.name),
            (None, Some(hand)) if hands > 1 => format!("{quantity} of hand {}", hand + 1),
            (None, Some(_)) => format!("{quantity} of the hand"),
            (None, None) => quantity.to_owned(),
        }
    }

    /// Checks that lengths match the twin's numbers of nodes and skin points, that indices exist
    /// and that numbers are finite.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, node_count: usize, skin_count: usize) -> Result<(), String> {
        let (regions, groups) = (self.regions.len(), self.groups.len());
        if regions > MOST_REGIONS {
            return Err(format!("{regions} regions: at most {MOST_REGIONS} are possible"));
        }
        let lengths = [
            ("regions of nodes", self.node_regions.len(), node_count),
            ("deviations of skin points", self.point_sd_m.len(), skin_count),
        ];
        if let Some((what, len, of)) =
            lengths.into_iter().find(|(_, len, of)| *len != 0 && len != of)
        {
            return Err(format!("{len} {what} of {of}"));
        }
        if let Some(r) = self.node_regions.iter().find(|r| usize::from(**r) >= regions) {
            return Err(format!("a node is in region {r} of {regions}"));
        }
        if let Some(r) =
            self.groups.iter().filter_map(|g| g.region).find(|r| *r as usize >= regions)
        {
            return Err(format!("a group is of region {r} of {regions}"));
        }
        if let Some(m) = self.motions.iter().find(|m| m.shares.len() != groups) {
            return Err(format!("{} shares of {groups} groups", m.shares.len()));
        }
        let is_possible = |x: &f32| x.is_finite() && *x >= 0.0;
        match self.point_sd_m.iter().find(|x| !is_possible(x)) {
            Some(x) => Err(format!("a skin point has the standard deviation {x}")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
