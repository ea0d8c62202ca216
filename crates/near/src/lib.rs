//! The nearest of many points, however they lie.
//!
//! A k-d tree whose halves have equally many points, which cells of a grid have not: all points in one place,
//! on a line, or in two heaps far apart take it no longer than points spread evenly. Equally far points
//! come in the order of their numbers, so results depend on nothing else.
//!
//! The trees of `kiddo`, which other steps use for points that are known to be spread, split along each axis
//! in turn, also where all coordinates are equal, and cannot skip a group of points.

use std::collections::BinaryHeap;

use bendtwin_core::Point;

/// Most points in a leaf.
const LEAF_POINTS: usize = 8;

/// Squared distance of two points [m²]. It must grow with the difference of every coordinate,
/// rounding included: parts of the tree are skipped by the distance of their boxes.
pub type Metric = fn(Point, Point) -> f64;

/// Points by place. Points that are not finite are near nothing.
#[derive(Clone, Debug)]
pub struct PointTree {
    metric: Metric,
    /// Points in the order of the leaves, with their numbers.
    points: Vec<(Point, u32)>,
    parts: Vec<Part>,
}

/// A box around `first..end` of the points.
#[derive(Clone, Copy, Debug)]
struct Part {
    low: Point,
    high: Point,
    first: u32,
    end: u32,
    /// The second half; the first is the next part. 0 for a leaf.
    second: u32,
    /// Smallest number of its points.
    least: u32,
    /// Group of all its points, if they have the same.
    group: Option<u32>,
}

/// A point that was found; nearer ones are less, of equally near ones those with smaller numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Squared distance [m²].
    pub square: f64,
    /// Number of the point: its place in the order in which the points were given.
    pub number: u32,
}

impl Eq for Near {}

impl PartialOrd for Near {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Near {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.square.total_cmp(&other.square).then(self.number.cmp(&other.number))
    }
}

/// The points that a search looks for.
#[derive(Clone, Copy, Debug)]
pub struct Search<'a> {
    /// Most points that are found.
    pub count: usize,
    /// Largest squared distance [m²].
    pub most: f64,
    /// Points whose squared distance is not larger are passed over [m²]; negative for none.
    pub beyond: f64,
    /// The group of each point, and one whose points are passed over. The groups must be those that the
    /// tree was made with.
    pub other_than: Option<(&'a [u32], u32)>,
}

impl Search<'_> {
    /// The `count` nearest points.
    pub fn nearest(count: usize) -> Self {
        Self { count, most: f64::INFINITY, beyond: -1.0, other_than: None }
    }
}

impl PointTree {
    /// A tree of points, with distances of differences that are rounded as coordinates are.
    pub fn new(points: impl IntoIterator<Item = Point>) -> Self {
        let metric =
            |a: Point, b: Point| a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        Self::with_metric(points, metric)
    }

    /// A tree of points with a metric.
    pub fn with_metric(points: impl IntoIterator<Item = Point>, metric: Metric) -> Self {
        Self::build(points, metric, &[])
    }

    /// A tree of points that belong to groups, for searches that pass over one of them.
    pub fn grouped(points: &[Point], groups: &[u32], metric: Metric) -> Self {
        Self::build(points.iter().copied(), metric, groups)
    }

    fn build(points: impl IntoIterator<Item = Point>, metric: Metric, groups: &[u32]) -> Self {
        let numbered = points.into_iter().zip(0..);
        let finite = numbered.filter(|(p, _)| p.iter().all(|x| x.is_finite()));
        let mut tree = Self { metric, points: finite.collect(), parts: Vec::new() };
        let mut points = std::mem::take(&mut tree.points);
        if !points.is_empty() {
            tree.parts.reserve(2 * points.len().div_ceil(LEAF_POINTS));
            split(&mut points, 0, groups, &mut tree.parts);
        }
        tree.points = points;
        tree
    }

    /// The nearest `count` points within `radius_m`, nearest first.
    pub fn within(&self, at: Point, radius_m: f64, count: usize) -> Vec<Near> {
        self.search(at, &Search { most: radius_m * radius_m, ..Search::nearest(count) })
    }

    /// The nearest point.
    pub fn closest(&self, at: Point) -> Option<Near> {
        self.search(at, &Search::nearest(1)).first().copied()
    }

    /// True if a point is within `radius_m`.
    pub fn any_within(&self, at: Point, radius_m: f64) -> bool {
        !self.within(at, radius_m, 1).is_empty()
    }

    /// The points that a search looks for, nearest first.
    pub fn search(&self, at: Point, search: &Search<'_>) -> Vec<Near> {
        self.counted(at, search).0
    }

    /// The same with the number of points whose distance was taken.
    fn counted(&self, at: Point, search: &Search<'_>) -> (Vec<Near>, usize) {
        let mut measured = 0;
        let mut found: BinaryHeap<Near> = BinaryHeap::new();
        let is_searched = search.count > 0 && at.iter().all(|x| x.is_finite());
        let mut left: Vec<(f64, u32)> = if is_searched { vec![(0.0, 0)] } else { Vec::new() };
        while let Some((square, index)) = left.pop() {
            let Some(part) = self.parts.get(index as usize) else { continue };
            let least = Near { square, number: part.least };
            if !is_wanted(&found, search, least) || self.is_passed_over(at, part, search) {
                continue;
            }
            if part.second > 0 {
                let halves = [index + 1, part.second];
                let [a, b] = halves.map(|half| (self.square_to(at, half), half));
                // The nearer one is searched first: it is pushed last.
                left.extend(if a.0 <= b.0 { [b, a] } else { [a, b] });
                continue;
            }
            for &(point, number) in &self.points[part.first as usize..part.end as usize] {
                measured += 1;
                let near = Near { square: (self.metric)(at, point), number };
                let passed = near.square <= search.beyond
                    || search.other_than.is_some_and(|(of, own)| of[number as usize] == own);
                if !passed && is_wanted(&found, search, near) {
                    found.push(near);
                    if found.len() > search.count {
                        found.pop();
                    }
                }
            }
        }
        (found.into_sorted_vec(), measured)
    }

    /// Squared distance of the box of a part [m²].
    fn square_to(&self, at: Point, part: u32) -> f64 {
        let Some(part) = self.parts.get(part as usize) else { return f64::INFINITY };
        (self.metric)(at, std::array::from_fn(|a| at[a].clamp(part.low[a], part.high[a])))
    }

    /// True if a search passes over all points of a part.
    fn is_passed_over(&self, at: Point, part: &Part, search: &Search<'_>) -> bool {
        if search.other_than.is_some_and(|(_, own)| part.group == Some(own)) {
            return true;
        }
        let farthest = std::array::from_fn(|a| {
            let [low, high] = [part.low[a], part.high[a]];
            if (at[a] - low).abs() > (at[a] - high).abs() { low } else { high }
        });
        search.beyond >= 0.0 && (self.metric)(at, farthest) <= search.beyond
    }
}

/// True if a point is near enough, and nearer than the last of those that were found.
fn is_wanted(found: &BinaryHeap<Near>, search: &Search<'_>, near: Near) -> bool {
    // NaN is not near.
    let within = near.square <= search.most;
    within && (found.len() < search.count || found.peek().is_some_and(|last| near < *last))
}

/// Appends the part of points that start at `first` in the whole, and all below it.
fn split(points: &mut [(Point, u32)], first: usize, groups: &[u32], parts: &mut Vec<Part>) {
    let [mut low, mut high] = [points[0].0; 2];
    let mut least = u32::MAX;
    let group_of = |number: u32| groups.get(number as usize).copied();
    let mut group = group_of(points[0].1);
    for (p, number) in points.iter() {
        low = std::array::from_fn(|a| low[a].min(p[a]));
        high = std::array::from_fn(|a| high[a].max(p[a]));
        least = least.min(*number);
        group = group.filter(|group| group_of(*number) == Some(*group));
    }
    let own = parts.len();
    let [from, end] = [first, first + points.len()].map(|x| x as u32);
    parts.push(Part { low, high, first: from, end, second: 0, least, group });
    if points.len() <= LEAF_POINTS {
        return;
    }
    let extent = |a: &usize| f64::from(high[*a]) - f64::from(low[*a]);
    let axis = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let half = points.len() / 2;
    // Equal coordinates are ordered by number, so equal points with smaller numbers are in the first half.
    points.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (left, right) = points.split_at_mut(half);
    split(left, first, groups, parts);
    parts[own].second = parts.len() as u32;
    split(right, first + half, groups, parts);
}

#[cfg(test)]
mod tests;
