//! What a quality table says, in a sentence.

use bendtwin_core::{
    Quality,
    quality::{ErrorSummary, Predictor},
};

/// The twin's future error beside standing still and beside axial only; none if the table does
/// not know.
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

/// The number that sums an error up: track where there are tracks.
fn headline(errors: &ErrorSummary) -> Option<f64> {
    errors.track_m.or(errors.coordinate_m).or(errors.chamfer_l1_m).filter(|e| *e > 0.0)
}

#[cfg(test)]
mod tests {
    use bendtwin_core::quality::Score;

    use super::*;

    fn score(predictor: Predictor, future_m: f64) -> Score {
        let future = ErrorSummary { track_m: Some(future_m), ..ErrorSummary::default() };
        Score { predictor, train: ErrorSummary::default(), future, per_frame: Vec::new() }
    }

    #[test]
    fn the_sentence_compares() {
        let scores = vec![
            score(Predictor::Bending, 0.004),
            score(Predictor::Axial, 0.006),
            score(Predictor::StandingStill, 0.1),
        ];
        let sentence = summary(&Quality { scores, warnings: Vec::new() }).unwrap();
        assert!(sentence.contains("4.0 mm: 25.0 times") && sentence.contains("1.50 times"));
        assert_eq!(summary(&Quality::default()), None);
    }
}
