//! Distances of an object's points to their targets, the points being nodes or skin.

use std::cell::OnceCell;

use bendtwin_core::Point;

use super::{Moment, mean_over, nearest::nearest};
use crate::{
    cpu::arithmetic::{Node, Quad, Real, add_scaled, dot, quad, scale, sub},
    objective::{PointLoss, PointSet},
};

/// The points at a frame; those of the skin are placed when a term asks for the first of them.
pub(super) struct Points<'a, T> {
    moment: Moment<'a, T>,
    skin: OnceCell<Vec<Node<T>>>,
}

impl<'a, T: Real> Points<'a, T> {
    pub(super) fn new(moment: Moment<'a, T>) -> Self {
        Self { moment, skin: OnceCell::new() }
    }

    /// All points of a set.
    pub(super) fn all(&self, of: PointSet) -> &[Node<T>] {
        match of {
            PointSet::Nodes => self.moment.now,
            PointSet::Skin => self.skin.get_or_init(|| {
                let skin = &self.moment.system.skin;
                let place = |m| {
                    let [x, y, z] = skin.position(m, self.node()).map(T::from_f64);
                    Node { x: [x, y, z, T::ZERO], v: [T::ZERO; 4] }
                };
                (0..skin.len()).map(place).collect()
            }),
        }
    }

    fn surface(&self, of: PointSet) -> &[Node<T>] {
        match of {
            PointSet::Nodes => &self.moment.now[..self.moment.system.surface],
            PointSet::Skin => self.all(of),
        }
    }

    /// Positions of nodes in double precision.
    fn node(&self) -> impl Fn(u32) -> [f64; 3] + Copy {
        let nodes = self.moment.now;
        move |i| {
            let [x, y, z, _] = nodes[i as usize].x;
            [x.to_f64(), y.to_f64(), z.to_f64()]
        }
    }

    /// The nearest point of the surface for each target, and the way to it from there [m]; none
    /// without a surface.
    pub(super) fn to_nearest(
        &self,
        of: PointSet,
        targets: &[Point],
    ) -> impl ExactSizeIterator<Item = (u32, Quad<T>)> {
        let surface = self.surface(of);
        let targets: Vec<Quad<T>> = targets.iter().map(|&p| quad(p)).collect();
        let found = nearest(surface, &targets);
        targets.into_iter().zip(found).map(move |(t, i)| (i, sub(surface[i as usize].x, t)))
    }

    /// Mean squared distance of targets to the nearest point of the surface.
    pub(super) fn chamfer(&self, of: PointSet, targets: &[Point]) -> f64 {
        let squares = self.to_nearest(of, targets).map(|(_, d)| dot(d, d).to_f64());
        squares.sum::<f64>() * mean_over(targets.len())
    }

    /// Mean loss of points and their targets.
    pub(super) fn track(
        &self,
        of: PointSet,
        points: &[u32],
        targets: &[Point],
        loss: PointLoss,
    ) -> f64 {
        let all = self.all(of);
        let each = points.iter().zip(targets).map(|(&i, &t)| {
            let d = sub(all[i as usize].x, quad(t));
            let square = dot(d, d).to_f64();
            match loss {
                PointLoss::SmoothL1 { beta_m } => smooth_l1(d, beta_m),
                PointLoss::Distance => square.sqrt(),
                PointLoss::SquaredDistance => square,
            }
        });
        each.sum::<f64>() * mean_over(points.len())
    }

    pub(super) fn add_chamfer_gradient(
        &self,
        of: PointSet,
        targets: &[Point],
        weight: f64,
        bar: &mut [Node<T>],
    ) {
        let w = T::from_f64(2.0 * weight * mean_over(targets.len()));
        let of_target = self.to_nearest(of, targets).map(|(i, d)| (i, scale(d, w)));
        self.add_point_bars(of, of_target, bar);
    }

    pub(super) fn add_track_gradient(
        &self,
        of: PointSet,
        points: &[u32],
        targets: &[Point],
        loss: PointLoss,
        weight: f64,
        bar: &mut [Node<T>],
    ) {
        let all = self.all(of);
        let w = T::from_f64(weight * mean_over(points.len()));
        let of_point = points.iter().zip(targets).map(|(&i, &t)| {
            let d = sub(all[i as usize].x, quad(t));
            (i, scale(point_gradient(loss, d), w))
        });
        self.add_point_bars(of, of_point, bar);
    }

    /// Adds d loss / d positions of points to those of nodes.
    pub(super) fn add_point_bars(
        &self,
        of: PointSet,
        point_bars: impl Iterator<Item = (u32, Quad<T>)>,
        bar: &mut [Node<T>],
    ) {
        let skin = &self.moment.system.skin;
        for (i, point_bar) in point_bars {
            match of {
                PointSet::Nodes => {
                    let to = &mut bar[i as usize].x;
                    *to = add_scaled(*to, T::ONE, point_bar);
                }
                PointSet::Skin => {
                    let [x, y, z, _] = point_bar;
                    let wide = [x.to_f64(), y.to_f64(), z.to_f64()];
                    skin.add_gradient(i as usize, self.node(), wide, |node, b| {
                        let to = &mut bar[node as usize].x;
                        let [x, y, z] = b.map(T::from_f64);
                        *to = add_scaled(*to, T::ONE, [x, y, z, T::ZERO]);
                    });
                }
            }
        }
    }
}

fn smooth_l1<T: Real>(d: Quad<T>, beta_m: f32) -> f64 {
    let beta = f64::from(beta_m);
    let each = d[..3].iter().map(|x| {
        let x = x.to_f64().abs();
        if x < beta { x * x / (2.0 * beta) } else { x - beta / 2.0 }
    });
    each.sum::<f64>() / 3.0
}

fn point_gradient<T: Real>(loss: PointLoss, d: Quad<T>) -> Quad<T> {
    match loss {
        PointLoss::SmoothL1 { beta_m } => {
            let beta = f64::from(beta_m);
            d.map(|x| {
                let x = x.to_f64();
                let slope = if x.abs() < beta {
                    x / beta
                } else if x == 0.0 {
                    0.0
                } else {
                    x.signum()
                };
                T::from_f64(slope / 3.0)
            })
        }
        PointLoss::Distance => {
            let length = dot(d, d).sqrt();
            if length > T::ZERO { scale(d, T::ONE / length) } else { [T::ZERO; 4] }
        }
        PointLoss::SquaredDistance => scale(d, T::from_f64(2.0)),
    }
}
