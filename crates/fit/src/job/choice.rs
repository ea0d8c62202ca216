//! The choice among the starts of a model.

use std::ops::Range;

use bendtwin_core::quality::Choice;

use super::{Run, checkpoint::ChosenStart, model_fit::ModelFit, validation::Validation};
use crate::{Error, refine::Refinement};

impl Run<'_> {
    /// The models of each kind, with bending or without: its starts.
    pub(super) fn kinds(&self) -> Vec<Range<usize>> {
        let same = |a: &ModelFit, b: &ModelFit| a.bending == b.bending;
        let mut end = 0;
        let kinds = self.models.chunk_by(same).map(|starts| {
            end += starts.len();
            end - starts.len()..end
        });
        kinds.collect()
    }

    /// The starts of the same kind as a model.
    pub(super) fn kind_of(&self, model: usize) -> Option<Range<usize>> {
        self.kinds().into_iter().find(|kind| kind.contains(&model))
    }

    /// Chooses the start of each kind of model that predicts the frames held back best, and sends it
    /// back to what its search found.
    pub(super) fn choose(
        &mut self,
        validation: &Validation<'_>,
        refinement: &Refinement<'_>,
    ) -> Result<(), Error> {
        let losses = validation.losses(&refinement.runs, &*self.job.backend, self.cancel)?;
        for kind in self.kinds() {
            let runs = || refinement.runs.iter().zip(&losses);
            let own = || runs().filter(|(r, _)| kind.contains(&r.model));
            let Some((best, _)) = own().min_by(|a, b| a.1.total_cmp(b.1)) else { continue };
            let of_model =
                |m: usize| own().find(|(r, _)| r.model == m).map_or(f64::INFINITY, |(_, l)| *l);
            let losses = kind.clone().map(of_model).collect();
            self.chosen.push(ChosenStart { model: best.model, losses });
        }
        self.chosen.iter().for_each(|c| self.models[c.model].choose());
        Ok(())
    }

    /// The choice of a model among the starts of its kind; `None` where there was no choice.
    pub(super) fn choice(&self, model: usize, refinement: &Refinement<'_>) -> Option<Choice> {
        let kind = self.kind_of(model).filter(|kind| kind.len() > 1)?;
        let finite = |loss: f64| loss.is_finite().then_some(loss);
        let held_back = self.chosen.iter().find(|c| c.model == model).zip(self.validation);
        let losses = match held_back {
            Some((chosen, _)) => chosen.losses.iter().map(|&l| finite(l)).collect(),
            None => {
                let run = |m: usize| refinement.runs.iter().find(|r| r.model == m);
                kind.clone().map(|m| run(m).and_then(|r| finite(r.state.best.loss))).collect()
            }
        };
        Some(Choice {
            start: (model - kind.start) as u32,
            held_back_frames: held_back.map_or(0, |(_, validation)| validation.frames),
            losses,
        })
    }
}
