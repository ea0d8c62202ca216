//! Collisions of nodes with each other, the ground and colliders, by impulses or as a smooth force, each
//! beside its adjoint.

pub(crate) mod clearance;
pub(crate) mod collider;
pub(crate) mod contact;
pub(crate) mod ground;
pub(crate) mod impulse;
pub(crate) mod meet;
pub(crate) mod smooth;
