//! The same fault in several cameras is one finding, which lists them: a wrong encoding is wrong in all.

use bendtwin_capture::raw::called;
use bendtwin_core::Finding;

use crate::Code;

/// Findings whose numbers are needed camera by camera: a correction belongs to one.
const SEPARATE: &[Code] = &[Code::CameraOff, Code::DepthScale, Code::CamerasSkewed];

/// Joins findings that say the same of one camera each. The worst gives the message and the numbers.
pub(crate) fn join(findings: &mut Vec<Finding>, names: &[String]) {
    let mut groups: Vec<(Option<String>, Vec<Finding>)> = Vec::new();
    for finding in findings.drain(..) {
        let template = template(&finding, names);
        match groups.iter_mut().find(|(other, _)| template.is_some() && *other == template) {
            Some((_, group)) => group.push(finding),
            None => groups.push((template, vec![finding])),
        }
    }
    findings.extend(groups.into_iter().filter_map(|(_, group)| joined(group, names)));
}

/// A finding about one camera without what differs from camera to camera: its name and all numbers.
fn template(finding: &Finding, names: &[String]) -> Option<String> {
    let [camera] = finding.cameras.as_slice() else { return None };
    if SEPARATE.iter().any(|code| code.name() == finding.code) {
        return None;
    }
    let mut text = finding.message.replace(&listed(*camera, names), "");
    if let Some(name) = names.get(*camera).filter(|name| !name.is_empty()) {
        text = text.replace(name.as_str(), "");
    }
    text.retain(|c| !c.is_ascii_digit() && c != '.');
    // One file, several files.
    Some(format!("{} {}", finding.code, text.replace("s ", " ")))
}

fn joined(mut group: Vec<Finding>, names: &[String]) -> Option<Finding> {
    group.sort_by_key(|f| f.severity);
    let mut group = group.into_iter();
    let mut worst = group.next()?;
    let mut others = Vec::new();
    for finding in group {
        others.extend(finding.cameras.iter().map(|camera| listed(*camera, names)));
        worst.cameras.extend(finding.cameras);
        let frames: Vec<usize> = worst.frames.drain(..).chain(finding.frames).collect();
        worst = worst.frames(sorted(frames));
        for code in finding.consequences {
            worst = worst.explains(code);
        }
    }
    if let Some((last, before)) = others.split_last() {
        let list = if before.is_empty() {
            last.clone()
        } else {
            format!("{} and {last}", before.join(", "))
        };
        worst.message = format!("{}; likewise {list}", worst.message);
    }
    worst.cameras = sorted(worst.cameras);
    Some(worst)
}

fn sorted(mut numbers: Vec<usize>) -> Vec<usize> {
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// The name of one of the cameras, as messages give it.
fn listed(index: usize, names: &[String]) -> String {
    called(index, names.get(index).map_or("", String::as_str))
}

#[cfg(test)]
mod tests {
    use bendtwin_core::Severity;

    use super::*;

    fn left(findings: &[Finding]) -> Vec<Finding> {
        let mut findings = findings.to_vec();
        join(&mut findings, &["left".to_owned(), "1".to_owned(), "right".to_owned()]);
        findings
    }

    #[test]
    fn one_fault_of_all_cameras_is_said_once() {
        let of = |camera: usize, text: &str| {
            Finding::warning("FRAMES_DAMAGED", text).cameras([camera]).frames([camera + 3])
        };
        let found = left(&[
            of(
                0,
                "1 file of camera 0 (left) cannot be read; the first: `color/left/3.png` is 16 bits",
            ),
            Finding::info("SINGLE_CAMERA", "one"),
            Finding {
                severity: Severity::Error,
                ..of(
                    1,
                    "36 files of camera 1 cannot be read; the first: `color/1/0.png` is 16 bits",
                )
            },
            of(
                2,
                "2 files of camera 2 (right) cannot be read; the first: `color/right/0.png` is 16 bits",
            ),
        ]);
        assert_eq!(found.len(), 2);
        assert_eq!(
            (found[0].severity, found[0].cameras.as_slice()),
            (Severity::Error, &[0, 1, 2][..])
        );
        assert_eq!(found[0].frames, [3, 4, 5]);
        let end = "`color/1/0.png` is 16 bits; likewise camera 0 (left) and camera 2 (right)";
        assert!(found[0].message.ends_with(end), "{}", found[0].message);
        // Said again, nothing changes.
        assert_eq!(left(&found), found);
    }

    #[test]
    fn different_faults_stay_apart() {
        let of =
            |camera: usize, code: &str, text: &str| Finding::warning(code, text).cameras([camera]);
        let found = [
            of(0, "FRAMES_DAMAGED", "1 file of camera 0 (left) is cut off"),
            of(1, "FRAMES_DAMAGED", "1 file of camera 1 is no image"),
            of(0, "CAMERA_OFF", "camera 0 (left) is 12 mm off"),
            of(1, "CAMERA_OFF", "camera 1 is 15 mm off"),
        ];
        assert_eq!(left(&found), found);
    }
}
