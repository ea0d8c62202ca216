//! Several recordings of one object, one after another. The report is that of the reference with
//! the findings of all.

use bendtwin_capture::{Opened, Part, several::join};
use bendtwin_core::{Category, Fault, Observer, Problem as _, Sequence, settings::ingest::Stage};

use crate::{Observed, Progress, Span, Work};

/// Ingests the recordings. A checkpoint is of the one that was being lifted; those before it are
/// lifted again.
pub(super) fn ingest(
    work: &Work<'_>,
    parts: Vec<Part>,
    name: &str,
    observer: &mut dyn Observer<Progress>,
) -> Result<Observed, Fault> {
    if let Some(fault) = refused(work) {
        return Ok(crate::unread(name, &fault));
    }
    let count = parts.len();
    let begin = |index: usize| index as f64 / count as f64;
    let (mut captures, mut report, mut fault) = (Vec::with_capacity(count), None, None);
    let mut recorded = Vec::with_capacity(count);
    for (index, Part { name: own, held_out, mut opened }) in parts.into_iter().enumerate() {
        let held_out = held_out || is_held_out(&mut opened);
        let mut share = Span { range: begin(index)..begin(index + 1), observer: &mut *observer };
        let named = if index == 0 { name } else { &own };
        let one = work.ingest_one(opened, named, &mut share)?;
        recorded.push(one.recorded.into_iter().next().flatten());
        match one.capture {
            Ok(capture) => captures.extend(capture.map(|c| (own.clone(), held_out, c))),
            Err(error) => {
                let message = format!("recording `{own}`: {}", error.message);
                fault.get_or_insert(Fault { message, ..error });
            }
        }
        match &mut report {
            None => report = Some(one.report),
            Some(report) => report.add_recording(&own, &one.report),
        }
    }
    let capture = match fault {
        Some(fault) => Err(fault),
        None => join(name.to_owned(), captures).map(Some).map_err(|e| e.fault()),
    };
    match report {
        Some(report) => Ok(Observed { recorded, ..Observed::new(capture, report) }),
        None => {
            let there = "which has no recordings".to_owned();
            let error = bendtwin_capture::Error::UnknownKind { name: name.to_owned(), there };
            Ok(crate::unread(name, &error.fault()))
        }
    }
}

/// The fault of work that is defined for one recording alone.
fn refused(work: &Work<'_>) -> Option<Fault> {
    let settings = work.settings;
    let what = if !settings.strokes.is_empty() || settings.until == Stage::Masks {
        "strokes are"
    } else if work.input.supplements.masks.is_some() {
        "the masks that were added are"
    } else {
        return None;
    };
    Some(Fault {
        category: Category::FailedPrecondition,
        reason: "SEVERAL_RECORDINGS".to_owned(),
        message: format!(
            "{what} for one recording, and this capture has several: send each recording as a capture to \
             mark it, download its masks, put them into its folder, and send the recordings together again; or remove \
             what was added (`bendtwin capture remove`)"
        ),
    })
}

/// True for points without frames for fitting. They are judged as if all frames were.
fn is_held_out(opened: &mut Opened) -> bool {
    let Opened::Observed(capture, _) = opened else { return false };
    let all = capture.sequences.iter().all(Sequence::is_held_out);
    if all {
        capture.sequences.iter_mut().for_each(|s| s.train_frame_count = s.frame_count);
    }
    all
}

#[cfg(test)]
mod tests;
