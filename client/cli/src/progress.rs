//! Progress of long work: a bar on a terminal, otherwise a line at intervals.

use std::time::{Duration, Instant};

use bendtwin_client::JobProgress;
use indicatif::{ProgressBar, ProgressStyle};

use crate::output;

/// Time between two lines of the same stage where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Progress bar of a fit.
pub(crate) struct FitBar {
    bar: ProgressBar,
    started: Instant,
    /// Stage and time of the last line.
    last: Option<(String, Instant)>,
    last_note: String,
    quiet: bool,
}

impl FitBar {
    /// `quiet` shows nothing (for `--json`).
    pub(crate) fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(1000) };
        let style = ProgressStyle::with_template("  {prefix:<16} [{bar:30}] {percent:>3}%  {msg}");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, started: Instant::now(), last: None, last_note: String::new(), quiet }
    }

    /// Prints a line above the bar.
    pub(crate) fn print(&self, text: &str) {
        if self.quiet {
        } else if self.bar.is_hidden() {
            eprintln!("  {text}");
        } else {
            self.bar.println(format!("  {text}"));
        }
    }

    /// Shows progress.
    pub(crate) fn show(&mut self, progress: &JobProgress) {
        if !progress.note.is_empty() && progress.note != self.last_note {
            self.print(&format!("note: {}", progress.note));
            self.last_note.clone_from(&progress.note);
        }
        let stage = stage(progress);
        let details = details(progress);
        if self.bar.is_hidden() {
            self.line(&stage, progress, &details);
        } else {
            self.bar.set_prefix(stage);
            self.bar.set_message(details);
            self.bar.set_position((progress.fraction.clamp(0.0, 1.0) * 1000.0) as u64);
        }
    }

    /// Removes the bar; returns the time since its start.
    pub(crate) fn finish(self) -> Duration {
        self.bar.finish_and_clear();
        self.started.elapsed()
    }

    fn line(&mut self, stage: &str, progress: &JobProgress, details: &str) {
        // Models that are fitted side by side take turns; they are one stage all the same.
        let due = match &self.last {
            Some((last, at)) => *last != progress.stage || at.elapsed() >= LINE_EVERY,
            None => true,
        };
        if due && !self.quiet {
            eprintln!("  {stage:<16} {:>3.0}%  {details}", 100.0 * progress.fraction);
            self.last = Some((progress.stage.clone(), Instant::now()));
        }
    }
}

fn stage(progress: &JobProgress) -> String {
    match progress.variant.as_str() {
        "" => progress.stage.clone(),
        variant => format!("{} {variant}", progress.stage),
    }
}

fn details(progress: &JobProgress) -> String {
    let mut parts = Vec::new();
    if progress.iterations > 0 {
        parts.push(format!("{}/{}", progress.iteration, progress.iterations));
    }
    if let Some(loss) = progress.best_loss.or(progress.loss) {
        parts.push(format!("loss {loss:.3e}"));
    }
    if let Some(eta) = progress.eta_s {
        parts.push(format!("{} left", output::duration(eta)));
    }
    parts.join("  ")
}

/// Progress bar in bytes, of an upload or of reading and writing files.
pub(crate) fn byte_bar(what: &'static str, bytes: u64, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(bytes).with_prefix(what);
    let style = ProgressStyle::with_template(
        "  {prefix:<16} [{bar:30}] {bytes}/{total_bytes}  {bytes_per_sec}",
    );
    match style {
        Ok(style) => bar.with_style(style.progress_chars("=> ")),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_show_what_is_known() {
        let mut progress = JobProgress { iteration: 3, iterations: 20, ..JobProgress::default() };
        assert_eq!(details(&progress), "3/20");
        progress.best_loss = Some(0.00123);
        progress.eta_s = Some(61.0);
        assert_eq!(details(&progress), "3/20  loss 1.230e-3  1 min 01 s left");
        progress.stage = "search".into();
        progress.variant = "axial".into();
        assert_eq!(stage(&progress), "search axial");
    }
}
