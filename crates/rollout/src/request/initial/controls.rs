//! Control points of a state that does not say where they are.

use bendtwin_core::{Graph, Point};

/// Control points that belong to positions of nodes: one that holds a node is where that node says,
/// the others are at rest.
pub(super) fn pinned(graph: &Graph, positions: &[Point]) -> Vec<Point> {
    let mut controls = graph.control_rest.clone();
    // The first pin of a control point decides, so later ones are written first.
    for pin in graph.pins.iter().rev() {
        let node = positions[pin.node as usize];
        controls[pin.control as usize] = std::array::from_fn(|i| node[i] - pin.offset_m[i]);
    }
    controls
}

/// Likely control points, if [`pinned`] leaves some at rest: a control point that holds no node has
/// moved like the mean of the nodes at its springs.
pub(super) fn likely(graph: &Graph, positions: &[Point]) -> Option<Vec<Point>> {
    let n = graph.node_count();
    let mut moved = vec![([0.0f32; 3], 0.0f32); graph.control_count()];
    for &[node, end] in &graph.springs {
        let Some(control) = (end as usize).checked_sub(n) else { continue };
        let (now, rest) = (positions[node as usize], graph.rest_positions[node as usize]);
        let (sum, count) = &mut moved[control];
        *sum = std::array::from_fn(|i| sum[i] + now[i] - rest[i]);
        *count += 1.0;
    }
    for pin in &graph.pins {
        moved[pin.control as usize].1 = 0.0;
    }
    if moved.iter().all(|(_, count)| *count == 0.0) {
        return None;
    }
    let mut controls = pinned(graph, positions);
    for (control, (sum, count)) in controls.iter_mut().zip(moved) {
        if count > 0.0 {
            *control = std::array::from_fn(|i| control[i] + sum[i] / count);
        }
    }
    Some(controls)
}
