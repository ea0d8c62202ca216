//! A quality table in a sentence.

use bendtwin_core::{
    Quality,
    quality::{ErrorSummary, Predictor},
};

/// The twin's future error beside standing still and beside the axial-only model; none if the table
/// lacks one of them.
pub(crate) fn summary(quality: &Quality) -> Option<String> {
    let future = |p| quality.score(p).and_then(|s| headline(&s.future));
    let twin = future(Predictor::Bending)?;
    let mut parts = Vec::new();
    if let Some(still) = future(Predictor::StandingStill) {
        parts.push(format!("{:.1} times nearer than standing still", still / twin));
    }
    if let Some(axial) = future(Predictor::Axial) {
        parts.push(format!("{:.2} times nearer than without bending", axial / twin));
    }
    if parts.is_empty() {
        return None;
    }
    Some(format!(
        "On frames that it never saw the twin is off by {:.1} mm: {}.",
        1e3 * twin,
        parts.join(" and ")
    ))
}

/// The fast variant in a line; none if there is none. `substeps` are those of the twin.
pub(crate) fn fast(quality: &Quality, substeps: u32) -> Option<String> {
    let fast = quality.fast.as_ref()?;
    if fast.substeps >= substeps {
        return Some(format!("{substeps} substeps a frame as well: fewer would stray too far"));
    }
    let softened = if fast.rate_limit.is_some() { ", softened" } else { "" };
    Some(format!(
        "{} substeps a frame ({:.1} times fewer{softened}), {:.2} mm from the exact twin on average, {:.1} mm at most, where nodes travel {:.0} mm",
        fast.substeps,
        f64::from(substeps) / f64::from(fast.substeps.max(1)),
        1e3 * fast.mean_deviation_m,
        1e3 * fast.max_deviation_m,
        1e3 * fast.mean_travel_m,
    ))
}

/// The headline error: that of tracks, if there are tracks.
fn headline(errors: &ErrorSummary) -> Option<f64> {
    errors.track_m.or(errors.coordinate_m).or(errors.chamfer_l1_m).filter(|e| *e > 0.0)
}

#[cfg(test)]
mod tests {
    use bendtwin_core::{FastVariant, quality::Score};

    use super::*;

    fn score(predictor: Predictor, future_m: f64) -> Score {
        let future = ErrorSummary { track_m: Some(future_m), ..ErrorSummary::default() };
        Score {
            predictor,
            train: ErrorSummary::default(),
            future,
            per_frame: Vec::new(),
            at_nodes: None,
        }
    }

    #[test]
    fn the_fast_variant_is_told_in_a_line() {
        let fast = FastVariant {
            substeps: 20,
            rate_limit: None,
            mean_deviation_m: 4.2e-4,
            max_deviation_m: 3e-3,
            mean_travel_m: 0.1,
            frames: 30,
        };
        let quality = Quality { fast: Some(fast), ..Quality::default() };
        let line = super::fast(&quality, 100).unwrap();
        assert!(line.contains("5.0 times fewer)") && line.contains("0.42 mm"), "{line}");
        assert!(super::fast(&quality, 20).unwrap().contains("as well"));
        assert_eq!(super::fast(&Quality::default(), 20), None);
    }

    #[test]
    fn the_sentence_compares() {
        let scores = vec![
            score(Predictor::Bending, 0.004),
            score(Predictor::Axial, 0.006),
            score(Predictor::StandingStill, 0.1),
        ];
        let sentence = summary(&Quality { scores, ..Quality::default() }).unwrap();
        assert!(sentence.contains("4.0 mm: 25.0 times") && sentence.contains("1.50 times"));
        assert_eq!(summary(&Quality::default()), None);
    }
}
