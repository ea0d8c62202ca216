//! Compares what identifiability reports say is open with what fits differ by: fits with other seeds, and
//! a fit to all frames.
//!
//! ```sh
//! cargo run --release -p bendtwin-fit --example identifiability -- SETTINGS.json SEEDS CAPTURE...
//! ```
//!
//! A row for each capture: what the report of seed 0 leaves open of the frames after the training frames
//! [mm], how far the fits with the other seeds and with all frames are apart there [mm], the correlation of
//! both by rank over points, that of what is left of a group's range, and of its share of the millimetres,
//! and of what the fits differ by in it over groups, the error to expect and the error [mm], and the report's part of the time of a fit. After it
//! come the groups by which the fit to all frames differs most, with what the report says of them.

use std::{path::Path, time::Instant};

use bendtwin_capture::{Limits, digest};
use bendtwin_core::{
    CancelToken, Capture, FitSettings, Graph, Identifiability, Point, Twin,
    geometry::{distance, point_distance},
    identifiability::{Group, Quantity},
};
use bendtwin_eval::predict;
use bendtwin_fit::FitJob;
use bendtwin_identify::identify_by_motion;

type Failure = Box<dyn std::error::Error>;

/// Groups that are named below a row.
const NAMED: usize = 4;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let mut argument = || arguments.next().ok_or("usage: SETTINGS.json SEEDS CAPTURE...");
    let settings: FitSettings = serde_json::from_slice(&std::fs::read(argument()?)?)?;
    let seeds: u64 = argument()?.parse()?;
    println!(
        "| capture | open | seeds apart | all frames apart | rank by point: seeds, all frames | rank by group: seeds, all frames, of shares | expected | error | error / expected | of the time |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for path in arguments {
        let name = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let capture = bendtwin_capture::read(Path::new(&path), &Limits::default())?;
        compare(&name, &capture, &settings, seeds)?;
    }
    Ok(())
}

/// A fit with its predictions of the tracked points in the frames after the training frames.
struct Fitted {
    twin: Twin,
    /// Shape [frames, points].
    future: Vec<Vec<Point>>,
    took_s: f64,
}

fn fit(capture: &Capture, settings: &FitSettings, split: &Capture) -> Result<Fitted, Failure> {
    let backend = bendtwin_engine::cpu();
    let began = Instant::now();
    let job = FitJob {
        capture,
        capture_digest: digest(capture),
        settings: settings.clone(),
        backend: backend.clone(),
        look: None,
    };
    let twin = job.run(None, &mut (), &CancelToken::default())?.twin;
    let took_s = began.elapsed().as_secs_f64();
    let sequence = &split.sequences[0];
    let paths = predict(&*backend, &twin, split, &CancelToken::default())?;
    let points = sequence.points_at(0).len();
    let at = |frame: usize| -> Vec<Point> {
        let mut all = vec![[f32::NAN; 3]; points];
        let skin = paths[0].at(frame).map(|nodes| twin.skin.positions(nodes)).unwrap_or_default();
        for (position, p) in skin.into_iter().zip(&twin.skin.observed_points) {
            if *p != Graph::NOT_OBSERVED {
                all[*p as usize] = position;
            }
        }
        all
    };
    let future = (sequence.train_frame_count..sequence.frame_count).map(at).collect();
    Ok(Fitted { twin, future, took_s })
}

fn compare(
    name: &str,
    capture: &Capture,
    settings: &FitSettings,
    seeds: u64,
) -> Result<(), Failure> {
    let mut fits = Vec::new();
    for seed in 0..seeds.max(2) {
        let settings = FitSettings { seed, ..settings.clone() };
        fits.push(fit(capture, &settings, capture)?);
    }
    let mut whole = capture.clone();
    for sequence in &mut whole.sequences {
        sequence.train_frame_count = sequence.frame_count;
    }
    let all = fit(&whole, settings, capture)?;
    let own = &fits[0];
    let began = Instant::now();
    let backend = bendtwin_engine::cpu();
    let report = identify_by_motion(&*backend, &own.twin, capture, &CancelToken::default())?;
    let took_s = began.elapsed().as_secs_f64();
    let (report, of_motions) = report.ok_or("there is no report")?;

    let sd_of_points = by_observed(&own.twin, &of_motions[0], capture);
    let between_seeds = apart(&fits.iter().collect::<Vec<_>>());
    let to_all = apart(&[own, &all]);
    let coordinates: Vec<Vec<f64>> =
        fits.iter().map(|f| coordinates(&f.twin, &own.twin, &report)).collect();
    let of_all = self::coordinates(&all.twin, &own.twin, &report);
    let left: Vec<f64> = report.groups.iter().map(|g| g.relative_sd).collect();
    let over_seeds: Vec<f64> = (0..left.len())
        .map(|g| deviation(coordinates.iter().map(|c| c[g])) / report.groups[g].prior_sd)
        .collect();
    let to_all_groups: Vec<f64> = (0..left.len())
        .map(|g| (of_all[g] - coordinates[0][g]).abs() / report.groups[g].prior_sd)
        .collect();
    let of = |fit: &Fitted| fit.twin.quality.headline().map_or(f64::NAN, |(_, error_m)| error_m);
    let error_m = fits.iter().map(of).sum::<f64>() / fits.len() as f64;
    let expected_m = report.expected_error_m.unwrap_or(f64::NAN);
    let shares = report.motions.first().map_or(&[][..], |m| &m.shares);
    let open_m = report.motions.first().map_or(f64::NAN, |m| m.sd_m);
    println!(
        "| {name} | {:.1} | {:.1} | {:.1} | {:.2}, {:.2} | {:.2}, {:.2}, {:.2} | {:.1} | {:.1} | {:.2} | {:.0} % |",
        1e3 * open_m,
        1e3 * mean(&between_seeds),
        1e3 * mean(&to_all),
        rank_correlation(&sd_of_points, &between_seeds),
        rank_correlation(&sd_of_points, &to_all),
        rank_correlation(&left, &over_seeds),
        rank_correlation(&left, &to_all_groups),
        rank_correlation(shares, &to_all_groups),
        1e3 * expected_m,
        1e3 * error_m,
        error_m / expected_m,
        100.0 * took_s / own.took_s,
    );
    for sentence in &report.summary {
        eprintln!("{name}: {sentence}");
    }
    eprintln!(
        "{name}: noise {:.2} mm, {:.1} observations, fit {:.1} s, report {took_s:.1} s",
        1e3 * report.noise_m,
        report.observations,
        own.took_s
    );
    let mut order: Vec<usize> = (0..left.len()).collect();
    order.sort_by(|a, b| to_all_groups[*b].total_cmp(&to_all_groups[*a]));
    for &g in order.iter().take(NAMED) {
        eprintln!(
            "{name}: all frames differ in {} by {:.2} of its range, of which {:.2} is left; share {:.2}",
            report.name(&report.groups[g]),
            to_all_groups[g],
            left[g],
            shares[g]
        );
    }
    Ok(())
}

fn mean(values: &[f64]) -> f64 {
    let finite = || values.iter().filter(|x| x.is_finite());
    finite().sum::<f64>() / finite().count().max(1) as f64
}

/// Standard deviation of a sample.
fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt()
}

/// The standard deviation of each tracked point by those of the skin; NaN where none of the skin is it.
fn by_observed(twin: &Twin, sd_m: &[f32], capture: &Capture) -> Vec<f64> {
    let mut all = vec![f64::NAN; capture.object.point_count];
    for (sd, p) in sd_m.iter().zip(&twin.skin.observed_points) {
        if *p != Graph::NOT_OBSERVED {
            all[*p as usize] = f64::from(*sd);
        }
    }
    all
}

/// Root mean square standard deviation of each tracked point over fits [m].
fn apart(fits: &[&Fitted]) -> Vec<f64> {
    let (frames, points) = (fits[0].future.len(), fits[0].future.first().map_or(0, Vec::len));
    let square = |p: usize, frame: usize| -> f64 {
        (0..3)
            .map(|a| deviation(fits.iter().map(|f| f64::from(f.future[frame][p][a]))).powi(2))
            .sum()
    };
    let of = |p: usize| {
        let sum: f64 = (0..frames).map(|frame| square(p, frame)).sum();
        (sum / frames.max(1) as f64).sqrt()
    };
    (0..points).map(of).collect()
}

/// Places of a twin along each group of a report, whose regions are those of the nodes of `of`.
fn coordinates(twin: &Twin, of: &Twin, report: &Identifiability) -> Vec<f64> {
    let nearest = |p: &Point| {
        let apart = of.graph.rest_positions.iter().map(|q| point_distance(*p, *q)).enumerate();
        apart.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| report.node_regions[i])
    };
    let regions: Vec<u8> = twin.graph.rest_positions.iter().map(nearest).collect();
    report.groups.iter().map(|group| coordinate(twin, &regions, group)).collect()
}

fn coordinate(twin: &Twin, regions: &[u8], group: &Group) -> f64 {
    let (graph, params, hands) = (&twin.graph, &twin.params, twin.hands());
    let n = graph.node_count();
    let log = |x: f32| f64::from(x.max(1e-9)).ln();
    let is_in = |node: u32| {
        let region = regions.get(node as usize).map(|r| u32::from(*r));
        region.is_some() && region == group.region
    };
    let springs = || graph.springs.iter().enumerate();
    let between = |value: &dyn Fn(usize) -> f64| -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (s, ends) in springs().filter(|(_, ends)| (ends[1] as usize) < n) {
            let share = ends.iter().filter(|e| is_in(**e)).count() as f64;
            sum += share * value(s);
            weight += share;
        }
        sum / weight
    };
    let all = |values: &[f32]| values.iter().map(|x| log(*x)).sum::<f64>() / values.len() as f64;
    match group.quantity {
        Quantity::Stiffness => between(&|s| log(params.spring_stiffness[s])),
        Quantity::RestLength => between(&|s| {
            let [a, b] = graph.springs[s].map(|e| graph.rest_endpoint(e));
            log(params.rest_lengths_m[s]) - log(distance(a, b))
        }),
        Quantity::BendStiffness => {
            let own = graph.triplets.iter().zip(&params.bend_stiffness);
            let own: Vec<f32> = own.filter(|(t, _)| is_in(t[1])).map(|(_, k)| *k).collect();
            all(&own)
        }
        Quantity::Grip => {
            let hand = |e: u32| (e as usize).checked_sub(n).map(|c| hands[c]);
            let own = springs().filter(|(_, ends)| hand(ends[1]) == group.hand);
            all(&own.map(|(s, _)| params.spring_stiffness[s]).collect::<Vec<_>>())
        }
        Quantity::TwistStiffness => all(&params.twist_stiffness),
        Quantity::Dashpot => all(&params.spring_dashpot),
        Quantity::BendDamping => all(&params.bend_damping),
        Quantity::Drag => log(params.drag),
        Quantity::GroundFriction => f64::from(params.contact.ground_friction),
        Quantity::GroundRestitution => f64::from(params.contact.ground_restitution),
    }
}

/// Spearman's correlation of the pairs that are numbers.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let pairs: Vec<[f64; 2]> = a
        .iter()
        .zip(b)
        .map(|(a, b)| [*a, *b])
        .filter(|pair| pair.iter().all(|x| x.is_finite()))
        .collect();
    let ranks = |part: usize| -> Vec<f64> {
        let rank = |x: f64| {
            let below = pairs.iter().filter(|p| p[part] < x).count() as f64;
            let equal = pairs.iter().filter(|p| p[part] == x).count() as f64;
            below + 0.5 * (equal - 1.0)
        };
        pairs.iter().map(|p| rank(p[part])).collect()
    };
    let (a, b) = (ranks(0), ranks(1));
    let middle = (pairs.len() as f64 - 1.0) / 2.0;
    let product = |x: &[f64], y: &[f64]| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - middle) * (y - middle)).sum()
    };
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}
