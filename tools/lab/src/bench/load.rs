//! `bendtwin-lab bench load`: what a fit and greedy clients leave to others on a running server. Small
//! rollouts are timed one after another, as a closed loop sends them: alone, beside a fit, and beside
//! the fit and clients that keep sending large rollouts. The fit's speed is measured meanwhile.

mod spread;

use std::{
    path::PathBuf,
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
    time::{Duration, Instant},
};

use anyhow::{Context as _, bail};
use bendtwin_client::{
    CaptureId, Client, Cost, Fidelity, Fit, FitId, FitSettings, ListQuery, Point, Rollout, TwinId,
};
use bendtwin_core::Twin;
use bendtwin_terminal::{
    fidelity::Mode, global::Global, measurement::Size, output, signals, table::Table,
};
use clap::Args;
use futures::future::join_all;
use serde::Serialize;
use tokio_util::sync::CancellationToken;

use self::spread::Spread;

/// Pause of a refused client. Greedy clients do not wait for the requested delay.
const PAUSE: Duration = Duration::from_secs(1);
/// Longest wait for the first generation of the fit.
const FIT_START: Duration = Duration::from_secs(300);

#[derive(Debug, Args)]
#[command(after_help = "\
It needs a server with a twin; its capture is fitted beside the rollouts (the fit is deleted afterwards):
  bendtwin server &
  cargo lab bench load --clients 64
A closed loop of one instance and one frame beside a fit, without greedy clients:
  cargo lab bench load --clients 0 --small 1x1
A planner's step:
  cargo lab bench load --clients 0 --small 128x20 --fidelity fast --costs
A rollout beside 32 connections that send the same ones with another key:
  cargo lab bench load --no-fit --clients 32 --clients-token-file other.key --large 128x60 --small 128x60
The gain of several workers over one on a batch, in one run:
  bendtwin server --workers 4 &
  cargo lab bench load --no-fit --clients 0 --spread 1000x30")]
pub(crate) struct Load {
    /// Twin to roll out [default: the newest that has a capture]
    #[arg(long, value_name = "NAME")]
    twin: Option<TwinId>,
    /// Number of greedy clients, each with its own connection; 0 for none
    #[arg(long, value_name = "N", default_value_t = 64)]
    clients: usize,
    /// File with a key that they use instead of that of the small rollouts: owners take turns
    #[arg(long, value_name = "FILE")]
    clients_token_file: Option<PathBuf>,
    /// Size of their rollouts: instances x frames
    #[arg(long, value_name = "BxF", default_value = "4000x200")]
    large: Size,
    /// Size of the small rollouts, which are sent one after another
    #[arg(long, value_name = "BxF", default_value = "16x30")]
    small: Size,
    /// Model that computes the small rollouts
    #[arg(long, value_enum, default_value_t = Mode::Exact)]
    fidelity: Mode,
    /// Request a cost of the small rollouts, like planners, and no positions
    #[arg(long)]
    costs: bool,
    /// Time for each measurement [s]
    #[arg(long, value_name = "S", default_value_t = 30, value_parser = clap::value_parser!(u64).range(1..=3600))]
    seconds: u64,
    /// Leave out the fit
    #[arg(long)]
    no_fit: bool,
    /// Also time a batch of this size, shared by idle workers and on one of them
    #[arg(long, value_name = "BxF")]
    spread: Option<Size>,
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
    /// Times in the queue and of computing, as in the replies [s].
    queue_p50_s: f64,
    queue_p99_s: f64,
    compute_p50_s: f64,
    compute_p99_s: f64,
    /// Rollouts a second of all clients, small and large.
    rollouts_per_s: f64,
    /// Generations of the fit a second.
    generations_per_s: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Report {
    clients: usize,
    large: Size,
    small: Size,
    /// Small rollouts alone.
    alone: Measured,
    /// Beside the fit.
    fit: Option<Measured>,
    /// Beside the greedy clients, and the fit if there is one.
    greedy: Option<Measured>,
    /// Large rollouts that were refused.
    large_refused: usize,
    /// A batch that workers share.
    spread: Option<Spread>,
}

/// Control points that hold still.
#[derive(Clone)]
struct Still {
    twin: TwinId,
    fidelity: Fidelity,
    /// True if costs are returned instead of positions.
    costs: bool,
    controls: Vec<Point>,
}

impl Still {
    fn rollout(&self, size: Size) -> Rollout {
        let knots = 2 * size.instances;
        let positions =
            std::iter::repeat_n(&self.controls, knots).flatten().copied().collect::<Vec<_>>();
        let shape = [size.instances, 2, self.controls.len()];
        let rollout = Rollout::of(self.twin).trajectories(shape, positions);
        let rollout = rollout.fidelity(self.fidelity).frames(size.frames);
        if !self.costs {
            return rollout;
        }
        let cost = Cost::keypoints("distance", 1.0, &[0], &self.controls[..1]);
        rollout.cost(cost).record_every(0)
    }
}

pub(super) async fn run(args: Load, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    let (twin, capture) = subject(&client, args.twin).await?;
    let file = client.twins().export(twin).await?;
    let controls = Twin::decode(&file).context("the twin cannot be read")?.graph.control_rest;
    let still = Still { twin, fidelity: args.fidelity.into(), costs: args.costs, controls };
    let capture = capture.filter(|_| !args.no_fit);
    let shutdown = signals::shutdown();
    let mut fit = None;
    let measured = tokio::select! {
        () = shutdown.cancelled() => Err(anyhow::anyhow!("interrupted")),
        measured = measure(&args, &client, global, &still, capture, &mut fit) => measured,
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
    let twins = client.twins().all(&ListQuery::default()).await?;
    let newest = twins.into_iter().filter(|t| t.capture.is_some()).max_by_key(|t| t.create_time);
    match newest {
        Some(twin) => Ok((twin.name, twin.capture)),
        None => bail!("the server has no twin of a capture: fit one, or name a twin with --twin"),
    }
}

/// A fit of short generations that does not end by itself in the time of a measurement; `made` is
/// set once it exists.
async fn start_fit(
    client: &Client,
    capture: CaptureId,
    made: &mut Option<FitId>,
) -> anyhow::Result<()> {
    let mut settings = FitSettings::default();
    settings.search.generations = Some(10_000);
    settings.search.population = Some(8);
    settings.search.starts = Some(1);
    settings.search.max_frames = 15;
    settings.search.max_sequences = 1;
    let fit = client.fits().create(capture, &settings, 100).await?.name;
    *made = Some(fit);
    let started = Instant::now();
    while generation(&client.fits().get(fit).await?)? == 0 {
        if started.elapsed() > FIT_START {
            bail!("the fit did not begin within {} s", FIT_START.as_secs());
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    Ok(())
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
    capture: Option<CaptureId>,
    fit: &mut Option<FitId>,
) -> anyhow::Result<Report> {
    let time = Duration::from_secs(args.seconds);
    // The first one loads the twin.
    client.rollouts().run(still.rollout(args.small)).await?;
    let nobody = AtomicUsize::new(0);
    let alone = phase(client, still, args.small, None, &nobody, time).await?;
    let spread = match args.spread {
        Some(size) => Some(Spread::measure(client, still, size, time).await?),
        None => None,
    };
    let mut beside_fit = None;
    if let Some(capture) = capture {
        start_fit(client, capture, fit).await?;
        beside_fit = Some(phase(client, still, args.small, *fit, &nobody, time).await?);
    }
    let (clients, large, small) = (args.clients, args.large, args.small);
    let report = Report {
        clients,
        large,
        small,
        alone,
        fit: beside_fit,
        greedy: None,
        large_refused: 0,
        spread,
    };
    if clients == 0 {
        return Ok(report);
    }
    let stop = CancellationToken::new();
    let token_file = args.clients_token_file.clone().or_else(|| global.token_file.clone());
    let of_clients = Global { token_file, ..global.clone() };
    let answered = AtomicUsize::new(0);
    let greedy = (0..clients).map(|_| greedy(&of_clients, still, large, &answered, &stop));
    let loaded = async {
        // The clients come first.
        tokio::time::sleep(Duration::from_secs(2)).await;
        let loaded = phase(client, still, small, *fit, &answered, time).await;
        stop.cancel();
        loaded
    };
    let (loaded, refused) = tokio::join!(loaded, join_all(greedy));
    let large_refused = refused.into_iter().sum::<anyhow::Result<usize>>()?;
    Ok(Report { greedy: Some(loaded?), large_refused, ..report })
}

/// Sends large rollouts until it is stopped, and counts those that were answered; returns how many were refused.
async fn greedy(
    global: &Global,
    still: &Still,
    size: Size,
    answered: &AtomicUsize,
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
        if result.is_ok() {
            answered.fetch_add(1, Relaxed);
        } else {
            refused += 1;
            tokio::time::sleep(PAUSE).await;
        }
    }
}

/// Small rollouts one after another, with the progress of the fit and the rollouts of others meanwhile.
async fn phase(
    client: &Client,
    still: &Still,
    size: Size,
    fit: Option<FitId>,
    others: &AtomicUsize,
    time: Duration,
) -> anyhow::Result<Measured> {
    let others_before = others.load(Relaxed);
    let started = Instant::now();
    let first = generations(client, fit).await?;
    let (mut took, mut queue, mut compute) = (Vec::new(), Vec::new(), Vec::new());
    let mut refused = 0;
    while started.elapsed() < time {
        let begun = Instant::now();
        match client.rollouts().run(still.rollout(size)).await {
            Ok(reply) => {
                took.push(begun.elapsed().as_secs_f64());
                queue.push(reply.timing.queue_s);
                compute.push(reply.timing.compute_s);
            }
            Err(_) => {
                refused += 1;
                tokio::time::sleep(PAUSE).await;
            }
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    let rollouts_per_s = (took.len() + others.load(Relaxed) - others_before) as f64 / seconds;
    let last = generations(client, fit).await?;
    let generations_per_s =
        first.zip(last).map(|(first, last)| f64::from(last.saturating_sub(first)) / seconds);
    let answered = took.len();
    let [[p50_s, p99_s], [queue_p50_s, queue_p99_s], [compute_p50_s, compute_p99_s]] =
        [took, queue, compute].map(|mut times| {
            times.sort_by(f64::total_cmp);
            [0.5, 0.99].map(|share| percentile(&times, share))
        });
    Ok(Measured {
        answered,
        refused,
        p50_s,
        p99_s,
        queue_p50_s,
        queue_p99_s,
        compute_p50_s,
        compute_p99_s,
        rollouts_per_s,
        generations_per_s,
    })
}

async fn generations(client: &Client, fit: Option<FitId>) -> anyhow::Result<Option<u32>> {
    let Some(fit) = fit else { return Ok(None) };
    let now = client.fits().get(fit).await?;
    Ok(Some(generation(&now)?))
}

/// The value below which this share of sorted values lies; 0 without values.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (sorted.len() as f64 * share).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

fn text(report: &Report) -> String {
    let columns = [("beside the fit", report.fit), ("beside greedy clients", report.greedy)];
    let measured: Vec<(&str, Measured)> = std::iter::once(("alone", report.alone))
        .chain(columns.into_iter().filter_map(|(name, measured)| Some((name, measured?))))
        .collect();
    let mut table = Table::new(std::iter::once("").chain(measured.iter().map(|(name, _)| *name)));
    let mut row = |name: &str, value: &dyn Fn(&Measured) -> String| {
        let values = measured.iter().map(|(_, m)| value(m));
        table.row(std::iter::once(name.to_owned()).chain(values).collect::<Vec<_>>());
    };
    let alone = &report.alone;
    let ms = |s: f64, alone_s: f64| match s / alone_s {
        ratio if ratio.is_finite() => format!("{:.1} ms ({ratio:.2} x)", 1e3 * s),
        _ => "-".to_owned(),
    };
    row("small, median", &|m| ms(m.p50_s, alone.p50_s));
    row("small, p99", &|m| ms(m.p99_s, alone.p99_s));
    let both = |p50_s: f64, p99_s: f64| format!("{:.1} / {:.1} ms", 1e3 * p50_s, 1e3 * p99_s);
    row("in line, median / p99", &|m| both(m.queue_p50_s, m.queue_p99_s));
    row("computed, median / p99", &|m| both(m.compute_p50_s, m.compute_p99_s));
    row("small rollouts", &|m| format!("{} ({} refused)", m.answered, m.refused));
    row("all rollouts/s", &|m| format!("{:.1}", m.rollouts_per_s));
    row("fit, generations/s", &|m| {
        m.generations_per_s.map_or_else(|| "-".to_owned(), |g| format!("{g:.2}"))
    });
    let (small, large) = (report.small, report.large);
    let greedy = match report.clients {
        0 => String::new(),
        n => format!(
            "; {n} greedy clients with {large}, {} of whose rollouts were refused",
            report.large_refused
        ),
    };
    let spread = report.spread.map(|spread| spread.text()).unwrap_or_default();
    format!("{}\nsmall rollouts of {small}{greedy}{spread}", table.text())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_that_were_measured() {
        let sorted: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!((percentile(&sorted, 0.5), percentile(&sorted, 0.99)), (100.0, 198.0));
        assert_eq!((percentile(&sorted[..1], 0.99), percentile(&[], 0.5)), (1.0, 0.0));
    }
}
