//! The report as one page: verdict and what to do on top, then figures, cameras, time, pictures. No
//! script, nothing from elsewhere; light and dark, and fit for paper.

mod cameras;
mod chart;
mod evidence;
mod findings;
mod markup;
mod pictures;
mod sources;
mod timeline;

use bendtwin_core::Severity;

use self::markup::escape;
use crate::{Kind, Report, Verdict};

/// The page's style sheet.
const STYLE: &str = include_str!("page/style.css");

pub(crate) fn page(report: &Report) -> String {
    let seen = report.inspection();
    let title = escape(&seen.name);
    let mut body = String::new();
    body.push_str(&verdict(report));
    body.push_str(&facts(report));
    body.push_str(&findings::section(seen));
    body.push_str(&sources::section(seen));
    body.push_str(&cameras::section(seen));
    body.push_str(&timeline::section(seen));
    body.push_str(&pictures::section(seen));
    body.push_str(&evidence::section(report.evidence()));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}: capture report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}\
         <footer>Capture report, version {}. The same as JSON: <code>bendtwin capture report</code>. What each code means: \
         docs/use/captures.md.</footer>\n</main>\n</body>\n</html>\n",
        crate::report::VERSION
    )
}

fn verdict(report: &Report) -> String {
    let seen = report.inspection();
    let (class, mark, words) = match seen.verdict {
        Verdict::Good => ("good", "&#10003;", "This recording is good."),
        Verdict::Usable => (
            "usable",
            "!",
            "This recording can be fitted; the warnings say what holds the twin back.",
        ),
        Verdict::Unusable => ("unusable", "&#10005;", "This recording cannot be fitted."),
    };
    let words = match seen.kind {
        Kind::Recording => words.to_owned(),
        Kind::Observed => words.replace("recording", "capture"),
    };
    let first = match seen.first_step() {
        Some(finding) => format!(
            "<p class=\"first\"><b>Do this first:</b> {}.</p><p class=\"why\">{}.</p>",
            escape(&capitalised(&finding.advice)),
            escape(&capitalised(&finding.message))
        ),
        None => "<p class=\"first\">Nothing has to be done: start a fit.</p>".to_owned(),
    };
    let count = |severity, one: &str| match report.count(severity) {
        0 => String::new(),
        1 => format!("<span class=\"count {one}\">1 {one}</span>"),
        n => format!("<span class=\"count {one}\">{n} {one}s</span>"),
    };
    format!(
        "<header class=\"verdict {class}\">\n<div class=\"mark\" aria-hidden=\"true\">{mark}</div>\n<div>\n<p class=\"kicker\">Capture \
         report</p>\n<h1>{}</h1>\n<p class=\"words\">{words}</p>\n{first}\n<p>{}{}</p>\n</div>\n</header>\n",
        escape(&seen.name),
        count(Severity::Error, "error"),
        count(Severity::Warning, "warning")
    )
}

fn capitalised(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

fn facts(report: &Report) -> String {
    let seen = report.inspection();
    let scene = &seen.scene;
    let mut facts: Vec<(&str, String)> = Vec::new();
    let duration = seen.fps.filter(|fps| *fps > 0.0).map(|fps| seen.frame_count as f64 / fps);
    let length = match (duration, seen.fps) {
        (Some(seconds), Some(fps)) => {
            format!("{} frames, {seconds:.1} s at {fps:.4} fps", seen.frame_count)
                .replace(".0000 fps", " fps")
        }
        _ => format!("{} frames", seen.frame_count),
    };
    facts.push(("Length", length));
    facts
        .push(("For fitting", format!("frames 0 to {}", seen.train_frame_count.saturating_sub(1))));
    if !seen.cameras.is_empty() {
        facts.push(("Cameras", seen.cameras.len().to_string()));
    }
    if let Some(observed) = &seen.observed {
        facts.push(("Tracked points", observed.point_count.to_string()));
        facts.push(("Control points", observed.control_count.to_string()));
        if observed.completed_count + observed.interior_count > 0 {
            facts.push((
                "Completed, interior",
                format!("{}, {}", observed.completed_count, observed.interior_count),
            ));
        }
    }
    let metres = |m: f64| {
        if m.abs() < 0.1 {
            format!("{:.0} mm", 1e3 * m)
        } else if m.abs() < 1.0 {
            format!("{:.1} cm", 1e2 * m)
        } else {
            format!("{m:.2} m")
        }
    };
    let mut measured = |name, value: Option<f64>| {
        facts.extend(value.map(|v| (name, metres(v))));
    };
    measured("Object's size", scene.object_size_m);
    measured("Hand's size", scene.manipulator_size_m);
    measured("Object travels", scene.travel_m);
    measured("Hand travels", scene.manipulator_travel_m);
    measured("Lowest over ground", scene.lowest_m);
    measured(
        "Hand to object, nearest",
        scene.gap_m.iter().flatten().copied().min_by(f64::total_cmp),
    );
    facts.extend(scene.fastest_m_s.map(|v| ("Fastest", format!("{v:.2} m/s"))));
    let cells = facts
        .iter()
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{}</dd></div>\n", escape(value)));
    format!("<dl class=\"facts\">\n{}</dl>\n", cells.collect::<String>())
}
