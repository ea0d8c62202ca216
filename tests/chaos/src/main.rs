//! A real server with its workers, or a fleet of servers and workers, under a seeded schedule of
//! faults, over a steady honest load; at the end everything that was acknowledged is compared.
//!
//! 1. [`reference`] asks an undisturbed server for twins and rollouts to compare with.
//! 2. [`server`] or [`fleet`] makes the [`system`]; [`supervised`] starts its processes, and starts
//!    them again when they have ended, as a process manager does.
//! 3. [`load`] uses it honestly and writes into the [`ledger`] what is acknowledged, while
//!    [`faults`] happen as the [`schedule`] says.
//! 4. When all is over, [`check`] compares, and the [`tally`] is printed.
//!
//! The program ends with 1 if a promise was broken. A line `BROKEN: promise: case` says which; the
//! folder of the run then has the rest: `chaos.log` (faults and refused calls by time), `ledger.log`
//! (what was acknowledged when), `server.log` (server, workers and readers) and `data`; that of a fleet
//! has a log for each process. The same
//! seed makes the same schedule; `--only` leaves classes of faults out without changing the others.

mod check;
mod clock;
mod disk;
mod faults;
mod fleet;
mod honest;
mod ledger;
mod load;
mod reference;
mod run;
mod schedule;
mod server;
mod supervised;
mod system;
mod tally;
mod watch;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
    time::Duration,
};

use anyhow::Context as _;
use clap::Parser;

use crate::{
    check::MemoryLimits,
    clock::Clock,
    disk::Disk,
    fleet::Fleet,
    ledger::Ledger,
    reference::References,
    run::{Run, Wanted},
    schedule::{Class, Counted, Counts, Paced},
    server::Server,
    supervised::Excuses,
    system::System,
    tally::Tally,
};

/// Memory that any process of a run may take [bytes]: a bound that protects this machine.
const MOST_MEMORY: u64 = 8 << 30;

/// Faults of a fleet in a minute, unless the minutes are given.
const FLEET_RATE: f64 = 20.0;

/// Runs a server or a fleet under a seeded schedule of faults and checks what it acknowledged.
#[derive(Debug, Parser)]
struct Args {
    /// Minutes with faults [default: 2; of a fleet, one for twenty faults, and up to three times
    /// as many until all that is asked for has happened]
    #[arg(long)]
    minutes: Option<f64>,
    /// Two servers and four workers over PostgreSQL and S3, on two machines
    #[arg(long)]
    fleet: bool,
    /// Kills, pauses, partitions, outages and steps of the clock of a fleet
    #[arg(long, default_value_t = 40, requires = "fleet")]
    faults: u32,
    /// Workers of a fleet that stand still in the middle of a job until another has it
    #[arg(long, default_value_t = 20, requires = "fleet")]
    zombies: u32,
    /// Fits that are ordered of a fleet at least
    #[arg(long, default_value_t = 20, requires = "fleet")]
    fits: usize,
    /// Seed of the schedule and of the load
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Faults of every class, as a multiple of the usual number
    #[arg(long, default_value_t = 1.0)]
    pace: f64,
    /// Folder for what the run leaves [default: a temporary one, removed if nothing was broken]
    #[arg(long)]
    log: Option<PathBuf>,
    /// Classes of faults [default: all]
    #[arg(long, value_delimiter = ',')]
    only: Vec<Class>,
    /// Memory of the server beyond what requests may take together [MiB]
    #[arg(long, default_value_t = 512)]
    server_memory_mib: u64,
    /// Memory of a worker beyond what all workers may take together [MiB]
    #[arg(long, default_value_t = 512)]
    worker_memory_mib: u64,
    /// Print the schedule and end
    #[arg(long)]
    schedule: bool,
}

fn main() -> anyhow::Result<ExitCode> {
    let args = Args::parse();
    let minutes =
        args.minutes.unwrap_or(if args.fleet { f64::from(args.faults) / FLEET_RATE } else { 2.0 });
    let length = Duration::try_from_secs_f64(minutes * 60.0).context("--minutes")?;
    anyhow::ensure!((0.01..=100.0).contains(&args.pace), "--pace must lie in 0.01..=100");
    if args.schedule {
        for event in events(&args, length, &classes(&args)) {
            println!("{event}");
        }
        return Ok(ExitCode::SUCCESS);
    }
    let temporary = tempfile::Builder::new().prefix("bendtwin-chaos-").tempdir()?;
    let folder = args.log.clone().unwrap_or_else(|| temporary.path().to_owned());
    std::fs::create_dir_all(&folder)?;
    let folder = folder.canonicalize()?;
    rlimit::setrlimit(rlimit::Resource::DATA, MOST_MEMORY, MOST_MEMORY).ok();
    // One thread: the cores are the server's.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let tasks = tokio::task::LocalSet::new();
    let result = tasks.block_on(&runtime, rounds(&args, length, &folder));
    if matches!(result, Ok(false)) {
        return Ok(ExitCode::SUCCESS);
    }
    // Kept for inspection.
    let _ = temporary.keep();
    println!("seed {}: look into {}", args.seed, folder.display());
    result.map(|_| ExitCode::FAILURE)
}

/// The classes of faults that are wanted and make sense.
fn classes(args: &Args) -> Vec<Class> {
    let all: &[Class] = if args.fleet { &Class::OF_FLEET } else { &Class::OF_SERVER };
    let wanted = |class: &Class| args.only.is_empty() || args.only.contains(class);
    all.iter().copied().filter(wanted).collect()
}

fn events(args: &Args, length: Duration, classes: &[Class]) -> Vec<schedule::Event> {
    let paced = Paced { length, pace: args.pace };
    let counted = Counted { faults: args.faults, zombies: args.zombies };
    let counts: &dyn Counts = if args.fleet { &counted } else { &paced };
    schedule::schedule(args.seed, length, counts, classes)
}

/// The whole run; true if a promise was broken.
async fn rounds(args: &Args, length: Duration, folder: &Path) -> anyhow::Result<bool> {
    let tally = Arc::new(Tally::new(folder)?);
    let what = if args.fleet { "of a fleet " } else { "" };
    let minutes = length.as_secs_f64() / 60.0;
    tally.say(format_args!("chaos {what}for {minutes:.1} minutes, seed {}", args.seed));
    for name in ["data", "tmp", "captures"] {
        std::fs::create_dir_all(folder.join(name))?;
    }
    let mut classes = classes(args);
    let machines = if args.fleet { Fleet::MACHINES } else { 1 };
    let clocks = or_skip(&tally, &mut classes, Class::Clock, || {
        (0..machines).map(|machine| clock(&folder.join(format!("clock-{machine}")))).collect()
    });
    let clocks: Vec<Clock> = clocks.unwrap_or_default();
    let disk = or_skip(&tally, &mut classes, Class::Disk, || disk(folder));
    let excuses = Excuses::default();
    let system = if args.fleet {
        System::Fleet(Fleet::new(folder, &clocks, tally.clone(), excuses.clone()).await?)
    } else {
        let clock = clocks.first().cloned();
        System::Server(Server::new(folder, clock, tally.clone(), excuses.clone())?)
    };
    if system.fleet().is_some_and(|fleet| !fleet.network.is_divided()) {
        classes.retain(|class| *class != Class::Partitions);
    }
    let events = events(args, length, &classes);
    for event in &events {
        tally.say(event);
    }
    let references = References::make(&folder.join("captures")).await?;
    let mut supervisors = system.start();
    system.is_whole().await?;
    if let Some(fleet) = system.fleet() {
        fleet.record()?;
    }
    let ledger = Ledger::new(folder)?;
    let (fits, faults) = if args.fleet { (args.fits, events.len()) } else { (0, 0) };
    let (wanted, devices) = (Wanted { length, fits, faults }, (clocks, disk));
    let run =
        Run::new(args.seed, wanted, (system, excuses), references, ledger, tally.clone(), devices);
    let run = Arc::new(run);
    run.import_twin().await?;

    let watching = tokio::task::spawn_local(watch::watch(run.clone()));
    let mut clients = load::start(&run);
    faults::happen(&run, events).await;
    while let Some(client) = clients.join_next().await {
        if let Err(error) = client {
            run.tally.broken("the suite itself works", error);
        }
    }
    if run.faults_to_come() > 0 {
        run.tally.say(format_args!("{} faults did not come about in time", run.faults_to_come()));
    }
    run.tally.say("all faults are over: checking");
    let memory = MemoryLimits {
        server: server::SERVER_MIB + args.server_memory_mib,
        worker: server::WORKERS_MIB + args.worker_memory_mib,
    };
    if let Err(error) = check::check(&run, memory).await {
        run.tally.broken("everything comes back by itself", format_args!("{error:#}"));
    }
    watching.abort();
    run.system.stop().await?;
    while let Some(ended) = supervisors.join_next().await {
        ended??;
    }
    check::check_remains(&run)?;
    if args.log.is_none() && !run.tally.all_broken().is_empty() {
        keep_data(folder);
    }
    Ok(report(&run.tally))
}

/// Means of a class of faults, if it is to happen and can.
fn or_skip<T>(
    tally: &Tally,
    classes: &mut Vec<Class>,
    class: Class,
    make: impl FnOnce() -> anyhow::Result<T>,
) -> Option<T> {
    if !classes.contains(&class) {
        return None;
    }
    let made = make();
    if let Err(error) = &made {
        classes.retain(|other| *other != class);
        tally.say(format_args!("SKIPPED {class}: {error:#}"));
    }
    made.ok()
}

fn clock(file: &Path) -> anyhow::Result<Clock> {
    let library = std::env::var_os("CHAOS_CLOCK_LIBRARY");
    let library = library.context("clock.c was not compiled: start this with tests/chaos/run")?;
    let clock = Clock::new(library.into(), file.to_owned())?;
    anyhow::ensure!(clock.works()?, "programs here do not use the clock of the preloaded library");
    Ok(clock)
}

fn disk(folder: &Path) -> anyhow::Result<Disk> {
    std::env::var_os("CHAOS_MAY_MOUNT").context("file systems cannot be mounted here")?;
    Disk::mount(&folder.join("data"))
}

/// Copies the data out of the small disk, which ends with this program.
fn keep_data(folder: &Path) {
    let mut copy = std::process::Command::new("cp");
    copy.arg("-r").arg(folder.join("data")).arg(folder.join("data-at-the-end")).status().ok();
}

/// Prints the summary; true if a promise was broken.
fn report(tally: &Tally) -> bool {
    tally.say("");
    for (what, value) in tally.rows() {
        tally.say(format_args!("{value:>10}  {what}"));
    }
    let broken = tally.all_broken();
    for (promise, times, first) in &broken {
        tally.say(format_args!("BROKEN {times} times: {promise} (first: {first})"));
    }
    if broken.is_empty() {
        tally.say("every promise was kept");
    }
    !broken.is_empty()
}
