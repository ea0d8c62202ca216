//! Geometry that several crates share: vectors, rigid motions and their robust fit, medians.
//!
//! Sums have a fixed order and nothing is fused, so every crate gets the same bits.

mod median;
mod rigid;
mod robust;
mod vector;

pub use self::{
    median::median,
    rigid::{Alignment, Kabsch, Pair, Prior, RigidMotion, kabsch},
    robust::{RobustFit, RobustRule, biweight},
    vector::{
        Scalar, Vector, add, bounds, cross, distance, dot, length, point, point_distance, scaled,
        sub, turn, turn_back, unit, vector3, wide,
    },
};

/// Rotation by nothing, row-major.
pub const IDENTITY: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[cfg(test)]
mod tests;
