//! Fitted parameters: one number per spring, per triplet, per rod, and a few global ones.

use serde::{Deserialize, Serialize};

use crate::Graph;

/// Largest axial stiffness that a fit may reach [N per unit strain].
pub const MAX_SPRING_STIFFNESS: f32 = 1e5;

/// Contact parameters of ground and objects.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Restitution against the ground, 0..=1.
    pub ground_restitution: f32,
    /// Coulomb friction against the ground, 0..=2.
    pub ground_friction: f32,
    /// Restitution between nodes, 0..=1.
    pub object_restitution: f32,
    /// Coulomb friction between nodes, 0..=2.
    pub object_friction: f32,
    /// Nodes nearer than this collide [m].
    pub collision_distance_m: f32,
    /// Contact between nodes of different objects.
    pub between_objects: bool,
    /// Contact between nodes of one object that no spring joins.
    pub within_object: bool,
    /// Ground and colliders meet the skin: a node touches them as far away as the skin that it
    /// carries is nearer to them than it is.
    #[serde(default, skip_serializing_if = "is_off")]
    pub skin: bool,
}

/// A file that does not have it stays as programs before it wrote it.
#[allow(clippy::trivially_copy_pass_by_ref)] // What serde calls has a reference.
fn is_off(skin: &bool) -> bool {
    !skin
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            ground_restitution: 0.5,
            ground_friction: 0.3,
            object_restitution: 0.7,
            object_friction: 0.3,
            collision_distance_m: 0.02,
            between_objects: true,
            within_object: false,
            skin: false,
        }
    }
}

/// The parameters of a twin. A node's mass is 1 unless the graph has
/// masses, so stiffness is per unit node mass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Params {
    /// Axial stiffness [N per unit strain], shape [E].
    pub spring_stiffness: Vec<f32>,
    /// Dashpot coefficient along the spring [N s/m], shape [E].
    pub spring_dashpot: Vec<f32>,
    /// Rest length [m], shape [E].
    pub rest_lengths_m: Vec<f32>,
    /// Bending stiffness [N m/rad], shape [T].
    pub bend_stiffness: Vec<f32>,
    /// Bending damping [N m s/rad], shape [T].
    pub bend_damping: Vec<f32>,
    /// Rest angle [rad], shape [T], 0..=pi.
    pub rest_angles_rad: Vec<f32>,
    /// Twist stiffness of a whole rod, torque per twist [N m/rad], shape [R].
    #[serde(default)]
    pub twist_stiffness: Vec<f32>,
    /// Twist damping of a whole rod [N m s/rad], shape [R].
    #[serde(default)]
    pub twist_damping: Vec<f32>,
    /// Twist at which a rod gives no torque, relative to how it is when a simulation begins [rad],
    /// shape [R]; of any sign and size.
    #[serde(default)]
    pub rest_twists_rad: Vec<f32>,
    /// Velocity decay rate [1/s].
    pub drag: f32,
    /// Contact parameters.
    pub contact: Contact,
}

impl Params {
    /// Checks that lengths fit the graph and numbers are finite and in range.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, graph: &Graph) -> Result<(), String> {
        let (e, t, r) = (graph.springs.len(), graph.triplets.len(), graph.rods.len());
        let arrays = [
            ("spring stiffness", &self.spring_stiffness, e),
            ("spring dashpot", &self.spring_dashpot, e),
            ("rest length", &self.rest_lengths_m, e),
            ("bend stiffness", &self.bend_stiffness, t),
            ("bend damping", &self.bend_damping, t),
            ("rest angle", &self.rest_angles_rad, t),
            ("twist stiffness", &self.twist_stiffness, r),
            ("twist damping", &self.twist_damping, r),
        ];
        for (what, values, expected) in arrays {
            if values.len() != expected {
                return Err(format!("{} values of {what} for {expected} elements", values.len()));
            }
            if let Some(i) = values.iter().position(|x| !(x.is_finite() && *x >= 0.0)) {
                return Err(format!(
                    "{what} {i} is {}: it must be finite and not negative",
                    values[i]
                ));
            }
        }
        let twists = &self.rest_twists_rad;
        if twists.len() != r {
            return Err(format!("{} values of rest twist for {r} rods", twists.len()));
        }
        if let Some(i) = twists.iter().position(|x| !x.is_finite()) {
            return Err(format!("rest twist {i} is {}: it must be finite", twists[i]));
        }
        let c = &self.contact;
        let globals = [
            ("drag", self.drag, f32::MAX),
            ("ground restitution", c.ground_restitution, 1.0),
            ("ground friction", c.ground_friction, 2.0),
            ("object restitution", c.object_restitution, 1.0),
            ("object friction", c.object_friction, 2.0),
            ("collision distance", c.collision_distance_m, f32::MAX),
        ];
        match globals.into_iter().find(|(_, x, high)| !(*x >= 0.0 && x <= high)) {
            Some((what, x, high)) => Err(format!("{what} is {x}: it must lie in 0..={high}")),
            None => Ok(()),
        }
    }
}
