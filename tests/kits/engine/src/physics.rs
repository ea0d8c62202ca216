//! Cases of the physics: closed forms, conservation laws and contact.

pub(crate) mod bending;
pub(crate) mod clamps;
pub(crate) mod colliders;
pub(crate) mod conservation;
pub(crate) mod contact;
pub(crate) mod forces;
pub(crate) mod grasps;
pub(crate) mod ground;
pub(crate) mod rest;
pub(crate) mod skin;
pub(crate) mod skin_contact;
pub(crate) mod smooth;
pub(crate) mod springs;
pub(crate) mod twist;
