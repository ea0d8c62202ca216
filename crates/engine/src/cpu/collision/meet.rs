//! Moving a free node for one substep with the ground and colliders in the way, and the adjoint.
//!
//! A node meets the ground first and then the colliders, in their order; the velocity after one is
//! that before the next. For a collider, the node at `x` is at `q = Aᵀ (x - p)` of its body in the
//! pose where the substep starts, d(q) is the signed distance and `n = A n(q) / |A n(q)|` the normal
//! there, and the surface has the velocity w of the body's point q, also where the model ignores that
//! of control points. With `u = v - w`:
//!
//! - it hits if `d - r + dt u . n < 1 µm` and `u . n < 0`, by the law of [`super::impulse`] for u,
//!   after `tau = clamp((d - r) / -(u . n), 0, dt)`, which is 0 up to a distance of 1 µm, with r the
//!   clearance of [`super::clearance`];
//! - inside (d < 0) it is also pushed out: the normal velocity that it leaves the surface with is at
//!   least `min(-d, 5 mm) / 10 ms`.
//!
//! The substep ends at `x + tau v + (dt - tau) v'` with the velocities before and after the last one
//! that changed it (tau = 0 if that one only pushed). The ground is that without a push, in exactly
//! the roundings of [`super::ground`]. Prescribed nodes meet nothing. With a width of contact,
//! [`super::smooth`] takes the place of both impact and push.

use super::{
    clearance::{Clearance, ClearanceAdjoint},
    collider::Collider,
    ground::{hits, impact_time},
    impulse::{Approach, Contact, ContactAdjoint, Law},
    smooth::Layer,
};
use crate::{
    constants::CONTACT_MARGIN_M,
    cpu::{
        arithmetic::{Node, Quad, Real, add, add_scaled, dot, scale, sub},
        surroundings::{
            Around, Surroundings,
            body::{BodyFrame, Pose, add_outer, into_body, into_body_adjoint, turn, turn_back},
            grasp::AroundAdjoint,
        },
        system::{Ground, System},
    },
};

/// A collider in a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacle<T> {
    /// Number among the colliders.
    pub(crate) collider: usize,
    pub(crate) body: BodyFrame<T>,
    /// Start of the substep, as a fraction of the frame.
    pub(crate) t: T,
    pub(crate) pose: Pose<T>,
}

/// A surface as a node sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<T> {
    pub(crate) distance: T,
    /// The distance less that at which the node touches.
    pub(crate) gap: T,
    pub(crate) normal: Quad<T>,
    /// Velocity of the surface.
    pub(crate) velocity: Quad<T>,
    /// The node in the body's coordinates, the normal there, and the length of that turned.
    place: Quad<T>,
    local: Quad<T>,
    length: T,
}

/// Surface of the ground.
#[inline(always)]
pub(crate) fn on_ground<T: Real>(ground: &Ground<T>, x: Quad<T>) -> Surface<T> {
    let zero = [T::ZERO; 4];
    let distance = dot(ground.normal, x) - ground.offset;
    Surface {
        distance,
        gap: distance,
        normal: ground.normal,
        velocity: zero,
        place: zero,
        local: zero,
        length: T::ONE,
    }
}

impl<T: Real> Obstacle<T> {
    /// Surface of an obstacle for a node.
    #[inline(always)]
    pub(crate) fn surface(&self, collider: &Collider<T>, x: Quad<T>) -> Surface<T> {
        let place = into_body(&self.pose, x);
        let (distance, local) = collider.distance(place);
        let turned = turn(&self.pose, local);
        let length = dot(turned, turned).sqrt();
        let normal = scale(turned, T::ONE / length);
        let velocity = self.body.velocity(place);
        Surface { distance, gap: distance, normal, velocity, place, local, length }
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
#[derive(Clone, Copy, Debug)]
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
    /// Velocity of the node before it.
    before: Quad<T>,
    /// Velocity relative to the surface.
    approach: Approach<T>,
    kind: Kind<T>,
    /// Change of velocity.
    pub(crate) change: Quad<T>,
    tau: T,
    /// True if `tau` depends on distance and approach.
    tau_varies: bool,
}

/// The way in which a velocity changed.
#[derive(Clone, Copy, Debug)]
enum Kind<T> {
    Hard(Contact<T>),
    Smooth,
}

impl<T: Real> Meeting<T> {
    /// Velocity of the node after it.
    #[inline(always)]
    fn after(&self) -> Quad<T> {
        add(self.before, self.change)
    }
}

impl<T: Real> Surface<T> {
    /// The velocity of a node relative to it.
    #[inline(always)]
    fn approach(&self, start: Quad<T>, v: Quad<T>) -> Approach<T> {
        Approach { start: sub(start, self.velocity), now: sub(v, self.velocity) }
    }
}

/// The meeting with a collider of a node that started the substep with velocity `start`.
#[inline(always)]
fn meeting<T: Real>(
    obstacle: usize,
    surface: Surface<T>,
    law: Law<T>,
    dt: T,
    start: Quad<T>,
    v: Quad<T>,
) -> Option<Meeting<T>> {
    let (d, gap, n) = (surface.distance, surface.gap, surface.normal);
    let approach = surface.approach(start, v);
    let along = dot(n, approach.now);
    let hits = (gap + dt * along < T::from_f64(CONTACT_MARGIN_M)) & (along < T::ZERO);
    let contact = Contact::new(law, approach, n, hits, (d < T::ZERO).then_some(d));
    contact.acts().then(|| hard(Some(obstacle), surface, law, dt, v, approach, contact))
}

#[inline(always)]
fn hard<T: Real>(
    with: Option<usize>,
    surface: Surface<T>,
    law: Law<T>,
    dt: T,
    before: Quad<T>,
    approach: Approach<T>,
    contact: Contact<T>,
) -> Meeting<T> {
    let along = dot(surface.normal, approach.now);
    let (tau, tau_varies) =
        if contact.hits { impact_time(surface.gap, along, dt) } else { (T::ZERO, false) };
    let (kind, change) = (Kind::Hard(contact), contact.change);
    Meeting { with, surface, law, before, approach, kind, change, tau, tau_varies }
}

/// The meeting with a surface in its layer.
#[inline(always)]
fn smooth_meeting<T: Real>(
    with: Option<usize>,
    surface: Surface<T>,
    law: Law<T>,
    layer: &Layer<T>,
    before: Quad<T>,
) -> Option<Meeting<T>> {
    layer.reaches(surface.gap).then(|| {
        let approach = surface.approach(before, before);
        let change = layer.change(law, surface.gap, approach.now, surface.normal);
        let (kind, tau, tau_varies) = (Kind::Smooth, T::ZERO, false);
        Meeting { with, surface, law, before, approach, kind, change, tau, tau_varies }
    })
}

/// The obstacles of a substep.
pub(crate) struct Scene<'a, T> {
    pub(crate) of: &'a Surroundings<T>,
    pub(crate) ground: Option<(Ground<T>, Law<T>)>,
    pub(crate) obstacles: &'a [Obstacle<T>],
    pub(crate) clearance: &'a Clearance<T>,
    pub(crate) dt: T,
    /// The layer of smooth contact, if it is smooth.
    pub(crate) layer: Option<Layer<T>>,
}

impl<T: Real> Scene<'_, T> {
    /// A node, after a substep that it starts as `start`, with velocity `v` after forces acted; shows
    /// what it meets.
    #[inline(always)]
    pub(crate) fn advance(
        &self,
        node: usize,
        start: Node<T>,
        v: Quad<T>,
        mut on_meeting: impl FnMut(&Meeting<T>),
    ) -> Node<T> {
        let (dt, x) = (self.dt, start.x);
        let mut now = v;
        let mut path = None;
        if let Some((ground, law)) = &self.ground {
            let ground = &ground.raised(self.clearance.of(None, node));
            let met = match &self.layer {
                None => hits(ground, v, add_scaled(x, dt, v)).then(|| {
                    let surface = on_ground(ground, x);
                    let approach = surface.approach(start.v, v);
                    let contact = Contact::new(*law, approach, ground.normal, true, None);
                    hard(None, surface, *law, dt, v, approach, contact)
                }),
                Some(layer) => smooth_meeting(None, on_ground(ground, x), *law, layer, v),
            };
            if let Some(m) = met {
                on_meeting(&m);
                (now, path) = (m.after(), Some((m.tau, m.before)));
            }
        }
        for (o, obstacle) in self.obstacles.iter().enumerate() {
            let collider = &self.of.colliders[obstacle.collider];
            let mut surface = obstacle.surface(collider, x);
            surface.gap = surface.distance - self.clearance.of(Some(o), node);
            let met = match &self.layer {
                None => meeting(o, surface, collider.law, dt, start.v, now),
                Some(layer) => smooth_meeting(Some(o), surface, collider.law, layer, now),
            };
            if let Some(m) = met {
                on_meeting(&m);
                (now, path) = (m.after(), Some((m.tau, m.before)));
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
    /// result, and d loss / d the velocity at the start. `seed` gives d loss / d velocity change by
    /// an obstacle of itself.
    #[inline(always)]
    pub(crate) fn advance_adjoint(
        &self,
        node: usize,
        (x, meetings): (Quad<T>, &[Meeting<T>]),
        bar: Node<T>,
        seed: impl Fn(Option<usize>) -> Quad<T>,
        law_bar: &mut Law<T>,
        (around, clearance): (&mut AroundAdjoint<T>, &mut ClearanceAdjoint<T>),
    ) -> (Node<T>, Quad<T>) {
        let dt = self.dt;
        let mut start_bar = [T::ZERO; 4];
        let Some(last) = meetings.last() else {
            return (Node { x: bar.x, v: add_scaled(bar.v, dt, bar.x) }, start_bar);
        };
        let mut x_bar = bar.x;
        let mut v_bar = add_scaled(bar.v, dt - last.tau, bar.x);
        // x' = x + tau v + (dt - tau) v'
        let mut tau_bar = -dot(bar.x, last.change);
        let mut before_bar = scale(bar.x, last.tau);
        for m in meetings.iter().rev() {
            let (s, n) = (&m.surface, m.surface.normal);
            let change_bar = add(v_bar, seed(m.with));
            let g = match (m.kind, &self.layer) {
                (Kind::Hard(contact), _) => {
                    contact.adjoint(m.law, m.approach, n, s.distance, change_bar)
                }
                (Kind::Smooth, Some(layer)) => {
                    layer.change_adjoint(m.law, s.gap, m.approach.now, n, change_bar)
                }
                (Kind::Smooth, None) => ContactAdjoint::ZERO,
            };
            if m.with.is_none() {
                law_bar.add(&g);
            }
            start_bar = add(start_bar, g.start);
            let mut in_bar = add(add(before_bar, v_bar), g.v);
            // A layer begins at the gap, a push at the surface itself.
            let (mut distance_bar, mut gap_bar) = (g.distance, T::ZERO);
            if matches!(m.kind, Kind::Smooth) {
                (distance_bar, gap_bar) = (T::ZERO, g.distance);
            }
            let mut s_bar = SurfaceAdjoint {
                distance: distance_bar,
                normal: g.normal,
                velocity: scale(add(g.v, g.start), -T::ONE),
            };
            if m.tau_varies {
                // tau = -gap / (u . n)
                let u = m.approach.now;
                let inverse = T::ONE / dot(n, u);
                gap_bar -= tau_bar * inverse;
                let along = -(tau_bar * m.tau * inverse);
                in_bar = add_scaled(in_bar, along, n);
                s_bar.velocity = add_scaled(s_bar.velocity, -along, n);
                s_bar.normal = add_scaled(s_bar.normal, along, u);
            }
            s_bar.distance += gap_bar;
            clearance.add(m.with, node, -gap_bar);
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
        (Node { x: x_bar, v: v_bar }, start_bar)
    }
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
        let mut obstacles = std::mem::take(&mut self.obstacles);
        obstacles.clear();
        obstacles.extend(self.obstacles_at(of, t));
        self.obstacles = obstacles;
    }

    /// The obstacles that nodes may reach, after a fraction of the frame.
    pub(crate) fn obstacles_at<'a>(
        &'a self,
        of: &'a Surroundings<T>,
        t: T,
    ) -> impl Iterator<Item = Obstacle<T>> + 'a {
        self.near.iter().map(move |&k| {
            let body = self.body(of.colliders[k].body);
            Obstacle { collider: k, body, t, pose: body.at(t) }
        })
    }
}
