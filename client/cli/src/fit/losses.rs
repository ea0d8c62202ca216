//! Curves of losses as lines of text.

use bendtwin_client::LossCurve;

use crate::table::Table;

/// Columns of a curve.
const WIDTH: usize = 32;
/// Heights of a column, lowest first.
const LEVELS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// A line for each curve: its first and its best loss, and how it falls, in logarithms.
pub(super) fn table(curves: &[LossCurve]) -> String {
    let mut table = Table::new(["STAGE", "MODEL", "ITERATIONS", "FIRST", "BEST", "LOSS"]);
    for curve in curves {
        let number = |loss: Option<f64>| loss.map_or("none".to_owned(), |l| format!("{l:.2e}"));
        table.row([
            curve.stage.clone(),
            curve.variant.clone(),
            curve.iterations.last().copied().unwrap_or(0).to_string(),
            number(curve.losses.iter().copied().flatten().next()),
            number(best(curve)),
            sparkline(curve),
        ]);
    }
    table.text()
}

/// The lowest loss of a curve.
pub(super) fn best(curve: &LossCurve) -> Option<f64> {
    curve.best_losses.iter().copied().flatten().reduce(f64::min)
}

/// The best loss over the iterations, each column the last iteration of its share.
fn sparkline(curve: &LossCurve) -> String {
    let Some(last) = curve.iterations.last().copied().filter(|last| *last > 0) else {
        return String::new();
    };
    let columns = WIDTH.min(curve.iterations.len());
    let at = |column: usize| {
        let until = (column + 1) as f64 / columns as f64 * f64::from(last);
        let end = curve.iterations.partition_point(|i| f64::from(*i) <= until + 1e-6);
        let index = end.checked_sub(1)?;
        curve.best_losses.get(index).copied().flatten().filter(|l| *l > 0.0).map(f64::ln)
    };
    let heights: Vec<Option<f64>> = (0..columns).map(at).collect();
    let known = || heights.iter().flatten().copied();
    let (low, high) =
        (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    let level = |height: f64| {
        let share = if high > low { (height - low) / (high - low) } else { 0.0 };
        LEVELS[((share * LEVELS.len() as f64) as usize).min(LEVELS.len() - 1)]
    };
    heights.iter().map(|height| height.map_or(' ', level)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(losses: &[Option<f64>]) -> LossCurve {
        LossCurve {
            stage: "refine".into(),
            variant: "bending".into(),
            iterations: (1..=losses.len() as u32).collect(),
            losses: losses.to_vec(),
            best_losses: losses.to_vec(),
            errors_m: vec![None; losses.len()],
        }
    }

    #[test]
    fn a_curve_falls_from_left_to_right() {
        let falling: Vec<_> = (0..200).map(|i| Some(0.95_f64.powi(i))).collect();
        let line = sparkline(&curve(&falling));
        assert_eq!(line.chars().count(), WIDTH);
        assert_eq!((line.chars().next(), line.chars().last()), (Some('█'), Some('▁')));
        let levels: Vec<_> =
            line.chars().map(|c| LEVELS.iter().position(|l| *l == c).unwrap()).collect();
        assert!(levels.is_sorted_by(|a, b| a >= b), "{line}");
    }

    #[test]
    fn curves_without_numbers_are_lines_too() {
        assert_eq!(sparkline(&curve(&[])), "");
        assert_eq!(sparkline(&curve(&[None, Some(0.0)])), "  ");
        assert_eq!(sparkline(&curve(&[None, Some(1.0), Some(1.0)])), " ▁▁");
        assert!(table(&[curve(&[None])]).contains("none"));
        assert_eq!(best(&curve(&[Some(2.0), Some(1.0)])), Some(1.0));
    }
}
