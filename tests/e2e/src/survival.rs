//! A fit survives the death of any process at any moment, and ends in the same twin.

use std::time::Duration;

use bendtwin_proto::v1::{Fit, job::State};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::sync::OnceCell;

use crate::harness::{
    Api, TestCluster,
    api::{fraction, has_ended, worker},
    reference::{FIT, Reference, capture, undisturbed},
};

/// A fit of some 15 seconds on an idle machine, so that twenty kills hit different moments. Most of
/// it is search: once refinement has converged, further passes take no time.
const SETTINGS: &str = r#"{
    "seed": 11,
    "compare_axial": false,
    "graph": {"max_nodes": 40},
    "search": {"starts": 1, "generations": 200, "population": 8},
    "refine": {"passes": 24}
}"#;
/// Fraction of a fit over which kills are spread.
const SPREAD: f64 = 0.75;

const WORKER_KILLS: usize = 20;
const SERVER_KILLS: usize = 10;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Victim {
    Worker,
    Server,
}

#[tokio::test]
async fn a_fit_survives_twenty_deaths_of_its_worker() {
    disturb(1, &[Victim::Worker; WORKER_KILLS]).await;
}

#[tokio::test]
async fn a_fit_survives_ten_deaths_of_the_server() {
    disturb(2, &[Victim::Server; SERVER_KILLS]).await;
}

#[tokio::test]
async fn a_fit_survives_deaths_of_both_in_turn() {
    disturb(3, &[Victim::Worker, Victim::Server].repeat(SERVER_KILLS)).await;
}

/// Runs a fit with the listed kills spread over it, and compares the twin.
async fn disturb(seed: u64, victims: &[Victim]) {
    static EXPECTED: OnceCell<Reference> = OnceCell::const_new();
    let expected = EXPECTED.get_or_init(|| undisturbed(SETTINGS)).await;
    let mut server = TestCluster::ordinary().await;
    let api = server.api();
    let capture = api.upload(&capture().await, "").await.unwrap();
    let fit = api.fit(&capture.name, SETTINGS, 0).await.unwrap();

    let mut schedule = KillSchedule::new(seed, victims.len());
    for victim in victims {
        schedule.wait_for_next(&api, &fit.name).await;
        match victim {
            Victim::Worker => server.kill_workers(),
            Victim::Server => {
                server.kill();
                server.start_again().await;
            }
        }
    }

    let ended = api.succeeded(&fit.name, FIT).await;
    let twins = api.list_twins().await.unwrap();
    assert_eq!(twins.len(), 1, "one fit, one twin");
    assert_eq!(twins[0].name, ended.twin);
    assert_eq!(twins[0].digest, expected.digest, "disturbed and undisturbed twin differ");
    assert_eq!(api.export(&ended.twin).await.unwrap(), expected.file);
    println!(
        "{} kills at {:?}, {} attempts: the same twin",
        victims.len(),
        schedule.killed_at.iter().map(|f| (f * 100.0).round() / 100.0).collect::<Vec<_>>(),
        ended.job.unwrap().attempts
    );
}

/// Random moments at which to kill, spread over the run. A job fails after three attempts without
/// progress, so at most every other kill comes before new progress.
struct KillSchedule {
    random: ChaCha8Rng,
    /// Fractions of the job at which kills are due, ascending.
    due: std::vec::IntoIter<f64>,
    /// Fractions of the job at which kills happened.
    killed_at: Vec<f64>,
    /// The worker of the job at the last kill.
    last_worker: String,
}

impl KillSchedule {
    fn new(seed: u64, count: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let moment = |i| SPREAD * (i as f64 + random.random_range(0.0..1.0)) / count as f64;
        let due: Vec<f64> = (0..count).map(moment).collect();
        Self { random, due: due.into_iter(), killed_at: Vec::new(), last_worker: String::new() }
    }

    async fn wait_for_next(&mut self, api: &Api, fit: &str) {
        let due = self.due.next().unwrap();
        let impatient = self.killed_at.len() % 3 == 2;
        let before = self.killed_at.last().copied().unwrap_or(-1.0);
        let ready = |fit: &Fit| {
            let taken_over = fit.state() == State::Running && worker(fit) != self.last_worker;
            let progressed = fraction(fit) > before && fraction(fit) >= due;
            has_ended(fit) || (taken_over && (impatient || progressed))
        };
        let what = format!("under way for kill {}", self.killed_at.len() + 1);
        let fit = api.fit_when(fit, &what, FIT, ready).await;
        assert!(
            !has_ended(&fit),
            "the fit ended before kill {}: {fit:?}",
            self.killed_at.len() + 1
        );
        self.killed_at.push(fraction(&fit).max(before));
        self.last_worker = worker(&fit).to_owned();
        let delay = self.random.random_range(0..150);
        tokio::time::sleep(Duration::from_millis(delay)).await;
    }
}
