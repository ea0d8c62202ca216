//! Forces of the elements of a graph (springs, bending triplets and rods), each beside its adjoint,
//! and the order in which elements are evaluated.

pub(crate) mod bend;
#[cfg(test)]
mod jacobian;
mod rod;
mod spring;
pub(crate) mod strips;

pub(crate) use self::{
    bend::{Triplet, TripletGradient, Triplets, bend_adjoint, bend_forces},
    rod::{Holder, Rod, RodGradient, Rods, Span, rod_adjoint, rod_forces, turned_pattern},
    spring::{Spring, SpringGradient, Springs, spring_adjoint, spring_forces},
    strips::{OwnedElement, Strips},
};
