//! Errors of recordings that cannot be lifted although every frame could be read.

use bendtwin_capture::raw::{self, Recording};

use bendtwin_core::{Finding, Severity, settings::ingest::ControlSettings};

use crate::{Error, Evidence, evidence::CameraEvidence, tracks::Tracks};

/// Fails if masks show a hand, but not at the start, or not for longer than can be filled.
pub(super) fn refuse_gaps(settings: &ControlSettings, seen: &[bool]) -> Result<(), Error> {
    let Some(gap) = settings.gap(seen) else { return Ok(()) };
    let (from, to) = (gap.start, gap.end - 1);
    if from == 0 {
        return Err(Error::HandLate { to });
    }
    Err(Error::HandLost { from, to, limit: settings.max_gap_frames as usize })
}

/// The frame after the last one in which something is seen.
fn end_of(seen: &[bool]) -> usize {
    seen.iter().rposition(|seen| *seen).map_or(0, |last| last + 1)
}

/// Least points of the object in a frame; with fewer, the object is lost.
const MIN_POINTS: usize = 3;

/// Fails if there is no object, or no track on it.
pub(super) fn refuse_nothing(
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

/// Fails if the object disappears from the masks, or is lost, before the training frames end and
/// does not return.
pub(super) fn refuse_lost(
    recording: &Recording,
    shown: &[bool],
    kept: &Tracks,
    findings: &mut Vec<Finding>,
) -> Result<(), Error> {
    let (train, from) = (recording.train_frame_count, end_of(shown));
    if from < train {
        return Err(Error::ObjectGone { from, train });
    }
    let seen = |f: usize| kept.seen_at(f).iter().filter(|s| **s).count();
    let lost = (0..kept.frames).rev().take_while(|f| seen(*f) < MIN_POINTS).count();
    let frame = kept.frames - lost;
    if lost > 0 && frame < recording.train_frame_count {
        return Err(Error::TracksLost { tracks: kept.count, seen: seen(frame), frame });
    }
    if lost > 0 {
        findings.push(Finding::from_sentence(Severity::Warning, "TRACKS_LOST", format!(
                "hardly any track on the object is seen from frame {frame} on: the future is judged by the frames before"
            )));
    }
    Ok(())
}
