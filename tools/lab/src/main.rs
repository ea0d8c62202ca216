//! The `bendtwin-lab` command: what developers of BendTwin measure with it, apart from the program
//! that users install. In the source tree `cargo lab` builds and runs it.

mod args;
mod bench;
mod boards;
mod corrections;
mod suite;

use std::process::ExitCode;

use bendtwin_terminal::{failure, logging};
use clap::Parser as _;

use self::args::{Arguments, Command};

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    logging::start(&arguments.logging, false, None);
    let runtime = match tokio::runtime::Builder::new_multi_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return failure::report(&error.into(), arguments.global.json),
    };
    let json = arguments.global.json;
    match runtime.block_on(run(arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error, json),
    }
}

async fn run(arguments: Arguments) -> anyhow::Result<()> {
    let global = &arguments.global;
    match arguments.command {
        Command::Suite(args) => suite::run(args, global).await,
        Command::Bench(args) => bench::run(args, global).await,
        Command::Boards(args) => boards::run(args, global).await,
        Command::Corrections(args) => corrections::run(args, global).await,
    }
}
