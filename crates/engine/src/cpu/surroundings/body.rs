//! Rigid bodies in one frame: the entries of a pose are interpolated linearly, so that a point `o` of
//! a body is at `A(t) o + p(t)` with `A(t) = (1 - t) A0 + t A1`, and has the constant velocity
//! `((A1 - A0) o + (p1 - p0)) / frame_s`. All of it is linear in the poses at both ends of the frame,
//! whose adjoint therefore gathers twelve numbers a boundary.

use crate::cpu::arithmetic::{Quad, Real, add, add_scaled, dot, scale, sub};

/// Rows of [A | p].
pub(crate) type Pose<T> = [Quad<T>; 3];

/// A client's pose in the simulation's scalar.
pub(crate) fn pose_of<T: Real>(pose: &crate::world::Pose) -> Pose<T> {
    pose.map(|row| row.map(T::from_f32))
}

/// A o.
#[inline(always)]
pub(crate) fn turn<T: Real>(pose: &Pose<T>, o: Quad<T>) -> Quad<T> {
    [dot(pose[0], o), dot(pose[1], o), dot(pose[2], o), T::ZERO]
}

/// p.
#[inline(always)]
pub(crate) fn origin<T: Real>(pose: &Pose<T>) -> Quad<T> {
    [pose[0][3], pose[1][3], pose[2][3], T::ZERO]
}

/// A o + p.
#[inline(always)]
pub(crate) fn apply<T: Real>(pose: &Pose<T>, o: Quad<T>) -> Quad<T> {
    add(turn(pose, o), origin(pose))
}

/// Aᵀ x.
#[inline(always)]
pub(crate) fn turn_back<T: Real>(pose: &Pose<T>, x: Quad<T>) -> Quad<T> {
    let sum = add_scaled(add_scaled(scale(pose[0], x[0]), x[1], pose[1]), x[2], pose[2]);
    [sum[0], sum[1], sum[2], T::ZERO]
}

/// Aᵀ (x - p): the coordinates of a point of the world in the body, as far as A is a rotation.
#[inline(always)]
pub(crate) fn into_body<T: Real>(pose: &Pose<T>, x: Quad<T>) -> Quad<T> {
    turn_back(pose, sub(x, origin(pose)))
}

/// bar += x [o, 1]ᵀ: adjoint of [`apply`] by the pose.
#[inline(always)]
pub(crate) fn add_outer<T: Real>(bar: &mut Pose<T>, x: Quad<T>, o: Quad<T>) {
    let o = [o[0], o[1], o[2], T::ONE];
    for (row, &x) in bar.iter_mut().zip(&x) {
        *row = add_scaled(*row, x, o);
    }
}

/// Adjoint of [`into_body`] for d loss / d result = `q_bar`: adds to the pose's, gives that of x.
#[inline(always)]
pub(crate) fn into_body_adjoint<T: Real>(
    pose: &Pose<T>,
    x: Quad<T>,
    q_bar: Quad<T>,
    bar: &mut Pose<T>,
) -> Quad<T> {
    let arm = sub(x, origin(pose));
    let x_bar = turn(pose, q_bar);
    for i in 0..3 {
        bar[i] = add_scaled(bar[i], arm[i], [q_bar[0], q_bar[1], q_bar[2], T::ZERO]);
        bar[i][3] -= x_bar[i];
    }
    x_bar
}

/// A body during a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyFrame<T> {
    /// Poses at both ends.
    pub(crate) from: Pose<T>,
    pub(crate) to: Pose<T>,
    /// 1 / the frame's length [1/s].
    pub(crate) rate: T,
}

impl<T: Real> BodyFrame<T> {
    /// The world itself.
    pub(crate) fn world() -> Self {
        let pose = pose_of(&crate::world::IDENTITY);
        Self { from: pose, to: pose, rate: T::ZERO }
    }

    /// The pose at a fraction of the frame; exact at both ends.
    #[inline(always)]
    pub(crate) fn at(&self, t: T) -> Pose<T> {
        let row = |i: usize| add_scaled(scale(self.from[i], T::ONE - t), t, self.to[i]);
        [row(0), row(1), row(2)]
    }

    /// Velocity of a point of the body.
    #[inline(always)]
    pub(crate) fn velocity(&self, o: Quad<T>) -> Quad<T> {
        scale(sub(apply(&self.to, o), apply(&self.from, o)), self.rate)
    }
}

/// d loss / d the poses at both ends of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BodyFrameAdjoint<T> {
    pub(crate) from: Pose<T>,
    pub(crate) to: Pose<T>,
}

impl<T: Real> BodyFrameAdjoint<T> {
    /// Adjoint of [`BodyFrame::at`].
    #[inline(always)]
    pub(crate) fn at(&mut self, t: T, pose: &Pose<T>) {
        for i in 0..3 {
            self.from[i] = add_scaled(self.from[i], T::ONE - t, pose[i]);
            self.to[i] = add_scaled(self.to[i], t, pose[i]);
        }
    }

    /// Adjoint of a point's position, by the poses.
    #[inline(always)]
    pub(crate) fn point(&mut self, t: T, o: Quad<T>, x_bar: Quad<T>) {
        add_outer(&mut self.from, scale(x_bar, T::ONE - t), o);
        add_outer(&mut self.to, scale(x_bar, t), o);
    }

    /// Adjoint of [`BodyFrame::velocity`], by the poses.
    #[inline(always)]
    pub(crate) fn velocity(&mut self, body: &BodyFrame<T>, o: Quad<T>, v_bar: Quad<T>) {
        let v_bar = scale(v_bar, body.rate);
        add_outer(&mut self.to, v_bar, o);
        add_outer(&mut self.from, scale(v_bar, -T::ONE), o);
    }
}
