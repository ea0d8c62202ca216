//! Choice and order of the points of a capture that become nodes.

use std::collections::{HashMap, HashSet};

use bendtwin_core::{
    Capture, Graph, NodeKind, Pin, Point, Sequence,
    capture::Object,
    settings::{GraphSettings, Sampling},
};
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::{
    Error, LeftOut, NodeSample, SurfacePoints,
    order::along_curve,
    spread::{farthest_points, mean_spacing},
};

/// Samples the nodes of a graph from a capture's first sequence at its start frame.
///
/// Tracked points, completed surface and (if `settings.interior`) interior
/// points are reduced to `settings.sampling_ratio` of their number, and to at
/// most `settings.max_nodes`, each kind in proportion, by farthest-point
/// sampling over all kinds together, or at random. Points that are pinned to a
/// control point are always kept, even beyond `max_nodes`. Of other points in one place only the first
/// counts. Nodes are ordered by kind and, within a kind, along a space-filling curve.
///
/// A capture with known edges (a cable) keeps all its tracked points, in their
/// own order, and nothing else.
///
/// # Errors
/// If an array of the capture has the wrong length, an index is out of range,
/// a point that is needed has no position at the start, or no point is left.
pub fn sample_nodes(
    capture: &Capture,
    settings: &GraphSettings,
    seed: u64,
) -> Result<NodeSample, Error> {
    let start = Start::of(capture)?;
    let object = &capture.object;
    let cable = !object.edges.is_empty();
    let mut left_out = LeftOut::default();
    let pool = if cable {
        start.cable(object)?
    } else {
        start.pool(capture, settings.interior.unwrap_or(true), &mut left_out)?
    };
    if pool.positions.is_empty() {
        return Err(Error::NoPoints {
            frame: start.frame,
            left_out: left_out.total(),
            points: object.point_count,
        });
    }
    let surface = pool.surface();
    let (pool, chosen) = if cable {
        let all = (0..pool.positions.len()).collect();
        (pool, all)
    } else {
        let pool = pool.distinct(object, &mut left_out);
        let chosen = pool.reduce(object, settings, seed);
        (pool, chosen)
    };
    let positions: Vec<Point> = chosen.iter().map(|&i| pool.positions[i]).collect();
    let point_spacing_m = mean_spacing(&pool.positions);
    let spacing_scale = if !settings.radius_scales || chosen.len() == pool.positions.len() {
        1.0
    } else {
        let scale = mean_spacing(&positions) / point_spacing_m;
        if scale.is_finite() { scale.max(1.0) } else { 1.0 }
    };
    let observed_points: Vec<u32> = chosen.iter().map(|&i| pool.observed(i)).collect();
    let pins = pins(object, &observed_points, &positions, start.controls);
    let rest_shape = (!object.rest_points.is_empty()).then(|| {
        chosen.iter().map(|&i| pool.tracked[i].map_or(pool.positions[i], |p| object.rest_points[p]))
    });
    Ok(NodeSample {
        kinds: chosen.iter().map(|&i| pool.kinds[i]).collect(),
        object_ids: vec![0; positions.len()],
        observed_points,
        control_rest: start.controls.to_vec(),
        pins,
        edges: cable.then(|| object.edges.clone()),
        rest_shape: rest_shape.map(Iterator::collect),
        point_spacing_m,
        spacing_scale,
        surface,
        left_out,
        positions,
    })
}

/// The first sequence at its start frame, with all shapes checked.
struct Start<'a> {
    frame: usize,
    points: &'a [Point],
    visible: &'a [bool],
    controls: &'a [Point],
}

impl<'a> Start<'a> {
    fn of(capture: &'a Capture) -> Result<Self, Error> {
        check_object(&capture.object)?;
        let Some(first) = capture.sequences.first() else {
            return Err(Error::Inconsistent("it has no sequence".into()));
        };
        let controls = first.control_count();
        for sequence in &capture.sequences {
            check_sequence(sequence, capture.object.point_count, controls)?;
        }
        let frame = first.start_frame();
        let start = Self {
            frame,
            points: first.points_at(frame),
            visible: first.visible_at(frame),
            controls: first.controls_at(frame),
        };
        if let Some(h) = capture.object.pins.iter().find(|h| h.control as usize >= controls) {
            return Err(Error::Inconsistent(format!(
                "point {} is held by control point {} of {controls}",
                h.point, h.control
            )));
        }
        match start.controls.iter().position(|p| !is_finite(p)) {
            Some(control) => Err(Error::ControlMissing { control, frame }),
            None => Ok(start),
        }
    }

    /// All tracked points of a cable.
    fn cable(&self, object: &Object) -> Result<Pool, Error> {
        let missing = |points: &[Point]| points.iter().position(|p| !is_finite(p));
        if let Some(point) = missing(self.points).or_else(|| missing(&object.rest_points)) {
            let why = "every point of a cable is a node";
            return Err(Error::PointMissing { point, frame: self.frame, why });
        }
        let mut pool = Pool::default();
        for (point, position) in self.points.iter().enumerate() {
            pool.push(*position, NodeKind::Observed, Some(point));
        }
        Ok(pool)
    }

    /// All points that may become nodes, by kind, along a space-filling curve.
    fn pool(
        &self,
        capture: &Capture,
        interior: bool,
        left_out: &mut LeftOut,
    ) -> Result<Pool, Error> {
        let object = &capture.object;
        let mut seen = vec![false; object.point_count];
        for sequence in &capture.sequences {
            for frame in 0..sequence.frame_count {
                seen.iter_mut().zip(sequence.visible_at(frame)).for_each(|(s, v)| *s |= v);
            }
        }
        let mut held = vec![false; object.point_count];
        object.pins.iter().for_each(|h| held[h.point as usize] = true);
        let has_rest = |p: usize| object.rest_points.get(p).is_none_or(is_finite);

        let mut tracked = Vec::new();
        for p in 0..object.point_count {
            if !is_finite(&self.points[p]) || !has_rest(p) {
                if held[p] {
                    let why = "a control point holds it";
                    return Err(Error::PointMissing { point: p, frame: self.frame, why });
                }
                left_out.not_finite += 1;
            } else if held[p] || self.visible[p] {
                tracked.push(p);
            } else if seen[p] {
                left_out.hidden_at_start += 1;
            } else {
                left_out.never_visible += 1;
            }
        }
        let mut pool = Pool::default();
        let at: Vec<Point> = tracked.iter().map(|&p| self.points[p]).collect();
        for i in along_curve(&at) {
            pool.push(at[i], NodeKind::Observed, Some(tracked[i]));
        }
        let more = [
            (NodeKind::Completed, object.completed_surface.as_slice()),
            (NodeKind::Interior, if interior { object.interior.as_slice() } else { &[] }),
        ];
        for (kind, points) in more {
            let points: Vec<Point> = points.iter().copied().filter(is_finite).collect();
            left_out.not_finite += match kind {
                NodeKind::Completed => object.completed_surface.len() - points.len(),
                _ if interior => object.interior.len() - points.len(),
                _ => 0,
            };
            for i in along_curve(&points) {
                pool.push(points[i], kind, None);
            }
        }
        Ok(pool)
    }
}

/// Points that may become nodes, in the order of nodes.
#[derive(Default)]
struct Pool {
    positions: Vec<Point>,
    kinds: Vec<NodeKind>,
    tracked: Vec<Option<usize>>,
}

impl Pool {
    fn push(&mut self, position: Point, kind: NodeKind, tracked: Option<usize>) {
        self.positions.push(position);
        self.kinds.push(kind);
        self.tracked.push(tracked);
    }

    /// The points without those that lie in the place of an earlier one, unless a control point holds them or
    /// they have another place in the undeformed shape.
    fn distinct(self, object: &Object, left_out: &mut LeftOut) -> Self {
        let held: HashSet<u32> = object.pins.iter().map(|h| h.point).collect();
        // 0 and -0 are the same place.
        let bits = |p: Point| p.map(|x| (x + 0.0).to_bits());
        let undeformed = |i: usize| object.rest_points.get(self.tracked[i]?).copied();
        let mut places = HashSet::with_capacity(self.positions.len());
        let mut distinct = Self::default();
        for (i, position) in self.positions.iter().enumerate() {
            let is_new = places.insert((bits(*position), undeformed(i).map(bits)));
            if is_new || held.contains(&self.observed(i)) {
                distinct.push(*position, self.kinds[i], self.tracked[i]);
            } else {
                left_out.coincident += 1;
            }
        }
        distinct
    }

    /// All but interior points.
    fn surface(&self) -> SurfacePoints {
        let count = self.kinds.iter().take_while(|k| k.is_surface()).count();
        SurfacePoints {
            positions: self.positions[..count].to_vec(),
            observed_points: (0..count).map(|i| self.observed(i)).collect(),
        }
    }

    fn observed(&self, i: usize) -> u32 {
        self.tracked[i].map_or(Graph::NOT_OBSERVED, |p| p as u32)
    }

    /// Indices of the points to keep, ascending.
    fn reduce(&self, object: &Object, settings: &GraphSettings, seed: u64) -> Vec<usize> {
        let total = self.positions.len();
        let wanted = (settings.sampling_ratio * total as f64).ceil() as usize;
        let wanted = wanted.min(settings.max_nodes.unwrap_or(usize::MAX)).clamp(1, total);
        if wanted == total {
            return (0..total).collect();
        }
        let held: HashSet<u32> = object.pins.iter().map(|h| h.point).collect();
        let mut chosen: Vec<usize> =
            (0..total).filter(|&i| held.contains(&self.observed(i))).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (kind, share) in self.shares(wanted) {
            let of_kind: Vec<usize> = (0..total).filter(|&i| self.kinds[i] == kind).collect();
            let have = chosen.iter().filter(|&&i| self.kinds[i] == kind).count();
            let more = share.saturating_sub(have);
            match settings.sampling {
                Sampling::Spread => {
                    let start = rng.random_range(0..of_kind.len().max(1));
                    farthest_points(&self.positions, &of_kind, &mut chosen, more, start);
                }
                Sampling::Random => {
                    let mut left = of_kind;
                    left.retain(|i| !held.contains(&self.observed(*i)));
                    let (drawn, _) = left.partial_shuffle(&mut rng, more);
                    chosen.extend_from_slice(drawn);
                }
            }
        }
        chosen.sort_unstable();
        chosen
    }

    /// Number of nodes of each kind that make `wanted`: in proportion, by largest remainders.
    fn shares(&self, wanted: usize) -> [(NodeKind, usize); 3] {
        let kinds = [NodeKind::Observed, NodeKind::Completed, NodeKind::Interior];
        let counts = kinds.map(|kind| self.kinds.iter().filter(|&&k| k == kind).count());
        let total = self.positions.len();
        let mut shares = counts.map(|n| n * wanted / total);
        let mut by_remainder = [0, 1, 2];
        by_remainder.sort_by_key(|&k| std::cmp::Reverse(counts[k] * wanted % total));
        let missing = wanted - shares.iter().sum::<usize>();
        by_remainder.iter().take(missing).for_each(|&k| shares[k] += 1);
        [0, 1, 2].map(|k| (kinds[k], shares[k]))
    }
}

fn pins(object: &Object, observed: &[u32], positions: &[Point], controls: &[Point]) -> Vec<Pin> {
    let node_of: HashMap<u32, usize> = observed.iter().copied().zip(0..).collect();
    let mut pins: Vec<Pin> = Vec::with_capacity(object.pins.len());
    for held in &object.pins {
        let Some(&node) = node_of.get(&held.point) else { continue };
        let (x, c) = (positions[node], controls[held.control as usize]);
        let offset_m = [x[0] - c[0], x[1] - c[1], x[2] - c[2]];
        pins.push(Pin { node: node as u32, control: held.control, offset_m });
    }
    pins.sort_by_key(|p| p.node);
    pins
}

fn check_object(object: &Object) -> Result<(), Error> {
    let points = object.point_count;
    let fault = |text: String| Err(Error::Inconsistent(text));
    if points > (u32::MAX / 2) as usize {
        return fault(format!("{points} tracked points are more than indices can name"));
    }
    if !object.rest_points.is_empty() && object.rest_points.len() != points {
        let n = object.rest_points.len();
        return fault(format!("{n} undeformed points for {points} tracked points"));
    }
    let mut held = vec![false; points];
    for h in &object.pins {
        match held.get_mut(h.point as usize) {
            None => return fault(format!("held point {} of {points}", h.point)),
            Some(true) => return fault(format!("point {} is held twice", h.point)),
            Some(slot) => *slot = true,
        }
    }
    match object.edges.iter().find(|[a, b]| a == b || (*a).max(*b) as usize >= points) {
        Some([a, b]) => fault(format!("an edge joins points {a} and {b} of {points}")),
        None => Ok(()),
    }
}

fn check_sequence(sequence: &Sequence, points: usize, controls: usize) -> Result<(), Error> {
    let fault =
        |text: String| Err(Error::Inconsistent(format!("sequence `{}`: {text}", sequence.name)));
    let frames = sequence.frame_count;
    if sequence.start_frame() >= frames {
        return fault(format!("it starts in frame {} of {frames}", sequence.start_frame()));
    }
    let arrays = [
        ("points", sequence.points.len(), points),
        ("visibilities", sequence.visible.len(), points),
        ("control points", sequence.controls.len(), controls),
    ];
    match arrays.into_iter().find(|(_, len, per)| Some(*len) != frames.checked_mul(*per)) {
        Some((what, len, per)) => fault(format!("{len} {what} for {frames} frames of {per}")),
        None => Ok(()),
    }
}

fn is_finite(p: &Point) -> bool {
    p.iter().all(|x| x.is_finite())
}
