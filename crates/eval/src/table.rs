//! The quality table for people: Markdown or plain text, in millimetres.

use std::fmt::Write;

use bendtwin_core::{
    Quality,
    quality::{Choice, ErrorSummary, Likeness, Predictor, RecordingScore, Score, SpreadScore},
};

/// The style of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableStyle {
    /// Aligned columns for a terminal.
    Plain,
    /// A Markdown table.
    Markdown,
}

/// Name of a predictor in tables and pictures.
pub fn predictor_name(predictor: Predictor) -> &'static str {
    match predictor {
        Predictor::Bending => "twin (bending)",
        Predictor::Axial => "axial only",
        Predictor::MeanOfFits => "mean of fits",
        Predictor::StandingStill => "standing still",
        Predictor::LastResidual => "last residual",
        Predictor::ClampInterpolation => "clamp interpolation",
    }
}

/// Name of a row of a quality table: that of its predictor, with the number of fits that it is a mean of.
fn row_name(quality: &Quality, predictor: Predictor) -> String {
    match (predictor, &quality.spread) {
        (Predictor::MeanOfFits, Some(spread)) => format!("mean of {} fits", spread.fits),
        _ => predictor_name(predictor).to_owned(),
    }
}

type Column = (&'static str, fn(&ErrorSummary) -> Option<f64>);

/// A name and the part of a score that it stands for.
type Span = (&'static str, fn(&Score) -> &ErrorSummary);

const COLUMNS: [Column; 5] = [
    ("CD", |e| e.chamfer_l1_m),
    ("CD (L2)", |e| e.chamfer_l2_m),
    ("track", |e| e.track_m),
    ("coordinate", |e| e.coordinate_m),
    ("padded RMS", |e| e.padded_rms_m),
];

/// Columns of errors at the nodes, over future frames.
const AT_NODES: [Column; 2] =
    [("CD at nodes", |e| e.chamfer_l1_m), ("track at nodes", |e| e.track_m)];

type LikenessColumn = (&'static str, usize, fn(&Likeness) -> Option<f64>);

/// Names of likenesses, their decimals, and their meanings.
const LIKENESSES: [LikenessColumn; 5] = [
    ("IoU", 3, |l| l.iou),
    ("PSNR [dB]", 2, |l| l.psnr_db),
    ("SSIM", 3, |l| l.ssim),
    ("FLIP", 3, |l| l.flip),
    ("LPIPS", 3, |l| l.lpips),
];

/// Likeness of renderings: each predictor over all cameras, then the first one's by camera.
fn rendered(quality: &Quality, style: TableStyle) -> Option<String> {
    let mut lines: Vec<(String, Likeness, Likeness)> = Vec::new();
    let of = |s: &Score| s.rendered.clone().map(|rendered| (s.predictor, rendered));
    let scores: Vec<_> = quality.scores.iter().filter_map(of).collect();
    for (predictor, score) in &scores {
        lines.push((predictor_name(*predictor).to_owned(), score.train, score.future));
    }
    for camera in &scores.first()?.1.cameras {
        let unseen = if camera.held_out { " (held out)" } else { "" };
        lines.push((format!("camera {}{unseen}", camera.name), camera.train, camera.future));
    }
    let mut rows = vec![vec!["renderings".to_owned()]];
    rows.extend(lines.iter().map(|line| vec![line.0.clone()]));
    for (name, decimals, measure) in LIKENESSES {
        for (span, is_train) in [("train", true), ("future", false)] {
            let part =
                |l: &(String, Likeness, Likeness)| measure(if is_train { &l.1 } else { &l.2 });
            if lines.iter().any(|l| part(l).is_some()) {
                rows[0].push(format!("{name} {span}"));
                for (row, line) in rows[1..].iter_mut().zip(&lines) {
                    let cell = part(line).map_or("-".to_owned(), |x| format!("{x:.decimals$}"));
                    row.push(cell);
                }
            }
        }
    }
    Some(lay_out(&rows, style))
}

/// The choice of one of several starts as a sentence.
fn choice_in_words(choice: &Choice) -> String {
    let number = |loss: &Option<f64>| loss.map_or("none".to_owned(), |l| format!("{l:.2e}"));
    let by = match choice.held_back_frames {
        0 => "lowest loss over the training frames".to_owned(),
        n => format!("lowest loss over the last {n} training frames, which no start had seen then"),
    };
    let losses: Vec<String> = choice.losses.iter().map(number).collect();
    let (start, starts) = (choice.start + 1, choice.losses.len());
    format!("kept start {start} of {starts}, which had the {by} ({})", losses.join(", "))
}

/// The spread of several fits as a sentence.
fn spread_in_words(spread: &SpreadScore) -> String {
    let mut text = format!(
        "the predictions of {} fits are {} mm apart where the twin's error is {} mm",
        spread.fits,
        in_mm(Some(spread.mean_m)),
        in_mm(Some(spread.error_m))
    );
    if let Some(factor) = spread.factor() {
        let percent = 100.0 * spread.within;
        let _ = write!(
            text,
            ": expect {factor:.1} times the spread; {percent:.0} % of the points are within twice that"
        );
    }
    text
}

/// The twin's errors by recording in millimetres, beside how far the recording's first frame is from
/// the twin that was registered to it.
fn recordings(quality: &Quality, style: TableStyle) -> String {
    let of = &quality.recordings;
    let mut columns: Vec<(String, Vec<Option<f64>>)> = Vec::new();
    let registered = of.iter().map(|r| r.registered.map(|s| 1e-3 * s.median_mm)).collect();
    columns.push(("registered within".to_owned(), registered));
    for (name, error) in COLUMNS {
        for (span, is_train) in [("train", true), ("future", false)] {
            let part = |r: &RecordingScore| if is_train { r.train } else { r.future };
            columns.push((format!("{name} {span}"), of.iter().map(|r| error(&part(r))).collect()));
        }
    }
    columns.retain(|(_, values)| values.iter().any(Option::is_some));
    let heads = columns.iter().map(|c| c.0.clone());
    let mut rows = vec![std::iter::once("mm, by recording".to_owned()).chain(heads).collect()];
    for (index, recording) in of.iter().enumerate() {
        let cells = columns.iter().map(|c| in_mm(c.1[index]));
        rows.push(std::iter::once(recording.name.clone()).chain(cells).collect());
    }
    lay_out(&rows, style)
}

/// A number of metres in millimetres.
fn in_mm(value_m: Option<f64>) -> String {
    value_m.map_or("-".to_owned(), |m| format!("{:.2}", 1e3 * m))
}

/// The table in millimetres: a row per predictor, training and future errors side by side, then
/// those of nodes that are not the skin. Columns that the capture does not determine are left out.
/// The twin's errors by recording, the likeness of renderings, the choice of a start and warnings follow.
pub fn format_table(quality: &Quality, style: TableStyle) -> String {
    let spans: [Span; 2] = [("train", |s| &s.train), ("future", |s| &s.future)];
    let mut columns: Vec<(String, Vec<Option<f64>>)> = Vec::new();
    for (name, error) in COLUMNS {
        for (span, part) in spans {
            let values: Vec<Option<f64>> = quality.scores.iter().map(|s| error(part(s))).collect();
            if values.iter().any(Option::is_some) {
                columns.push((format!("{name} {span}"), values));
            }
        }
    }
    for (name, error) in AT_NODES {
        let at_nodes = |s: &Score| error(&s.at_nodes?.future);
        let values: Vec<Option<f64>> = quality.scores.iter().map(at_nodes).collect();
        if values.iter().any(Option::is_some) {
            columns.push((format!("{name} future"), values));
        }
    }
    let mut rows =
        vec![std::iter::once("mm".to_owned()).chain(columns.iter().map(|c| c.0.clone())).collect()];
    for (index, score) in quality.scores.iter().enumerate() {
        let cells = columns.iter().map(|c| in_mm(c.1[index]));
        let name = row_name(quality, score.predictor);
        rows.push(std::iter::once(name).chain(cells).collect());
    }
    let mut text = lay_out(&rows, style);
    if !quality.recordings.is_empty() {
        text.push('\n');
        text += &recordings(quality, style);
    }
    if let Some(rendered) = rendered(quality, style) {
        text.push('\n');
        text += &rendered;
    }
    if let Some(choice) = &quality.choice {
        let choice = choice_in_words(choice);
        let _ = match style {
            TableStyle::Plain => writeln!(text, "{choice}"),
            TableStyle::Markdown => writeln!(text, "\nThe fit {choice}."),
        };
    }
    if let Some(spread) = &quality.spread {
        let spread = spread_in_words(spread);
        let _ = match style {
            TableStyle::Plain => writeln!(text, "{spread}"),
            TableStyle::Markdown => writeln!(text, "\nUncertainty: {spread}."),
        };
    }
    for warning in &quality.warnings {
        let _ = match style {
            TableStyle::Plain => writeln!(text, "warning: {warning}"),
            TableStyle::Markdown => writeln!(text, "\n> {warning}"),
        };
    }
    text
}

fn lay_out(rows: &[Vec<String>], style: TableStyle) -> String {
    let width = |c: usize| {
        rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..rows.first().map_or(0, Vec::len)).map(width).collect();
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        let pad = |(c, cell): (usize, &String)| {
            let w = widths[c];
            if c == 0 { format!("{cell:<w$}") } else { format!("{cell:>w$}") }
        };
        let cells: Vec<String> = row.iter().enumerate().map(pad).collect();
        let _ = match style {
            TableStyle::Plain => writeln!(text, "{}", cells.join("  ").trim_end()),
            TableStyle::Markdown => writeln!(text, "| {} |", cells.join(" | ")),
        };
        if index == 0 && style == TableStyle::Markdown {
            let rule = |(c, w): (usize, &usize)| {
                let dashes = "-".repeat((*w).max(3) - usize::from(c > 0));
                if c == 0 { dashes } else { format!("{dashes}:") }
            };
            let rules: Vec<String> = widths.iter().enumerate().map(rule).collect();
            let _ = writeln!(text, "| {} |", rules.join(" | "));
        }
    }
    text
}

#[cfg(test)]
mod tests;
