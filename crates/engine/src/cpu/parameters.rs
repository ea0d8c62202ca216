//! The fitted numbers in the simulation's scalar; gradients have the same shape.

use bendtwin_core::{Contact, Params};

use super::arithmetic::Real;

/// [`Params`] over any scalar.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters<T> {
    /// See [`Params::spring_stiffness`].
    pub spring_stiffness: Vec<T>,
    /// See [`Params::spring_dashpot`].
    pub spring_dashpot: Vec<T>,
    /// See [`Params::rest_lengths_m`].
    pub rest_lengths_m: Vec<T>,
    /// See [`Params::bend_stiffness`].
    pub bend_stiffness: Vec<T>,
    /// See [`Params::bend_damping`].
    pub bend_damping: Vec<T>,
    /// See [`Params::rest_angles_rad`].
    pub rest_angles_rad: Vec<T>,
    /// See [`Params::twist_stiffness`].
    pub twist_stiffness: Vec<T>,
    /// See [`Params::twist_damping`].
    pub twist_damping: Vec<T>,
    /// See [`Params::rest_twists_rad`].
    pub rest_twists_rad: Vec<T>,
    /// See [`Params::drag`].
    pub drag: T,
    /// See [`Contact::ground_restitution`].
    pub ground_restitution: T,
    /// See [`Contact::ground_friction`].
    pub ground_friction: T,
    /// See [`Contact::object_restitution`].
    pub object_restitution: T,
    /// See [`Contact::object_friction`].
    pub object_friction: T,
}

// The scalars are f32 and f64; the trait for them is private.
#[allow(private_bounds)]
impl<T: Real> Parameters<T> {
    /// The same numbers in another scalar.
    pub(crate) fn from_params(p: &Params) -> Self {
        let each = |v: &[f32]| v.iter().map(|&x| T::from_f32(x)).collect();
        Self {
            spring_stiffness: each(&p.spring_stiffness),
            spring_dashpot: each(&p.spring_dashpot),
            rest_lengths_m: each(&p.rest_lengths_m),
            bend_stiffness: each(&p.bend_stiffness),
            bend_damping: each(&p.bend_damping),
            rest_angles_rad: each(&p.rest_angles_rad),
            twist_stiffness: each(&p.twist_stiffness),
            twist_damping: each(&p.twist_damping),
            rest_twists_rad: each(&p.rest_twists_rad),
            drag: T::from_f32(p.drag),
            ground_restitution: T::from_f32(p.contact.ground_restitution),
            ground_friction: T::from_f32(p.contact.ground_friction),
            object_restitution: T::from_f32(p.contact.object_restitution),
            object_friction: T::from_f32(p.contact.object_friction),
        }
    }

    /// All zero, for the given numbers of springs, triplets and rods.
    pub(crate) fn zero(springs: usize, triplets: usize, rods: usize) -> Self {
        Self {
            spring_stiffness: vec![T::ZERO; springs],
            spring_dashpot: vec![T::ZERO; springs],
            rest_lengths_m: vec![T::ZERO; springs],
            bend_stiffness: vec![T::ZERO; triplets],
            bend_damping: vec![T::ZERO; triplets],
            rest_angles_rad: vec![T::ZERO; triplets],
            twist_stiffness: vec![T::ZERO; rods],
            twist_damping: vec![T::ZERO; rods],
            rest_twists_rad: vec![T::ZERO; rods],
            ..Self::default()
        }
    }

    /// True if all numbers are finite, in f32 too.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn fit_f32(&self) -> bool {
        let fits = |x: &T| (x.to_f64() as f32).is_finite();
        let arrays = [
            &self.spring_stiffness,
            &self.spring_dashpot,
            &self.rest_lengths_m,
            &self.bend_stiffness,
            &self.bend_damping,
            &self.rest_angles_rad,
            &self.twist_stiffness,
            &self.twist_damping,
            &self.rest_twists_rad,
        ];
        let globals = [
            &self.drag,
            &self.ground_restitution,
            &self.ground_friction,
            &self.object_restitution,
            &self.object_friction,
        ];
        arrays.into_iter().flatten().chain(globals).all(fits)
    }

    /// The gradient in its public form: parameters without a derivative are zero or off.
    pub(crate) fn into_gradient(self) -> Params {
        let each = |v: Vec<T>| v.into_iter().map(narrow).collect();
        Params {
            spring_stiffness: each(self.spring_stiffness),
            spring_dashpot: each(self.spring_dashpot),
            rest_lengths_m: each(self.rest_lengths_m),
            bend_stiffness: each(self.bend_stiffness),
            bend_damping: each(self.bend_damping),
            rest_angles_rad: each(self.rest_angles_rad),
            twist_stiffness: each(self.twist_stiffness),
            twist_damping: each(self.twist_damping),
            rest_twists_rad: each(self.rest_twists_rad),
            drag: narrow(self.drag),
            contact: Contact {
                ground_restitution: narrow(self.ground_restitution),
                ground_friction: narrow(self.ground_friction),
                object_restitution: narrow(self.object_restitution),
                object_friction: narrow(self.object_friction),
                collision_distance_m: 0.0,
                ..Contact::default()
            },
        }
    }
}

/// Converts to `f32`; a gradient beyond its range saturates instead of becoming infinite, NaN
/// becomes zero.
pub(crate) fn narrow<T: Real>(x: T) -> f32 {
    let x = saturate(x);
    if x.is_nan() { 0.0 } else { x }
}

/// Converts to `f32`; values beyond its range saturate instead of becoming infinite, NaN stays NaN.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn saturate<T: Real>(x: T) -> f32 {
    (x.to_f64() as f32).clamp(-f32::MAX, f32::MAX)
}
