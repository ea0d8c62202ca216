//! Errors of two fits that differ in bending alone, on motions that neither saw, and the reason for
//! their difference, for people who see a twin for the first time.

use bendtwin_core::{Quality, quality::Predictor};
use bendtwin_eval::differ;

const SAME: &str = "Both fits have the same points, the same recording, the same search and as many steps; bending is\n\
                    all that differs.";
const WHY: &str = "Why: a spring keeps two points at their distance and nothing else. A line of points that springs\n\
                   join folds at every point, like a chain, however stiff the springs are. A cable resists that:\n\
                   its stiffness lies in its angles and in its twist, which bending elements have and springs lack.";
const NOT_ALWAYS: &str = "Not every object needs it. In foam or plush each point has many springs that cross, which hold\n\
                          the shape by themselves; a fit without bending is as good there (docs/develop/accuracy/bending.md).";
const NO_DIFFERENCE: &str =
    "No difference: two fits that differ only by chance are as far apart. Try another --seed.";

/// Paragraphs about the table of a twin with bending, the fit without it among its rows; none if a
/// row is missing.
pub(super) fn paragraphs(quality: &Quality) -> Option<Vec<String>> {
    let (measure, own) = quality.scores.first()?.future.headline()?;
    let of = |predictor| measure.of(&quality.score(predictor)?.future);
    let (axial, still) = (of(Predictor::Axial)?, of(Predictor::StandingStill)?);
    let millimetres = |error: f64, what: &str| format!("  {:6.1} mm  {what}", 1e3 * error);
    let found = if !differ([own, axial]) {
        "springs and bending".to_owned()
    } else if own < axial {
        format!("springs and bending: {:.1} times nearer", axial / own)
    } else {
        format!("springs and bending: {:.1} times farther", own / axial)
    };
    let figures = [
        "On the motions that neither fit saw, points are off by".to_owned(),
        millimetres(still, "if nothing moves"),
        millimetres(axial, "springs alone"),
        millimetres(own, &found),
    ];
    let is_nearer = differ([own, axial]) && own < axial;
    let said: &[&str] = match is_nearer {
        true => &[WHY, NOT_ALWAYS],
        false if !differ([own, axial]) => &[NO_DIFFERENCE],
        false => &[],
    };
    let paragraphs = [figures.join("\n"), SAME.to_owned()].into_iter();
    Some(paragraphs.chain(said.iter().map(|text| (*text).to_owned())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quality(own_mm: f64, axial_mm: f64) -> Quality {
        let score = |predictor: &str, mm: f64| serde_json::json!({"predictor": predictor, "train": {}, "future": {"track_m": 1e-3 * mm}});
        let scores =
            [score("bending", own_mm), score("axial", axial_mm), score("standing_still", 80.0)];
        serde_json::from_value(serde_json::json!({ "scores": scores })).unwrap()
    }

    #[test]
    fn a_gain_is_explained() {
        let text = paragraphs(&quality(5.0, 15.0)).unwrap().join("\n\n");
        for part in ["80.0 mm  if nothing", "15.0 mm  springs alone", "5.0 mm", "3.0 times nearer"]
        {
            assert!(text.contains(part), "{part} in\n{text}");
        }
        assert!(text.contains("like a chain") && text.contains("bending is\nall that differs"));
    }

    #[test]
    fn nothing_is_explained_where_there_is_no_gain() {
        let text = paragraphs(&quality(6.8, 6.3)).unwrap().join("\n\n");
        assert!(text.contains("No difference") && !text.contains("Why"), "{text}");
        let text = paragraphs(&quality(12.0, 6.0)).unwrap().join("\n\n");
        assert!(text.contains("2.0 times farther") && !text.contains("Why"), "{text}");
        assert_eq!(paragraphs(&Quality::default()), None);
    }
}
