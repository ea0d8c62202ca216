use std::sync::Arc;

use bendtwin_capture::raw::{Mask, Region};
use bendtwin_core::{Problem as _, settings::ingest::Part};
use bendtwin_synth::{Dyes, FilmOptions, Hands, Scene, Shape, film};

use super::*;

/// A small film with three cameras.
fn options(frames: usize) -> FilmOptions {
    FilmOptions {
        frames,
        cameras: 3,
        size: [212, 120],
        tracks: false,
        shape: Shape::Absent,
        ..FilmOptions::tiny(5)
    }
}

/// The true masks of a film, and the film without them.
fn filmed(scene: Scene, options: &FilmOptions) -> (MaskSet, Recording) {
    let recording = film(scene, options).unwrap();
    let truth = MaskSet::of(&recording).unwrap();
    let none = Arc::new(MaskSet::empty(&recording));
    (truth, recording.with_masks(none))
}

/// Clicks in the middle of the object, and of this number of hands, in the first camera.
fn clicks(truth: &MaskSet, frame: usize, hands: usize) -> Vec<Stroke> {
    let mut strokes = Vec::new();
    for (part, region, count) in
        [(Part::Object, Region::Object, 1), (Part::Hand, Region::Manipulator, hands)]
    {
        let mask = truth.mask(0, frame, region).unwrap();
        let mut taken: Vec<[f64; 2]> = Vec::new();
        for _ in 0..count {
            let [x, y] = middle(&mask, &taken);
            strokes.push(Stroke { frame: frame as u32, ..Stroke::click(part, 0, x, y) });
            taken.push([x, y]);
        }
    }
    strokes
}

/// The pixel of a mask with most of its pixels around it, away from others.
fn middle(mask: &Mask, taken: &[[f64; 2]]) -> [f64; 2] {
    let around = |x: usize, y: usize| {
        let rows = y.saturating_sub(4)..y + 5;
        let columns = x.saturating_sub(4)..x + 5;
        rows.flat_map(|row| columns.clone().map(move |column| (column, row)))
            .filter(|(column, row)| mask.get(*column, *row) == Some(true))
            .count()
    };
    let free =
        |x: usize, y: usize| taken.iter().all(|[a, b]| (a - x as f64).hypot(b - y as f64) > 35.0);
    let all = (0..mask.pixels.len()).map(|at| (at % mask.width, at / mask.width));
    let inside = all.filter(|(x, y)| mask.get(*x, *y) == Some(true) && free(*x, *y));
    let (x, y) = inside.max_by_key(|(x, y)| around(*x, *y)).unwrap();
    [x as f64, y as f64]
}

/// Intersection over union of object and of hands, of all cameras and these frames.
fn overlap(truth: &MaskSet, made: &MaskSet, frames: std::ops::Range<usize>) -> [f64; 2] {
    [Region::Object, Region::Manipulator].map(|region| {
        let (mut both, mut any) = (0, 0);
        for (camera, frame) in (0..3).flat_map(|c| frames.clone().map(move |f| (c, f))) {
            let [a, b] = [truth, made].map(|set| set.mask(camera, frame, region).unwrap());
            for (a, b) in a.pixels.iter().zip(&b.pixels) {
                both += usize::from(*a && *b);
                any += usize::from(*a || *b);
            }
        }
        both as f64 / any as f64
    })
}

fn made(recording: &Recording, strokes: &[Stroke]) -> Segmented {
    segment(recording, strokes, &mut |_| {}, &CancelToken::default()).unwrap()
}

fn has(made: &Segmented, code: &str) -> bool {
    made.findings.iter().any(|finding| finding.code == code)
}

#[test]
fn a_click_for_the_object_and_one_for_the_hand_mask_a_toy() {
    let (truth, recording) = filmed(Scene::Toy, &options(10));
    let strokes = clicks(&truth, 0, 1);
    let mut shares = Vec::new();
    let progress = &mut |share| shares.push(share);
    let made = segment(&recording, &strokes, progress, &CancelToken::default()).unwrap();
    let [object, hand] = overlap(&truth, &made.masks, 0..10);
    assert!(object > 0.9 && hand > 0.85, "{object:.3} {hand:.3}");
    assert!(made.findings.is_empty(), "{:?}", made.findings);
    let doubts: Vec<f32> = made.doubt.iter().flatten().map(|doubt| doubt.unwrap()).collect();
    assert!(doubts.len() == 30 && doubts.iter().all(|doubt| (0.0..0.2).contains(doubt)));
    assert!(shares.len() == 10 && shares.is_sorted() && shares[9] == 1.0);
    // However threads divide the work.
    assert_eq!(self::made(&recording, &strokes).masks, made.masks);

    // Cameras that move have no backdrop.
    let mut moving = recording.clone();
    moving.cameras.iter_mut().for_each(|camera| camera.poses = vec![camera.poses[0]; 10]);
    let [object, hand] = overlap(&truth, &self::made(&moving, &strokes).masks, 0..10);
    assert!(object > 0.85 && hand > 0.75, "moving {object:.3} {hand:.3}");
}

#[test]
fn two_hands_are_marked_by_a_click_each() {
    let (truth, recording) = filmed(Scene::Ring, &FilmOptions { hands: Hands::Two, ..options(10) });
    let made = made(&recording, &clicks(&truth, 0, 2));
    let [object, hand] = overlap(&truth, &made.masks, 0..10);
    assert!(object > 0.85 && hand > 0.85, "{object:.3} {hand:.3}");
}

#[test]
fn a_second_hand_that_comes_later_is_known_by_its_colour() {
    let options = FilmOptions { hands: Hands::Joining, clutter: true, ..options(20) };
    let (truth, recording) = filmed(Scene::Bar, &options);
    let made = made(&recording, &clicks(&truth, 0, 1));
    let [object, hand] = overlap(&truth, &made.masks, 14..20);
    assert!(object > 0.8 && hand > 0.8, "{object:.3} {hand:.3}");
}

#[test]
fn a_later_stroke_changes_frames_before_and_after_it() {
    let (truth, recording) = filmed(Scene::Toy, &options(12));
    let object = Stroke { frame: 2, ..clicks(&truth, 2, 1)[0].clone() };
    let without = made(&recording, std::slice::from_ref(&object));
    assert!(has(&without, "HAND_NOT_MARKED"));
    let shown = |made: &Segmented, frame: usize| {
        let mask = made.masks.mask(1, frame, Region::Manipulator).unwrap();
        mask.pixels.iter().filter(|shown| **shown).count()
    };
    assert!((0..12).all(|frame| shown(&without, frame) == 0));
    let hand = clicks(&truth, 8, 1)[1].clone();
    let with = made(&recording, &[object, hand]);
    // Half way between the two frames with strokes, and to the end.
    let [_, iou] = overlap(&truth, &with.masks, 6..12);
    assert!(iou > 0.8, "{iou:.3}");
    // From the first of them to the start.
    assert!(with.doubt.iter().all(|doubt| doubt.iter().all(Option::is_some)));
}

#[test]
fn what_cannot_be_told_apart_is_said() {
    let base = Dyes::default();
    let alike = FilmOptions { dyes: Dyes { hand: base.body, ..base }, ..options(4) };
    let (truth, recording) = filmed(Scene::Toy, &alike);
    let made = made(&recording, &clicks(&truth, 0, 1));
    assert!(has(&made, "MASKS_INSEPARABLE"), "{:?}", made.findings);
    let camouflaged = FilmOptions { dyes: Dyes { body: base.table, ..base }, ..options(4) };
    let (truth, recording) = filmed(Scene::Toy, &camouflaged);
    let made = self::made(&recording, &clicks(&truth, 0, 1));
    assert!(has(&made, "OBJECT_LIKE_TABLE"), "{:?}", made.findings);
    assert!(!has(&made, "MASKS_INSEPARABLE"), "{:?}", made.findings);
}

#[test]
fn work_is_cancelled_within_a_frame() {
    let (truth, recording) = filmed(Scene::Toy, &options(8));
    let strokes = clicks(&truth, 0, 1);
    let cancel = CancelToken::default();
    let mut calls = 0;
    let stopped = segment(
        &recording,
        &strokes,
        &mut |_| {
            calls += 1;
            if calls == 3 {
                cancel.cancel();
            }
        },
        &cancel,
    );
    assert!(matches!(stopped, Err(Error::Cancelled)) && calls == 3);
    let stopped = segment(&recording, &strokes, &mut |_| calls += 1, &cancel);
    assert!(matches!(stopped, Err(Error::Cancelled)) && calls == 3);
}

#[test]
fn strokes_that_mean_nothing_are_named() {
    let (truth, recording) = filmed(Scene::Toy, &options(4));
    let good = clicks(&truth, 0, 1);
    let stray =
        |part, camera, frame, x: f64| Stroke { frame, ..Stroke::click(part, camera, x, 0.0) };
    let strays = [
        stray(Part::Hand, 99, 0, 1.0),
        stray(Part::Hand, 0, u32::MAX, 1.0),
        stray(Part::Background, 1, 0, 9e9),
        // The void above the table.
        stray(Part::Background, 2, 1, 1.0),
    ];
    let made = made(&recording, &[good.as_slice(), &strays].concat());
    let count = |code: &str| made.findings.iter().filter(|f| f.code == code).count();
    assert_eq!(
        (count("STROKE_OUTSIDE"), count("STROKE_WITHOUT_DEPTH")),
        (3, 1),
        "{:?}",
        made.findings
    );
    let [object, hand] = overlap(&truth, &made.masks, 0..4);
    assert!(object > 0.85 && hand > 0.8, "{object:.3} {hand:.3}");

    let refused = |strokes: &[Stroke]| {
        segment(&recording, strokes, &mut |_| {}, &CancelToken::default()).unwrap_err().reason()
    };
    assert_eq!(refused(&strays), "OBJECT_NOT_MARKED");
    assert_eq!(refused(&[stray(Part::Object, 2, 1, 1.0)]), "OBJECT_WITHOUT_DEPTH");
    assert_eq!(refused(&[stray(Part::Object, 7, 1, 1.0)]), "OBJECT_WITHOUT_DEPTH");
    let mut nowhere = recording.clone();
    nowhere.cameras[1].poses.clear();
    let refused = segment(&nowhere, &good, &mut |_| {}, &CancelToken::default()).unwrap_err();
    assert_eq!(refused.reason(), "NOT_CALIBRATED");
}

#[test]
fn the_document_has_the_strokes_and_the_doubt() {
    let (truth, recording) = filmed(Scene::Toy, &options(4));
    let strokes = clicks(&truth, 0, 1);
    let document = made(&recording, &strokes).document(&strokes);
    assert_eq!(document["cameras"].as_array().unwrap().len(), 3);
    assert_eq!(document["cameras"][0]["doubt"].as_array().unwrap().len(), 4);
    let read: Vec<Stroke> = serde_json::from_value(document["strokes"].clone()).unwrap();
    assert_eq!(read, strokes);
}

#[test]
fn doubtful_and_lost_images_are_named() {
    let names = ["left".to_owned(), "right".to_owned()];
    let mut doubt = vec![vec![Some(0.1); 20]; 2];
    assert!(findings::doubtful(&names, &doubt).is_none());
    doubt[1][4..6].fill(Some(0.4));
    let found = findings::doubtful(&names, &doubt).unwrap();
    assert_eq!((found.cameras, found.frames), (vec![1], vec![4, 5]));
    let lost = findings::lost("object", "OBJECT_NOT_FOLLOWED", &[true, false, true]);
    assert_eq!(lost.unwrap().frames, [1]);
    assert!(findings::lost("hand", "HAND_NOT_FOLLOWED", &[true; 3]).is_none());
}
