//! A hand without tracks, because it has no texture or no tracker was run on it: its motion from
//! its shape alone.
//!
//! The points of the hand that all cameras see in the first frame are the template. Each later
//! frame's points are brought onto it by iterated closest points, to the planes of the template
//! (Chen and Medioni, 1992), robustly, from where the motion so far leads. Turns that the shape
//! does not determine, of a ball say, are damped.

use bendtwin_core::{Finding, Severity};
use bendtwin_core::{Point, settings::ingest::ControlSettings};
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};

use super::{
    Controls, MIN_TRACKS,
    body::fill,
    by_frame,
    contact::{Contact, holding},
    dealt, long_gap,
};
use crate::{
    Error,
    evidence::HandEvidence,
    grid::Grid,
    rigid::{Rigid, vector},
    thin::spread,
};

/// Spacing of the template [m].
const SPACING_M: f64 = 0.003;
/// Distance within which neighbours determine a normal [m].
const NORMAL_RADIUS_M: f64 = 0.01;
/// Distance from the template beyond which a point is no part of the hand [m].
const MAX_DISTANCE_M: f64 = 0.02;
/// Distances below this are noise [m].
const NOISE_M: f64 = 0.002;
/// Least points of a hand, in the template and in a frame.
const MIN_POINTS: usize = 20;
/// Most points of a frame that are used.
const MAX_POINTS: usize = 600;
/// Gauss-Newton steps, each with new correspondences.
const ITERATIONS: usize = 20;
/// Stiffness against rotation, as a share of what the shape could determine at best.
const ROTATION_STIFFNESS: f64 = 0.02;
/// Weight of distances along the surface, beside those across it.
const TANGENTIAL_WEIGHT: f64 = 0.02;

/// Control points from what cameras see of hands: their points in every frame [m].
pub(crate) fn controls(
    clouds: &[Vec<Point>],
    tracks: usize,
    contact: &Contact,
    settings: &ControlSettings,
) -> Result<Controls, Error> {
    let templates = templates(clouds.first().map_or(&[], Vec::as_slice), settings);
    if templates.is_empty() {
        return Err(Error::NoHandTracks { tracks, needed: MIN_TRACKS });
    }
    let motions = follow(&templates, clouds);
    let (mut columns, mut hands) = (Vec::new(), Vec::new());
    let (mut longest_gap, mut gaps) = (0, Vec::new());
    for (hand, (template, motion)) in templates.iter().zip(motions).enumerate() {
        let filled_frames = motion.poses.iter().filter(|p| p.is_none()).count();
        let Some((poses, gap)) = fill(motion.poses, &template.points) else {
            return Err(Error::NoHandTracks { tracks, needed: MIN_TRACKS });
        };
        longest_gap = longest_gap.max(gap);
        gaps.extend(long_gap(hand, gap, settings));
        let wanted = dealt(settings, hand, templates.len());
        let (picked, distances_m) = contact.choose(&template.points, wanted);
        let mut residuals = motion.residuals_m;
        residuals.sort_by(f64::total_cmp);
        let at = |share: usize| residuals.get(residuals.len() * share / 100).copied();
        hands.push(HandEvidence {
            controls: picked.len(),
            holding: holding(&distances_m),
            residual_m: at(50).unwrap_or(0.0),
            residual_p95_m: at(95).unwrap_or(0.0),
            rigid: true,
            by_shape: true,
            filled_frames,
            ..HandEvidence::default()
        });
        let trajectory = |i: usize| poses.iter().map(|p| p.apply(template.points[i])).collect();
        columns.extend(picked.into_iter().map(trajectory).collect::<Vec<Vec<Point>>>());
    }
    let points = by_frame(&columns, clouds.len());
    let by_shape = Finding::from_sentence(
        Severity::Info,
        "HAND_FOLLOWED_BY_SHAPE",
        format!(
            "{tracks} tracks lie on the hand, too few: its motion is taken from its shape in the depth images, which does not \
             tell every turn; tracks on the hand would"
        ),
    );
    let findings = std::iter::once(by_shape).chain(gaps).collect();
    Ok(Controls { points, hands, longest_gap, findings })
}

/// A hand's surface in the first frame.
struct Template {
    points: Vec<Point>,
    normals: Vec<Vector3<f64>>,
    grid: Grid,
    middle: Vector3<f64>,
    /// Root mean square distance from the middle [m].
    size_m: f64,
}

/// A hand's motion from the template, and how far its points are from that [m].
struct Motion {
    poses: Vec<Option<Rigid>>,
    residuals_m: Vec<f64>,
}

/// The hands in a cloud, the largest first.
fn templates(cloud: &[Point], settings: &ControlSettings) -> Vec<Template> {
    let thinned = spread(&mut Grid::new(SPACING_M), cloud.iter().copied().enumerate(), SPACING_M);
    let points: Vec<Point> = thinned.into_iter().map(|i| cloud[i]).collect();
    // Half the gap that tracks may have: a surface has none.
    let reach = settings.hand_gap_m / 2.0;
    let grid = Grid::of(points.iter().copied(), reach);
    let mut group_of = vec![usize::MAX; points.len()];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for seed in 0..points.len() {
        if group_of[seed] != usize::MAX {
            continue;
        }
        group_of[seed] = groups.len();
        let mut group = vec![seed];
        let mut next = 0;
        while let Some(&i) = group.get(next) {
            next += 1;
            for (_, j) in grid.within(points[i], reach) {
                if group_of[j] == usize::MAX {
                    group_of[j] = groups.len();
                    group.push(j);
                }
            }
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups.sort_by_key(|g| (std::cmp::Reverse(g.len()), g[0]));
    let largest = groups.first().map_or(0, Vec::len);
    groups.retain(|g| g.len() >= MIN_POINTS && 10 * g.len() >= largest);
    groups.truncate(settings.max_hands as usize);
    groups
        .into_iter()
        .filter_map(|g| Template::of(g.iter().map(|i| points[*i]).collect()))
        .collect()
}

impl Template {
    fn of(all: Vec<Point>) -> Option<Self> {
        let near = Grid::of(all.iter().copied(), NORMAL_RADIUS_M);
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for p in &all {
            let around: Vec<Point> =
                near.within(*p, NORMAL_RADIUS_M).map(|(_, i)| all[i]).collect();
            if let Some(normal) = normal(&around) {
                points.push(*p);
                normals.push(normal);
            }
        }
        if points.len() < MIN_POINTS {
            return None;
        }
        let middle = points.iter().map(|p| vector(*p)).sum::<Vector3<f64>>() / points.len() as f64;
        let squares = points.iter().map(|p| (vector(*p) - middle).norm_squared());
        let size_m = (squares.sum::<f64>() / points.len() as f64).sqrt();
        let grid = Grid::of(points.iter().copied(), MAX_DISTANCE_M / 2.0);
        Some(Self { points, normals, grid, middle, size_m })
    }

    /// The motion from the template to a frame's points, from a guess; and the points' distances.
    fn pose(&self, cloud: &[Point], guess: &Rigid) -> Option<(Rigid, Vec<f64>)> {
        let mut back = guess.inverse();
        let mut distances = Vec::new();
        for _ in 0..ITERATIONS {
            let pairs: Vec<(Vector3<f64>, usize)> = cloud
                .iter()
                .filter_map(|p| {
                    let at = back.apply(*p);
                    Some((vector(at), self.grid.closest(at, MAX_DISTANCE_M)?))
                })
                .collect();
            // What is far from the guess is not this hand, but then most of it must be.
            if pairs.len() < MIN_POINTS || 3 * pairs.len() < cloud.len() {
                return None;
            }
            let residual = |(at, i): &(Vector3<f64>, usize)| {
                self.normals[*i].dot(&(at - vector(self.points[*i])))
            };
            distances = pairs.iter().map(|p| residual(p).abs()).collect();
            let mut sorted = distances.clone();
            let middle = sorted.len() / 2;
            let scale = (*sorted.select_nth_unstable_by(middle, f64::total_cmp).1).max(NOISE_M);
            let mut normal = Matrix6::zeros();
            let mut right = Vector6::zeros();
            for (pair, distance) in pairs.iter().zip(&distances) {
                let u = distance / (3.0 * scale);
                let weight = if u < 1.0 { (1.0 - u * u).powi(2) } else { continue };
                let n = self.normals[pair.1];
                let turn = (pair.0 - self.middle).cross(&n);
                let row = Vector6::new(turn.x, turn.y, turn.z, n.x, n.y, n.z);
                normal += row * row.transpose() * weight;
                right -= row * (weight * residual(pair));
                // At the outline the nearest point lies to the side: the only hint at motions along
                // the surface.
                let aside = pair.0 - vector(self.points[pair.1]);
                let arm = pair.0 - self.middle;
                for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                    let turn = arm.cross(&axis);
                    let row = Vector6::new(turn.x, turn.y, turn.z, axis.x, axis.y, axis.z);
                    normal += row * row.transpose() * (TANGENTIAL_WEIGHT * weight);
                    right -= row * (TANGENTIAL_WEIGHT * weight * aside.dot(&axis));
                }
            }
            let count = pairs.len() as f64;
            for i in 0..3 {
                normal[(i, i)] += ROTATION_STIFFNESS * count * self.size_m * self.size_m;
                normal[(i + 3, i + 3)] += 1e-6 * count;
            }
            let step = normal.cholesky()?.solve(&right);
            let turn = Rotation3::from_scaled_axis(Vector3::new(step[0], step[1], step[2]));
            let shift = Vector3::new(step[3], step[4], step[5]);
            // A small motion about the middle, after what there is.
            let rotation: Matrix3<f64> = *turn.matrix();
            back = Rigid {
                rotation: rotation * back.rotation,
                translation: rotation * (back.translation - self.middle) + self.middle + shift,
            };
            if step.norm() < 1e-7 {
                break;
            }
        }
        let pose = back.inverse();
        pose.translation.iter().all(|x| x.is_finite()).then_some((pose, distances))
    }
}

/// The direction in which points spread least.
fn normal(points: &[Point]) -> Option<Vector3<f64>> {
    if points.len() < 5 {
        return None;
    }
    let middle = points.iter().map(|p| vector(*p)).sum::<Vector3<f64>>() / points.len() as f64;
    let mut spread = Matrix3::zeros();
    for p in points {
        let d = vector(*p) - middle;
        spread += d * d.transpose();
    }
    let eigen = spread.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    Some(eigen.eigenvectors.column(least).into_owned())
}

/// Follows all hands through all frames.
fn follow(templates: &[Template], clouds: &[Vec<Point>]) -> Vec<Motion> {
    let still = Rigid { rotation: Matrix3::identity(), translation: Vector3::zeros() };
    templates
        .iter()
        .map(|template| {
            let mut poses: Vec<Option<Rigid>> = Vec::new();
            let mut residuals_m = Vec::new();
            let (mut last, mut speed) = (still, Vector3::zeros());
            for cloud in clouds {
                let guess = Rigid { translation: last.translation + speed, ..last };
                let own = points_of_hand(templates, template, cloud, &guess);
                // After a halt the guess from its speed is the worse one.
                let found = template.pose(&own, &guess).or_else(|| template.pose(&own, &last));
                let pose = found.map(|(pose, distances)| {
                    residuals_m.extend(distances);
                    pose
                });
                if let Some(pose) = pose {
                    // The middle's step: a turn must not count as one.
                    let at = |m: &Rigid| m.rotation * template.middle + m.translation;
                    speed = if poses.last().is_some_and(Option::is_some) {
                        at(&pose) - at(&last)
                    } else {
                        Vector3::zeros()
                    };
                    last = pose;
                } else {
                    speed = Vector3::zeros();
                }
                poses.push(pose);
            }
            Motion { poses, residuals_m }
        })
        .collect()
}

/// A frame's points that may be this hand's: all if there is one hand, else those near it.
fn points_of_hand(
    templates: &[Template],
    template: &Template,
    cloud: &[Point],
    guess: &Rigid,
) -> Vec<Point> {
    let back = guess.inverse();
    let near = |p: &Point| {
        templates.len() == 1 || template.grid.closest(back.apply(*p), MAX_DISTANCE_M).is_some()
    };
    let own: Vec<Point> = cloud.iter().copied().filter(near).collect();
    let stride = own.len().div_ceil(MAX_POINTS).max(1);
    own.into_iter().step_by(stride).collect()
}

#[cfg(test)]
mod tests;
