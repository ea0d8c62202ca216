//! The cameras side by side, and how they agree in pairs.

use super::markup::{escape, mm, ms, percent};
use crate::{CameraReport, Inspection, PairReport, thresholds::AgreementThresholds};

/// Most cameras of a readable matrix.
const MAX_CAMERAS: usize = 16;

pub(super) fn section(seen: &Inspection) -> String {
    if seen.cameras.is_empty() {
        return String::new();
    }
    let rows: String = seen.cameras.iter().enumerate().map(|(i, c)| row(seen, i, c)).collect();
    format!(
        "<section>\n<h2>Cameras</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>Camera</th><th>Image</th>\
         <th title=\"frames without colour or depth\">Missing</th><th title=\"frames like the one before\">Repeated</th>\
         <th title=\"frames that came late by their times\">Late</th><th title=\"how much later than the others, by motion\">Skew</th>\
         <th title=\"median share of the object with depth\">Coverage</th><th title=\"frames in which the mask's area jumps\">Mask jumps</th>\
         <th title=\"tracks, and how many of the visible lie on the masks\">Tracks</th><th title=\"median distance to the other cameras' surfaces\">\
         Disagrees</th><th title=\"what would move it onto the others\">Correction</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n{}</section>\n",
        matrix(seen)
    )
}

fn row(seen: &Inspection, index: usize, camera: &CameraReport) -> String {
    let own = seen.findings.iter().filter(|f| f.cameras.contains(&index));
    let worst = own.map(|f| f.severity).min();
    let class = match worst {
        Some(bendtwin_core::Severity::Error) => "error",
        Some(bendtwin_core::Severity::Warning) => "warning",
        _ => "fine",
    };
    let count = |frames: &[usize]| match frames.len() {
        0 => "<td class=\"zero\">0</td>".to_owned(),
        n => format!("<td class=\"some\">{n}</td>"),
    };
    let agreement = camera.agreement.unwrap_or_default();
    let correction = match (agreement.correction_deg, agreement.correction_mm) {
        (Some(angle), Some(shift)) => format!("{shift:.1} mm, {angle:.1}&deg;"),
        _ if agreement.disagreement_mm.is_some() => "none".to_owned(),
        _ => "&ndash;".to_owned(),
    };
    let tracks = match &camera.tracks {
        Some(tracks) => format!("{}, {} on masks", tracks.count, percent(tracks.inside)),
        None => "&ndash;".to_owned(),
    };
    format!(
        "<tr class=\"{class}\"><th scope=\"row\"><span class=\"dot\"></span>{index} <span class=\"name\">{}</span></th><td>{} &times; {}</td>{}{}{}<td>{}</td><td>{}</td>{}<td>{tracks}</td><td>{}</td><td>{correction}</td></tr>\n",
        escape(&camera.name),
        camera.width,
        camera.height,
        count(&camera.missing_frames),
        count(&camera.repeated_frames),
        count(&camera.late_frames),
        ms(camera.skew_ms.or(camera.skew_by_times_ms)),
        percent(camera.median_coverage),
        count(&camera.mask_jumps),
        mm(agreement.disagreement_mm),
    )
}

fn matrix(seen: &Inspection) -> String {
    let n = seen.cameras.len().min(MAX_CAMERAS);
    if n < 2 || seen.pairs.iter().all(|p| p.misfit.is_none()) {
        return String::new();
    }
    let find = |a: usize, b: usize| seen.pairs.iter().find(|p| (p.a, p.b) == (a.min(b), a.max(b)));
    let head: String = (0..n).map(|b| format!("<th>{b}</th>")).collect();
    let rows: String = (0..n)
        .map(|a| {
            let cells: String =
                (0..n)
                    .map(|b| {
                        if a == b {
                            "<td class=\"self\"></td>".to_owned()
                        } else {
                            cell(find(a, b))
                        }
                    })
                    .collect();
            format!("<tr><th scope=\"row\">{a}</th>{cells}</tr>\n")
        })
        .collect();
    format!(
        "<h3>Agreement in pairs</h3>\n<p class=\"hint\">Median distance between the surfaces that two cameras measured where both face them, \
         and the share of points that contradict the other camera's masks or depth.</p>\n<div class=\"wide\"><table class=\"matrix\">\n\
         <thead><tr><th></th>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

fn cell(pair: Option<&PairReport>) -> String {
    let Some(pair) = pair.filter(|p| p.misfit.is_some()) else {
        return "<td class=\"none\">nothing in common</td>".to_owned();
    };
    let limits = AgreementThresholds::default();
    let is_apart = |m: f64| pair.disagreement_mm.is_some_and(|mm| mm > 1e3 * m);
    let class = match pair.misfit.unwrap_or(0.0) {
        m if m > limits.max_misfit || is_apart(limits.max_disagreement_m) => "bad",
        m if m > limits.fair_misfit || is_apart(limits.fair_disagreement_m) => "fair",
        _ => "well",
    };
    format!(
        "<td class=\"{class}\">{}<small>{:.0} % contradict</small></td>",
        mm(pair.disagreement_mm),
        100.0 * pair.conflict
    )
}
