use super::{
    hypothesis::{Hypothesis, PoseChange},
    *,
};
use crate::{
    testing::{disturbed, healthy},
    thresholds::Thresholds,
    vector::distance,
};

#[test]
fn a_disturbed_camera_is_put_back() {
    let (_, mut recording) = healthy();
    let right = recording.cameras[2].poses[0];
    recording.cameras[2].poses[0] = disturbed(&right, 2.0, [0.004, -0.003, 0.006]);
    recording.frame_count = 1;
    let thresholds = Thresholds::default();
    let cancel = Default::default();
    let scans = crate::scan::scan(&recording, &thresholds, &cancel, &mut |_| {}).unwrap();
    let set = ViewSet {
        views: views(&recording.cameras, &scans, &thresholds.consistency),
        frames: vec![0],
        stride: 1,
        thresholds: &thresholds.consistency,
    };
    let declared = Hypothesis::declared(3);
    let found = correction::correct(&set, &declared, 2).unwrap();
    let moved = declared.with(2, |s| s.moved = Some(found.motion));
    let (before, after) = (set.misfit(&declared).unwrap(), set.misfit(&moved).unwrap());
    assert!(after < 0.6 * before, "{before} {after}");
    // The surface in the middle lands where it was, independent of the rest of the motion.
    let middle = [0.0, 0.0, 0.6];
    let put_back = moved.posed(&set.views, 2, 0).unwrap().pose;
    let place = |pose| crate::vector::to_world(pose, middle);
    assert!(distance(place(&put_back), place(&right)) < 0.006);
}

#[test]
fn repaired_mistakes_leave_nothing() {
    let (_, recording) = healthy();
    let right = recording.cameras[0].poses[0];
    for change in [
        PoseChange::Inverse,
        PoseChange::OpenGl,
        PoseChange::RotationInverse,
        PoseChange::Mirrored(0),
        PoseChange::Mirrored(2),
        PoseChange::MirroredPlace(1),
    ] {
        let twice = change.apply(&change.apply(&right));
        let apart = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
        let numbers = |p: &bendtwin_capture::raw::Pose| {
            p.rotation.iter().flatten().chain(&p.translation).copied().collect::<Vec<_>>()
        };
        assert!(numbers(&twice).iter().zip(&numbers(&right)).all(apart), "{change:?}");
    }
}

#[test]
fn crops_of_large_masks_are_coarser_and_still_place_pixels() {
    use bendtwin_capture::raw::{DepthImage, Mask};
    let (width, height) = (848, 480);
    let mask = Mask::filled(width, height, true);
    let depth = DepthImage::filled(width, height, 0.5);
    let crop = Crop::of(0, &mask, None, &depth, None).unwrap();
    assert_eq!(crop.stride, 3);
    assert!(crop.labels.len() <= 60_000);
    let cell = crop.cell([301.0, 200.0]).unwrap();
    assert_eq!(crop.pixel(cell), [300.0, 201.0]);
    assert_eq!(crop.cell([-5.0, 3.0]), None);
    assert!(Crop::of(0, &Mask::filled(4, 4, false), None, &depth, None).is_none());
}
