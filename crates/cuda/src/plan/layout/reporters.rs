//! Choice of the end of a spring that reports its gradient. A row of a warp waits for its node that
//! reports most, so every node should report half of its springs: each is walked along once, and
//! reported where it is left.

use bendtwin_core::Graph;

/// True for each spring that its first end reports. A node reports at most half of the springs that
/// join it to other nodes, rounded up, and all that join it to control points, which report none.
pub(super) fn first_ends(graph: &Graph) -> Vec<bool> {
    let n = graph.node_count();
    let between = |s: &[u32; 2]| s.iter().all(|&e| (e as usize) < n);
    // Springs of each node, one after another: where those of each end, and of each its index, its
    // other end, and whether the node is its first end.
    let mut ends = vec![0_usize; n + 1];
    for &e in graph.springs.iter().filter(|s| between(s)).flatten() {
        ends[e as usize + 1] += 1;
    }
    (0..n).for_each(|i| ends[i + 1] += ends[i]);
    let mut springs_of = vec![(0_u32, 0_u32, false); ends[n]];
    let starts = ends.clone();
    for (s, &[a, b]) in (0_u32..).zip(&graph.springs).filter(|(_, ends)| between(ends)) {
        for (end, other) in [(a, b), (b, a)] {
            // The end of the node before is where the next of this one goes.
            springs_of[ends[end as usize]] = (s, other, end == a);
            ends[end as usize] += 1;
        }
    }
    let mut first = vec![true; graph.springs.len()];
    let mut walked = vec![false; graph.springs.len()];
    // Walks pass through nodes, so that they leave them as often as they come. Only where an odd
    // number of springs meets must one start or end: there first, then what is left is round trips.
    let odd: Vec<usize> = (0..n).filter(|&i| (ends[i] - starts[i]) % 2 == 1).collect();
    for start in odd.into_iter().chain(0..n) {
        let mut at = start;
        while ends[at] > starts[at] {
            ends[at] -= 1;
            let (s, other, is_first) = springs_of[ends[at]];
            if std::mem::replace(&mut walked[s as usize], true) {
                continue;
            }
            first[s as usize] = is_first;
            at = other as usize;
        }
    }
    first
}

#[cfg(test)]
mod tests;
