//! Arithmetic of a simulation: its scalar and its vectors, blocks of elements in lanes, and the
//! instruction sets that compute with them.

mod lanes;
mod machine;
mod real;

pub(crate) use self::{
    lanes::{FIRST, Index, LANES, Lane, Node},
    machine::{Machine, Pack, Pack3, Portable, Work, v3},
    real::{Quad, Real, add, add_scaled, dot, product, quad, scale, sub},
};
