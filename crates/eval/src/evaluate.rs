//! The quality table: the twin, the axial-only fit beside it, and the free baselines.

mod mean;
mod row;

use std::{borrow::Cow, sync::Arc};

use bendtwin_core::{
    CancelToken, Capture, Quality, Sequence, Twin,
    quality::{Predictor, RecordingScore, RegistrationScore, Score},
};
use bendtwin_engine::{Backend, model::State};

use self::{
    mean::mean_of_fits,
    row::{Measured, Row},
};
use crate::{
    Error, Motion, Placement, Trajectory,
    baselines::{clamp_interpolation, standing_still},
    check_capture, is_own_capture,
    metrics::PredictorErrors,
    placement::refuse_cable,
    predict,
    spread::SpreadErrors,
    trajectory::{check, predict_from},
};

/// Share of the observed points that a registration without a warning explains.
const LEAST_EXPLAINED: f64 = 0.8;

/// Contents of the table apart from the twin and the baselines.
#[derive(Clone, Copy, Debug, Default)]
pub struct EvaluateOptions<'a> {
    /// The axial-only fit of the same nodes, as a row beside the twin's.
    pub axial: Option<&'a Twin>,
    /// Keep the errors of every frame.
    pub per_frame: bool,
}

/// Rolls out every sequence of every recording from its start without re-seeding and scores it.
/// Held-out sequences and the frames after a split count as future, and so do all frames of a capture
/// that the twin was not fitted to. To recordings other than its own the twin is registered first;
/// one of several to which it cannot be is left out with a warning.
///
/// # Errors
/// If the twin fits no recording of the capture, on cancellation, or if the backend fails.
pub fn evaluate(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    options: &EvaluateOptions<'_>,
    cancel: &CancelToken,
) -> Result<Quality, Error> {
    Ok(fill(Table::new(twin, options), backend, twin, capture, options, cancel)?.quality())
}

/// [`evaluate`] with the predicted motion of a sequence, by its index among those of all
/// recordings. The motion is missing if the twin could not be registered to its recording, or the
/// sequence does not exist.
///
/// # Errors
/// Those of [`evaluate`].
pub fn evaluate_with_motion(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    options: &EvaluateOptions<'_>,
    sequence: usize,
    cancel: &CancelToken,
) -> Result<(Quality, Option<Motion>), Error> {
    let table = Table { wanted: Some(sequence), ..Table::new(twin, options) };
    let mut table = fill(table, backend, twin, capture, options, cancel)?;
    let motion = table.motion.take();
    Ok((table.quality(), motion))
}

fn fill(
    mut table: Table,
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    options: &EvaluateOptions<'_>,
    cancel: &CancelToken,
) -> Result<Table, Error> {
    check_capture(capture)?;
    let unseen = !is_own_capture(twin, capture);
    let (mut refused, mut measured) = (None, 0);
    for recording in capture.recordings() {
        if is_own_capture(twin, recording) {
            let own = Case::of_own_capture(backend, twin, options, recording, cancel)?;
            table.add(&own, false);
            measured += 1;
            table.passed += recording.sequences.len();
            continue;
        }
        match Case::all_elsewhere(backend, twin, options, recording, cancel) {
            Ok(cases) => {
                for case in &cases {
                    table.add(case, unseen);
                    table.passed += 1;
                }
                measured += cases.len();
            }
            Err(error) => {
                let cancelled = bendtwin_register::Error::Cancelled;
                if matches!(&error, Error::Backend(_)) || error == Error::Register(cancelled) {
                    return Err(error);
                }
                table
                    .warnings
                    .push(format!("recording `{}` is not scored: {error}", recording.name));
                refused.get_or_insert(error);
                table.passed += recording.sequences.len();
            }
        }
    }
    match refused {
        Some(error) if measured == 0 => Err(error),
        _ => Ok(table),
    }
}

/// The quality table of predictions that were made already by [`predict`], without a spread.
pub fn score(
    twin: &Twin,
    predictions: &[Trajectory],
    axial: Option<(&Twin, &[Trajectory])>,
    capture: &Capture,
    per_frame: bool,
) -> Quality {
    let options = EvaluateOptions { axial: axial.map(|(twin, _)| twin), per_frame };
    let mut table = Table::new(twin, &options);
    let own = Case {
        model: Predicted { twin: Cow::Borrowed(twin), paths: predictions.to_vec() },
        axial: axial
            .map(|(twin, paths)| Predicted { twin: Cow::Borrowed(twin), paths: paths.to_vec() }),
        members: Vec::new(),
        recording: capture,
        sequences: &capture.sequences,
        registered: None,
    };
    table.add(&own, false);
    table.quality()
}

/// A twin and its predictions of some sequences.
struct Predicted<'a> {
    twin: Cow<'a, Twin>,
    paths: Vec<Trajectory>,
}

/// Predictions of some sequences of a recording.
struct Case<'a> {
    model: Predicted<'a>,
    axial: Option<Predicted<'a>>,
    /// Predictions of the twin's members.
    members: Vec<Vec<Trajectory>>,
    recording: &'a Capture,
    sequences: &'a [Sequence],
    registered: Option<RegistrationScore>,
}

impl<'a> Case<'a> {
    /// All sequences of the capture that the twin was fitted to.
    fn of_own_capture(
        backend: &dyn Backend,
        twin: &'a Twin,
        options: &EvaluateOptions<'a>,
        recording: &'a Capture,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let predicted = |twin: &'a Twin| -> Result<Predicted<'a>, Error> {
            let paths = predict(backend, twin, recording, cancel)?;
            Ok(Predicted { twin: Cow::Borrowed(twin), paths })
        };
        Ok(Self {
            model: predicted(twin)?,
            axial: options.axial.map(predicted).transpose()?,
            members: fits(twin)
                .map(|fit| predict(backend, &fit, recording, cancel))
                .collect::<Result<_, _>>()?,
            recording,
            sequences: &recording.sequences,
            registered: None,
        })
    }

    /// The sequences of another recording, each registered to the twin.
    fn all_elsewhere(
        backend: &dyn Backend,
        twin: &'a Twin,
        options: &EvaluateOptions<'a>,
        recording: &'a Capture,
        cancel: &CancelToken,
    ) -> Result<Vec<Self>, Error> {
        refuse_cable(twin, recording)?;
        let mut cases = Vec::with_capacity(recording.sequences.len());
        for sequence in &recording.sequences {
            let placed = Placement::new(&twin.graph, &twin.skin, recording, sequence, cancel)?;
            let sequences = std::slice::from_ref(sequence);
            let start = Arc::new(State {
                positions: placed.positions.clone(),
                velocities: placed.velocities.clone(),
                ..State::default()
            });
            // The axial fit has the same nodes.
            let predicted = |twin: &Twin| -> Result<Predicted<'a>, Error> {
                let twin = placed.twin(twin, recording, sequence)?;
                check(&twin, recording)?;
                let fps = recording.fps;
                let paths = predict_from(backend, &twin, fps, sequences, Some(&start), cancel)?;
                Ok(Predicted { twin: Cow::Owned(twin), paths })
            };
            cases.push(Self {
                model: predicted(twin)?,
                axial: options.axial.map(predicted).transpose()?,
                members: fits(twin)
                    .map(|fit| predicted(&fit).map(|predicted| predicted.paths))
                    .collect::<Result<_, _>>()?,
                recording,
                sequences,
                registered: Some(placed.score),
            });
        }
        Ok(cases)
    }
}

/// A twin's members as twins.
fn fits(twin: &Twin) -> impl Iterator<Item = Twin> + '_ {
    twin.members.iter().map(|member| member.twin(twin))
}

/// A quality table in the making.
struct Table {
    own: Predictor,
    /// A row for each predictor that may be measured, the twin first.
    rows: Vec<Row>,
    per_frame: bool,
    recordings: Vec<(RecordingScore, PredictorErrors)>,
    spread: SpreadErrors,
    warnings: Vec<String>,
    of_axial: Vec<String>,
    /// Sequences of the recordings before the one that is added.
    passed: usize,
    /// The sequence whose motion is kept, and that motion.
    wanted: Option<usize>,
    motion: Option<Motion>,
}

impl Table {
    fn new(twin: &Twin, options: &EvaluateOptions<'_>) -> Self {
        let own =
            if twin.graph.triplets.is_empty() { Predictor::Axial } else { Predictor::Bending };
        let beside =
            (options.axial.is_some() && own == Predictor::Bending).then_some(Predictor::Axial);
        let baselines =
            [Predictor::StandingStill, Predictor::LastResidual, Predictor::ClampInterpolation];
        let all = [own, Predictor::MeanOfFits].into_iter().chain(beside).chain(baselines);
        let rows = all.map(Row::new).collect();
        let per_frame = options.per_frame;
        let (recordings, warnings, of_axial) = (Vec::new(), Vec::new(), Vec::new());
        let (passed, wanted, motion) = (0, None, None);
        Self {
            own,
            rows,
            per_frame,
            recordings,
            spread: SpreadErrors::default(),
            warnings,
            of_axial,
            passed,
            wanted,
            motion,
        }
    }

    /// Adds the sequences of a case. If the twin has not seen the recording, all frames count as future.
    fn add(&mut self, case: &Case<'_>, unseen: bool) {
        let Case { model, axial, members, recording, sequences, registered } = case;
        let rows = &mut self.rows;
        let weights = model.twin.fit_weights();
        let mut of_recording = PredictorErrors::default();
        for (index, sequence) in sequences.iter().enumerate() {
            let Some(prediction) = model.paths.get(index) else { continue };
            let measure = |twin, prediction: &Trajectory| {
                let measured = Measured::new(twin, recording, sequence, prediction)?;
                Some(if unseen { measured.unseen() } else { measured })
            };
            let Some(measured) = measure(&model.twin, prediction) else { continue };
            measured.add(prediction, self.own, rows);
            let on_skin = prediction.at_skin(&model.twin.skin);
            of_recording.add(&measured.at_skin, &on_skin);
            if self.wanted == Some(self.passed + index) {
                let reference = &measured.at_skin;
                self.motion =
                    Some(Motion::new(recording, sequence, reference, prediction, &on_skin));
            }
            if let Some(other) = axial
                && self.own != Predictor::Axial
                && let Some(prediction) = other.paths.get(index)
                && let Some(measured) = measure(&other.twin, prediction)
            {
                measured.add(prediction, Predictor::Axial, rows);
            }
            let start = &prediction.positions[..prediction.node_count];
            let still = standing_still(&model.twin.graph, sequence, start);
            measured.add(&still, Predictor::StandingStill, rows);
            if !unseen {
                measured.add_last_residual(prediction, rows);
            }
            let others: Vec<&Trajectory> = members.iter().filter_map(|m| m.get(index)).collect();
            if !others.is_empty() {
                let train_frames = if unseen { 0 } else { sequence.train_frame_count };
                self.spread.add(&model.twin, sequence, prediction, &others, train_frames);
                let (mean, warning) = mean_of_fits(sequence, prediction, &others, &weights);
                measured.add(&mean, Predictor::MeanOfFits, rows);
                self.warnings.extend(warning);
            }
            let graph = &model.twin.graph;
            if let Some(between) = clamp_interpolation(recording, graph, sequence, start) {
                measured.add(&between, Predictor::ClampInterpolation, rows);
            }
        }
        self.warnings.extend(divergences(sequences, &model.paths));
        if let Some(axial) = axial {
            let named = |w: String| format!("the axial-only fit: {w}");
            self.of_axial.extend(divergences(sequences, &axial.paths).into_iter().map(named));
        }
        if let Some(registered) = registered {
            self.warnings.extend(doubtful(&recording.name, registered));
        }
        let score = RecordingScore {
            name: recording.name.clone(),
            registered: *registered,
            ..RecordingScore::default()
        };
        self.recordings.push((score, of_recording));
    }

    fn quality(self) -> Quality {
        let per_frame = self.per_frame;
        let mut quality = Quality {
            scores: self.rows.into_iter().filter_map(|row| row.score(per_frame)).collect(),
            warnings: self.warnings,
            spread: self.spread.score(),
            ..Quality::default()
        };
        quality.warnings.extend(self.of_axial);
        // Of a twin's only capture they would say what the table says.
        let is_plain = self.recordings.len() == 1 && self.recordings[0].0.registered.is_none();
        if !is_plain {
            let score = |(score, errors): (RecordingScore, PredictorErrors)| RecordingScore {
                train: errors.train.summary(),
                future: errors.future.summary(),
                ..score
            };
            quality.recordings = self.recordings.into_iter().map(score).collect();
        }
        let warning = beaten_by_standing_still(&quality, self.own);
        quality.warnings.extend(warning);
        quality
    }
}

/// A warning about a registration that was accepted, but explains little.
fn doubtful(name: &str, registered: &RegistrationScore) -> Option<String> {
    (registered.explained < LEAST_EXPLAINED).then(|| {
        format!(
            "only {:.0} % of what recording `{name}` shows at its start is within reach of the twin: \
             check that it is the same object, seen from the same sides",
            100.0 * registered.explained
        )
    })
}

fn divergences(sequences: &[Sequence], predictions: &[Trajectory]) -> Vec<String> {
    let pairs = sequences.iter().zip(predictions);
    let diverged = pairs.filter_map(|(s, p)| Some((s, p.diverged?, p.start_frame)));
    diverged
        .map(|(s, at, start)| {
            format!(
                "the simulation of sequence `{}` diverged in frame {} at node {}; it is scored as if \
                 the object had stopped there",
                s.name,
                start + at.frame,
                at.node
            )
        })
        .collect()
}

fn beaten_by_standing_still(quality: &Quality, own: Predictor) -> Option<String> {
    let (twin, still) = (quality.score(own)?, quality.score(Predictor::StandingStill)?);
    let measure = |s: &Score| {
        let part = if s.future == Default::default() { s.train } else { s.future };
        part.track_m.or(part.chamfer_l1_m)
    };
    let (ours, theirs) = (measure(twin)?, measure(still)?);
    (ours >= theirs).then(|| {
        format!(
            "the twin ({:.1} mm) predicts no better than standing still ({:.1} mm)",
            1e3 * ours,
            1e3 * theirs
        )
    })
}

#[cfg(test)]
mod tests;
