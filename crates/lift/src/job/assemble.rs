//! Assembly of one capture from the results of all units.

use bendtwin_core::{
    CancelToken, Capture, Point, Sequence, capture::Object, settings::ingest::IngestSettings,
};
use bendtwin_core::{Finding, Severity};
use bendtwin_flow::Texture;

use super::{
    Observation,
    gather::Assembly,
    refuse::{refuse_gaps, refuse_lost, refuse_nothing},
};
use crate::{
    Error, Evidence,
    error::check,
    evidence::TrackEvidence,
    hands::{self, Controls, MIN_TRACKS, contact::Contact},
    motion,
    shape::{
        complete::{Shape, complete},
        shape,
    },
    survey::TrackLabel,
    thin::one_per_spot,
    tracks::Tracks,
};

/// Makes the capture and its evidence.
pub(super) fn assemble(from: &Assembly<'_>, cancel: &CancelToken) -> Result<Observation, Error> {
    let Assembly { recording, settings, .. } = *from;
    let mut evidence = Evidence { cameras: from.cameras(), ..Evidence::default() };
    let mut object = from.gather(TrackLabel::Object);
    refuse_nothing(&evidence, from.tracks, &object)?;
    check(cancel)?;

    for camera in &evidence.cameras {
        if let Some(t) =
            camera.tracker.as_ref().filter(|t| matches!(t.verdict, Texture::Poor | Texture::None))
        {
            evidence.findings.push(Finding::from_sentence(
                Severity::Warning,
                "POOR_TEXTURE",
                t.summary.clone(),
            ));
        }
    }
    let (mut kept, valid) = filter_tracks(&mut object, settings, &mut evidence.tracks, cancel)?;
    refuse_lost(recording, &from.object_seen(), &kept, &mut evidence.findings)?;
    check(cancel)?;

    let grippers = &recording.grippers;
    let seen = match grippers.as_slice() {
        [] => from.hand_seen(),
        grippers => hands::gripper::known(grippers, recording.frame_count),
    };
    if seen.contains(&true) {
        refuse_gaps(&settings.controls, &seen)?;
    }
    let observed = from.surface();
    let clouds = from.hands();
    let hands = clouds.first().map_or(&[][..], Vec::as_slice);
    let findings = &mut evidence.findings;
    let shape = match shape(recording, &observed, hands, settings, findings, cancel)? {
        None => Shape::default(),
        Some((shape, mut made)) => {
            let shape = complete(kept.points_at(0), &shape, &settings.completion);
            (made.surface, made.interior) = (shape.surface.len(), shape.interior.len());
            evidence.shape = Some(made);
            shape
        }
    };
    check(cancel)?;

    let (mut controls, mut control_hands) = (Vec::new(), Vec::new());
    if seen.contains(&true) {
        let object = [kept.points_at(0), &shape.surface, &shape.interior].concat();
        let contact = Contact::new(object, hands.to_vec());
        let made = if grippers.is_empty() {
            follow(from, &clouds, &contact)?
        } else {
            hands::gripper::controls(grippers, recording.frame_count, &contact, &settings.controls)?
        };
        controls = made.points;
        // Control points of one hand are beside each other.
        let hands = made.hands.iter().zip(0..);
        control_hands = hands.flat_map(|(h, hand)| std::iter::repeat_n(hand, h.controls)).collect();
        evidence.hands = made.hands;
        evidence.findings.extend(made.findings);
    } else {
        evidence.findings.push(Finding::from_sentence(Severity::Warning, "NO_HAND", "no mask shows a hand or gripper, so nothing moves the object but gravity: add masks of what \
                      holds it"));
    }
    kept.fill_unseen();
    let sequence = Sequence {
        name: recording.name.clone(),
        frame_count: kept.frames,
        train_frame_count: recording.train_frame_count,
        points: kept.points,
        visible: kept.seen,
        motion_valid: valid,
        controls,
        truth_tracks: recording.truth_tracks.clone(),
        start_frames: 1,
    };
    let capture = Capture {
        name: recording.name.clone(),
        fps: recording.fps,
        environment: recording.environment,
        source_to_world: recording.source_to_world,
        object: Object {
            point_count: kept.count,
            colors: kept.colors,
            completed_surface: shape.surface,
            interior: shape.interior,
            mass_kg: recording.mass_kg,
            control_hands,
            ..Object::default()
        },
        sequences: vec![sequence],
        others: Vec::new(),
    };
    Ok(Observation { capture, evidence })
}

/// Control points from the tracks on hands, or from the hands' shape where there are too few tracks or
/// these are lost for long.
fn follow(
    from: &Assembly<'_>,
    clouds: &[Vec<Point>],
    contact: &Contact,
) -> Result<Controls, Error> {
    let settings = &from.settings.controls;
    let hand = &from.gather(TrackLabel::Manipulator);
    let by_shape = || hands::cloud::controls(clouds, hand.count, contact, settings);
    if hand.count < MIN_TRACKS {
        return by_shape();
    }
    match hands::controls(hand, contact, settings) {
        Ok(made) if made.longest_gap <= settings.max_gap_frames as usize => Ok(made),
        Ok(made) => match by_shape() {
            Ok(other) if other.longest_gap < made.longest_gap => Ok(other),
            _ => Ok(made),
        },
        Err(error) => by_shape().map_err(|_| error),
    }
}

/// The reliable tracks, one for each spot, and the validity of their motions, shape [T, N].
fn filter_tracks(
    object: &mut Tracks,
    settings: &IngestSettings,
    evidence: &mut TrackEvidence,
    cancel: &CancelToken,
) -> Result<(Tracks, Vec<bool>), Error> {
    let before = object.survival();
    let checked = motion::check_motion(object, &settings.motion, cancel)?;
    let reliable: Vec<usize> =
        (0..object.count).filter(|i| 2 * checked.drifts[*i] <= before[*i]).collect();
    let survival = object.survival();
    let lengths: Vec<usize> = reliable.iter().map(|i| survival[*i]).collect();
    let candidates = object.select(&reliable);
    let spots = one_per_spot(&candidates, &lengths, settings.spacing_m);
    let kept: Vec<usize> = spots.iter().map(|i| reliable[*i]).collect();

    let valid: Vec<bool> = (0..object.frames)
        .flat_map(|f| kept.iter().map(move |i| (f, i)))
        .map(|(f, i)| checked.valid[f * object.count + i])
        .collect();
    let count = kept.len();
    let share =
        |flags: &[bool]| flags.iter().filter(|v| **v).count() as f32 / flags.len().max(1) as f32;
    let ratio = |part: u64, whole: u64| part as f64 / whole.max(1) as f64;
    let kept = object.select(&kept);
    *evidence = TrackEvidence {
        on_object: object.count,
        unreliable: object.count - reliable.len(),
        thinned: reliable.len() - count,
        kept: count,
        seen: kept.seen.chunks(count.max(1)).map(share).collect(),
        motion_valid: valid.chunks(count.max(1)).map(share).collect(),
        drifted: ratio(checked.drifted, checked.seen),
        unconfirmed: ratio(checked.unconfirmed, checked.moved),
        motion_residual_m: checked.residual_m,
    };
    Ok((kept, valid))
}
