//! The `bendtwin` command: the whole system in one binary.

mod access;
mod args;
mod bench;
mod ca;
mod capture;
mod demo;
mod doctor;
mod eval;
mod fit;
mod labels;
mod process;
mod quality;
mod rollout;
mod server;
mod settings;
mod store;
mod trash;
mod twin;
mod worker;

use std::process::ExitCode;

use bendtwin_telemetry::Exporter;
// Modules name these as `crate::output` and so on, like their own.
use bendtwin_terminal::{
    backend, failure, global, logging, observation, output, progress, signals, table,
};
use clap::Parser as _;
use tokio::runtime::Runtime;

use self::args::{Arguments, Command};

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let service = match &arguments.command {
        Command::Server(_) => Some("bendtwin-server"),
        Command::Worker(worker) if worker.is_service() => Some("bendtwin-worker"),
        _ => None,
    };
    let reads_capture = matches!(arguments.command, Command::IngestCapture(_));
    if service.is_some() || reads_capture {
        process::keep_files_private();
    }
    // Its memory is counted: it does without the threads of a runtime.
    if let Command::IngestCapture(args) = &arguments.command {
        logging::start(&arguments.logging, true, None);
        return match worker::ingest_capture(args) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => failure::report(&error, false),
        };
    }
    let runtime = match tokio::runtime::Builder::new_multi_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return failure::report(&error.into(), arguments.global.json),
    };
    let traces = start_logging(&arguments, service, &runtime);
    if service.is_some() {
        process::raise_descriptor_limit();
    }
    let json = arguments.global.json;
    let result = runtime.block_on(run(arguments));
    if let Some(traces) = traces {
        traces.end();
    }
    // A thread that still waits for its standard input must not hold up the end.
    runtime.shutdown_background();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error, json),
    }
}

/// Starts logging, and for a service traces if the environment asks for them.
fn start_logging(
    arguments: &Arguments,
    service: Option<&'static str>,
    runtime: &Runtime,
) -> Option<Exporter> {
    let _entered = runtime.enter();
    let traces = service.map(Exporter::from_environment).transpose();
    let (traces, fault) = match traces {
        Ok(traces) => (traces.flatten(), None),
        Err(fault) => (None, Some(fault)),
    };
    logging::start(&arguments.logging, service.is_some(), traces.as_ref());
    if let Some(fault) = fault {
        tracing::warn!("{fault}");
    }
    traces
}

async fn run(arguments: Arguments) -> anyhow::Result<()> {
    let global = &arguments.global;
    match arguments.command {
        Command::Demo(args) => demo::run(args, global).await,
        Command::Server(args) => server::run(*args, &arguments.logging).await,
        Command::Worker(args) => worker::run(args, global).await,
        Command::IngestCapture(args) => worker::ingest_capture(&args),
        Command::Capture(args) => capture::run(args, global).await,
        Command::Fit(args) => fit::run(args, global).await,
        Command::Trash(args) => trash::run(args, global).await,
        Command::Retention(args) => trash::retention::run(args, global).await,
        Command::Login(args) => access::login::log_in(args, global).await,
        Command::Logout => access::login::log_out(global).await,
        Command::Console(args) => access::console::run(args, global).await,
        Command::Whoami => access::login::who_am_i(global).await,
        Command::Key(args) => access::key::run(args, global).await,
        Command::Project(args) => access::project::run(args, global).await,
        Command::Admin(args) => access::admin::run(args, global).await,
        Command::Ca(args) => ca::run(args, global),
        Command::Twin(args) => twin::run(args, global).await,
        Command::Rollout(args) => rollout::run(args, global).await,
        Command::Eval(args) => eval::run(args, global).await,
        Command::Bench(args) => bench::run(args, global).await,
        Command::Store(args) => store::run(args, global).await,
        Command::Doctor(args) => doctor::run(args, global).await,
        Command::Healthcheck(args) => server::healthcheck::run(args, global).await,
        Command::Completions(args) => args::completions::run(&args),
        Command::Licenses(args) => args::licenses::run(&args, global),
    }
}
