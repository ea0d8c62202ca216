//! The spread of the predictions of a twin's fits.

use bendtwin_client::{Client, Reply, Rollout, Statistic, TwinId};

use crate::failure::Usage;

/// The fits that every action is simulated on.
pub(super) struct Spread {
    fits: usize,
    /// The error to expect over the spread, if that was measured.
    factor: Option<f64>,
}

impl Spread {
    /// All fits of a twin.
    pub(super) async fn of(client: &Client, twin: TwinId) -> anyhow::Result<Self> {
        let fits = client.twins().geometry(twin).await?.fits;
        if fits < 2 {
            let why = "the twin is a single fit, so there is nothing that its predictions could be compared \
                       with: fit its capture with --set search.starts=4, say";
            return Err(Usage::error(why));
        }
        let quality = client.twins().get(twin).await?.quality;
        let factor = quality.spread.and_then(|spread| spread.factor());
        Ok(Self { fits, factor })
    }

    /// Asks for the spread of every `every`-th frame.
    pub(super) fn ask(&self, request: Rollout, every: u32) -> Rollout {
        request.on_fits(self.fits as u32, Statistic::Mean).record_every(every).spread()
    }

    /// Makes what is said of the members of each action what is said of the twin.
    pub(super) fn fold(&self, reply: &mut Reply) {
        reply.diagnostics = reply.diagnostics.iter().step_by(self.fits).copied().collect();
        reply.instances.iter_mut().for_each(|instance| *instance /= self.fits);
        reply.diverged.retain(|d| d.instance.is_multiple_of(self.fits));
        reply.diverged.iter_mut().for_each(|d| d.instance /= self.fits);
        reply.implausible.retain(|i| i.instance.is_multiple_of(self.fits));
        reply.implausible.iter_mut().for_each(|i| i.instance /= self.fits);
    }

    /// The mean spread in each recorded frame of the first instance [m].
    pub(super) fn by_frame(reply: &Reply) -> Vec<f64> {
        let frames = reply.frames.len();
        let width = reply.spread.len().checked_div(reply.instances.len() * frames).unwrap_or(0);
        let rows = reply.spread.chunks(width.max(1)).take(frames);
        rows.map(|row| row.iter().map(|s| f64::from(*s)).sum::<f64>() / row.len() as f64).collect()
    }

    /// A line about the first instance.
    pub(super) fn text(&self, reply: &Reply) -> String {
        let by_frame = Self::by_frame(reply);
        let mean = by_frame.iter().sum::<f64>() / by_frame.len().max(1) as f64;
        let last = by_frame.last().copied().unwrap_or(0.0);
        let mut text = format!(
            "\nspread of {} fits: {:.1} mm on average, {:.1} mm at the end",
            self.fits,
            1e3 * mean,
            1e3 * last
        );
        if let Some(factor) = self.factor {
            text += &format!(
                "; on its capture the error is {factor:.1} times that, so expect {:.1} and {:.1} mm",
                1e3 * factor * mean,
                1e3 * factor * last
            );
        }
        text
    }
}
