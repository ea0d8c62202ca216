//! Free baselines: predictors without a fit, which a twin has to beat.

use bendtwin_core::{Capture, Graph, Point, Sequence};

use crate::{
    Trajectory,
    distance::{euclidean, is_finite},
    surface::Surface,
    trajectory::difference,
};

/// The object at rest except for its pinned nodes, which follow their control points.
pub(crate) fn standing_still(graph: &Graph, sequence: &Sequence, start: &[Point]) -> Trajectory {
    predicted(graph, sequence, |_, positions| positions.copy_from_slice(start))
}

/// The twin's prediction plus its error in the last training frame. A point that was seen in that
/// frame carries its own error, any other one that of the nearest point that was seen. `None` where
/// a sequence is not split.
pub(crate) fn last_residual(
    of: &Surface,
    sequence: &Sequence,
    prediction: &Trajectory,
) -> Option<Trajectory> {
    let last = sequence.train_frame_count.checked_sub(1)?;
    if sequence.train_frame_count >= sequence.frame_count || last <= sequence.start_frame() {
        return None;
    }
    let predicted = prediction.at(last)?;
    let (points, visible) = (sequence.points_at(last), sequence.visible_at(last));
    let known: Vec<(usize, Point)> = of
        .observed_points
        .iter()
        .enumerate()
        .filter_map(|(own, &p)| {
            let p = p as usize;
            let point = points.get(p).filter(|x| visible[p] && is_finite(x))?;
            Some((own, difference(*point, predicted[own])))
        })
        .collect();
    let residual = |own: usize| {
        let at = of.rest[own];
        let distance = |k: &&(usize, Point)| euclidean(of.rest[k.0], at);
        let nearest = known.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or([0.0; 3], |k| k.1)
    };
    if known.is_empty() {
        return None;
    }
    let residuals: Vec<Point> = (0..of.rest.len()).map(residual).collect();
    let mut corrected = prediction.clone();
    for row in corrected.positions.chunks_exact_mut(residuals.len()) {
        for (x, r) in row.iter_mut().zip(&residuals) {
            *x = std::array::from_fn(|a| x[a] + r[a]);
        }
    }
    Some(corrected)
}

/// Free nodes are displaced between the clamps along the object's known edges, in proportion to
/// rest length (harmonically, which on a cable is linearly). `None` unless the capture has edges
/// and held points.
pub(crate) fn clamp_interpolation(
    capture: &Capture,
    graph: &Graph,
    sequence: &Sequence,
    start: &[Point],
) -> Option<Trajectory> {
    if capture.object.edges.is_empty() || graph.pins.is_empty() {
        return None;
    }
    let shares: Vec<Vec<f64>> = harmonic_shares(graph);
    Some(predicted(graph, sequence, |held, positions| {
        for (i, x) in positions.iter_mut().enumerate() {
            *x = std::array::from_fn(|a| {
                let moved: f64 = shares
                    .iter()
                    .zip(held)
                    .map(|(share, (node, at))| share[i] * f64::from(at[a] - start[*node][a]))
                    .sum();
                start[i][a] + moved as f32
            });
        }
    }))
}

/// Builds a prediction frame by frame; held nodes stand where their control points put them.
fn predicted(
    graph: &Graph,
    sequence: &Sequence,
    mut place: impl FnMut(&[(usize, Point)], &mut [Point]),
) -> Trajectory {
    let (first, n) = (sequence.start_frame(), graph.node_count());
    let mut positions = vec![[0.0; 3]; (sequence.frame_count - first) * n];
    for (frame, row) in (first..).zip(positions.chunks_exact_mut(n.max(1))) {
        let controls = sequence.controls_at(frame);
        let at = |p: &bendtwin_core::Pin| {
            let c = controls[p.control as usize];
            (p.node as usize, std::array::from_fn(|a| c[a] + p.offset_m[a]))
        };
        let held: Vec<(usize, Point)> = graph.pins.iter().map(at).collect();
        place(&held, row);
        held.iter().for_each(|(node, x)| row[*node] = *x);
    }
    Trajectory { start_frame: first, node_count: n, positions, diverged: None }
}

/// Share of each pin's displacement that a node takes over: one at the pin, zero at the others, and
/// in between the mean of the neighbours, weighted by one over rest length. Shape [pins, N].
fn harmonic_shares(graph: &Graph) -> Vec<Vec<f64>> {
    let n = graph.node_count();
    let mut edges: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
    for &[a, b] in graph.springs.iter().filter(|s| (s[1] as usize) < n) {
        let (a, b) = (a as usize, b as usize);
        let weight = 1.0 / euclidean(graph.rest_positions[a], graph.rest_positions[b]).max(1e-6);
        edges[a].push((b, weight));
        edges[b].push((a, weight));
    }
    let mut pinned = vec![false; n];
    graph.pins.iter().for_each(|p| pinned[p.node as usize] = true);
    let share = |pin: &bendtwin_core::Pin| {
        let mut x = vec![0.0; n];
        x[pin.node as usize] = 1.0;
        relax(&edges, &pinned, &mut x);
        x
    };
    graph.pins.iter().map(share).collect()
}

/// Solves the weighted Laplace equation for the nodes that are not pinned, by conjugate gradients.
fn relax(edges: &[Vec<(usize, f64)>], pinned: &[bool], x: &mut [f64]) {
    let apply = |v: &[f64]| -> Vec<f64> {
        let at = |i: usize| edges[i].iter().map(|&(j, w)| w * (v[i] - v[j])).sum();
        (0..v.len()).map(|i| if pinned[i] { 0.0 } else { at(i) }).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut residual: Vec<f64> = apply(x).iter().map(|r| -r).collect();
    let mut direction = residual.clone();
    let mut size = dot(&residual, &residual);
    let goal = size * 1e-20;
    for _ in 0..4 * x.len() {
        if size <= goal {
            break;
        }
        let image = apply(&direction);
        let curvature = dot(&direction, &image);
        if curvature <= 0.0 {
            break;
        }
        let length = size / curvature;
        for i in 0..x.len() {
            x[i] += length * direction[i];
            residual[i] -= length * image[i];
        }
        let next = dot(&residual, &residual);
        let keep = next / size;
        direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + keep * *d);
        size = next;
    }
}

#[cfg(test)]
mod tests;
