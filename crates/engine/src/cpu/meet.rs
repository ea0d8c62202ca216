//! Moving a free node for one substep with the ground and colliders in the way, and the adjoint.
//!
//! A node meets the ground first and then the colliders, in their order; the velocity after one is
//! that before the next. For a collider, the node at `x` is at `q = Aᵀ (x - p)` of its body in the
//! pose where the substep starts, d(q) is the signed distance and `n = A n(q) / |A n(q)|` the normal
//! there, and the surface has the velocity w of the body's point q, also where the model ignores that
//! of control points. With `u = v - w`:
//!
//! - it hits if `d + dt u . n < 0` and `u . n < -1e-4 m/s`, by the law of [`super::impulse`] for u,
//!   after `tau = clamp(d / -(u . n), 0, dt)`;
//! - inside (d < 0) it is also pushed out: the normal velocity that it leaves the surface with is at
//!   least `min(-d, 5 mm) / 10 ms`.
//!
//! The substep ends at `x + tau v + (dt - tau) v'` with the velocities before and after the last one
//! that changed it (tau = 0 if that one only pushed). The ground is that without a push, in exactly
//! the roundings of [`super::ground`]. Prescribed nodes meet nothing. With a width of contact,
//! [`super::smooth`] takes the place of both impact and push.

use super::{
    body::{BodyFrame, Pose, add_outer, into_body, into_body_adjoint, turn, turn_back},
    collider::Collider,
    grasp::AroundAdjoint,
    impulse::{Law, impact, impact_adjoint},
    lanes::Node,
    real::{Quad, Real, add, add_scaled, dot, scale, sub},
    smooth::Layer,
    surroundings::{Around, Surroundings},
    system::{Ground, System},
};
use crate::constants::{MAX_PUSH_M, MIN_APPROACH_M_S, PUSH_S};

/// A collider in a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacle<T> {
    /// Number among the colliders.
    pub(crate) collider: usize,
    pub(crate) body: BodyFrame<T>,
    /// Where the substep starts, as a fraction of the frame.
    pub(crate) t: T,
    pub(crate) pose: Pose<T>,
}

/// A surface as a node sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<T> {
    pub(crate) distance: T,
    pub(crate) normal: Quad<T>,
    /// Velocity of the surface.
    pub(crate) velocity: Quad<T>,
    /// The node in the body's coordinates, the normal there, and the length of that turned.
    place: Quad<T>,
    local: Quad<T>,
    length: T,
}

/// Of the ground.
#[inline(always)]
pub(crate) fn on_ground<T: Real>(ground: &Ground<T>, x: Quad<T>) -> Surface<T> {
    let zero = [T::ZERO; 4];
    Surface {
        distance: dot(ground.normal, x) - ground.offset,
        normal: ground.normal,
        velocity: zero,
        place: zero,
        local: zero,
        length: T::ONE,
    }
}

impl<T: Real> Obstacle<T> {
    /// Its surface for a node.
    #[inline(always)]
    pub(crate) fn surface(&self, collider: &Collider<T>, x: Quad<T>) -> Surface<T> {
        let place = into_body(&self.pose, x);
        let (distance, local) = collider.distance(place);
        let turned = turn(&self.pose, local);
        let length = dot(turned, turned).sqrt();
        let normal = scale(turned, T::ONE / length);
        let velocity = self.body.velocity(place);
        Surface { distance, normal, velocity, place, local, length }
    }

    /// Adjoint of [`Self::surface`]: gives d loss / d x.
    #[inline(always)]
    pub(crate) fn surface_adjoint(
        &self,
        collider: &Collider<T>,
        x: Quad<T>,
        s: &Surface<T>,
        bar: SurfaceAdjoint<T>,
        around: &mut AroundAdjoint<T>,
    ) -> Quad<T> {
        let across = add_scaled(bar.normal, -dot(s.normal, bar.normal), s.normal);
        let turned_bar = scale(across, T::ONE / s.length);
        let mut q_bar = collider.curvature(s.place, turn_back(&self.pose, turned_bar));
        q_bar = add_scaled(q_bar, bar.distance, s.local);
        let v_bar = scale(bar.velocity, self.body.rate);
        q_bar = add(q_bar, turn_back(&self.body.to, v_bar));
        q_bar = sub(q_bar, turn_back(&self.body.from, v_bar));
        let mut pose_bar = Pose::default();
        add_outer(&mut pose_bar, turned_bar, s.local);
        // A direction is turned, not moved.
        pose_bar.iter_mut().for_each(|row| row[3] = T::ZERO);
        let x_bar = into_body_adjoint(&self.pose, x, q_bar, &mut pose_bar);
        if let Some(b) = collider.body {
            around.bodies[b].at(self.t, &pose_bar);
            around.bodies[b].velocity(&self.body, s.place, bar.velocity);
        }
        x_bar
    }
}

/// d loss / d a [`Surface`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurfaceAdjoint<T> {
    pub(crate) distance: T,
    pub(crate) normal: Quad<T>,
    pub(crate) velocity: Quad<T>,
}

/// A meeting that changed a node's velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting<T> {
    /// Number among the obstacles; `None` is the ground.
    pub(crate) with: Option<usize>,
    surface: Surface<T>,
    law: Law<T>,
    /// Velocities before, after the impact, and after the push.
    before: Quad<T>,
    between: Quad<T>,
    pub(crate) after: Quad<T>,
    kind: Kind,
    tau: T,
}

/// The way in which a velocity changed.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Hard { hits: bool, pushes: bool },
    Smooth,
}

impl<T: Real> Meeting<T> {
    /// Change of velocity.
    #[inline(always)]
    pub(crate) fn change(&self) -> Quad<T> {
        sub(self.after, self.before)
    }
}

/// Velocity with which a node so deep inside leaves at least, and its derivative by the distance.
#[inline(always)]
fn push<T: Real>(distance: T) -> (T, T) {
    let (deepest, rate) = (T::from_f64(MAX_PUSH_M), T::from_f64(1.0 / PUSH_S));
    if -distance < deepest { (-distance * rate, -rate) } else { (deepest * rate, T::ZERO) }
}

#[inline(always)]
fn meeting<T: Real>(
    obstacle: usize,
    surface: Surface<T>,
    law: Law<T>,
    dt: T,
    v: Quad<T>,
) -> Option<Meeting<T>> {
    let (d, n) = (surface.distance, surface.normal);
    let u = sub(v, surface.velocity);
    let along = dot(n, u);
    let hits = (d + dt * along < T::ZERO) & (along < -T::from_f64(MIN_APPROACH_M_S));
    let between = if hits { add(v, impact(law, u, n)) } else { v };
    let mut after = between;
    let mut pushes = false;
    if d < T::ZERO {
        let lack = push(d).0 - dot(n, sub(between, surface.velocity));
        pushes = lack > T::ZERO;
        if pushes {
            after = add_scaled(after, lack, n);
        }
    }
    let tau = if hits { (d / -along).at_least(T::ZERO).at_most(dt) } else { T::ZERO };
    (hits | pushes).then_some(Meeting {
        with: Some(obstacle),
        surface,
        law,
        before: v,
        between,
        after,
        kind: Kind::Hard { hits, pushes },
        tau,
    })
}

/// The meeting with a surface in its layer.
#[inline(always)]
fn smooth_meeting<T: Real>(
    with: Option<usize>,
    surface: Surface<T>,
    law: Law<T>,
    layer: &Layer<T>,
    v: Quad<T>,
) -> Option<Meeting<T>> {
    layer.reaches(surface.distance).then(|| {
        let u = sub(v, surface.velocity);
        let after = add(v, layer.change(law, surface.distance, u, surface.normal));
        let (kind, tau) = (Kind::Smooth, T::ZERO);
        Meeting { with, surface, law, before: v, between: after, after, kind, tau }
    })
}

/// The obstacles of a substep.
pub(crate) struct Scene<'a, T> {
    pub(crate) of: &'a Surroundings<T>,
    pub(crate) ground: Option<(Ground<T>, Law<T>)>,
    pub(crate) obstacles: &'a [Obstacle<T>],
    pub(crate) dt: T,
    /// The layer of smooth contact, if it is smooth.
    pub(crate) layer: Option<Layer<T>>,
}

impl<T: Real> Scene<'_, T> {
    /// The node after a substep that it starts at `x` with velocity `v`; shows what it meets.
    #[inline(always)]
    pub(crate) fn advance(
        &self,
        x: Quad<T>,
        v: Quad<T>,
        mut on_meeting: impl FnMut(&Meeting<T>),
    ) -> Node<T> {
        let dt = self.dt;
        let mut now = v;
        let mut path = None;
        if let Some((ground, law)) = &self.ground {
            let met = match &self.layer {
                None => {
                    hits_ground(ground, x, v, dt).then(|| meeting_ground(ground, *law, dt, x, v))
                }
                Some(layer) => smooth_meeting(None, on_ground(ground, x), *law, layer, v),
            };
            if let Some(m) = met {
                on_meeting(&m);
                (now, path) = (m.after, Some((m.tau, m.before)));
            }
        }
        for (o, obstacle) in self.obstacles.iter().enumerate() {
            let collider = &self.of.colliders[obstacle.collider];
            let surface = obstacle.surface(collider, x);
            let met = match &self.layer {
                None => meeting(o, surface, collider.law, dt, now),
                Some(layer) => smooth_meeting(Some(o), surface, collider.law, layer, now),
            };
            if let Some(m) = met {
                on_meeting(&m);
                (now, path) = (m.after, Some((m.tau, m.before)));
            }
        }
        match path {
            Some((tau, before)) => {
                Node { x: add_scaled(add_scaled(x, tau, before), dt - tau, now), v: now }
            }
            None => Node { x: add_scaled(x, dt, now), v: now },
        }
    }

    /// Adjoint of [`Self::advance`], given what the node met: d loss / d (x, v) from that of the
    /// result. `seed` gives d loss / d velocity change by an obstacle of itself.
    #[inline(always)]
    pub(crate) fn advance_adjoint(
        &self,
        (x, meetings): (Quad<T>, &[Meeting<T>]),
        bar: Node<T>,
        seed: impl Fn(Option<usize>) -> Quad<T>,
        law_bar: &mut Law<T>,
        around: &mut AroundAdjoint<T>,
    ) -> Node<T> {
        let dt = self.dt;
        let Some(last) = meetings.last() else {
            return Node { x: bar.x, v: add_scaled(bar.v, dt, bar.x) };
        };
        let mut x_bar = bar.x;
        let mut v_bar = add_scaled(bar.v, dt - last.tau, bar.x);
        // x' = x + tau v + (dt - tau) v'
        let mut tau_bar = -dot(bar.x, last.change());
        let mut before_bar = scale(bar.x, last.tau);
        for m in meetings.iter().rev() {
            let (s, n) = (&m.surface, m.surface.normal);
            let seed = seed(m.with);
            let after_bar = add(v_bar, seed);
            let mut in_bar = sub(before_bar, seed);
            let mut s_bar = SurfaceAdjoint::default();
            let mut between_bar = after_bar;
            let (hits, pushes) = match m.kind {
                Kind::Hard { hits, pushes } => (hits, pushes),
                Kind::Smooth => (false, false),
            };
            if pushes {
                let along = dot(n, after_bar);
                let (speed, slope) = push(s.distance);
                let leaves = sub(m.between, s.velocity);
                s_bar.distance += slope * along;
                s_bar.velocity = scale(n, along);
                s_bar.normal = add_scaled(scale(after_bar, speed - dot(n, leaves)), -along, leaves);
                between_bar = add_scaled(after_bar, -along, n);
            }
            in_bar = add(in_bar, between_bar);
            if let (Kind::Smooth, Some(layer)) = (m.kind, &self.layer) {
                let u = sub(m.before, s.velocity);
                let (g, h_bar) = layer.change_adjoint(m.law, s.distance, u, n, after_bar);
                if m.with.is_none() {
                    law_bar.restitution += g.restitution;
                    law_bar.friction += g.friction;
                }
                in_bar = add(in_bar, g.v);
                s_bar.velocity = scale(g.v, -T::ONE);
                s_bar.normal = g.normal;
                s_bar.distance = h_bar;
            }
            if hits {
                let u = sub(m.before, s.velocity);
                let g = impact_adjoint(m.law, u, n, between_bar);
                if m.with.is_none() {
                    law_bar.restitution += g.restitution;
                    law_bar.friction += g.friction;
                }
                in_bar = add(in_bar, g.v);
                s_bar.velocity = sub(s_bar.velocity, g.v);
                s_bar.normal = add(s_bar.normal, g.normal);
                if s.distance > T::ZERO {
                    // tau = -d / (u . n)
                    let inverse = T::ONE / dot(n, u);
                    s_bar.distance -= tau_bar * inverse;
                    let along = -(tau_bar * m.tau * inverse);
                    in_bar = add_scaled(in_bar, along, n);
                    s_bar.velocity = add_scaled(s_bar.velocity, -along, n);
                    s_bar.normal = add_scaled(s_bar.normal, along, u);
                }
            }
            x_bar = match m.with {
                None => add_scaled(x_bar, s_bar.distance, n),
                Some(o) => {
                    let obstacle = &self.obstacles[o];
                    let collider = &self.of.colliders[obstacle.collider];
                    add(x_bar, obstacle.surface_adjoint(collider, x, s, s_bar, around))
                }
            };
            (v_bar, before_bar, tau_bar) = (in_bar, [T::ZERO; 4], T::ZERO);
        }
        Node { x: x_bar, v: v_bar }
    }
}

/// True if a node hits the ground, in the roundings of [`super::ground::advance`].
#[inline(always)]
fn hits_ground<T: Real>(ground: &Ground<T>, x: Quad<T>, v: Quad<T>, dt: T) -> bool {
    let height = dot(ground.normal, add_scaled(x, dt, v)) - ground.offset;
    (height < T::ZERO) & (dot(ground.normal, v) < -T::from_f64(MIN_APPROACH_M_S))
}

/// The meeting of a node that hits the ground.
#[inline(always)]
fn meeting_ground<T: Real>(
    ground: &Ground<T>,
    law: Law<T>,
    dt: T,
    x: Quad<T>,
    v: Quad<T>,
) -> Meeting<T> {
    let surface = on_ground(ground, x);
    let after = add(v, impact(law, v, ground.normal));
    let along = dot(ground.normal, v);
    let tau = (surface.distance / -along).at_least(T::ZERO).at_most(dt);
    let kind = Kind::Hard { hits: true, pushes: false };
    Meeting { with: None, surface, law, before: v, between: after, after, kind, tau }
}

impl<T: Real> Around<T> {
    /// The obstacles that nodes may reach, in a substep.
    pub(crate) fn place_obstacles(
        &mut self,
        of: &Surroundings<T>,
        system: &System<T>,
        substep: usize,
    ) {
        let t = T::from_f64(substep as f64 / system.substeps as f64);
        self.obstacles.clear();
        for &k in &self.near {
            let body = self.body(of.colliders[k].body);
            let obstacle = Obstacle { collider: k, body, t, pose: body.at(t) };
            self.obstacles.push(obstacle);
        }
    }
}
