//! The predictions of a twin's fits: how far they are apart, and their mean.

use std::fmt::Write as _;

use bendtwin_client::{Client, Reply, Rollout, Statistic, TwinId};

use crate::failure::Usage;

/// The fits of a twin, on which every action is simulated.
pub(super) struct Fits {
    count: usize,
    /// The error to expect over the spread, if the spread is asked for and that was measured.
    spread: Option<Option<f64>>,
    /// True if positions and costs are to be those of the mean motion.
    of_mean: bool,
    /// Number of the fits that diverged in each action that one did, once there is a reply.
    lost: Vec<(usize, usize)>,
}

impl Fits {
    /// All fits of a twin, for their spread, their mean or both; none if neither is asked for.
    pub(super) async fn of(
        client: &Client,
        twin: TwinId,
        spread: bool,
        of_mean: bool,
    ) -> anyhow::Result<Option<Self>> {
        if !spread && !of_mean {
            return Ok(None);
        }
        let count = client.twins().geometry(twin).await?.fits;
        if count < 2 {
            let why = "the twin is a single fit, so its predictions have no other fits to compare with: fit its \
                       capture with several starts, for example --set search.starts=4";
            return Err(Usage::error(why));
        }
        let spread = match spread {
            true => {
                let quality = client.twins().get(twin).await?.quality;
                Some(quality.spread.and_then(|spread| spread.factor()))
            }
            false => None,
        };
        Ok(Some(Self { count, spread, of_mean, lost: Vec::new() }))
    }

    /// Asks for it in every `every`-th frame.
    pub(super) fn ask(&self, request: Rollout, every: u32) -> Rollout {
        let statistic = if self.of_mean { Statistic::MeanPrediction } else { Statistic::Mean };
        let request = request.on_fits(self.count as u32, statistic);
        match self.spread {
            Some(_) => request.record_every(every).spread(),
            None => request,
        }
    }

    /// Reduces the values of the members of each action to those of the twin.
    pub(super) fn fold(&mut self, reply: &mut Reply) {
        let count = self.count;
        if self.of_mean {
            for action in 0..reply.costs.len() {
                let of = reply.diverged.iter().filter(|d| d.instance / count == action).count();
                self.lost.extend((of > 0).then_some((action, of)));
            }
        }
        reply.diagnostics = reply.diagnostics.iter().step_by(count).copied().collect();
        reply.instances.iter_mut().for_each(|instance| *instance /= count);
        reply.diverged.retain(|d| d.instance.is_multiple_of(count));
        reply.diverged.iter_mut().for_each(|d| d.instance /= count);
        reply.implausible.retain(|i| i.instance.is_multiple_of(count));
        reply.implausible.iter_mut().for_each(|i| i.instance /= count);
    }

    /// The mean spread in each recorded frame of the first instance [m].
    pub(super) fn by_frame(reply: &Reply) -> Vec<f64> {
        let frames = reply.frames.len();
        let width = reply.spread.len().checked_div(reply.instances.len() * frames).unwrap_or(0);
        let rows = reply.spread.chunks(width.max(1)).take(frames);
        rows.map(|row| row.iter().map(|s| f64::from(*s)).sum::<f64>() / row.len() as f64).collect()
    }

    /// Lines about the mean, and about the spread of the first instance.
    pub(super) fn text(&self, reply: &Reply) -> String {
        let mut text = String::new();
        if self.of_mean {
            let count = self.count;
            let _ = write!(text, "\ncosts and positions are those of the mean of {count} fits");
            for (action, lost) in &self.lost {
                let _ = write!(
                    text,
                    "\ninstance {action}: {lost} of {count} fits diverged and are left out of the mean"
                );
            }
        }
        if let Some(factor) = self.spread {
            text += &self.spread_text(reply, factor);
        }
        text
    }

    fn spread_text(&self, reply: &Reply, factor: Option<f64>) -> String {
        let by_frame = Self::by_frame(reply);
        let mean = by_frame.iter().sum::<f64>() / by_frame.len().max(1) as f64;
        let last = by_frame.last().copied().unwrap_or(0.0);
        let mut text = format!(
            "\nspread of {} fits: {:.1} mm on average, {:.1} mm at the end",
            self.count,
            1e3 * mean,
            1e3 * last
        );
        if let Some(factor) = factor {
            text += &format!(
                "; on its capture the error is {factor:.1} times that, so expect {:.1} and {:.1} mm",
                1e3 * factor * mean,
                1e3 * factor * last
            );
        }
        text
    }
}
