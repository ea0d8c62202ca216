use bendtwin_core::Severity;

use super::*;

fn left(findings: &[Finding]) -> Vec<Finding> {
    let mut findings = findings.to_vec();
    leave_out(&mut findings);
    findings
}

#[test]
fn what_follows_is_left_out_and_named_by_its_cause() {
    let cause = Finding::error("DEPTH_MISALIGNED", "depth is elsewhere");
    let consequence = Finding::warning("DEPTH_SPARSE", "much has no depth");
    let other = Finding::warning("FRAMES_LATE", "frames are late");
    let found = left(&[consequence, cause, other]);
    let codes: Vec<&str> = found.iter().map(|f| f.code.as_str()).collect();
    assert_eq!(codes, ["DEPTH_MISALIGNED", "FRAMES_LATE"]);
    assert_eq!(found[0].consequences, ["DEPTH_SPARSE"]);
    assert!(found[1].consequences.is_empty());
}

#[test]
fn no_error_is_lost() {
    // A certain cause takes over the severity.
    let found = left(&[
        Finding::warning("TRACKS_OFF_OBJECT", "tracks lie elsewhere"),
        Finding::error("OBJECT_NOT_TRACKED", "no track lies on the object"),
    ]);
    assert_eq!((found.len(), found[0].severity), (1, Severity::Error));
    // A likely one hides nothing worse.
    let found = left(&[
        Finding::warning("CAMERAS_SKEWED", "a camera is late"),
        Finding::error("CAMERA_OFF", "a camera is elsewhere"),
    ]);
    assert_eq!(found.len(), 2);
}

#[test]
fn causes_pass_on_what_followed_from_what_they_explain() {
    let found = left(&[
        Finding::error("MASK_COVERS_IMAGE", "white"),
        Finding::warning("MASKS_OVERLAP", "both").explains("TRACKS_OFF_OBJECT"),
    ]);
    assert_eq!(found[0].consequences, ["MASKS_OVERLAP", "TRACKS_OFF_OBJECT"]);
}

#[test]
fn no_fault_follows_from_itself() {
    let all = Code::ALL.iter().map(|code| Finding::error(code, "found"));
    let found = left(&all.collect::<Vec<_>>());
    assert!(found.iter().all(|f| !f.consequences.contains(&f.code)), "{found:?}");
}

#[test]
fn damage_throughout_explains_the_cameras_that_it_empties() {
    let damage = |camera| Finding::error("FRAMES_DAMAGED", "16-bit").cameras([camera]);
    let empty = |camera| Finding::error("CAMERA_EMPTY", "no frame").cameras([camera]);
    let found = left(&[damage(0), empty(0), damage(1), empty(1), empty(2)]);
    let kept: Vec<(&str, usize)> = found.iter().map(|f| (f.code.as_str(), f.cameras[0])).collect();
    assert_eq!(kept, [("FRAMES_DAMAGED", 0), ("FRAMES_DAMAGED", 1), ("CAMERA_EMPTY", 2)]);
    // A single damaged file explains no camera without masks.
    let one = Finding::warning("FRAMES_DAMAGED", "cut off").cameras([0]);
    let found = left(&[one, Finding::error("MASKS_MISSING", "no masks")]);
    assert_eq!(found.len(), 2);
}

#[test]
fn what_a_finding_names_is_not_said_again() {
    let cause = Finding::warning("HELD_MARKERS_MISSING", "none is held").explains("NO_CONTROLS");
    let found = left(&[cause.clone(), Finding::warning("NO_CONTROLS", "none")]);
    assert_eq!(found, std::slice::from_ref(&cause));
    // A worse one is.
    assert_eq!(left(&[cause, Finding::error("NO_CONTROLS", "none")]).len(), 2);
}
