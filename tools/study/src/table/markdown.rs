//! The table for people.

use std::fmt::Write as _;

use super::{
    Difference, Figure, Gains, Kind, Row, Table,
    samples::{COLUMNS, Column},
};
use crate::Verdict;

/// Writes the whole document.
pub(super) fn write(table: &Table) -> String {
    let mut text = format!("# {}\n", table.suite);
    if !table.about.is_empty() {
        let _ = write!(text, "\n{}\n", table.about);
    }
    text += "\nErrors in mm: one-sided Chamfer distance in the L1 norm (CD) and Euclidean (L2), track error, mean coordinate \
             difference (motion capture) and its padded root mean square (cables with branches), on training and on future frames.\n\n";
    text += &errors(table);
    if !table.differences.is_empty() {
        text += "\nErrors of the first against those of the second; negative is better. Below a difference of means, the \
                 interval that 95 % of draws of captures and seeds lie in. `no difference`: it contains zero, or seeds differ by \
                 more.\n\n";
        text += &differences(&table.differences);
    }
    if let Some(gains) = &table.gains {
        text += "\nThe same by the springs that meet at a node, in the twin that is compared with: geometric means over \
                 captures of the ratio of errors in future frames (track, else coordinate, else CD), in percent.\n\n";
        text += &by_degree(gains);
    }
    if !table.failures.is_empty() {
        text += "\nFailed:\n\n";
        for failure in &table.failures {
            let message = failure.message.replace('\n', " ");
            let _ = writeln!(text, "- `{}` ({}): {message}", failure.run, failure.reason);
        }
    }
    if table.missing > 0 {
        let _ = writeln!(text, "\n{} of {} runs have no result yet.", table.missing, table.runs);
    }
    let _ = writeln!(text, "\nMade by {} on {} with", list(&table.builds), list(&table.devices));
    let _ = writeln!(text, "\n    {}", table.command);
    let commands = table.rows.iter().filter_map(|r| r.command.as_ref());
    text += "\nA row by itself (in another folder than this, where its runs are done):\n\n";
    for command in commands {
        let _ = writeln!(text, "    {command}");
    }
    text += "\nA run by itself, without the suite: the `command` in its file under `runs/`.\n";
    text
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "nothing yet".to_owned() } else { names.join(", ") }
}

fn errors(table: &Table) -> String {
    let rows = || table.rows.iter().chain(&table.means);
    let columns: Vec<&Column> =
        COLUMNS.iter().filter(|c| rows().any(|r| r.errors.contains_key(c.key))).collect();
    let mut header = vec!["capture".to_owned(), "twin or baseline".to_owned()];
    header.extend(["nodes", "springs", "degree", "triplets"].map(str::to_owned));
    header.extend(columns.iter().map(|c| c.heading.to_owned()));
    header.push("fit [s]".to_owned());
    let mut lines = vec![header];
    for row in rows() {
        let count = |of: fn(&super::Size) -> f64| {
            row.size.as_ref().map_or("-".to_owned(), |size| format!("{:.0}", of(size)))
        };
        let mut cells = vec![name(row), row.label.clone()];
        let degree = row.size.and_then(|size| size.degree);
        let degree = degree.map_or("-".to_owned(), |degree| format!("{degree:.1}"));
        cells.extend([count(|s| s.nodes), count(|s| s.springs), degree, count(|s| s.triplets)]);
        cells.extend(columns.iter().map(|c| figure(row.errors.get(c.key), 2)));
        cells.push(figure(row.fit_s.as_ref(), 1));
        lines.push(cells);
    }
    lay_out(&lines, 2)
}

fn name(row: &Row) -> String {
    match (&row.capture, row.captures) {
        (Some(capture), _) => capture.clone(),
        (None, Some(n)) => format!("mean of {n}"),
        (None, None) if row.kind == Kind::Published => "mean as published".to_owned(),
        (None, None) => "mean".to_owned(),
    }
}

fn figure(figure: Option<&Figure>, digits: usize) -> String {
    match figure {
        Some(Figure { mean, spread: Some(spread) }) => {
            format!("{mean:.digits$} ± {spread:.digits$}")
        }
        Some(Figure { mean, spread: None }) => format!("{mean:.digits$}"),
        None => "-".to_owned(),
    }
}

fn differences(all: &[Difference]) -> String {
    let columns: Vec<&Column> =
        COLUMNS.iter().filter(|c| all.iter().any(|d| d.percent.contains_key(c.key))).collect();
    let mut header = vec!["%".to_owned(), "capture".to_owned(), "same nodes".to_owned()];
    header.extend(columns.iter().map(|c| c.heading.to_owned()));
    let mut lines = vec![header];
    for d in all {
        let same = match d.same_nodes {
            Some(true) => "yes",
            Some(false) => "no",
            None => "-",
        };
        let capture = d.capture.as_deref().unwrap_or("mean").to_owned();
        let mut cells = vec![format!("{} against {}", d.of, d.against), capture, same.to_owned()];
        let is_none =
            |c: &Column| d.certainty.get(c.key).is_some_and(|c| c.verdict == Verdict::NoDifference);
        cells.extend(columns.iter().map(|c| match d.percent.get(c.key) {
            Some(_) if is_none(c) => NO_DIFFERENCE.to_owned(),
            Some(percent) => format!("{percent:+.1}"),
            None => "-".to_owned(),
        }));
        lines.push(cells);
        if !d.certainty.is_empty() {
            let mut cells = vec![String::new(), "between".to_owned(), String::new()];
            cells.extend(columns.iter().map(|c| match d.certainty.get(c.key) {
                Some(certainty) => interval(certainty.interval),
                None => "-".to_owned(),
            }));
            lines.push(cells);
        }
        if !d.better.is_empty() {
            let mut cells = vec![String::new(), "better in".to_owned(), String::new()];
            cells.extend(columns.iter().map(|c| match d.better.get(c.key) {
                Some((wins, n)) => format!("{wins} of {n}"),
                None => "-".to_owned(),
            }));
            lines.push(cells);
        }
    }
    lay_out(&lines, 3)
}

/// Text in place of a difference that chance explains.
const NO_DIFFERENCE: &str = "no difference";

fn interval([low, high]: [f64; 2]) -> String {
    format!("{low:+.1}, {high:+.1}")
}

fn by_degree(gains: &Gains) -> String {
    let header = ["series", "group", "degree", "captures", "pairs", "%", "between", "seeds differ"];
    let mut lines = vec![header.map(str::to_owned).to_vec()];
    for gain in &gains.gains {
        let dash = || "-".to_owned();
        let certainty = gain.certainty.as_ref();
        let said = match certainty.map(|c| c.verdict) {
            Some(Verdict::NoDifference) => NO_DIFFERENCE.to_owned(),
            _ => format!("{:+.1}", gain.percent),
        };
        let seeds = certainty.and_then(|c| c.seeds_differ);
        lines.push(vec![
            gain.series.clone(),
            gain.group.clone().unwrap_or_else(|| "all".to_owned()),
            format!("{:.1}", gain.mean_degree),
            gain.captures.to_string(),
            gain.pairs.to_string(),
            said,
            certainty.map_or_else(dash, |c| interval(c.interval)),
            seeds.map_or_else(dash, |seeds| format!("{seeds:.1}")),
        ]);
    }
    lay_out(&lines, 2)
}

/// Columns as wide as their widest cell; the first `text_columns` begin on the left, the others end
/// on the right.
fn lay_out(lines: &[Vec<String>], text_columns: usize) -> String {
    let width = |c: usize| {
        lines.iter().filter_map(|l| l.get(c)).map(|s| s.chars().count()).max().unwrap_or(0).max(3)
    };
    let widths: Vec<usize> = (0..lines.first().map_or(0, Vec::len)).map(width).collect();
    let mut text = String::new();
    for (index, line) in lines.iter().enumerate() {
        let pad = |(c, cell): (usize, &String)| {
            let w = widths[c];
            if c < text_columns { format!("{cell:<w$}") } else { format!("{cell:>w$}") }
        };
        let cells: Vec<String> = line.iter().enumerate().map(pad).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
        if index == 0 {
            let rule = |(c, w): (usize, &usize)| {
                if c < text_columns { "-".repeat(*w) } else { "-".repeat(w - 1) + ":" }
            };
            let rules: Vec<String> = widths.iter().enumerate().map(rule).collect();
            let _ = writeln!(text, "| {} |", rules.join(" | "));
        }
    }
    text
}
