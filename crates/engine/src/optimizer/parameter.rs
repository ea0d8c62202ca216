//! The fields of [`Params`] that a loss has derivatives by, one by one.

use bendtwin_core::Params;

/// A field of [`Params`] with derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// [`Params::spring_stiffness`].
    SpringStiffness,
    /// [`Params::spring_dashpot`].
    SpringDashpot,
    /// [`Params::rest_lengths_m`].
    RestLength,
    /// [`Params::bend_stiffness`].
    BendStiffness,
    /// [`Params::bend_damping`].
    BendDamping,
    /// [`Params::rest_angles_rad`].
    RestAngle,
    /// [`Params::twist_stiffness`].
    TwistStiffness,
    /// [`Params::twist_damping`].
    TwistDamping,
    /// [`Params::rest_twists_rad`].
    RestTwist,
    /// [`Params::drag`].
    Drag,
    /// [`bendtwin_core::Contact::ground_restitution`].
    GroundRestitution,
    /// [`bendtwin_core::Contact::ground_friction`].
    GroundFriction,
    /// [`bendtwin_core::Contact::object_restitution`].
    ObjectRestitution,
    /// [`bendtwin_core::Contact::object_friction`].
    ObjectFriction,
}

impl Parameter {
    /// All of them, in the order of [`Params`].
    pub const ALL: [Self; 14] = [
        Self::SpringStiffness,
        Self::SpringDashpot,
        Self::RestLength,
        Self::BendStiffness,
        Self::BendDamping,
        Self::RestAngle,
        Self::TwistStiffness,
        Self::TwistDamping,
        Self::RestTwist,
        Self::Drag,
        Self::GroundRestitution,
        Self::GroundFriction,
        Self::ObjectRestitution,
        Self::ObjectFriction,
    ];

    /// The values of this field; globals as a slice of one.
    pub fn values(self, p: &Params) -> &[f32] {
        let one = std::slice::from_ref;
        match self {
            Self::SpringStiffness => &p.spring_stiffness,
            Self::SpringDashpot => &p.spring_dashpot,
            Self::RestLength => &p.rest_lengths_m,
            Self::BendStiffness => &p.bend_stiffness,
            Self::BendDamping => &p.bend_damping,
            Self::RestAngle => &p.rest_angles_rad,
            Self::TwistStiffness => &p.twist_stiffness,
            Self::TwistDamping => &p.twist_damping,
            Self::RestTwist => &p.rest_twists_rad,
            Self::Drag => one(&p.drag),
            Self::GroundRestitution => one(&p.contact.ground_restitution),
            Self::GroundFriction => one(&p.contact.ground_friction),
            Self::ObjectRestitution => one(&p.contact.object_restitution),
            Self::ObjectFriction => one(&p.contact.object_friction),
        }
    }

    /// Mutable [`Parameter::values`].
    pub fn values_mut(self, p: &mut Params) -> &mut [f32] {
        let one = std::slice::from_mut;
        match self {
            Self::SpringStiffness => &mut p.spring_stiffness,
            Self::SpringDashpot => &mut p.spring_dashpot,
            Self::RestLength => &mut p.rest_lengths_m,
            Self::BendStiffness => &mut p.bend_stiffness,
            Self::BendDamping => &mut p.bend_damping,
            Self::RestAngle => &mut p.rest_angles_rad,
            Self::TwistStiffness => &mut p.twist_stiffness,
            Self::TwistDamping => &mut p.twist_damping,
            Self::RestTwist => &mut p.rest_twists_rad,
            Self::Drag => one(&mut p.drag),
            Self::GroundRestitution => one(&mut p.contact.ground_restitution),
            Self::GroundFriction => one(&mut p.contact.ground_friction),
            Self::ObjectRestitution => one(&mut p.contact.object_restitution),
            Self::ObjectFriction => one(&mut p.contact.object_friction),
        }
    }
}
