//! The report of a twin on the recordings that it was fitted to.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Capture, Identifiability, Skin, Twin,
    geometry::point_distance,
    identifiability::{Certainty, Group, MotionUncertainty, NextRecording, Quantity},
};
use bendtwin_engine::{Backend, fidelity::Reduction};
use bendtwin_eval::Error;
use nalgebra::DMatrix;

use crate::{
    Regions,
    candidates::{Candidate, candidates},
    directions::{Direction, directions, prior_sd},
    motions::{Hold, scene},
    noise::Noise,
    posterior::{Query, covariance, information},
    recorded::{SequenceRecords, failed, recorded},
    response::{Sample, Variation},
    words,
};

/// Points of the skin that are asked about, spread evenly; the others have the number of the nearest.
const MOST_POINTS: usize = 1000;
/// Records of a standard motion.
const RECORDS: usize = 6;

/// The identifiability of a twin by the recordings of a capture that it was fitted to; none if it has no
/// training frames, or the twin diverges in all of them.
///
/// # Errors
/// If the twin does not fit the capture, on cancellation, or if the backend fails.
pub fn identify(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    cancel: &CancelToken,
) -> Result<Option<Identifiability>, Error> {
    Ok(identify_by_motion(backend, twin, capture, cancel)?.map(|(report, _)| report))
}

/// A report, and the standard deviation of each skin point in each of its motions [m], shape
/// [motions, M].
pub type ByMotion = (Identifiability, Vec<Vec<f32>>);

/// [`identify`] with the standard deviation of each skin point in each of the report's motions [m],
/// shape [motions, M].
///
/// # Errors
/// Those of [`identify`].
pub fn identify_by_motion(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    cancel: &CancelToken,
) -> Result<Option<ByMotion>, Error> {
    if twin.skin.is_empty() || twin.graph.springs.is_empty() {
        return Ok(None);
    }
    let regions = Regions::of(twin);
    let asking = Question {
        backend,
        twin,
        directions: directions(twin, &regions),
        points: Points::of(&twin.skin),
        regions,
        cancel,
    };
    asking.report(capture)
}

/// Points of a skin that are asked about.
struct Points {
    skin: Arc<Skin>,
    /// Nearest evaluated point for each point of the skin.
    nearest: Vec<usize>,
}

impl Points {
    fn of(skin: &Skin) -> Self {
        let stride = skin.len().div_ceil(MOST_POINTS).max(1);
        let asked: Vec<usize> = (0..skin.len()).step_by(stride).collect();
        Self { skin: Arc::new(skin.select(&asked)), nearest: Vec::new() }
    }

    /// Standard deviations of all points of a skin from the variances of the points that are asked about.
    fn deviations(&mut self, twin: &Twin, variances: &[f64]) -> Vec<f32> {
        let rest = &twin.graph.rest_positions;
        let (all, asked) = (twin.skin.positions(rest), self.skin.positions(rest));
        if self.nearest.is_empty() {
            let nearest = |p| {
                let apart = asked.iter().map(|a| point_distance(*a, p)).enumerate();
                apart.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
            };
            self.nearest = all.into_iter().map(nearest).collect();
        }
        let value = |i: &usize| variances.get(*i).map_or(0.0, |v| v.max(0.0).sqrt() as f32);
        self.nearest.iter().map(value).collect()
    }
}

/// A twin that is asked about.
struct Question<'a> {
    backend: &'a dyn Backend,
    twin: &'a Twin,
    regions: Regions,
    directions: Vec<Direction>,
    points: Points,
    cancel: &'a CancelToken,
}

/// Information of the recordings.
struct Learnt {
    information: DMatrix<f64>,
    /// Columns of the frames after the training frames; empty without such frames.
    future: Vec<Vec<f32>>,
    /// Residuals of the recordings, with their training frames.
    noises: Vec<(Noise, usize)>,
    observations: f64,
}

impl Question<'_> {
    fn report(mut self, capture: &Capture) -> Result<Option<ByMotion>, Error> {
        let recordings = recorded(self.backend, self.twin, capture, self.cancel)?;
        let Some(learnt) = self.learn(&recordings)? else { return Ok(None) };
        let before = DMatrix::identity(self.directions.len(), self.directions.len());
        let after = covariance(&learnt.information);
        let groups: Vec<Group> = self
            .directions
            .iter()
            .enumerate()
            .map(|(d, direction)| {
                let relative_sd = after[(d, d)].max(0.0).sqrt().min(1.0);
                Group {
                    quantity: direction.quantity,
                    region: direction.region.map(|r| r as u32),
                    hand: direction.hand,
                    prior_sd: prior_sd(direction.quantity),
                    relative_sd,
                    certainty: Certainty::of(relative_sd),
                }
            })
            .collect();
        let candidates = candidates(self.twin, &self.regions, most_open(&groups));
        let mut asked: Vec<(&str, Query)> = Vec::new();
        if learnt.future.first().is_some_and(|column| !column.is_empty()) {
            asked.push(("future", Query::new(&learnt.future)));
        }
        let mut tried: Vec<(&Candidate, DMatrix<f64>)> = Vec::new();
        let noise = learnt.noises.first().map(|(noise, frames)| (*noise, *frames));
        for candidate in &candidates {
            let Some(columns) = self.motion(candidate)? else { continue };
            if let Some((noise, frames)) = noise {
                let points = self.points.skin.len();
                let samples = columns.first().map_or(0, Vec::len) / (3 * points).max(1);
                let weight = noise.weight(frames, samples, points);
                tried.push((candidate, information(&columns, &[], weight)));
            }
            if candidate.is_asked {
                asked.push((candidate.name, Query::new(&columns)));
            }
        }
        let points = self.points.skin.len();
        let mut by_motion: Vec<Vec<f64>> = Vec::with_capacity(asked.len());
        let mut motions = Vec::with_capacity(asked.len());
        for (name, query) in &asked {
            let variances = query.variances(&after);
            by_motion.push(mean_by_point(&variances, points));
            motions.push(MotionUncertainty {
                motion: (*name).to_owned(),
                sd_m: mean_root(&variances),
                prior_sd_m: mean_root(&query.variances(&before)),
                shares: query.shares(&after),
            });
        }
        let over_motions: Vec<f64> = (0..points)
            .map(|p| by_motion.iter().map(|m| m[p]).sum::<f64>() / by_motion.len().max(1) as f64)
            .collect();
        let next = self.next(&learnt, &asked, &motions, &tried, &after);
        let noise_m = noise.map_or(0.0, |(noise, _)| noise.sd_m);
        let of_future = motions.first().filter(|m| m.motion == "future");
        let expected_error_m = of_future.map(|m| (3.0 * noise_m * noise_m + m.sd_m.powi(2)).sqrt());
        let mut report = Identifiability {
            summary: Vec::new(),
            regions: self.regions.parts.clone(),
            groups,
            motions,
            next,
            noise_m,
            observations: learnt.observations,
            expected_error_m,
            node_regions: self.regions.of_nodes.clone(),
            point_sd_m: self.points.deviations(self.twin, &over_motions),
        };
        report.summary = words::summary(&report);
        let of_motions =
            by_motion.iter().map(|variances| self.points.deviations(self.twin, variances));
        let of_motions = of_motions.collect();
        Ok(Some((report, of_motions)).filter(|(report, _)| is_finite(report)))
    }

    /// Information of the recordings about the directions; none without training frames.
    fn learn(&self, recordings: &[SequenceRecords]) -> Result<Option<Learnt>, Error> {
        let count = self.directions.len();
        let mut learnt = Learnt {
            information: DMatrix::zeros(count, count),
            future: vec![Vec::new(); count],
            noises: Vec::new(),
            observations: 0.0,
        };
        for recorded in recordings {
            let own: Vec<usize> =
                (0..count).filter(|&d| recorded.has(&self.directions[d])).collect();
            let shared = own.iter().map(|&d| Variation::Along(self.directions[d]));
            let variations: Vec<Variation> = shared.chain(recorded.nuisances()).collect();
            let after = recorded.future.iter();
            let after = after.map(|&frame| Sample { frame, skin: self.points.skin.clone() });
            let samples: Vec<Sample> = recorded.training.iter().cloned().chain(after).collect();
            let response = recorded
                .scene
                .respond(
                    self.backend,
                    &self.regions.of_nodes,
                    &variations,
                    &samples,
                    recorded.every,
                    self.cancel,
                )
                .map_err(failed)?;
            let Some(response) = response else { continue };
            let observed = 3 * recorded.training.iter().map(|s| s.skin.len()).sum::<usize>();
            let zero = vec![0.0; response.columns.first().map_or(0, Vec::len)];
            let (shared, nuisances) =
                response.columns.split_at(own.len().min(response.columns.len()));
            let column = |d: usize| {
                own.iter().position(|o| *o == d).and_then(|at| shared.get(at)).unwrap_or(&zero)
            };
            for (d, future) in learnt.future.iter_mut().enumerate() {
                future.extend_from_slice(&column(d)[observed..]);
            }
            let Some(noise) = recorded.noise.filter(|_| observed > 0) else { continue };
            let weight =
                noise.weight(recorded.training_frames, recorded.training.len(), recorded.tracked);
            let first = |column: &Vec<f32>| column[..observed].to_vec();
            let shared: Vec<Vec<f32>> = (0..count).map(|d| first(column(d))).collect();
            let nuisances: Vec<Vec<f32>> = nuisances.iter().map(first).collect();
            learnt.information += information(&shared, &nuisances, weight) * recorded.stands_for;
            learnt.observations +=
                recorded.stands_for * noise.observations(recorded.training_frames);
            learnt.noises.push((noise, recorded.training_frames));
        }
        Ok((!learnt.noises.is_empty()).then_some(learnt))
    }

    /// Responses of the points that are asked about in a motion; none if it diverges, or a backend
    /// cannot hold the object so.
    fn motion(&self, candidate: &Candidate) -> Result<Option<Vec<Vec<f32>>>, Error> {
        let reduction = self.twin.quality.fast.as_ref().map(Reduction::from);
        let scene = scene(self.twin, &self.regions, reduction, candidate.hold, candidate.act);
        let every = (scene.frames / RECORDS).max(1);
        let frames = (every..=scene.frames).step_by(every);
        let samples: Vec<Sample> =
            frames.map(|frame| Sample { frame, skin: self.points.skin.clone() }).collect();
        let is_open = |d: &Direction| candidate.hold != Hold::Own && d.quantity == Quantity::Grip;
        let has_part = |d: &Direction| {
            !is_open(d)
                && !matches!(d.quantity, Quantity::GroundFriction | Quantity::GroundRestitution)
        };
        let own: Vec<usize> =
            (0..self.directions.len()).filter(|&d| has_part(&self.directions[d])).collect();
        let variations: Vec<Variation> =
            own.iter().map(|&d| Variation::Along(self.directions[d])).collect();
        let of_nodes = &self.regions.of_nodes;
        let response = scene
            .respond(self.backend, of_nodes, &variations, &samples, every, self.cancel)
            .map_err(failed)?;
        let Some(response) = response else { return Ok(None) };
        let zero = vec![0.0; response.columns.first().map_or(0, Vec::len)];
        let mut columns = vec![zero; self.directions.len()];
        for (d, column) in own.into_iter().zip(response.columns) {
            columns[d] = column;
        }
        Ok(Some(columns))
    }

    /// Recordings by the uncertainty that they would leave, the most informative first.
    fn next(
        &self,
        learnt: &Learnt,
        asked: &[(&str, Query)],
        motions: &[MotionUncertainty],
        tried: &[(&Candidate, DMatrix<f64>)],
        now: &DMatrix<f64>,
    ) -> Vec<NextRecording> {
        let has_hands = self.twin.graph.control_count() > 0;
        let left = |(candidate, more): &(&Candidate, DMatrix<f64>)| {
            let then = covariance(&(&learnt.information + more));
            let of = |((_, query), motion): (&(&str, Query), &MotionUncertainty)| {
                let before = query.rms_m(now);
                if before > 0.0 { motion.sd_m * query.rms_m(&then) / before } else { 0.0 }
            };
            let sum: f64 = asked.iter().zip(motions).map(of).sum();
            NextRecording {
                motion: candidate.name.to_owned(),
                action: candidate.action(&self.regions, has_hands),
                sd_m: sum / asked.len().max(1) as f64,
            }
        };
        let mut next: Vec<NextRecording> = tried.iter().map(left).collect();
        next.sort_by(|a, b| a.sd_m.total_cmp(&b.sd_m));
        next
    }
}

/// Mean of the roots of variances.
fn mean_root(variances: &[f64]) -> f64 {
    variances.iter().map(|v| v.max(0.0).sqrt()).sum::<f64>() / variances.len().max(1) as f64
}

/// Mean over samples of the variance of each of `points` points, whose samples follow one another.
fn mean_by_point(variances: &[f64], points: usize) -> Vec<f64> {
    let mut means = vec![0.0; points];
    let samples = (variances.len() / points.max(1)).max(1) as f64;
    for row in variances.chunks(points.max(1)) {
        means.iter_mut().zip(row).for_each(|(mean, v)| *mean += v / samples);
    }
    means
}

/// True if all numbers of a report are finite: a file could not hold others.
fn is_finite(report: &Identifiability) -> bool {
    let groups = report.groups.iter().map(|g| g.relative_sd);
    let motions = report
        .motions
        .iter()
        .flat_map(|m| [m.sd_m, m.prior_sd_m].into_iter().chain(m.shares.iter().copied()));
    let next = report.next.iter().map(|n| n.sd_m);
    let whole = [report.noise_m, report.observations];
    let points = report.point_sd_m.iter().map(|x| f64::from(*x));
    groups.chain(motions).chain(next).chain(whole).chain(points).all(f64::is_finite)
}

/// The region whose stiffness the recordings leave most open.
fn most_open(groups: &[Group]) -> usize {
    let of = groups.iter().filter(|g| g.quantity == Quantity::Stiffness);
    let most = of.max_by(|a, b| a.relative_sd.total_cmp(&b.relative_sd));
    most.and_then(|g| g.region).unwrap_or_default() as usize
}

#[cfg(test)]
mod tests;
