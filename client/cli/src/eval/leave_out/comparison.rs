//! Recordings of an object left out in turn: the error of each as predicted by twins of the others,
//! of one alone and of all together.
//!
//! All frames of the others are fitted, apart from recordings that are held out anyway, and all
//! frames of the one left out are scored. A twin sees its first frame alone, to which it is
//! registered.

use std::{fmt::Write as _, sync::Arc};

use bendtwin_core::{
    CancelToken, Capture, Category, Fault, FitSettings, Observer, Problem, Progress, Quality, Twin,
    quality::{ErrorSummary, Measure, Predictor, RegistrationScore},
};
use bendtwin_engine::Backend;
use bendtwin_eval::{EvaluateOptions, evaluate};
use bendtwin_fit::{Error as FitError, FitJob};
use serde::Serialize;

/// Recordings of one object, and the fits to them.
#[derive(Clone)]
pub(super) struct LeaveOneOut {
    /// Each without others.
    recordings: Vec<Capture>,
    settings: FitSettings,
    backend: Arc<dyn Backend>,
}

/// A recording, predicted by twins fitted without it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct LeftOut {
    /// Name of the recording.
    pub(super) recording: String,
    /// Predictions of a twin of each other recording alone.
    pub(super) from_one: Vec<Prediction>,
    /// Prediction of a twin of all other recordings; none if there is a single one.
    pub(super) from_all: Option<Prediction>,
}

/// A prediction of a recording that was left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Prediction {
    /// Names of the recordings that the twin was fitted to, the reference first.
    pub(super) fitted_to: Vec<String>,
    /// Errors; none if there is no such twin, or it could not be registered.
    pub(super) scores: Option<Scores>,
    /// The reason for missing predictions.
    pub(super) refused: Option<Fault>,
}

/// Errors in a recording that was left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Scores {
    /// The twin's, over all frames.
    pub(super) twin: ErrorSummary,
    /// The twin's in the first frame after the start: what the registration leaves.
    pub(super) first_frame: ErrorSummary,
    /// Errors of the mean prediction of the twin and its members; `None` without members.
    pub(super) mean_of_fits: Option<ErrorSummary>,
    /// Errors of an object that does not move.
    pub(super) standing_still: ErrorSummary,
    /// Distances of the first frame from the registered twin.
    pub(super) registered: RegistrationScore,
}

/// A twin, or the reason why it is missing.
struct Fitted {
    to: Vec<String>,
    twin: Result<Twin, Fault>,
}

impl LeaveOneOut {
    /// The recordings of captures, all of one object.
    ///
    /// # Errors
    /// If fewer than two of them may be fitted, or there are too many.
    pub(super) fn new(
        captures: Vec<Capture>,
        settings: FitSettings,
        backend: Arc<dyn Backend>,
    ) -> Result<Self, Fault> {
        let mut recordings = Vec::new();
        for mut capture in captures {
            let others = std::mem::take(&mut capture.others);
            recordings.extend([capture].into_iter().chain(others));
        }
        for recording in &mut recordings {
            for sequence in recording.sequences.iter_mut().filter(|s| s.train_frame_count > 0) {
                sequence.train_frame_count = sequence.frame_count;
            }
        }
        let fitted = recordings.iter().filter(|r| is_fitted(r)).count();
        let wrong = |message: String| Fault {
            category: Category::InvalidArgument,
            reason: "CAPTURE_CANNOT_BE_FITTED".to_owned(),
            message,
        };
        if fitted < 2 {
            return Err(wrong(format!(
                "to leave a recording out takes two that may be fitted: {fitted} of {} may",
                recordings.len()
            )));
        }
        if recordings.len() > Capture::MOST_RECORDINGS {
            let (n, most) = (recordings.len(), Capture::MOST_RECORDINGS);
            return Err(wrong(format!("there are {n} recordings: give at most {most}")));
        }
        Ok(Self { recordings, settings, backend })
    }

    /// Number of fits that are made.
    pub(super) fn fits(&self) -> usize {
        let alone = self.recordings.iter().filter(|r| is_fitted(r)).count();
        let joint = (0..self.recordings.len()).filter(|&left| self.others(left).count() > 1);
        alone + joint.count()
    }

    /// Fits and scores. Calls `tell` with the number of each fit, from 0, and its progress. A fit
    /// that fails, or a twin that cannot be registered, is part of the result.
    ///
    /// # Errors
    /// On cancellation, or if the device fails.
    pub(super) fn run(
        &self,
        tell: &mut dyn FnMut(usize, Progress),
        cancel: &CancelToken,
    ) -> Result<Vec<LeftOut>, Fault> {
        let mut done = 0;
        let mut fit = |of: &[usize]| {
            let number = done;
            done += 1;
            self.fit(of, &mut |progress| tell(number, progress), cancel)
        };
        let mut alone = Vec::with_capacity(self.recordings.len());
        for (index, recording) in self.recordings.iter().enumerate() {
            alone.push(if is_fitted(recording) { Some(fit(&[index])?) } else { None });
        }
        let mut all = Vec::with_capacity(self.recordings.len());
        for (left, recording) in self.recordings.iter().enumerate() {
            // Each is the reference once.
            let others: Vec<usize> = self.others(left).collect();
            let from_all = match &others[..] {
                [] | [_] => None,
                several => Some(self.predict(&fit(several)?, left, cancel)?),
            };
            let twins = others.iter().filter_map(|&other| alone[other].as_ref());
            let from_one =
                twins.map(|fitted| self.predict(fitted, left, cancel)).collect::<Result<_, _>>()?;
            all.push(LeftOut { recording: recording.name.clone(), from_one, from_all });
        }
        Ok(all)
    }

    /// The recordings that may be fitted, without one, from the one after it on.
    fn others(&self, left: usize) -> impl Iterator<Item = usize> + '_ {
        let n = self.recordings.len();
        (left + 1..left + n).map(move |i| i % n).filter(|&i| is_fitted(&self.recordings[i]))
    }

    /// A twin of these recordings; the first is the reference.
    fn fit(
        &self,
        of: &[usize],
        tell: &mut dyn FnMut(Progress),
        cancel: &CancelToken,
    ) -> Result<Fitted, Fault> {
        let names = of.iter().map(|&i| self.recordings[i].name.clone()).collect();
        let others = of.iter().skip(1).map(|&i| self.recordings[i].clone()).collect();
        let capture = Capture { others, ..self.recordings[of[0]].clone() };
        let job = FitJob {
            capture: &capture,
            capture_digest: bendtwin_capture::digest(&capture),
            settings: self.settings.clone(),
            backend: self.backend.clone(),
            look: None,
        };
        let twin = match job.twin(&mut Teller(tell), cancel) {
            Ok(twin) => Ok(twin),
            Err(error) if ends_all(error.category()) => return Err(error.fault()),
            Err(error @ FitError::Settings(_)) => return Err(error.fault()),
            Err(error) => Err(error.fault()),
        };
        Ok(Fitted { to: names, twin })
    }

    fn predict(
        &self,
        fitted: &Fitted,
        left: usize,
        cancel: &CancelToken,
    ) -> Result<Prediction, Fault> {
        let Fitted { to, twin } = fitted;
        let (recording, options) =
            (&self.recordings[left], EvaluateOptions { axial: None, per_frame: true });
        let scores = match twin {
            Ok(twin) => match evaluate(&*self.backend, twin, recording, &options, cancel) {
                Ok(quality) => Ok(Scores::new(&quality)),
                Err(error) if ends_all(error.category()) => return Err(error.fault()),
                Err(error) => Err(error.fault()),
            },
            Err(fault) => Err(fault.clone()),
        };
        let (scores, refused) = match scores {
            Ok(scores) => (Some(scores), None),
            Err(fault) => (None, Some(fault)),
        };
        Ok(Prediction { fitted_to: to.clone(), scores, refused })
    }
}

/// True if frames of a recording are for fitting.
fn is_fitted(recording: &Capture) -> bool {
    recording.sequences.iter().any(|s| s.train_frame_count > 0)
}

/// True if the remaining runs would fail in the same way.
fn ends_all(category: Category) -> bool {
    matches!(category, Category::Cancelled | Category::Internal | Category::Unavailable)
}

struct Teller<'a>(&'a mut dyn FnMut(Progress));

impl Observer<Progress> for Teller<'_> {
    fn progress(&mut self, progress: Progress) {
        (self.0)(progress);
    }
}

impl Scores {
    fn new(quality: &Quality) -> Self {
        let own = quality.scores.first();
        let of = |predictor| quality.score(predictor).map(|s| s.future);
        let registered = quality.recordings.first().and_then(|r| r.registered);
        Self {
            twin: own.map(|s| s.future).unwrap_or_default(),
            first_frame: own.and_then(|s| s.per_frame.first().copied()).unwrap_or_default(),
            mean_of_fits: of(Predictor::MeanOfFits),
            standing_still: of(Predictor::StandingStill).unwrap_or_default(),
            registered: registered.unwrap_or_default(),
        }
    }
}

impl LeftOut {
    /// Every prediction.
    fn all(&self) -> impl Iterator<Item = &Prediction> {
        self.from_one.iter().chain(&self.from_all)
    }

    /// The error that predictions of this recording are judged by.
    fn measure(&self) -> Option<Measure> {
        self.all().find_map(|p| Some(p.scores?.twin.headline()?.0))
    }

    /// Error of the twins of one recording, a mean over them [m].
    pub(super) fn one_m(&self) -> Option<f64> {
        let measure = self.measure()?;
        mean(self.from_one.iter().filter_map(|p| measure.of(&p.scores?.twin)))
    }

    /// Error of the twin of all other recordings [m].
    pub(super) fn all_m(&self) -> Option<f64> {
        self.measure()?.of(&self.from_all.as_ref()?.scores?.twin)
    }

    fn mean_m(&self, of: fn(&Scores) -> ErrorSummary) -> Option<f64> {
        let measure = self.measure()?;
        mean(self.all().filter_map(|p| measure.of(&of(&p.scores?))))
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, n), x| (sum + x, n + 1));
    (count > 0).then(|| sum / count as f64)
}

/// The results as a Markdown table in millimetres, with the reasons of what is missing below.
pub(super) fn left_out_table(results: &[LeftOut]) -> String {
    let mm = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{:.1}", 1e3 * x));
    let change = |one: Option<f64>, all: Option<f64>| match (one, all) {
        (Some(one), Some(all)) => format!("{:+.0} %", 100.0 * (all / one - 1.0)),
        _ => "-".to_owned(),
    };
    let mut text = String::from(
        "| left out | standing still | first frame | from one other | from all others | change |\n\
         |---|--:|--:|--:|--:|--:|\n",
    );
    let row = |text: &mut String, name: &str, still, first, one, all| {
        let (still, first, change) = (mm(still), mm(first), change(one, all));
        let _ =
            writeln!(text, "| {name} | {still} | {first} | {} | {} | {change} |", mm(one), mm(all));
    };
    let still = |left: &LeftOut| left.mean_m(|s| s.standing_still);
    let first = |left: &LeftOut| left.mean_m(|s| s.first_frame);
    for left in results {
        row(&mut text, &left.recording, still(left), first(left), left.one_m(), left.all_m());
    }
    let whole: Vec<&LeftOut> =
        results.iter().filter(|l| l.one_m().is_some() && l.all_m().is_some()).collect();
    if whole.len() > 1 {
        let mean_of =
            |of: &dyn Fn(&LeftOut) -> Option<f64>| mean(whole.iter().filter_map(|left| of(left)));
        let (still, first) = (mean_of(&still), mean_of(&first));
        row(&mut text, "mean", still, first, mean_of(&LeftOut::one_m), mean_of(&LeftOut::all_m));
    }
    for left in results {
        for prediction in left.all() {
            if let Some(fault) = &prediction.refused {
                let (name, of) = (&left.recording, prediction.fitted_to.join(" + "));
                let _ = write!(text, "\n{name} from {of}: {}", fault.message);
            }
        }
    }
    text
}

#[cfg(test)]
mod tests;
