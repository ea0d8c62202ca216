//! Rest lengths of springs and rest angles of triplets.

use bendtwin_core::{Graph, Point};

use super::{MIN_REST_LENGTH_M, NodeSample};

/// Rest lengths [m], shape [E], and rest angles [rad, 0..=pi], shape [T], of a
/// graph that [`super::connect`] made of `sample`: from the undeformed shape
/// where the capture has one, and from the start frame otherwise and wherever a
/// control point takes part. Lengths are at least [`MIN_REST_LENGTH_M`].
pub fn rest_geometry(graph: &Graph, sample: &NodeSample) -> (Vec<f32>, Vec<f32>) {
    let n = sample.node_count() as u32;
    let offset = |from: u32, to: u32| {
        let at = |e: u32| {
            if from < n && to < n {
                sample.undeformed()[e as usize]
            } else {
                graph.rest_endpoint(e)
            }
        };
        let (a, b) = (at(from), at(to));
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
    };
    let lengths = graph.springs.iter().map(|&[a, b]| norm(offset(a, b)).max(MIN_REST_LENGTH_M));
    let angles = graph.triplets.iter().map(|&[i, j, k]| angle(offset(j, i), offset(j, k)));
    (lengths.collect(), angles.collect())
}

/// Angle between two arms [rad], 0..=pi; exact near 0 and pi, 0 where an arm is zero.
fn angle(u: Point, w: Point) -> f32 {
    let (u, w) = (u.map(f64::from), w.map(f64::from));
    let cross = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
    let sine = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    let cosine: f64 = u.iter().zip(&w).map(|(a, b)| a * b).sum();
    // Rounding to f32 must not carry pi above itself.
    (sine.atan2(cosine) as f32).min(std::f32::consts::PI)
}

fn norm(v: Point) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}
