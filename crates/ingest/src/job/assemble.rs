//! From what all units saw to one capture.

use bendtwin_capture::{
    Finding, Severity,
    raw::{self, Recording},
};
use bendtwin_core::{Capture, Point, Sequence, capture::Object, settings::ingest::IngestSettings};

use super::Observation;
use crate::{
    CancelToken, Error, Evidence,
    checkpoint::Checkpoint,
    complete::{Shape, complete},
    error::check,
    evidence::{CameraEvidence, TrackEvidence},
    hands::{self, LEAST_TRACKS},
    motion,
    shape::shape,
    survey::{Sight, Unit},
    thin::one_per_spot,
    tracks::Tracks,
};

/// A frame with fewer points of the object is lost.
const FEWEST_POINTS: usize = 3;

pub(super) fn assemble(
    recording: &Recording,
    settings: &IngestSettings,
    tracks: &[raw::Tracks],
    units: &[Unit],
    done: &Checkpoint,
    cancel: &CancelToken,
) -> Result<Observation, Error> {
    let mut evidence =
        Evidence { cameras: cameras(recording, tracks, units, done), ..Evidence::default() };
    let mut object = gather(recording, tracks, units, done, Sight::Object);
    let hand = gather(recording, tracks, units, done, Sight::Manipulator);
    refuse_nothing(&evidence, tracks, &object)?;
    check(cancel)?;

    let (mut kept, valid) = believe(&mut object, settings, &mut evidence.tracks);
    refuse_lost(recording, &kept, &mut evidence.findings)?;
    check(cancel)?;

    let mut controls = Vec::new();
    let shown: u64 = evidence.cameras.iter().map(|c| c.manipulator.kept).sum();
    if hand.count >= LEAST_TRACKS {
        let made = hands::controls(&hand, &settings.controls)?;
        controls = made.points;
        evidence.hands = made.hands;
        evidence.findings.extend(made.findings);
    } else if shown > 0 {
        return Err(Error::NoHandTracks { tracks: hand.count, needed: LEAST_TRACKS });
    } else {
        evidence.findings.push(Finding {
            severity: Severity::Warning,
            code: "NO_HAND".to_owned(),
            message: "no mask shows a hand or gripper, so nothing moves the object but gravity: add masks of what \
                      holds it"
                .to_owned(),
        });
    }
    check(cancel)?;
    let observed = surface(units, done);
    let shape = match shape(recording, &observed, settings, &mut evidence.findings)? {
        None => Shape::default(),
        Some((shape, mut told)) => {
            let shape = complete(kept.points_at(0), &shape, &settings.completion);
            (told.surface, told.interior) = (shape.surface.len(), shape.interior.len());
            evidence.shape = Some(told);
            shape
        }
    };

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
            ..Object::default()
        },
        sequences: vec![sequence],
    };
    Ok(Observation { capture, evidence })
}

/// All cameras' tracks that show `what` in the first frame.
fn gather(
    recording: &Recording,
    tracks: &[raw::Tracks],
    units: &[Unit],
    done: &Checkpoint,
    what: Sight,
) -> Tracks {
    let mut columns: Vec<Vec<usize>> = vec![Vec::new(); tracks.len()];
    let mut colors = Vec::new();
    for (unit, surveyed) in units.iter().zip(&done.units).filter(|(u, _)| u.first == 0) {
        let first = surveyed.sights.iter().take(tracks[unit.camera].count);
        for (track, _) in first.enumerate().filter(|(_, s)| **s == what) {
            columns[unit.camera].push(track);
            colors.push(surveyed.colors.get(track).copied().unwrap_or([0.5; 3]));
        }
    }
    let count = columns.iter().map(Vec::len).sum();
    let frames = recording.frame_count;
    let mut points = vec![[0.0; 3]; frames * count];
    let mut seen = vec![false; frames * count];
    let offsets = columns.iter().scan(0, |next, c| {
        let offset = *next;
        *next += c.len();
        Some(offset)
    });
    let offsets: Vec<usize> = offsets.collect();
    for (unit, surveyed) in units.iter().zip(&done.units) {
        let width = tracks[unit.camera].count;
        for frame in unit.first..unit.end {
            for (i, track) in columns[unit.camera].iter().enumerate() {
                let from = (frame - unit.first) * width + track;
                let to = frame * count + offsets[unit.camera] + i;
                if surveyed.sights.get(from) == Some(&what) {
                    points[to] = surveyed.points[from];
                    seen[to] = true;
                }
            }
        }
    }
    Tracks { count, frames, points, seen, colors }
}

/// The tracks that are believed, one for each spot, and whether their motions are valid, shape [T, N].
fn believe(
    object: &mut Tracks,
    settings: &IngestSettings,
    evidence: &mut TrackEvidence,
) -> (Tracks, Vec<bool>) {
    let before = object.survival();
    let verdict = motion::judge(object, &settings.motion);
    let steady: Vec<usize> =
        (0..object.count).filter(|i| 2 * verdict.drifts[*i] <= before[*i]).collect();
    let survival = object.survival();
    let worth: Vec<usize> = steady.iter().map(|i| survival[*i]).collect();
    let candidates = object.select(&steady);
    let spots = one_per_spot(&candidates, &worth, settings.spacing_m);
    let kept: Vec<usize> = spots.iter().map(|i| steady[*i]).collect();

    let valid: Vec<bool> = (0..object.frames)
        .flat_map(|f| kept.iter().map(move |i| (f, i)))
        .map(|(f, i)| verdict.valid[f * object.count + i])
        .collect();
    let count = kept.len();
    let share =
        |flags: &[bool]| flags.iter().filter(|v| **v).count() as f32 / flags.len().max(1) as f32;
    let ratio = |part: u64, whole: u64| part as f64 / whole.max(1) as f64;
    let kept = object.select(&kept);
    *evidence = TrackEvidence {
        on_object: object.count,
        unreliable: object.count - steady.len(),
        thinned: steady.len() - count,
        kept: count,
        seen: kept.seen.chunks(count.max(1)).map(share).collect(),
        motion_valid: valid.chunks(count.max(1)).map(share).collect(),
        drifted: ratio(verdict.drifted, verdict.seen),
        unconfirmed: ratio(verdict.unconfirmed, verdict.moved),
        motion_residual_m: verdict.residual_m,
    };
    (kept, valid)
}

fn cameras(
    recording: &Recording,
    tracks: &[raw::Tracks],
    units: &[Unit],
    done: &Checkpoint,
) -> Vec<CameraEvidence> {
    let start = recording.cameras.iter().zip(tracks).zip(&done.tracked);
    let mut cameras: Vec<CameraEvidence> = start
        .map(|((camera, tracks), tracked)| CameraEvidence {
            name: camera.name.clone(),
            tracks: tracks.count,
            tracker_quality: tracked.as_ref().map(|t| t.quality),
            ..CameraEvidence::default()
        })
        .collect();
    for (unit, surveyed) in units.iter().zip(&done.units) {
        let camera = &mut cameras[unit.camera];
        camera.missing_frames += surveyed.missing_frames;
        camera.object.add(&surveyed.object);
        camera.manipulator.add(&surveyed.manipulator);
        camera.lifts.add(&surveyed.lifts);
    }
    cameras
}

fn refuse_nothing(
    evidence: &Evidence,
    tracks: &[raw::Tracks],
    object: &Tracks,
) -> Result<(), Error> {
    let detail = |c: &CameraEvidence| {
        let o = &c.object;
        format!(
            "camera {}: {} of its frames recorded, {} masks of which {} are empty, {} pixels, {} of them without depth",
            c.name,
            if c.missing_frames == 0 {
                "all".to_owned()
            } else {
                format!("all but {}", c.missing_frames)
            },
            o.frames,
            o.empty_frames,
            o.pixels,
            o.no_depth
        )
    };
    if evidence.cameras.iter().all(|c| c.object.kept == 0) {
        let cameras: Vec<String> = evidence.cameras.iter().map(detail).collect();
        return Err(Error::NoObject(cameras.join("; ")));
    }
    if object.count == 0 {
        let lost = |c: &CameraEvidence| {
            let l = &c.lifts;
            format!(
                "camera {}, all frames: {} on the object, {} on a hand, {} on neither, {} hidden, {} outside the image",
                c.name,
                l.object,
                l.manipulator,
                l.off_mask + l.unsupported,
                l.hidden,
                l.outside
            )
        };
        let cameras: Vec<String> = evidence.cameras.iter().map(lost).collect();
        return Err(Error::NoTracks {
            tracks: tracks.iter().map(|t| t.count).sum(),
            detail: cameras.join("; "),
        });
    }
    Ok(())
}

/// Fails if the object is lost for good before the training frames end.
fn refuse_lost(
    recording: &Recording,
    kept: &Tracks,
    findings: &mut Vec<Finding>,
) -> Result<(), Error> {
    let seen = |f: usize| kept.seen_at(f).iter().filter(|s| **s).count();
    let lost = (0..kept.frames).rev().take_while(|f| seen(*f) < FEWEST_POINTS).count();
    let frame = kept.frames - lost;
    if lost > 0 && frame < recording.train_frame_count {
        return Err(Error::TracksLost { tracks: kept.count, seen: seen(frame), frame });
    }
    if lost > 0 {
        findings.push(Finding {
            severity: Severity::Warning,
            code: "TRACKS_LOST".to_owned(),
            message: format!(
                "hardly any track on the object is seen from frame {frame} on: the future is judged by the frames before"
            ),
        });
    }
    Ok(())
}

/// The object's surface in the first frame, as all cameras see it [m].
fn surface(units: &[Unit], done: &Checkpoint) -> Vec<Point> {
    let first = units.iter().zip(&done.units).filter(|(u, _)| u.first == 0);
    first.flat_map(|(_, s)| s.surface.iter().copied()).collect()
}
