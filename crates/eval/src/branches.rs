//! A cable with branches, as in DEFT's metric.
//!
//! There every branch is a separate array, from the point where it begins to its tip, padded with
//! zeros to the length of the longest branch; the error is taken over the whole block. A point in
//! which branches begin therefore counts once for each branch that it belongs to, and the zeros
//! count as points without an error: the result is smaller than the true root mean square by a
//! factor that depends on the cable alone (1.33 on BDLO1).

/// Multiplicity of each point of a branched cable, and the number of places in all.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Branches {
    /// Branches that a point belongs to, shape [P].
    pub(crate) memberships: Vec<f64>,
    /// Places over places that are no filling, at least 1.
    pub(crate) padding: f64,
}

impl Branches {
    /// The branches of edges between this many points; `None` unless they form one tree with at
    /// least one junction.
    ///
    /// Branches follow from the edges: one fewer than there are tips; the longest branch is the
    /// longest path, and at a junction of d edges d - 1 branches meet, in any decomposition.
    pub(crate) fn new(edges: &[[u32; 2]], point_count: usize) -> Option<Self> {
        if edges.len().checked_add(1)? != point_count {
            return None;
        }
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); point_count];
        for edge in edges {
            let [a, b] = edge.map(|p| p as usize);
            neighbours.get_mut(a)?.push(b);
            neighbours.get_mut(b)?.push(a);
        }
        let steps = distances(&neighbours, 0);
        // With one edge less than points, connected means a tree.
        if steps.contains(&None) {
            return None;
        }
        let far = (0..point_count).max_by_key(|&p| steps[p])?;
        let longest = distances(&neighbours, far).into_iter().flatten().max()? + 1;
        let tips = neighbours.iter().filter(|n| n.len() == 1).count();
        if tips < 3 {
            return None;
        }
        let memberships: Vec<f64> =
            neighbours.iter().map(|n| n.len().saturating_sub(1).max(1) as f64).collect();
        let places = (tips - 1) as f64 * longest as f64;
        let padding = places / memberships.iter().sum::<f64>();
        Some(Self { memberships, padding })
    }
}

/// Number of edges from a point to each other one; `None` where no edges lead.
fn distances(neighbours: &[Vec<usize>], from: usize) -> Vec<Option<usize>> {
    let mut steps = vec![None; neighbours.len()];
    let mut front = vec![from];
    let mut step = 0;
    while !front.is_empty() {
        let mut next = Vec::new();
        for point in front {
            if steps[point].is_none() {
                steps[point] = Some(step);
                next.extend(neighbours[point].iter().copied().filter(|&p| steps[p].is_none()));
            }
        }
        front = next;
        step += 1;
    }
    steps
}

#[cfg(test)]
mod tests;
