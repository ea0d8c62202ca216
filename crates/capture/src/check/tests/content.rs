//! Captures that can be read, but should not be believed.

use super::{
    Severity::{Error, Warning},
    *,
};

type Break = fn(&mut Capture);

const BROKEN: &[(&str, Severity, &str, Break)] = &[
    ("NO_FRAMES", Error, "`main`", |c| {
        let s = &mut c.sequences[0];
        for points in [&mut s.points, &mut s.controls, &mut s.truth_tracks] {
            points.clear();
        }
        s.visible.clear();
        s.motion_valid.clear();
        (s.frame_count, s.train_frame_count) = (0, 0);
    }),
    ("ONE_FRAME", Error, "one frame", |c| cut(c, 1)),
    ("NO_POINTS", Error, "no tracked points", |c| {
        c.object.point_count = 0;
        c.object.colors.clear();
        let s = &mut c.sequences[0];
        s.points.clear();
        s.visible.clear();
        s.motion_valid.clear();
    }),
    ("SPLIT_EMPTY", Error, "0 frames", |c| c.sequences[0].train_frame_count = 0),
    ("SPLIT_OUT_OF_RANGE", Error, "frame 25", |c| c.sequences[0].train_frame_count = 25),
    ("NO_FUTURE", Warning, "predicts", |c| c.sequences[0].train_frame_count = 24),
    ("FPS_INVALID", Error, "NaN fps", |c| c.fps = f64::NAN),
    ("FPS_INVALID", Error, "0.000", |c| c.fps = 1e-300),
    ("FPS_INVALID", Error, "1000000", |c| c.fps = 1e300),
    ("FPS_IMPLAUSIBLE", Warning, "0.033 fps", |c| c.fps = 0.033),
    ("FPS_IMPLAUSIBLE", Warning, "30000 fps", |c| c.fps = 30_000.0),
    ("GRAVITY_MISSING", Warning, "gravity is zero", |c| c.environment.gravity = [0.0; 3]),
    ("GRAVITY_INVALID", Error, "not finite", |c| c.environment.gravity[1] = f32::INFINITY),
    ("GRAVITY_IMPLAUSIBLE", Warning, "9810", |c| c.environment.gravity = [0.0, 0.0, -9810.0]),
    ("GRAVITY_DIRECTION", Error, "180 degrees", |c| c.environment.gravity = [0.0, 0.0, 9.81]),
    ("GRAVITY_DIRECTION", Error, "90 degrees", |c| c.environment.gravity = [0.0, -9.81, 0.0]),
    ("LENGTH_MISMATCH", Error, "visibilities", |c| {
        c.sequences[0].visible.pop();
    }),
    ("LENGTH_MISMATCH", Error, "control positions", |c| {
        c.sequences[0].controls.pop();
    }),
    ("LENGTH_MISMATCH", Error, "colours", |c| {
        c.object.colors.pop();
    }),
    ("LENGTH_MISMATCH", Error, "start frames", |c| c.sequences[0].start_frames = 0),
    ("LENGTH_MISMATCH", Error, "no sequence", |c| c.sequences.clear()),
    ("ALL_INVISIBLE", Error, "inverted", |c| c.sequences[0].visible.fill(false)),
    ("NAN_VISIBLE_POINTS", Error, "point 3 in frame 1", |c| {
        let points = c.object.point_count;
        c.sequences[0].visible[points + 3] = true;
        c.sequences[0].points[points + 3][2] = f32::NAN;
    }),
    ("VISIBLE_AT_ORIGIN", Warning, "origin", |c| {
        let points = c.object.point_count;
        c.sequences[0].visible.fill(true);
        c.sequences[0].points[points..2 * points].fill([0.0; 3]);
    }),
    ("START_WITHOUT_POINTS", Error, "frame 0", |c| hide(c, 0)),
    ("FRAMES_WITHOUT_POINTS", Warning, "first frame 5", |c| hide(c, 5)),
    ("TRACKS_LOST", Warning, "only 2 of 40", |c| {
        hide(c, 7);
        let points = c.object.point_count;
        c.sequences[0].visible[7 * points..7 * points + 2].fill(true);
        c.sequences[0].points[7 * points..7 * points + 2].fill([0.2, 0.0, 0.05]);
    }),
    ("FEW_POINTS", Warning, "only 5", |c| {
        let points = c.object.point_count;
        let s = &mut c.sequences[0];
        let keep = |cell: usize| cell % points < 5;
        let mut cell = 0..;
        s.points.retain(|_| keep(cell.next().unwrap()));
        let mut cell = 0..;
        s.visible.retain(|_| keep(cell.next().unwrap()));
        let mut cell = 0..;
        s.motion_valid.retain(|_| keep(cell.next().unwrap()));
        c.object.colors.truncate(5);
        c.object.point_count = 5;
    }),
    ("VISIBILITY_FLICKERS", Warning, "hidden in", |c| {
        let points = c.object.point_count;
        for (cell, visible) in c.sequences[0].visible.iter_mut().enumerate() {
            *visible &= (cell / points + cell % points).is_multiple_of(2);
        }
    }),
    ("SCALE_TOO_LARGE", Error, "millimetres", |c| scale(c, 1000.0)),
    ("SCALE_TOO_LARGE", Error, "centimetres", |c| scale(c, 100.0)),
    ("SCALE_TOO_SMALL", Error, " mm long", |c| scale(c, 0.001)),
    ("BELOW_GROUND", Error, "up axis", |c| {
        let s = &mut c.sequences[0];
        for p in s.points.iter_mut().chain(&mut s.controls) {
            p[2] = -p[2];
        }
    }),
    ("POINTS_TELEPORT", Warning, "faster than 15 m/s", |c| {
        let points = c.object.point_count;
        c.sequences[0].points[points + 2] = [9.0, 0.0, 0.5];
        c.sequences[0].visible[points + 2] = true;
    }),
    ("FRAMES_DUPLICATED", Warning, "first frame 6", |c| {
        let points = c.object.point_count;
        let s = &mut c.sequences[0];
        s.points.copy_within(5 * points..6 * points, 6 * points);
        s.visible.copy_within(5 * points..6 * points, 6 * points);
    }),
    ("FRAMES_DROPPED", Warning, "at frame 12 while they", |c| {
        let points = c.object.point_count;
        for p in &mut c.sequences[0].points[12 * points..] {
            p[0] += 0.3;
        }
    }),
    ("OBJECT_STILL", Warning, "moves more than", |c| {
        let points = c.object.point_count;
        let s = &mut c.sequences[0];
        for frame in 1..s.frame_count {
            s.points.copy_within(0..points, frame * points);
        }
        s.visible.fill(true);
    }),
    ("NO_CONTROLS", Warning, "no control points", |c| c.sequences[0].controls.clear()),
    ("NAN_CONTROLS", Error, "control point 1", |c| c.sequences[0].controls[9][0] = f32::NAN),
    ("CONTROLS_STILL", Warning, "frozen", |c| {
        let s = &mut c.sequences[0];
        let controls = s.control_count();
        for frame in 1..s.frame_count {
            s.controls.copy_within(0..controls, frame * controls);
        }
    }),
    ("CONTROLS_FAR", Error, "never come nearer", |c| {
        c.sequences[0].controls.iter_mut().for_each(|p| p[1] += 2.0);
    }),
    ("CONTROLS_JUMP", Warning, "into frame 4", |c| {
        let controls = c.sequences[0].control_count();
        c.sequences[0].controls[4 * controls][0] += 1.0;
    }),
    ("NAN_OBJECT_POINTS", Error, "interior", |c| c.object.interior[0][0] = f32::NAN),
    ("COLORS_OUT_OF_RANGE", Warning, "255", |c| c.object.colors[0] = [200.0, 10.0, 0.0]),
    ("COMPLETION_FAR", Warning, "shape prior", |c| {
        c.object.completed_surface.iter_mut().for_each(|p| p[1] += 1.0);
    }),
    ("INTERIOR_OUTSIDE", Warning, "bounding box", |c| {
        c.object.interior.iter_mut().for_each(|p| p[1] += 0.2);
    }),
    ("TRUTH_FAR", Warning, "true tracks", |c| {
        c.sequences[0].truth_tracks.iter_mut().for_each(|p| p[1] += 0.5);
    }),
    ("TRUTH_UNKNOWN", Warning, "track metric", |c| {
        c.sequences[0].truth_tracks.fill([f32::NAN; 3]);
    }),
    ("EDGE_OUT_OF_RANGE", Error, "points 0 and 40", |c| c.object.edges = vec![[0, 40]]),
    ("EDGE_OUT_OF_RANGE", Error, "edge 1", |c| c.object.edges = vec![[0, 1], [2, 2]]),
    ("PIN_OUT_OF_RANGE", Error, "control point 8", |c| {
        c.object.pins = vec![bendtwin_core::capture::HeldPoint { point: 0, control: 8 }];
    }),
    ("LENGTH_MISMATCH", Error, "two control points", |c| {
        c.object.pins =
            [0, 1].map(|control| bendtwin_core::capture::HeldPoint { point: 0, control }).to_vec();
    }),
];

fn cut(c: &mut Capture, frames: usize) {
    let points = c.object.point_count;
    let s = &mut c.sequences[0];
    let (controls, truth) = (s.control_count(), s.truth_count());
    s.points.truncate(frames * points);
    s.visible.truncate(frames * points);
    s.motion_valid.truncate(frames * points);
    s.controls.truncate(frames * controls);
    s.truth_tracks.truncate(frames * truth);
    s.frame_count = frames;
    s.train_frame_count = frames;
}

fn hide(c: &mut Capture, frame: usize) {
    let points = c.object.point_count;
    c.sequences[0].visible[frame * points..(frame + 1) * points].fill(false);
}

fn scale(c: &mut Capture, factor: f32) {
    let s = &mut c.sequences[0];
    for points in [&mut s.points, &mut s.controls, &mut s.truth_tracks] {
        points.iter_mut().flatten().for_each(|x| *x *= factor);
    }
}

#[test]
fn broken_captures_get_their_message() {
    let mut wrong = Vec::new();
    for (code, severity, names, break_it) in BROKEN {
        let mut capture = rope();
        break_it(&mut capture);
        let report = check(&capture);
        wrong.extend(lacks(&report, *severity, code, names));
        assert_eq!(report.is_usable(), report.require().is_ok(), "{code}");
        if (*severity == Error) == report.is_usable() {
            wrong.push(format!("{code} and others: {:?}", report.findings));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn slipping_pins_are_named() {
    let mut capture = cable();
    let controls = capture.sequences[0].control_count();
    let frames = capture.sequences[0].frame_count;
    capture.sequences[0].controls[(frames - 1) * controls][1] += 0.05;
    expect(&check(&capture), Warning, "PIN_SLIPS", "50 mm against control point 0");
}
