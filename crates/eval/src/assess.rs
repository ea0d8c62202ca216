//! The quality table in words: whether predictions of a twin are to be trusted, why, and what to do
//! next. The rule is stated in docs/use/accuracy.md.

use bendtwin_core::{
    Point, Quality,
    geometry::distance,
    quality::{Assessment, Level, Predictor},
};
use bendtwin_graph::mean_spacing;

/// Largest error of a good twin, and of a fair one, by the object's size.
const OF_SIZE: [f64; 2] = [0.03, 0.06];
/// Bounds of the error relative to the error of standing still.
const OF_STANDING_STILL: [f64; 2] = [0.2, 0.33];
/// Share by which errors of two fits of one capture differ although only their seeds do
/// (docs/use/accuracy.md): a smaller difference between two fits says nothing.
const SEEDS_DIFFER: f64 = 0.15;

/// Lengths that errors of a twin are compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scale {
    /// Mean distance of a node to its sixth neighbour [m]; of a cable, of two nodes that follow one
    /// another on a rod.
    pub spacing_m: f64,
    /// Diagonal of the box around the nodes at rest [m].
    pub size_m: f64,
}

/// A comparison of the twin's error.
struct Comparison {
    level: Level,
    /// Text after "off by 3.1 mm: ".
    text: String,
    /// Advice if it is the worst.
    next: &'static str,
}

impl Scale {
    /// Size of the nodes of a twin at rest [m], shape [N, 3], and its rods, as in
    /// [`Graph::rods`](bendtwin_core::Graph::rods); rods of nodes that do not exist are skipped.
    pub fn of_nodes(nodes: &[Point], rods: &[Vec<u32>]) -> Self {
        let side = |axis: usize| {
            let along = || nodes.iter().map(|p| f64::from(p[axis]));
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let size_m = (0..3).map(|axis| side(axis).powi(2)).sum::<f64>().sqrt();
        let size_m = if nodes.is_empty() { 0.0 } else { size_m };
        Self { spacing_m: rod_spacing(nodes, rods).unwrap_or_else(|| mean_spacing(nodes)), size_m }
    }
}

/// Mean distance of nodes that follow one another on rods [m]; none without rods.
fn rod_spacing(nodes: &[Point], rods: &[Vec<u32>]) -> Option<f64> {
    let node = |index: u32| nodes.get(index as usize);
    let pairs = rods.iter().flat_map(|rod| rod.windows(2));
    let lengths = pairs.filter_map(|pair| Some(distance(*node(pair[0])?, *node(pair[1])?)));
    let (sum, count) =
        lengths.fold((0.0, 0), |(sum, count), length| (sum + f64::from(length), count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Puts a quality table in words. Of the comparisons with the object's size, the distance of the
/// nodes, standing still, the last residual and the error in training the worst decides; those
/// without data are left out.
pub fn assess(quality: &Quality, scale: Scale) -> Assessment {
    let measured = quality.scores.first().and_then(|own| Some((own, own.future.headline()?)));
    let Some((own, (measure, error_m))) = measured else { return unknown(quality) };
    let beside = |p: Predictor| {
        let score = quality.score(p).filter(|_| p != own.predictor)?;
        measure.of(&score.future).filter(|m| *m > 0.0)
    };
    let comparisons: Vec<Comparison> = [
        beside(Predictor::StandingStill).map(|m| beside_standing_still(error_m, m)),
        (scale.size_m > 0.0).then(|| of_size(error_m, scale)),
        (scale.spacing_m > 0.0).then(|| of_spacing(error_m, scale.spacing_m)),
        beside(Predictor::LastResidual).map(|m| beside_last_residual(error_m, m)),
        measure.of(&own.train).map(|m| of_training(error_m, m, scale)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let mut texts: Vec<String> = comparisons.iter().map(|c| c.text.clone()).collect();
    texts.extend(beside(Predictor::Axial).map(|axial_m| beside_axial(error_m, axial_m)));
    let off = format!("On frames that it never saw the twin is off by {:.1} mm", 1e3 * error_m);
    let why = match texts.is_empty() {
        true => format!("{off}."),
        false => format!("{off}: {}.", texts.join(", ")),
    };
    let of = |level: Level| comparisons.iter().find(|c| c.level == level);
    match (comparisons.is_empty(), of(Level::Poor).or_else(|| of(Level::Fair))) {
        (true, _) => Assessment { level: Level::Unknown, why, next: NOTHING_BESIDE.into() },
        (_, Some(worst)) => Assessment { level: worst.level, why, next: worst.next.into() },
        (_, None) => Assessment { level: Level::Good, why, next: USE_IT.into() },
    }
}

/// Errors below this have no ratio [m].
const LEAST_M: f64 = 1e-6;

const USE_IT: &str = "Use it for rollouts and plans of motions like those of its capture.";
const NOTHING_BESIDE: &str = "There is nothing to compare that with: score the twin with `bendtwin eval CAPTURE --twin FILE`.";
const DOES_NOT_FOLLOW: &str = "Do not plan with it: where the object hardly moves in these frames record a larger motion; else look for \
     what the recording lacks in `bendtwin capture report`, and fit again with `search.starts` of 3 or more.";
const FOLLOWS_ROUGHLY: &str = "Plan over short times with it, and fit again with `search.starts` of 3 or more or with sequences of \
     more motions.";
const FINER: &str = "Allow for that error in plans; a larger `graph.max_nodes` and `search.starts` of 3 or more can lower it.";
const NOT_FINER: &str = "Allow for that error in plans; it is one of motion, not of the graph: `search.starts` of 3 or more or \
     sequences of more motions can lower it, more nodes hardly.";
const MISSES_TRAINING: &str = "It misses even the frames that it was fitted to: look for what the recording lacks in `bendtwin \
     capture report`, and fit again with a larger `graph.max_nodes` and `search.starts` of 3 or more.";
/// A twin file keeps this text, so that another wording would change the bytes of twins.
const LASTS: &str = "Its error lasts: correct its states by what cameras see while it runs (docs/accuracy.md, predictions \
     from corrected states).";

fn beside_standing_still(error_m: f64, still_m: f64) -> Comparison {
    let level = level(error_m / still_m, OF_STANDING_STILL);
    let text = match error_m < still_m {
        true => {
            format!("{} times nearer than standing still", times(still_m / error_m.max(LEAST_M)))
        }
        false => format!("no nearer than standing still ({:.1} mm)", 1e3 * still_m),
    };
    let next = if level == Level::Poor { DOES_NOT_FOLLOW } else { FOLLOWS_ROUGHLY };
    Comparison { level, text, next }
}

fn of_size(error_m: f64, scale: Scale) -> Comparison {
    let share = error_m / scale.size_m;
    let level = level(share, OF_SIZE);
    let text =
        format!("{:.1} % of the object's size ({:.0} mm)", 100.0 * share, 1e3 * scale.size_m);
    let next = match level {
        Level::Poor => DOES_NOT_FOLLOW,
        _ if error_m <= scale.spacing_m => FINER,
        _ => NOT_FINER,
    };
    Comparison { level, text, next }
}

fn of_spacing(error_m: f64, spacing_m: f64) -> Comparison {
    let less = error_m <= spacing_m;
    let level = if less { Level::Good } else { Level::Fair };
    let than = if less { "less" } else { "more" };
    let text = format!("{than} than the {:.1} mm between its nodes", 1e3 * spacing_m);
    Comparison { level, text, next: NOT_FINER }
}

fn beside_last_residual(error_m: f64, residual_m: f64) -> Comparison {
    let nearer = error_m <= residual_m;
    let level = if nearer { Level::Good } else { Level::Fair };
    let by = if nearer { "nearer" } else { "farther" };
    let text = format!("{by} than with its last training error added ({:.1} mm)", 1e3 * residual_m);
    Comparison { level, text, next: LASTS }
}

fn beside_axial(error_m: f64, axial_m: f64) -> String {
    if !differ([error_m, axial_m]) {
        return format!("no difference from a fit without bending ({:.1} mm)", 1e3 * axial_m);
    }
    let (ratio, by) = match axial_m >= error_m {
        true => (axial_m / error_m.max(LEAST_M), "nearer"),
        false => (error_m / axial_m.max(LEAST_M), "farther"),
    };
    format!("{} times {by} than without bending", times(ratio))
}

/// True if two fits' errors of one capture differ by more than seeds alone make them differ. An error
/// that is no number differs from any.
pub fn differ(errors: [f64; 2]) -> bool {
    let [low, high] = [errors[0].min(errors[1]), errors[0].max(errors[1])];
    errors.iter().any(|e| e.is_nan()) || high > (1.0 + SEEDS_DIFFER) * low
}

/// The error on the frames of the fit, which shows whether the model can move as the object did;
/// beside it, the error on other frames shows how well the result generalises.
fn of_training(error_m: f64, train_m: f64, scale: Scale) -> Comparison {
    let share = if scale.size_m > 0.0 { train_m / scale.size_m } else { 0.0 };
    let text = format!(
        "{} times its error on the frames that it was fitted to ({:.1} mm)",
        times(error_m / train_m.max(LEAST_M)),
        1e3 * train_m
    );
    Comparison { level: level(share, OF_SIZE), text, next: MISSES_TRAINING }
}

fn unknown(quality: &Quality) -> Assessment {
    let train = quality.scores.first().and_then(|own| own.train.headline());
    let why = match train {
        Some((_, error_m)) => format!(
            "No frame was left that the fit did not see; on those that it saw the twin is off by {:.1} mm, \
             which says little of others.",
            1e3 * error_m
        ),
        None => "The twin was not scored.".to_owned(),
    };
    let next = "Keep frames at the end, or a whole sequence, out of training and fit again, or score the \
                twin on another capture of the object with `bendtwin eval CAPTURE --twin FILE`.";
    Assessment { level: Level::Unknown, why, next: next.into() }
}

fn level(ratio: f64, [good, fair]: [f64; 2]) -> Level {
    match ratio {
        r if r <= good => Level::Good,
        r if r <= fair => Level::Fair,
        // NaN too.
        _ => Level::Poor,
    }
}

fn times(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.2}") } else { format!("{ratio:.0}") }
}

#[cfg(test)]
mod tests;
