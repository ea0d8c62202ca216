//! Disjoint sets: numbers that are joined step by step.

/// Disjoint sets of the numbers from 0. The name of a set is its smallest number, so names do not depend on the
/// order in which sets were joined.
#[derive(Clone, Debug)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// The numbers below `n`, each alone.
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    /// The set of a number.
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }

    /// Joins the sets of two numbers. False if they were one set.
    pub fn union(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// The set of each number.
    pub fn names(&mut self) -> Vec<u32> {
        (0..self.0.len() as u32).map(|x| self.find(x)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_named_by_their_smallest_number() {
        let mut sets = DisjointSets::new(6);
        assert!(sets.union(5, 3) && sets.union(3, 4) && sets.union(2, 1));
        assert!(!sets.union(4, 5));
        assert_eq!(sets.names(), [0, 1, 1, 3, 3, 3]);
    }
}
