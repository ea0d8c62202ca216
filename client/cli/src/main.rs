//! The `bendtwin` command: the whole system in one binary.

mod args;
mod backend;
mod bench;
mod capture;
mod completions;
mod demo;
mod doctor;
mod eval;
mod exchange;
mod failure;
mod fit;
mod global;
mod key;
mod labels;
mod logging;
mod npy;
mod observation;
mod output;
mod picture;
mod process;
mod progress;
mod quality;
mod rollout;
mod server;
mod settings;
mod signals;
mod store;
mod suite;
mod table;
mod twin;
mod worker;

use std::process::ExitCode;

use clap::Parser as _;

use self::args::{Arguments, Command};

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let service = match &arguments.command {
        Command::Server(_) | Command::IngestCapture(_) => true,
        Command::Worker(worker) => worker.is_service(),
        _ => false,
    };
    if service {
        process::keep_files_private();
    }
    logging::start(&arguments.logging, service);
    // Its memory is counted: it does without the threads of a runtime.
    if let Command::IngestCapture(args) = &arguments.command {
        return match worker::ingest_capture(args) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => failure::report(&error, false),
        };
    }
    let runtime = match tokio::runtime::Builder::new_multi_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return failure::report(&error.into(), arguments.global.json),
    };
    let json = arguments.global.json;
    let result = runtime.block_on(run(arguments));
    // A thread that still waits for its standard input must not hold up the end.
    runtime.shutdown_background();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error, json),
    }
}

async fn run(arguments: Arguments) -> anyhow::Result<()> {
    let global = &arguments.global;
    match arguments.command {
        Command::Demo(args) => demo::run(args, global).await,
        Command::Server(args) => server::run(args).await,
        Command::Worker(args) => worker::run(args, global).await,
        Command::IngestCapture(args) => worker::ingest_capture(&args),
        Command::Capture(args) => capture::run(args, global).await,
        Command::Fit(args) => fit::run(args, global).await,
        Command::Key(args) => key::run(args, global).await,
        Command::Twin(args) => twin::run(args, global).await,
        Command::Rollout(args) => rollout::run(args, global).await,
        Command::Eval(args) => eval::run(args, global).await,
        Command::Suite(args) => suite::run(args, global).await,
        Command::Bench(args) => bench::run(args, global).await,
        Command::Store(args) => store::run(args, global).await,
        Command::Doctor(args) => doctor::run(args, global).await,
        Command::Completions(args) => completions::run(&args),
    }
}
