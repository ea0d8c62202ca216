//! Substeps of a frame, forward and backward, for objects with and without surroundings.

pub(crate) mod adjoint;
pub(crate) mod control;
pub(crate) mod integrate;
pub(crate) mod surrounded;
