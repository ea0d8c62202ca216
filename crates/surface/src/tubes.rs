//! Tubes along the nodes of a cable.

use bendtwin_core::{
    Graph, NodeKind, Tube,
    geometry::{length, sub},
};

/// Radius of a tube over the distance of neighbouring nodes, and its bounds [m]: captures do not say how thick
/// a cable is.
const RADIUS: f32 = 0.25;
const RADII_M: [f32; 2] = [0.001, 0.005];
/// Springs of a node on average below which the nodes are those of a cable with branches: a body has several
/// times as many.
const MOST_DEGREE: f64 = 2.3;

/// The tubes of a cable: along its rods and everything between ends and branches. Empty for other bodies.
pub(crate) fn of(graph: &Graph) -> Vec<Tube> {
    let n = graph.node_count();
    let springs: Vec<[u32; 2]> =
        graph.springs.iter().filter(|s| (s[1] as usize) < n).copied().collect();
    let is_tracked = graph.kinds.iter().all(|kind| *kind == NodeKind::Observed);
    let is_thin = 2.0 * springs.len() as f64 <= MOST_DEGREE * n as f64;
    if !is_tracked || !is_thin || springs.is_empty() {
        return Vec::new();
    }
    let radius_m = radius(graph, &springs);
    paths(n, &springs).into_iter().map(|nodes| Tube { nodes, radius_m }).collect()
}

fn radius(graph: &Graph, springs: &[[u32; 2]]) -> f32 {
    let place = |i: u32| graph.rest_positions[i as usize];
    let mut lengths: Vec<f32> =
        springs.iter().map(|[a, b]| length(sub(place(*a), place(*b)))).collect();
    lengths.sort_by(f32::total_cmp);
    (RADIUS * lengths[lengths.len() / 2]).clamp(RADII_M[0], RADII_M[1])
}

/// Paths along springs that have each spring once, each from an end or a branch to the next; rings begin anywhere.
fn paths(n: usize, springs: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut at: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (index, ends) in springs.iter().enumerate() {
        ends.iter().for_each(|end| at[*end as usize].push(index));
    }
    let mut is_used = vec![false; springs.len()];
    let mut paths = Vec::new();
    let is_end = |node: &u32| at[*node as usize].len() != 2;
    let nodes = || 0..n as u32;
    for start in nodes().filter(is_end).chain(nodes()) {
        while let Some(&first) = at[start as usize].iter().find(|s| !is_used[**s]) {
            let (mut path, mut spring) = (vec![start], Some(first));
            while let Some(index) = spring {
                is_used[index] = true;
                let [a, b] = springs[index];
                let last = path[path.len() - 1];
                let next = if a == last { b } else { a };
                path.push(next);
                spring = match is_end(&next) {
                    true => None,
                    false => at[next as usize].iter().copied().find(|s| !is_used[*s]),
                };
            }
            paths.push(path);
        }
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_run_between_ends_and_branches_and_around_rings() {
        let line = [[0, 1], [1, 2], [2, 3]];
        assert_eq!(paths(4, &line), [[0, 1, 2, 3]]);
        let branched = [[0, 1], [1, 2], [2, 3], [2, 4]];
        assert_eq!(paths(5, &branched), [vec![0, 1, 2], vec![2, 3], vec![2, 4]]);
        let ring = [[0, 1], [1, 2], [0, 2]];
        assert_eq!(paths(3, &ring), [[0, 1, 2, 0]]);
    }
}
