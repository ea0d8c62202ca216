//! Progress of long work: a bar on a terminal, otherwise a line at intervals.

use std::time::{Duration, Instant};

use bendtwin_client::{JobProgress, ModelLoss};
use indicatif::{ProgressBar, ProgressStyle};

use crate::output;

/// Time between two lines of the same stage where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Progress bar of a fit.
pub struct FitBar {
    bar: ProgressBar,
    started: Instant,
    /// Stage and time of the last line.
    last: Option<(String, Instant)>,
    last_note: String,
    /// The last loss of each model of the stage.
    models: Vec<ModelLoss>,
    quiet: bool,
}

impl FitBar {
    /// `quiet` shows nothing (for `--json`).
    pub fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(1000) };
        let style = ProgressStyle::with_template("  {prefix:<16} [{bar:30}] {percent:>3}%  {msg}");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        let (last_note, models) = (String::new(), Vec::new());
        Self { bar, started: Instant::now(), last: None, last_note, models, quiet }
    }

    /// Prints a line above the bar.
    pub fn print(&self, text: &str) {
        if self.quiet {
        } else if self.bar.is_hidden() {
            eprintln!("  {text}");
        } else {
            self.bar.println(format!("  {text}"));
        }
    }

    /// Shows progress.
    pub fn show(&mut self, progress: &JobProgress) {
        if !progress.note.is_empty() && progress.note != self.last_note {
            self.print(&format!("note: {}", progress.note));
            self.last_note.clone_from(&progress.note);
        }
        self.models = models(std::mem::take(&mut self.models), progress);
        let stage = stage(progress, &self.models);
        let details = details(progress, &self.models);
        if self.bar.is_hidden() {
            self.line(&stage, progress, &details);
        } else {
            self.bar.set_prefix(stage);
            self.bar.set_message(details);
            self.bar.set_position((progress.fraction.clamp(0.0, 1.0) * 1000.0) as u64);
        }
    }

    /// Removes the bar; returns the time since its start.
    pub fn finish(self) -> Duration {
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

/// The models of the stage: as the report names them, or those that were reported before with this
/// one.
fn models(before: Vec<ModelLoss>, progress: &JobProgress) -> Vec<ModelLoss> {
    if !progress.models.is_empty() {
        return progress.models.clone();
    }
    let mut models = before;
    models.retain(|m| m.stage == progress.stage && m.variant != progress.variant);
    if progress.loss.or(progress.best_loss).is_some() {
        models.push(ModelLoss {
            stage: progress.stage.clone(),
            variant: progress.variant.clone(),
            iteration: progress.iteration,
            loss: progress.loss,
            best_loss: progress.best_loss,
            error_m: None,
        });
    }
    // A start that was not chosen makes no more passes.
    models.retain(|m| progress.iteration.saturating_sub(m.iteration) <= 1);
    models.sort_by_key(|m| (!m.variant.starts_with("bending"), m.variant.clone()));
    models
}

/// The stage, with its model if there is only one.
fn stage(progress: &JobProgress, models: &[ModelLoss]) -> String {
    match progress.variant.as_str() {
        variant if variant.is_empty() || models.len() > 1 => progress.stage.clone(),
        variant => format!("{} {variant}", progress.stage),
    }
}

/// The lowest loss of each kind of model, and of how many starts it is the lowest.
fn lowest(models: &[ModelLoss]) -> Vec<(&str, f64, usize)> {
    let mut kinds: Vec<(&str, f64, usize)> = Vec::new();
    for model in models {
        let Some(loss) = model.best_loss.or(model.loss) else { continue };
        let kind = model.variant.split(' ').next().unwrap_or_default();
        match kinds.iter_mut().find(|(other, ..)| *other == kind) {
            Some((_, lowest, starts)) => (*lowest, *starts) = (lowest.min(loss), *starts + 1),
            None => kinds.push((kind, loss, 1)),
        }
    }
    kinds
}

fn details(progress: &JobProgress, models: &[ModelLoss]) -> String {
    let mut parts = Vec::new();
    if progress.iterations > 0 {
        parts.push(format!("{}/{}", progress.iteration, progress.iterations));
    }
    match &lowest(models)[..] {
        [] => {
            let loss = progress.best_loss.or(progress.loss);
            parts.extend(loss.map(|loss| format!("loss {loss:.3e}")));
        }
        kinds => {
            parts.extend(kinds.iter().map(|(kind, loss, starts)| match (kinds.len(), starts) {
                (1, 1) => format!("loss {loss:.3e}"),
                (_, 1) => format!("{kind} {loss:.3e}"),
                (_, starts) => format!("{kind} {loss:.3e} (best of {starts})"),
            }));
        }
    }
    parts.extend(progress.error_m.map(|error_m| format!("off by {:.1} mm", 1e3 * error_m)));
    if let Some(eta) = progress.eta_s {
        parts.push(format!("{} left", output::duration(eta)));
    }
    parts.join("  ")
}

/// Progress bar in bytes, of an upload or of reading and writing files.
pub fn byte_bar(what: &'static str, bytes: u64, quiet: bool) -> ProgressBar {
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
        assert_eq!(details(&progress, &[]), "3/20");
        progress.best_loss = Some(0.00123);
        progress.eta_s = Some(61.0);
        assert_eq!(details(&progress, &[]), "3/20  loss 1.230e-3  1 min 01 s left");
        progress.error_m = Some(0.00834);
        assert_eq!(details(&progress, &[]), "3/20  loss 1.230e-3  off by 8.3 mm  1 min 01 s left");
        progress.stage = "search".into();
        progress.variant = "axial".into();
        assert_eq!(stage(&progress, &[]), "search axial");
    }

    fn report(variant: &str, iteration: u32, loss: f64) -> JobProgress {
        let (stage, variant) = ("refine".to_owned(), variant.to_owned());
        let (loss, iterations) = (Some(loss), 20);
        JobProgress { stage, variant, iteration, iterations, loss, ..JobProgress::default() }
    }

    /// `--axial` fits two models side by side, whose reports take turns.
    #[test]
    fn models_that_are_fitted_side_by_side_are_all_shown() {
        let first = models(Vec::new(), &report("bending", 3, 0.5));
        assert_eq!(stage(&report("bending", 3, 0.5), &first), "refine bending");
        let last = report("axial", 3, 0.25);
        let both = models(first, &last);
        assert_eq!(stage(&last, &both), "refine");
        assert_eq!(details(&last, &both), "3/20  bending 5.000e-1  axial 2.500e-1");
        // As a server names them.
        let named = JobProgress { models: both.clone(), ..report("axial", 3, 0.25) };
        assert_eq!(models(Vec::new(), &named), both);
        // The next stage begins with its own.
        let next = JobProgress { stage: "evaluate".into(), ..JobProgress::default() };
        assert_eq!(models(both, &next), []);
    }

    #[test]
    fn of_several_starts_the_best_is_shown() {
        let reports = ["bending 1/3", "bending 2/3", "axial 1/3"].map(|v| report(v, 4, 0.5));
        let all = reports.iter().fold(Vec::new(), models);
        let text = details(&reports[2], &all);
        assert_eq!(text, "4/20  bending 5.000e-1 (best of 2)  axial 5.000e-1");
        let later = models(all, &report("bending 2/3", 6, 0.25));
        assert_eq!(details(&report("bending 2/3", 6, 0.25), &later), "6/20  loss 2.500e-1");
    }
}
