//! `bendtwin bench load`: what greedy clients leave to others on a running server. Small rollouts
//! are timed and a fit's speed is measured, first alone, then beside clients that keep sending
//! large rollouts.

use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use bendtwin_client::{CaptureId, Client, Fit, FitId, FitSettings, Point, Rollout, TwinId};
use bendtwin_core::Twin;
use clap::Args;
use futures::future::join_all;
use serde::Serialize;
use tokio_util::sync::CancellationToken;

use crate::{global::Global, output, signals, table::Table};

/// Pause of a client that was refused. Greedy ones do not wait as long as they are told to.
const PAUSE: Duration = Duration::from_secs(1);
/// Longest wait for the first generation of the fit.
const FIT_START: Duration = Duration::from_secs(300);

#[derive(Debug, Args)]
#[command(after_help = "\
It needs a server with a twin, whose capture is fitted beside (the fit is deleted afterwards):
  bendtwin server &
  bendtwin bench load --clients 64")]
pub(crate) struct Load {
    /// Twin to roll out [default: the newest that has a capture]
    #[arg(long, value_name = "NAME")]
    twin: Option<TwinId>,
    /// Number of greedy clients, each with a connection of its own
    #[arg(long, value_name = "N", default_value_t = 64)]
    clients: usize,
    /// Size of their rollouts: instances x frames
    #[arg(long, value_name = "BxF", default_value = "4000x200", value_parser = size)]
    large: Size,
    /// Size of the small rollouts, which come one after another
    #[arg(long, value_name = "BxF", default_value = "16x30", value_parser = size)]
    small: Size,
    /// Time for each of the two measurements [s]
    #[arg(long, value_name = "S", default_value_t = 30, value_parser = clap::value_parser!(u64).range(1..=3600))]
    seconds: u64,
    /// Leave out the fit
    #[arg(long)]
    no_fit: bool,
}

/// Size of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
struct Size {
    instances: usize,
    frames: u32,
}

fn size(text: &str) -> Result<Size, String> {
    let fault = || format!("`{text}` is no size: give instances x frames, 4000x200 say");
    let (instances, frames) = text.split_once('x').ok_or_else(fault)?;
    let size = Size {
        instances: instances.parse().map_err(|_| fault())?,
        frames: frames.parse().map_err(|_| fault())?,
    };
    if size.instances == 0 || size.frames == 0 { Err(fault()) } else { Ok(size) }
}

/// Results of one measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct Measured {
    /// Small rollouts that were answered, and that were refused.
    answered: usize,
    refused: usize,
    /// Their median and 99th percentile [s].
    p50_s: f64,
    p99_s: f64,
    /// Generations of the fit a second.
    generations_per_s: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Report {
    clients: usize,
    large: Size,
    small: Size,
    idle: Measured,
    loaded: Measured,
    /// Large rollouts that were refused.
    large_refused: usize,
}

/// Control points that hold still.
#[derive(Clone)]
struct Still {
    twin: TwinId,
    controls: Vec<Point>,
}

impl Still {
    fn rollout(&self, size: Size) -> Rollout {
        let knots = 2 * size.instances;
        let positions =
            std::iter::repeat_n(&self.controls, knots).flatten().copied().collect::<Vec<_>>();
        let shape = [size.instances, 2, self.controls.len()];
        Rollout::of(self.twin).trajectories(shape, positions).frames(size.frames)
    }
}

pub(super) async fn run(args: Load, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    let (twin, capture) = subject(&client, args.twin).await?;
    let file = client.twins().export(twin).await?;
    let controls = Twin::decode(&file).context("the twin cannot be read")?.graph.control_rest;
    let still = Still { twin, controls };
    let fit = match capture.filter(|_| !args.no_fit) {
        Some(capture) => Some(start_fit(&client, capture).await?),
        None => None,
    };
    let shutdown = signals::shutdown();
    let measured = tokio::select! {
        () = shutdown.cancelled() => Err(anyhow::anyhow!("interrupted")),
        measured = measure(&args, &client, global, &still, fit) => measured,
    };
    if let Some(fit) = fit {
        // Deleting a fit that still runs is refused: it is cancelled first.
        client.fits().cancel(fit).await?;
        client.fits().wait(fit).await?;
        client.fits().delete(fit).await?;
    }
    let report = measured?;
    output::print(global, &report, || text(&report))
}

async fn subject(
    client: &Client,
    twin: Option<TwinId>,
) -> anyhow::Result<(TwinId, Option<CaptureId>)> {
    if let Some(name) = twin {
        let twin = client.twins().get(name).await?;
        return Ok((twin.name, twin.capture));
    }
    let twins = client.twins().all(None).await?;
    let newest = twins.into_iter().filter(|t| t.capture.is_some()).max_by_key(|t| t.create_time);
    match newest {
        Some(twin) => Ok((twin.name, twin.capture)),
        None => bail!("the server has no twin of a capture: fit one, or name a twin with --twin"),
    }
}

/// A fit of short generations that does not end by itself in the time of a measurement.
async fn start_fit(client: &Client, capture: CaptureId) -> anyhow::Result<FitId> {
    let mut settings = FitSettings::default();
    settings.search.generations = Some(10_000);
    settings.search.population = 8;
    settings.search.starts = Some(1);
    settings.search.max_frames = 15;
    settings.search.max_sequences = 1;
    let fit = client.fits().create(capture, &settings, 100).await?.name;
    let started = Instant::now();
    while generation(&client.fits().get(fit).await?)? == 0 {
        if started.elapsed() > FIT_START {
            bail!("the fit did not begin within {} s", FIT_START.as_secs());
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    Ok(fit)
}

fn generation(fit: &Fit) -> anyhow::Result<u32> {
    if fit.job.state.has_ended() {
        bail!("{} has ended as {}", fit.name, fit.job.state.as_str());
    }
    let progress = fit.job.progress.as_ref();
    Ok(progress.filter(|p| p.stage == "search").map_or(0, |p| p.iteration))
}

async fn measure(
    args: &Load,
    client: &Client,
    global: &Global,
    still: &Still,
    fit: Option<FitId>,
) -> anyhow::Result<Report> {
    let time = Duration::from_secs(args.seconds);
    // The first one loads the twin.
    client.rollouts().run(still.rollout(args.small)).await?;
    let idle = phase(client, still, args.small, fit, time).await?;
    let stop = CancellationToken::new();
    let greedy = (0..args.clients).map(|_| greedy(global, still, args.large, &stop));
    let loaded = async {
        // The clients come first.
        tokio::time::sleep(Duration::from_secs(2)).await;
        let loaded = phase(client, still, args.small, fit, time).await;
        stop.cancel();
        loaded
    };
    let (loaded, refused) = tokio::join!(loaded, join_all(greedy));
    let large_refused = refused.into_iter().sum::<anyhow::Result<usize>>()?;
    let (clients, large, small) = (args.clients, args.large, args.small);
    Ok(Report { clients, large, small, idle, loaded: loaded?, large_refused })
}

/// Sends large rollouts until it is stopped; returns how many were refused.
async fn greedy(
    global: &Global,
    still: &Still,
    size: Size,
    stop: &CancellationToken,
) -> anyhow::Result<usize> {
    let client = global.connect().await?;
    let mut refused = 0;
    loop {
        let rollouts = client.rollouts();
        let result = tokio::select! {
            result = rollouts.run(still.rollout(size)) => result,
            () = stop.cancelled() => return Ok(refused),
        };
        if result.is_err() {
            refused += 1;
            tokio::time::sleep(PAUSE).await;
        }
    }
}

/// Small rollouts one after another, and the progress of the fit meanwhile.
async fn phase(
    client: &Client,
    still: &Still,
    size: Size,
    fit: Option<FitId>,
    time: Duration,
) -> anyhow::Result<Measured> {
    let started = Instant::now();
    let first = generations(client, fit).await?;
    let mut took = Vec::new();
    let mut refused = 0;
    while started.elapsed() < time {
        let begun = Instant::now();
        match client.rollouts().run(still.rollout(size)).await {
            Ok(_) => took.push(begun.elapsed().as_secs_f64()),
            Err(_) => {
                refused += 1;
                tokio::time::sleep(PAUSE).await;
            }
        }
    }
    let last = generations(client, fit).await?;
    let seconds = started.elapsed().as_secs_f64();
    let generations_per_s =
        first.zip(last).map(|(first, last)| f64::from(last.saturating_sub(first)) / seconds);
    took.sort_by(f64::total_cmp);
    let (p50_s, p99_s) = (percentile(&took, 0.5), percentile(&took, 0.99));
    Ok(Measured { answered: took.len(), refused, p50_s, p99_s, generations_per_s })
}

async fn generations(client: &Client, fit: Option<FitId>) -> anyhow::Result<Option<u32>> {
    let Some(fit) = fit else { return Ok(None) };
    let now = client.fits().get(fit).await?;
    Ok(Some(generation(&now)?))
}

/// The value below which this share of sorted values lies; 0 if there are none.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (sorted.len() as f64 * share).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

fn text(report: &Report) -> String {
    let mut table = Table::new(["", "alone", "beside greedy clients", "ratio"]);
    let (idle, loaded) = (&report.idle, &report.loaded);
    let ms = |s: f64| format!("{:.1} ms", 1e3 * s);
    let ratio = |a: f64, b: f64| if a > 0.0 { format!("{:.2}", b / a) } else { "-".to_owned() };
    let mut row = |name: &str, a: String, b: String, ratio: String| {
        table.row([name.to_owned(), a, b, ratio]);
    };
    for (name, a, b) in
        [("small, median", idle.p50_s, loaded.p50_s), ("small, p99", idle.p99_s, loaded.p99_s)]
    {
        row(name, ms(a), ms(b), ratio(a, b));
    }
    let count = |m: &Measured| format!("{} ({} refused)", m.answered, m.refused);
    row("small rollouts", count(idle), count(loaded), String::new());
    if let (Some(a), Some(b)) = (idle.generations_per_s, loaded.generations_per_s) {
        row("fit, generations/s", format!("{a:.2}"), format!("{b:.2}"), ratio(a, b));
    }
    let Size { instances, frames } = report.large;
    format!(
        "{}\n{} greedy clients with {instances} x {frames}; {} of their rollouts were refused",
        table.text(),
        report.clients,
        report.large_refused
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_instances_times_frames() {
        assert_eq!(size("4000x200"), Ok(Size { instances: 4000, frames: 200 }));
        for wrong in ["", "4000", "x", "0x200", "4000x0", "4000x200x3", "-1x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn percentiles_are_values_that_were_measured() {
        let sorted: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!((percentile(&sorted, 0.5), percentile(&sorted, 0.99)), (100.0, 198.0));
        assert_eq!((percentile(&sorted[..1], 0.99), percentile(&[], 0.5)), (1.0, 0.0));
    }
}
