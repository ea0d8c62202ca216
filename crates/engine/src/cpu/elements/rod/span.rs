//! Spans of rods: the part of each that the clamps twist which hold now.
//!
//! A *clamp* is an edge of the rod whose two nodes control points hold, or the same hand does: it
//! gives the rod a direction, and its frame with it. The span lies between the outermost two clamps,
//! from the inner edge of the one to the inner edge of the other; an arm at the rod's end counts as
//! one. A hand between them lets the rod turn in its fingers. The rest of the rod turns freely, and so
//! does all of a rod with less than two clamps: it has no torque.
//!
//! A span that is the share w of the rod's length is 1/w times as stiff. With a twist that counts
//! for the whole rod, as if all of it were twisted as the span is, its torque stays the same function
//! of the twist, which grows 1/w times as fast ([`super::rod_forces`]). Then nothing jumps where a
//! clamp closes within the span. The twist between the span and a clamp that opens is lost, and that of
//! the span spreads out when a clamp closes outside: see [`kept`].

use std::sync::Arc;

use super::Rods;
use crate::cpu::arithmetic::Real;

/// Holder of an edge of a rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holder {
    /// Control points.
    Controls,
    /// The hand of this number.
    Hand(usize),
}

/// The part of a rod between two clamps: inner nodes, counted along the rod from 0, each of which
/// follows the edge of its number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) first: usize,
    pub(crate) end: usize,
    /// Holders of the edges `first` and `end`; an arm has none.
    pub(crate) near: Option<Holder>,
    pub(crate) far: Option<Holder>,
}

/// A rod in the graph.
#[derive(Debug)]
pub(super) struct Path {
    pub(super) nodes: Vec<u32>,
    pub(super) has_arm: bool,
    /// Share of the rod's length at each inner node.
    pub(super) shares: Vec<f32>,
}

/// Paths of all rods.
pub(super) type Paths = Arc<Vec<Path>>;

impl Path {
    fn inner(&self) -> usize {
        self.nodes.len().saturating_sub(2)
    }

    /// The span while `holder` says what holds a node.
    fn span(&self, holder: &impl Fn(u32) -> Option<Holder>) -> Span {
        let edges = self.inner() + usize::from(!self.has_arm);
        let held: Vec<Option<Holder>> = self.nodes[..=edges]
            .windows(2)
            .map(|ends| holder(ends[0]).filter(|h| holder(ends[1]) == Some(*h)))
            .collect();
        let Some(outer) = held.iter().position(Option::is_some) else { return Span::default() };
        let first = held[outer..].iter().position(Option::is_none).map_or(edges, |n| outer + n) - 1;
        let (end, far) = if self.has_arm {
            (self.inner(), None)
        } else {
            let last = held.iter().rposition(Option::is_some).unwrap_or(first);
            let end = held[..last].iter().rposition(Option::is_none).map_or(0, |n| n + 1);
            (end, held[end])
        };
        if end > first { Span { first, end, near: held[first], far } } else { Span::default() }
    }

    /// Share of the rod's length in some of its inner nodes; exactly 1 for all of them.
    fn share(&self, first: usize, end: usize) -> f32 {
        if first == 0 && end == self.inner() {
            return 1.0;
        }
        self.shares.get(first..end).unwrap_or_default().iter().sum()
    }
}

impl<T: Real> Rods<T> {
    /// The spans of all rods while `holder` says what holds a node.
    pub(crate) fn spans(&self, holder: impl Fn(u32) -> Option<Holder>) -> Vec<Span> {
        self.paths.iter().map(|path| path.span(&holder)).collect()
    }

    /// True if these spans are the rods as a whole.
    pub(crate) fn are_whole(&self, spans: &[Span]) -> bool {
        let is_whole = |(span, path): (&Span, &Path)| span.first == 0 && span.end == path.inner();
        spans.iter().zip(&*self.paths).all(is_whole)
    }

    /// The first two nodes of an edge of a rod.
    pub(crate) fn edge(&self, rod: usize, edge: usize) -> [u32; 2] {
        [self.paths[rod].nodes[edge], self.paths[rod].nodes[edge + 1]]
    }

    /// The rods, twisted between the clamps of `spans` alone.
    pub(crate) fn within(&self, spans: &[Span]) -> Self {
        let mut this = Self { paths: self.paths.clone(), ..Self::default() };
        for ((span, path), rod) in spans.iter().zip(&*self.paths).zip(&self.rods) {
            let share = path.share(span.first, span.end);
            let nodes = &path.nodes[span.first..span.end + 2];
            let is_twisted = span.end > span.first;
            let nodes = if is_twisted { nodes } else { &[] };
            let inverse_share = if is_twisted { 1.0 / share } else { 1.0 };
            this.add(nodes, path.has_arm, rod.clone());
            if let Some(rod) = this.rods.last_mut() {
                rod.inverse_share = T::from_f32(inverse_share);
            }
        }
        this
    }

    /// Share of a rod's twist beyond its rest that is left when one span takes another's place: with
    /// nothing of the twist outside the span before, and the part of it that stays spread over all of
    /// the span behind, `|before ∩ behind| / |behind|`. 1 where the span only becomes shorter, 0
    /// without clamps.
    pub(crate) fn kept(&self, rod: usize, before: &Span, behind: &Span) -> T {
        let path = &self.paths[rod];
        let (first, end) = (before.first.max(behind.first), before.end.min(behind.end));
        if behind.end <= behind.first || end <= first {
            return T::ZERO;
        }
        if (first, end) == (behind.first, behind.end) {
            return T::ONE;
        }
        T::from_f32(path.share(first, end) / path.share(behind.first, behind.end))
    }
}
