//! Tracking: whether a state that is corrected again and again still follows its object.
//!
//! The *misfit* of a correction is how far its result is from explaining the observation, as a
//! registration judges it: the larger one of the median distance of the points by what noise and the
//! twin's resolution let expect, and of the share of points out of reach by the half that a
//! registration tolerates. Up to 1 the observation is explained.
//!
//! A state is *lost* if three observations in a row are not explained, or if the mean of the
//! misfits, each weighted by 3/4 of the one after it, is above 1. So a single frame that shows
//! something else loses nothing (a misfit counts at most 1.5, and moves a healthy mean, of some
//! 0.5, to 0.75); an object that is elsewhere is noticed at the third observation; so is one that
//! is explained every other time; and a state is found again only after a few observations that it
//! explains.

/// Weight of the newest misfit in the mean: a memory of about four observations.
const NEWEST: f64 = 0.25;
/// Largest misfit that counts.
const MOST: f64 = 1.5;
/// Observations in a row that are not explained, from which a state is lost.
const IN_A_ROW: u32 = 3;

/// Record of how well a state explains the observations of its object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracking {
    /// Mean of the misfits; above 1 the state is lost.
    pub misfit: f64,
    /// Last observations in a row that were not explained; from 3 on the state is lost.
    pub unexplained: u32,
}

impl Tracking {
    /// The record with one more observation, of this misfit.
    #[must_use]
    pub fn after(self, misfit: f64) -> Self {
        // One that is no number explains nothing.
        let newest = if misfit < MOST { misfit } else { MOST };
        Self {
            misfit: (1.0 - NEWEST) * self.misfit + NEWEST * newest,
            unexplained: if newest > 1.0 { self.unexplained.saturating_add(1) } else { 0 },
        }
    }

    /// True if the state does not follow its object any more.
    pub fn is_lost(&self) -> bool {
        self.misfit > 1.0 || self.unexplained >= IN_A_ROW
    }
}

#[cfg(test)]
mod tests {
    use std::iter::repeat_n;

    use super::*;

    fn after(misfits: impl IntoIterator<Item = f64>) -> Tracking {
        misfits.into_iter().fold(Tracking::default(), Tracking::after)
    }

    #[test]
    fn an_object_that_is_elsewhere_is_noticed_at_the_third_observation() {
        for before in [0, 1, 10, 100] {
            let healthy = || repeat_n(0.5, before);
            assert!(!after(healthy().chain([9.0, f64::NAN])).is_lost());
            assert!(after(healthy().chain([9.0, f64::INFINITY, f64::NAN])).is_lost());
            assert!(after(healthy().chain([1.1; 3])).is_lost());
        }
    }

    #[test]
    fn a_healthy_state_and_single_strangers_lose_nothing() {
        let mixed = (0..200).map(|i| if i % 4 == 3 { 50.0 } else { 0.6 });
        for count in 0..200 {
            assert!(!after(mixed.clone().take(count)).is_lost(), "{count}");
            assert!(!after(repeat_n(0.95, count)).is_lost());
        }
        assert!(after((0..40).map(|i| if i % 2 == 0 { 0.6 } else { 5.0 })).is_lost());
    }

    #[test]
    fn a_lost_state_is_found_by_what_it_explains() {
        let lost = after(repeat_n(5.0, 30));
        assert!(lost.is_lost());
        let found = [0.4; 4].into_iter().fold(lost, Tracking::after);
        assert!(found.unexplained == 0 && !found.is_lost(), "{found:?}");
        assert!(lost.after(0.4).is_lost());
    }
}
