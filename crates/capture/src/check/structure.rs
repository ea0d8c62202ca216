//! Conditions that have to hold before anything may index into a capture: lengths agree,
//! indices exist. [`crate::check()`] judges the numbers.

use bendtwin_core::Capture;

use crate::{Error, files::at_most};

/// Checks lengths and indices.
///
/// # Errors
/// The first contradiction found.
pub fn validate(capture: &Capture) -> Result<(), Error> {
    let count = capture.recordings().count();
    at_most("recordings", count, Capture::MOST_RECORDINGS)?;
    if capture.others.iter().any(|r| !r.others.is_empty()) {
        return Err(Error::Lengths("a recording of several has further recordings".to_owned()));
    }
    one(capture)?;
    let named = |r: &Capture, e| Error::InRecording { name: r.name.clone(), error: Box::new(e) };
    capture.others.iter().try_for_each(|r| one(r).map_err(|e| named(r, e)))
}

fn one(capture: &Capture) -> Result<(), Error> {
    let object = &capture.object;
    let points = object.point_count;
    let optional =
        [("object colours", object.colors.len()), ("rest points", object.rest_points.len())];
    for (what, len) in optional {
        if len != 0 && len != points {
            return Err(Error::Lengths(format!(
                "there are {len} {what} for {points} points: one each, or none"
            )));
        }
    }
    for (index, &[a, b]) in object.edges.iter().enumerate() {
        if a as usize >= points || b as usize >= points || a == b {
            return Err(Error::EdgeRange { index, a: i64::from(a), b: i64::from(b), points });
        }
    }
    if capture.sequences.is_empty() {
        return Err(Error::Lengths("the capture has no sequence: record at least one".to_owned()));
    }
    let controls = capture.sequences[0].control_count();
    for sequence in &capture.sequences {
        let frames = sequence.frame_count;
        let fail =
            |fault: String| Err(Error::Lengths(format!("sequence `{}`: {fault}", sequence.name)));
        let cells = frames.checked_mul(points);
        for (what, len) in [
            ("points", sequence.points.len()),
            ("visibilities", sequence.visible.len()),
            ("motion validities", sequence.motion_valid.len()),
        ] {
            if Some(len) != cells {
                return fail(format!("{len} {what} for {frames} frames of {points} points"));
            }
        }
        for (what, len) in [
            ("control positions", sequence.controls.len()),
            ("truth positions", sequence.truth_tracks.len()),
        ] {
            if len != 0 && (frames == 0 || len % frames != 0) {
                return fail(format!("{len} {what} do not divide into {frames} frames"));
            }
        }
        if sequence.control_count() != controls {
            return fail(format!(
                "it has {} control points, the first sequence has {controls}: they must be the same",
                sequence.control_count()
            ));
        }
        if sequence.train_frame_count > frames {
            let split = i64::try_from(sequence.train_frame_count).unwrap_or(i64::MAX);
            return Err(Error::SplitRange { sequence: sequence.name.clone(), split, frames });
        }
        if sequence.start_frames == 0 || sequence.start_frames > frames.max(1) {
            return fail(format!(
                "{} start frames of {frames} frames: one starts at rest, two start with a velocity",
                sequence.start_frames
            ));
        }
    }
    let hands = object.control_hands.len();
    if hands != 0 && hands != controls {
        return Err(Error::Lengths(format!(
            "there are {hands} hands for {controls} control points: one each, or none"
        )));
    }
    let mut held = vec![false; points];
    for (index, pin) in object.pins.iter().enumerate() {
        if pin.point as usize >= points || pin.control as usize >= controls {
            let (point, control) = (i64::from(pin.point), i64::from(pin.control));
            return Err(Error::PinRange { index, point, control, points, controls });
        }
        if std::mem::replace(&mut held[pin.point as usize], true) {
            let point = pin.point;
            return Err(Error::Lengths(format!(
                "point {point} is held by two control points: keep one of them"
            )));
        }
    }
    Ok(())
}
