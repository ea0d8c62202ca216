//! Rollouts that are divided in time. A span of frames of all instances of a part is simulated from
//! where the one before ended, and sent before the next one begins. On the CPU its bits are those of
//! a rollout that never stopped; costs are added up frame by frame, as the engine does.

mod track;

use bendtwin_core::Point;
use bendtwin_engine::{
    Objective,
    backend::{Instance, Outputs, Rollout},
};
use bendtwin_proto::v1::{RollOutResponse, roll_out_response::Window};

use self::track::Track;
use crate::{
    cut,
    error::Error,
    reply::{self, Span},
    request::plausible::Extremes,
    run::execute::{BatchResult, Execution},
};

impl Execution<'_> {
    /// Spans of at most `frames` frames, of one part of the instances after another.
    pub(crate) fn each_span(
        &self,
        frames: usize,
        emit: &mut impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<(), Error> {
        for range in self.parts() {
            let indices = self.plan.instances(range);
            let mut tracks: Vec<Track> =
                indices.iter().map(|index| Track::new(self.plan, self.starts, *index)).collect();
            for span in Span::of(self.plan.frames, frames) {
                let rollouts = self.simulate(&mut tracks, span)?;
                let mut part = self.part(&indices, &tracks, span)?;
                self.record(&indices, &tracks, span, &rollouts, &mut part);
                emit(self.signed(part))?;
            }
        }
        Ok(())
    }

    /// Takes all tracks to the end of a span; nothing is recorded of those that diverged before.
    fn simulate(&self, tracks: &mut [Track], span: Span) -> Result<Vec<Rollout>, Error> {
        let outputs = self.outputs();
        let costs = &self.plan.costs;
        let shared = (!costs.are_by_instance()).then(|| costs.scored_over(0, span));
        let mut rollouts: Vec<Rollout> = tracks.iter().map(|t| t.stopped(span)).collect();
        let running: Vec<usize> = (0..tracks.len()).filter(|i| tracks[*i].runs()).collect();
        for run in cut::runs(0..running.len(), self.plan.prepared) {
            let run = &running[run];
            let batch: Vec<Instance> = run
                .iter()
                .map(|i| {
                    let objective = self.objective(&tracks[*i], span, shared.as_ref());
                    tracks[*i].instance(span, objective)
                })
                .collect();
            let results = self.backend.roll_out(&batch, &outputs, self.cancel)?;
            for ((i, instance), result) in run.iter().zip(&batch).zip(results) {
                rollouts[*i] = tracks[*i].advance(self.plan, span, instance, result);
            }
        }
        Ok(rollouts)
    }

    /// Outputs of the engine over a span. A cost that looks back needs the positions of all frames.
    fn outputs(&self) -> Outputs {
        let asked = self.plan.returns.outputs();
        let forces = asked.forces || self.plan.limits_grasp_force();
        let outputs = Outputs { frame_costs: true, final_state: true, forces, ..asked };
        if self.plan.costs.look_back() {
            return Outputs { every: 1, nodes: None, ..outputs };
        }
        outputs
    }

    fn objective(&self, track: &Track, span: Span, shared: Option<&Objective>) -> Objective {
        let action = self.plan.action(track.index);
        let own = || self.plan.costs.scored_over(action, span);
        self.plan.variant(track.index).objective(&shared.cloned().unwrap_or_else(own))
    }

    /// The part of a span: all that is reported of whole rollouts if it is the last.
    fn part(
        &self,
        indices: &[usize],
        tracks: &[Track],
        span: Span,
    ) -> Result<RollOutResponse, Error> {
        let plan = self.plan;
        let window = Window { first_frame: span.from as u32 + 1, last_frame: span.to as u32 };
        let mut part = if span.to == plan.frames {
            let rollouts: Vec<Rollout> = tracks.iter().map(|t| t.whole(&plan.costs)).collect();
            let extremes: Vec<Extremes> =
                tracks.iter().map(|t| t.extremes_at_end(plan, self.starts)).collect();
            self.summary(indices, &BatchResult::of(rollouts, extremes))?
        } else {
            for track in tracks {
                let judged =
                    plan.plausibility.judge(track.index, &track.extremes, Some(&track.so_far));
                plan.plausibility.refuse(&judged)?;
            }
            let first = indices.first().map_or(0, |index| plan.action(*index));
            RollOutResponse { first_instance: first as u32, ..reply::head(plan) }
        };
        let diverged = tracks.iter().filter_map(|t| reply::divergence(plan, t.index, &t.so_far));
        part.diverged = diverged.filter(|d| span.has(d.frame as usize)).collect();
        part.window = Some(window);
        Ok(part)
    }

    /// Arrays by frame, and final states at the end.
    fn record(
        &self,
        indices: &[usize],
        tracks: &[Track],
        span: Span,
        rollouts: &[Rollout],
        part: &mut RollOutResponse,
    ) {
        let plan = self.plan;
        let ends: Vec<Point> = tracks.iter().flat_map(Track::end).copied().collect();
        let path = |track: &Track| track.controls(span.rows()).to_vec();
        let paths =
            if plan.returns.controls { tracks.iter().flat_map(path).collect() } else { Vec::new() };
        let arrays = reply::Arrays {
            indices,
            rollouts,
            means: &[],
            starts: self.starts,
            ends: &ends,
            paths: &paths,
        };
        reply::add_arrays(plan, span, &arrays, part);
    }
}
