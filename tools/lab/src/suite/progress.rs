//! Progress of a suite: a line for each run that starts or ends, and one line that changes.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use bendtwin_core::{Progress, quality::ErrorSummary};
use bendtwin_engine::Backend;
use bendtwin_study::{Event, Outcome, Plan, Record, RunId};
use bendtwin_terminal::output;
use indicatif::{ProgressBar, ProgressStyle};

/// Time between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(30);
/// Positions of the bar for each run.
const STEPS: f64 = 1000.0;

pub(super) struct SuiteProgress {
    bar: ProgressBar,
    quiet: bool,
    total: usize,
    ended: usize,
    running: Vec<(RunId, Option<Progress>)>,
    began: Instant,
    last_line: Instant,
}

impl SuiteProgress {
    /// `quiet` shows nothing (for `--json`).
    pub(super) fn new(plan: &Plan<'_>, backends: &[Arc<dyn Backend>], quiet: bool) -> Self {
        let total = plan.pending();
        let bar = if quiet || total == 0 {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(total as u64 * STEPS as u64)
        };
        let style = ProgressStyle::with_template("  [{bar:20}] {percent:>3}%  {wide_msg}");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        let now = Instant::now();
        let (ended, running) = (0, Vec::new());
        let bar = Self { bar, quiet, total, ended, running, began: now, last_line: now };
        let device = backends.first().map(|b| b.device().name).unwrap_or_default();
        bar.print(&format!(
            "{}, {} at a time ({device} each); {} are done already",
            run_count(total),
            backends.len(),
            plan.done()
        ));
        bar
    }

    pub(super) fn show(&mut self, event: &Event<'_>) {
        match event {
            Event::Started { run, resumed } => {
                self.running.push(((*run).clone(), None));
                let how = if *resumed { "resumes" } else { "starts" };
                self.print(&format!("{run} {how}"));
            }
            Event::Progress { run, progress } => {
                if let Some(entry) = self.running.iter_mut().find(|(id, _)| id == *run) {
                    entry.1 = Some(progress.clone());
                }
            }
            Event::Ended(record) => {
                self.remove(&record.run);
                self.ended += 1;
                self.print(&format!("[{}/{}] {}", self.ended, self.total, result(record)));
            }
            Event::Interrupted(run) => {
                self.remove(run);
                self.print(&format!("{run} stops; it can be resumed"));
            }
        }
        self.refresh();
    }

    /// Removes the bar.
    pub(super) fn finish(self) {
        self.bar.finish_and_clear();
    }

    fn remove(&mut self, run: &RunId) {
        self.running.retain(|(id, _)| id != run);
    }

    fn print(&self, text: &str) {
        if self.quiet {
        } else if self.bar.is_hidden() {
            eprintln!("  {text}");
        } else {
            self.bar.println(format!("  {text}"));
        }
    }

    fn refresh(&mut self) {
        let fraction =
            |p: &Option<Progress>| p.as_ref().map_or(0.0, |p| p.fraction.clamp(0.0, 1.0));
        let done: f64 =
            self.ended as f64 + self.running.iter().map(|(_, p)| fraction(p)).sum::<f64>();
        let running = self.running.iter().map(|(id, p)| run_status(id, p.as_ref()));
        let mut text = running.collect::<Vec<_>>().join(", ");
        if done > 0.0 {
            let left = self.began.elapsed().as_secs_f64() / done * (self.total as f64 - done);
            text += &format!("; {} left", output::duration(left));
        }
        if !self.bar.is_hidden() {
            self.bar.set_position((done * STEPS) as u64);
            self.bar.set_message(text);
        } else if self.last_line.elapsed() >= LINE_EVERY {
            self.last_line = Instant::now();
            self.print(&format!("{} of {} done; {text}", self.ended, self.total));
        }
    }
}

/// A number of runs for people.
pub(super) fn run_count(runs: usize) -> String {
    format!("{runs} run{}", if runs == 1 { "" } else { "s" })
}

fn run_status(run: &RunId, progress: Option<&Progress>) -> String {
    let Some(progress) = progress else { return run.to_string() };
    let stage = progress.stage.as_str();
    format!("{run} {stage} {}/{}", progress.iteration, progress.iterations)
}

/// The end of a run in a line: its headline errors on future frames, or its fault.
fn result(record: &Record) -> String {
    let finished = match &record.outcome {
        Outcome::Finished(finished) => finished,
        Outcome::Failed(fault) => return format!("{} failed: {fault}", record.run),
    };
    let unknown = ErrorSummary::default();
    let score = finished.quality.scores.first();
    let (span, errors) = match score {
        Some(s) if s.future != unknown => ("future", &s.future),
        Some(s) => ("train", &s.train),
        None => ("", &unknown),
    };
    let named = [
        ("CD", errors.chamfer_l1_m),
        ("track", errors.track_m),
        ("coordinate", errors.coordinate_m),
        ("padded RMS", errors.padded_rms_m),
    ];
    let figures = named.into_iter().filter_map(|(name, m)| Some(format!("{name} {:.2}", 1e3 * m?)));
    format!(
        "{} {span} {} mm, {} nodes, in {}",
        record.run,
        figures.collect::<Vec<_>>().join(" "),
        finished.graph.nodes,
        output::duration(finished.fit_s)
    )
}
