//! The rigid motion that brings a shape to an observation: of tracks a robust fit; of a cloud the
//! iterated nearest points (ICP) from many rotations, on the share of points that agree best.

use bendtwin_core::{
    CancelToken, Point,
    geometry::{Alignment, Kabsch, Pair, Prior, RigidMotion, RobustRule, kabsch, point, vector3},
};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::{Error, surface::Surface};

/// Points in a first attempt, and in a fine one.
const COARSE: usize = 150;
const FINE: usize = 1500;
/// Iterations of a first attempt, and of a fine one.
const COARSE_ROUNDS: usize = 15;
const FINE_ROUNDS: usize = 25;
/// Turns about the vertical that are tried, upright and upside down.
const TURNS: usize = 12;
/// Share of the points that have to agree.
const AGREEING: f64 = 0.85;
/// Motions that are handed on.
const KEPT: usize = 4;
/// Deviation of points below which a rotation that they leave open is kept [m].
const OPEN_M: f64 = 1e-3;

/// A shape and the points that it is brought to.
pub(crate) struct Target<'a> {
    /// The shape's surface.
    pub(crate) surface: &'a Surface,
    /// Points of the shape [m].
    pub(crate) skin: &'a [Vector3<f64>],
    /// Observed points [m].
    pub(crate) points: &'a [Point],
    /// Points of the shape whose positions are known beside the observation.
    pub(crate) known: &'a [Pair],
    /// Upward direction.
    pub(crate) up: Vector3<f64>,
}

/// The motion of tracks: pairs of places on the shape and observed points.
pub(crate) fn of_tracks(pairs: &[Pair], noise_m: f64) -> Option<RigidMotion> {
    let prior = Some(Prior { rotation: Matrix3::identity(), deviation_m: OPEN_M });
    let options = Kabsch { prior, ..Kabsch::default() };
    let rule = RobustRule {
        rounds: 10,
        least_width_m: 6.0 * noise_m,
        first_width: 3.0,
        least_agreeing: 1,
        fits_last: true,
        about_origin: false,
        kabsch: options,
    };
    let start = rule.start(pairs)?;
    Some(rule.fit(pairs, start).map_or(start, |fit| fit.motion).motion())
}

impl Target<'_> {
    /// The best motions of a cloud, the best first, none like another.
    pub(crate) fn motions(&self, cancel: &CancelToken) -> Result<Vec<RigidMotion>, Error> {
        let middle = |points: &mut dyn Iterator<Item = Vector3<f64>>| {
            let (sum, n) = points.fold((Vector3::zeros(), 0), |(s, n), p| (s + p, n + 1));
            sum / f64::from(n.max(1))
        };
        let from = middle(&mut self.skin.iter().copied());
        let to = middle(&mut self.points.iter().map(|p| vector3(*p)));
        let mut found: Vec<(f64, RigidMotion)> = Vec::new();
        for rotation in self.starts(from, to) {
            let start = RigidMotion { rotation, translation: to - rotation * from };
            let points = thinned(self.points, COARSE);
            found.extend(self.iterate(start, &points, COARSE_ROUNDS, false, cancel)?);
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut kept: Vec<(f64, RigidMotion)> = Vec::new();
        for (_, motion) in found {
            let turned = |k: &(f64, RigidMotion)| (k.1.rotation - motion.rotation).norm() < 0.3;
            if kept.len() < KEPT && !kept.iter().any(turned) {
                let points = thinned(self.points, FINE);
                kept.extend(self.iterate(motion, &points, FINE_ROUNDS, true, cancel)?);
            }
        }
        kept.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(kept.into_iter().map(|(_, motion)| motion).collect())
    }

    /// Rotations to start from: none, a turn about the vertical, upside down, and principal axes
    /// onto principal axes.
    fn starts(&self, from: Vector3<f64>, to: Vector3<f64>) -> Vec<Matrix3<f64>> {
        let any = if self.up.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let side = nalgebra::Unit::new_normalize(self.up.cross(&any));
        let up = nalgebra::Unit::new_normalize(self.up);
        let over = Rotation3::from_axis_angle(&side, std::f64::consts::PI);
        let mut starts = Vec::new();
        for i in 0..TURNS {
            let angle = std::f64::consts::TAU * i as f64 / TURNS as f64;
            let turn = Rotation3::from_axis_angle(&up, angle);
            starts.extend([*turn.matrix(), *(turn * over).matrix()]);
        }
        let mut skin = self.skin.iter().map(|p| p - from);
        let mut points = self.points.iter().map(|p| vector3(*p) - to);
        if let (Some(a), Some(b)) = (axes(&mut skin), axes(&mut points)) {
            for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
                let flip = Vector3::new(signs[0], signs[1], signs[0] * signs[1]);
                starts.push(b * Matrix3::from_diagonal(&flip) * a.transpose());
            }
        }
        starts
    }

    /// Nearest points and their motion in turn; the mean square of the distances that agree [m²].
    fn iterate(
        &self,
        start: RigidMotion,
        points: &[Point],
        rounds: usize,
        fine: bool,
        cancel: &CancelToken,
    ) -> Result<Option<(f64, RigidMotion)>, Error> {
        let agreeing = ((AGREEING * points.len() as f64).ceil() as usize).clamp(1, points.len());
        let each = agreeing as f64 / self.known.len().max(1) as f64;
        let mut motion = start;
        let mut score = f64::INFINITY;
        for _ in 0..rounds {
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let back = motion.inverse();
            let mut pairs: Vec<(f64, Pair)> = points
                .iter()
                .map(|y| {
                    let p = back.apply(*y);
                    let (before, distance_m) = match fine {
                        true => {
                            let foot = self.surface.foot(p);
                            let place = foot.corners().map(|(p, w)| self.skin[p] * w).sum();
                            (place, foot.distance_m)
                        }
                        false => {
                            let (nearest, distance_m) = self.surface.nearest(p);
                            (self.skin[nearest as usize], distance_m)
                        }
                    };
                    (distance_m, Pair { before: point(before), after: *y, weight: 1.0 })
                })
                .collect();
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            pairs.truncate(agreeing);
            let mut square = pairs.iter().map(|(d, _)| d * d).sum::<f64>();
            let mut pairs: Vec<Pair> = pairs.into_iter().map(|(_, pair)| pair).collect();
            for pair in self.known {
                let gap = vector3(motion.apply(pair.before)) - vector3(pair.after);
                square += each * gap.norm_squared();
                pairs.push(Pair { weight: each, ..*pair });
            }
            let last = score;
            score = square / agreeing as f64;
            let weights: Vec<f64> = pairs.iter().map(|p| p.weight).collect();
            let prior = Some(Prior { rotation: motion.rotation, deviation_m: OPEN_M });
            let fit = kabsch(&pairs, &weights, &Kabsch { prior, ..Kabsch::default() });
            let Some(fit): Option<Alignment> = fit else { return Ok(None) };
            motion = fit.motion();
            if (last - score).abs() <= 1e-4 * score {
                break;
            }
        }
        Ok(score.is_finite().then_some((score, motion)))
    }
}

/// Principal axes as columns, right-handed.
fn axes(points: &mut dyn Iterator<Item = Vector3<f64>>) -> Option<Matrix3<f64>> {
    let covariance: Matrix3<f64> = points.map(|p| p * p.transpose()).sum();
    let svd = covariance.try_svd(true, false, 1e-12, 100)?;
    let mut u = svd.u?;
    if u.determinant() < 0.0 {
        let last = -u.column(2);
        u.set_column(2, &last);
    }
    u.iter().all(|x| x.is_finite()).then_some(u)
}

/// At most `most` of the points, evenly chosen.
pub(crate) fn thinned<T: Copy>(points: &[T], most: usize) -> Vec<T> {
    let stride = points.len().div_ceil(most).max(1);
    points.iter().copied().step_by(stride).collect()
}

#[cfg(test)]
mod tests;
