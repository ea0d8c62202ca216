//! Constants of the physics, shared by all backends. GPU kernels have them defined in front of
//! their source.

/// Sine below which a triplet counts as collinear.
pub const MIN_SINE: f64 = 1e-4;
/// Length of a triplet's arm [m] below which it has no direction: the triplet is skipped.
pub const MIN_ARM_M: f64 = 1e-6;
/// Width of the rounding of a triplet's angle, as a share of pi - theta0.
pub const ROUNDING: f64 = 0.5;
/// Distance from pi [rad] below which a rest angle is pi (an `f32` pi is not quite).
pub const STRAIGHT_RAD: f64 = 1e-6;
/// 1 + cosine of the turn at a node below which the rod counts as folded: 172 degrees.
pub const MIN_FOLD: f64 = 1e-2;
/// Length of a rod's edge [m] below which it has no direction.
pub const MIN_EDGE_M: f64 = 1e-6;
/// Sine squared of the angle between the rod's last edge and the branch below which the branch
/// holds nothing: 6 degrees.
pub const MIN_SINE_SQUARED: f64 = 1e-2;
/// Length [m] below which a spring has no direction and exerts no force.
pub const MIN_LENGTH_M: f64 = 1e-12;
/// Distance from a surface [m] within which a node touches it: above the rounding of coordinates of
/// a few metres in `f32`.
pub const CONTACT_MARGIN_M: f64 = 1e-6;
/// Most contact candidates of a node, the nearest: bounds memory where an object has collapsed.
pub const MAX_PARTNERS: usize = 512;
/// Largest coordinate [m]: a node farther out has diverged.
pub const MAX_COORDINATE_M: f64 = 1000.0;
/// Height above the ground [m] below which a node stands on it.
pub const ON_GROUND_M: f64 = 1e-3;
/// Time [s] in which a collider, or another node, pushes out a node inside its surface.
pub const PUSH_S: f64 = 0.01;
/// Depth [m] inside a surface beyond which it pushes no faster.
pub const MAX_PUSH_M: f64 = 0.005;
/// Distance from a line [m] within which a point has no angle around it.
pub const LEAST_RADIUS_M: f64 = 1e-6;
/// Stiffness of smooth contact times its width [m/s²], such that a node rests half the width deep
/// under standard gravity.
pub const SMOOTH_STIFFNESS_M_S2: f64 = 16.25;
/// Tangential speed by the width of smooth contact [1/s] below which friction is viscous.
pub const SMOOTH_RATE_1_S: f64 = 10.0;
