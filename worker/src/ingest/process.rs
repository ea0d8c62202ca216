//! The child's side: confines itself first, then reads one capture and writes the results beside
//! it.

use std::{
    io::{self, Read as _, Write as _},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use bendtwin_capture::{self as capture, raw::Supplements};
use bendtwin_core::{
    CancelToken, Category, Fault, Observer, ObserverError, Problem as _, Progress, Stage,
    settings::ingest::IngestSettings,
};
use bendtwin_ingest::{Error, Input, Observed, Played, Step, ingest, views, write_playback};
use bendtwin_inspect::Report;

use super::{
    protocol::{
        ARCHIVE, CHECKPOINT, EARLIER_MASKS, MASKS, Message, OBSERVATION, PAGE, PLAYBACK, REPORT,
        Request, SUPPLEMENT_CALIBRATION, SUPPLEMENT_MASKS,
    },
    sandbox::{self, Enforced, Sandbox},
};

/// Least time between two progress messages.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(200);
/// Shares of an ingest that are over when the views are begun, and the playback.
const OBSERVED: f64 = 0.85;
const VIEWED: f64 = 0.92;

/// Reads the capture in a folder that a worker prepared, writes progress to standard output, and
/// leaves the results in the folder. A fault of the capture is a result, too.
///
/// # Errors
/// If the folder is not as a worker prepares it, or this process cannot confine itself.
pub fn ingest_capture(folder: &Path) -> io::Result<()> {
    let request = Request::read(folder)?;
    let enforced = sandbox::confine(folder, &request.resources)?;
    write_message(&Message::Confined(enforced))?;
    end_with_parent();
    let last = match work(folder, &request, enforced) {
        Ok(last) => last,
        Err(fault) => Message::Failed(fault),
    };
    write_message(&last)
}

fn work(folder: &Path, request: &Request, enforced: Enforced) -> Result<Message, Fault> {
    if request.sandbox == Sandbox::Required && !enforced.suffices() {
        return Err(unconfined(&enforced));
    }
    let settings: IngestSettings = match request.settings.trim() {
        "" => IngestSettings::default(),
        json => {
            serde_json::from_str(json).map_err(|e| Error::Settings(vec![e.to_string()]).fault())?
        }
    };
    // What is known to need more is refused with a reason before it is tried.
    let standard = capture::Limits::default();
    let limits = capture::Limits {
        total_bytes: request.resources.memory_bytes,
        file_bytes: standard.file_bytes.min(request.resources.memory_bytes),
        ..standard
    };
    let mut reporter = StdoutReporter { checkpoint: folder.join(CHECKPOINT), reported_at: None };
    let checkpoint = std::fs::read(folder.join(CHECKPOINT)).ok();
    let archive = folder.join(ARCHIVE);
    let there = |file: &str| Some(folder.join(file)).filter(|path| path.exists());
    let (masks, calibration) = (there(SUPPLEMENT_MASKS), there(SUPPLEMENT_CALIBRATION));
    let earlier_masks = there(EARLIER_MASKS);
    let input = Input {
        supplements: Supplements { masks: masks.as_deref(), calibration: calibration.as_deref() },
        earlier_masks: earlier_masks.as_deref(),
        checkpoint: checkpoint.as_deref(),
        ..Input::new(&archive, &request.name)
    };
    let observer = &mut Observing(&mut reporter);
    let made = ingest(input, &settings, &limits, observer, &CancelToken::default())?;
    write_report(folder, &made.report).map_err(|e| unwritable(REPORT, e))?;
    let mut tell = |fraction: f64| {
        reporter.progress(bendtwin_ingest::Progress { step: Step::Playback, fraction });
    };
    if let Ok(Some(observed)) = &made.capture {
        // The reference is what a twin is made of.
        let views = made.recorded.first().and_then(Option::as_ref).and_then(|recording| {
            views(recording, &mut |share| tell(OBSERVED + (VIEWED - OBSERVED) * share))
        });
        capture::write_observation(observed, views.as_ref(), &folder.join(OBSERVATION))
            .map_err(unwritten)?;
    }
    if let Some(masks) = &made.masks {
        masks.write(&folder.join(MASKS)).map_err(unwritten)?;
    }
    write_shown(folder, &request.name, &made, &mut |share| {
        tell(VIEWED + (1.0 - VIEWED) * share);
    })?;
    let verdict = made.report.inspection().verdict;
    Ok(match made.capture {
        Ok(Some(_)) => Message::Observed { verdict },
        Ok(None) => Message::Masked { verdict },
        Err(fault) => Message::Refused { verdict, fault },
    })
}

/// The fault of a result that was not written.
fn unwritten(error: capture::Error) -> Fault {
    match error {
        capture::Error::Io { at, source } => unwritable(&at, source),
        error => error.fault(),
    }
}

/// Writes the playback: of everything that can be shown, also of a capture that cannot be fitted.
fn write_shown(
    folder: &Path,
    name: &str,
    made: &Observed,
    tell: &mut dyn FnMut(f64),
) -> Result<(), Fault> {
    let capture = made.capture.as_ref().ok().and_then(Option::as_ref);
    if capture.is_none() && made.recorded.iter().flatten().next().is_none() {
        return Ok(());
    }
    let doubt = made.masks.as_ref().map_or(&[][..], |masks| masks.doubt.as_slice());
    let name = capture.map_or(name, |capture| capture.name.as_str());
    let played = Played { name, capture, recorded: &made.recorded, doubt };
    write_playback(played, &folder.join(PLAYBACK), tell).map_err(|e| unwritable(PLAYBACK, e))
}

/// The fault of a system that cannot confine this process as its worker demands.
fn unconfined(enforced: &Enforced) -> Fault {
    Fault {
        category: Category::FailedPrecondition,
        reason: "INGEST_SANDBOX_MISSING".to_owned(),
        message: format!(
            "this system does not confine the process that reads captures ({}), and the worker demands it: use a \
             kernel with Landlock and seccomp, or start the worker with --ingest-sandbox best-effort",
            enforced.lacking().unwrap_or_default()
        ),
    }
}

/// Ends this process when its standard input ends: the worker, which holds the pipe, is gone.
fn end_with_parent() {
    std::thread::spawn(|| {
        let mut buffer = [0; 64];
        while matches!(io::stdin().read(&mut buffer), Ok(read) if read > 0) {}
        std::process::exit(1);
    });
}

pub(super) fn write_report(folder: &Path, report: &Report) -> io::Result<()> {
    write_new(&folder.join(REPORT), &report.to_json())?;
    write_new(&folder.join(PAGE), &report.to_html())
}

/// Writes a file in place of anything at the path: the worker writes, too, where a child ended.
fn write_new(path: &Path, text: &str) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    std::fs::File::create_new(path)?.write_all(text.as_bytes())
}

fn unwritable(at: &str, source: io::Error) -> Fault {
    Fault {
        category: Category::ResourceExhausted,
        reason: "NO_DISK_SPACE".to_owned(),
        message: format!("{at} cannot be written: {source}; free disk space or set --scratch-dir"),
    }
}

fn write_message(message: &Message) -> io::Result<()> {
    let mut line = serde_json::to_vec(message)?;
    line.push(b'\n');
    let mut out = io::stdout().lock();
    out.write_all(&line)?;
    out.flush()
}

/// Observer of the ingest itself, whose progress is a part of the whole.
struct Observing<'a>(&'a mut StdoutReporter);

impl Observer<bendtwin_ingest::Progress> for Observing<'_> {
    fn progress(&mut self, progress: bendtwin_ingest::Progress) {
        let fraction = OBSERVED * progress.fraction;
        self.0.progress(bendtwin_ingest::Progress { fraction, ..progress });
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        self.0.checkpoint(checkpoint)
    }
}

/// Writes progress and checkpoints as messages to standard output.
struct StdoutReporter {
    checkpoint: PathBuf,
    /// Time of the last progress message.
    reported_at: Option<Instant>,
}

impl Observer<bendtwin_ingest::Progress> for StdoutReporter {
    fn progress(&mut self, progress: bendtwin_ingest::Progress) {
        if self.reported_at.is_some_and(|at| at.elapsed() < PROGRESS_INTERVAL) {
            return;
        }
        self.reported_at = Some(Instant::now());
        let progress = Progress {
            stage: Stage::Ingest,
            variant: progress.step.as_str().to_owned(),
            iteration: 0,
            iterations: 0,
            fraction: progress.fraction,
            loss: None,
            best_loss: None,
            eta_s: None,
            note: None,
            models: Vec::new(),
            error_m: None,
            preview: None,
        };
        // A worker that does not listen any more is gone, which the other thread notices.
        let _ = write_message(&Message::Progress(progress));
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        // The worker never finds half of one.
        let new = self.checkpoint.with_extension("new");
        match std::fs::write(&new, checkpoint)
            .and_then(|()| std::fs::rename(&new, &self.checkpoint))
        {
            Ok(()) => Ok(write_message(&Message::Checkpoint)?),
            // A checkpoint saves work, but is not necessary. Its space may save the result.
            Err(error) if error.kind() == io::ErrorKind::StorageFull => {
                eprintln!("no room for a checkpoint: {error}");
                let _ = std::fs::remove_file(&new);
                Ok(())
            }
            Err(error) => Err(error.into()),
        }
    }
}
