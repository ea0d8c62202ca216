//! Choice of the end of a spring that reports its gradient. A row of a warp waits for its node that
//! reports most, so every node should report half of its springs: each is walked along once, and
//! reported where it is left.

use bendtwin_core::Graph;

/// For each spring, whether its first end reports it. A node reports at most half of the springs
/// that join it to other nodes, rounded up, and all that join it to control points, which report
/// none.
pub(super) fn first_ends(graph: &Graph) -> Vec<bool> {
    let n = graph.node_count();
    let between = |s: &[u32; 2]| s.iter().all(|&e| (e as usize) < n);
    let mut springs_of: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (s, ends) in graph.springs.iter().enumerate().filter(|(_, ends)| between(ends)) {
        ends.iter().for_each(|&e| springs_of[e as usize].push(s as u32));
    }
    let mut first = vec![true; graph.springs.len()];
    let mut walked = vec![false; graph.springs.len()];
    // Walks pass through nodes, so that they leave them as often as they come. Only where an odd
    // number of springs meets must one start or end: there first, then what is left is round trips.
    let odd: Vec<usize> = (0..n).filter(|&i| springs_of[i].len() % 2 == 1).collect();
    for start in odd.into_iter().chain(0..n) {
        let mut at = start;
        while let Some(s) = springs_of[at].pop() {
            let s = s as usize;
            if std::mem::replace(&mut walked[s], true) {
                continue;
            }
            let [a, b] = graph.springs[s].map(|e| e as usize);
            first[s] = a == at;
            at = if a == at { b } else { a };
        }
    }
    first
}

#[cfg(test)]
mod tests;
