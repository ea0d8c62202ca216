//! Differences between the starts of a fit, beside their seeds.
//!
//! Starts whose graphs differ err differently where the recording does not decide, so that the lowest
//! training loss has more to choose from, and the mean of their predictions cancels more.

use std::borrow::Cow;

use super::{FitSettings, SearchSettings};

/// Reach of the hands of a wide grip, over that of the settings.
const WIDER_REACH: f64 = 2.0;
/// Springs of each control point of a wide grip, over those of the settings.
const MORE_SPRINGS: usize = 3;

/// Springs that a node opens in a dense graph, over those of the settings.
const MORE_NEIGHBOURS: usize = 2;

/// A way in which a start departs from the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Variation {
    /// Hands that reach farther and hold more firmly.
    WideGrip,
    /// Axial springs alone.
    Axial,
    /// More springs between nodes.
    Dense,
    /// Settings unchanged.
    None,
}

/// Variations of the starts, in turn.
const IN_TURN: [Variation; 4] =
    [Variation::WideGrip, Variation::Axial, Variation::Dense, Variation::None];

impl SearchSettings {
    /// Number of starts of each model, by settings without open ones. Without a search there is a
    /// single one: all would refine the same parameters.
    pub fn start_count(&self) -> u32 {
        match self.generations {
            Some(0) => 1,
            _ => self.starts.unwrap_or(1),
        }
    }
}

impl FitSettings {
    /// Settings of a start, counted from 0: a variation of those of the fit if there are several starts
    /// and `search.vary` asks for it, else those of the fit.
    #[must_use]
    pub fn of_start(&self, start: u32) -> Cow<'_, Self> {
        let mut varied = Cow::Borrowed(self);
        if self.search.vary != Some(true) || self.search.start_count() < 2 {
            return varied;
        }
        match IN_TURN[start as usize % IN_TURN.len()] {
            Variation::None => {}
            Variation::WideGrip => {
                let graph = &mut varied.to_mut().graph;
                graph.control_radius_m *= WIDER_REACH;
                graph.control_neighbours = graph.control_neighbours.saturating_mul(MORE_SPRINGS);
            }
            // A fit that is compared with an axial one has it already.
            Variation::Axial if self.compare_axial => {}
            Variation::Axial => varied.to_mut().bending = false,
            Variation::Dense => {
                let neighbours = &mut varied.to_mut().graph.max_neighbours;
                *neighbours = neighbours.map(|n| n.saturating_mul(MORE_NEIGHBOURS));
            }
        }
        varied
    }

    /// Settings of all starts that may differ.
    pub fn of_starts(&self) -> impl Iterator<Item = Cow<'_, Self>> {
        let starts = self.search.start_count().clamp(1, IN_TURN.len() as u32);
        (0..starts).map(|start| self.of_start(start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_starts(starts: u32, vary: Option<bool>) -> FitSettings {
        let mut settings = FitSettings::default();
        (settings.search.starts, settings.search.vary) = (Some(starts), vary);
        settings
    }

    #[test]
    fn starts_vary_in_turn() {
        let mut settings = with_starts(8, Some(true));
        settings.graph.max_neighbours = Some(30);
        let wide = settings.of_start(0).graph.clone();
        assert!((wide.control_radius_m - 2.0 * settings.graph.control_radius_m).abs() < 1e-12);
        assert_eq!(wide.control_neighbours, 3 * settings.graph.control_neighbours);
        assert!(!settings.of_start(1).bending);
        assert_eq!(settings.of_start(2).graph.max_neighbours, Some(60));
        assert_eq!(*settings.of_start(3), settings);
        assert_eq!(settings.of_start(5), settings.of_start(1));
        settings.compare_axial = true;
        assert!(settings.of_start(1).bending, "the axial fit beside it is one already");
        assert_eq!(settings.of_starts().count(), 4);
    }

    #[test]
    fn starts_are_alike_where_they_do_not_vary() {
        for vary in [None, Some(false)] {
            let settings = with_starts(3, vary);
            assert!(settings.of_starts().all(|of_start| *of_start == settings));
        }
        let single = with_starts(1, Some(true));
        assert!(single.of_starts().eq([Cow::Borrowed(&single)]));
        let mut refined = with_starts(3, Some(true));
        refined.search.generations = Some(0);
        assert!(refined.of_starts().eq([Cow::Borrowed(&refined)]), "nothing is searched");
    }
}
