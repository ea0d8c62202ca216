//! Cutting a graph into parts of equal work for the blocks of a team, along the axes in which it is
//! long, so that few elements reach from one part into another.

use bendtwin_core::Graph;

/// Work of a node beside its half-springs, in half-springs.
const NODE_WORK: u64 = 24;

/// The nodes of each of `parts` parts; every node is in one. Parts may be empty.
pub(crate) fn partition(graph: &Graph, parts: usize) -> Vec<Vec<u32>> {
    let n = graph.node_count();
    let mut work = vec![NODE_WORK; n];
    for end in graph.springs.iter().flatten().filter(|&&e| (e as usize) < n) {
        work[*end as usize] += 1;
    }
    let mut out = Vec::with_capacity(parts);
    let all: Vec<u32> = (0..n as u32).collect();
    split(graph, &work, all, parts.max(1), &mut out);
    out
}

fn split(graph: &Graph, work: &[u64], mut nodes: Vec<u32>, parts: usize, out: &mut Vec<Vec<u32>>) {
    if parts == 1 {
        out.push(nodes);
        return;
    }
    let axis = longest_axis(graph, &nodes);
    let at = |i: &u32| graph.rest_positions[*i as usize][axis];
    nodes.sort_by(|a, b| at(a).total_cmp(&at(b)).then(a.cmp(b)));
    let left_parts = parts / 2;
    let total: u64 = nodes.iter().map(|&i| work[i as usize]).sum();
    let wanted = total * left_parts as u64 / parts as u64;
    let mut sum = 0;
    let cut = nodes.iter().position(|&i| {
        let before = sum;
        sum += work[i as usize];
        // The node that crosses the line goes to the nearer side.
        before + work[i as usize] / 2 >= wanted
    });
    let right = nodes.split_off(cut.unwrap_or(nodes.len()));
    split(graph, work, nodes, left_parts, out);
    split(graph, work, right, parts - left_parts, out);
}

fn longest_axis(graph: &Graph, nodes: &[u32]) -> usize {
    let extent = |axis: usize| {
        let along = nodes.iter().map(|&i| graph.rest_positions[i as usize][axis]);
        let (low, high) =
            along.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b)).then(b.cmp(&a))).unwrap_or(0)
}

#[cfg(test)]
mod tests;
