//! Writes the seeds of a target into a folder, for the fuzzer: `seeds TARGET FOLDER`.

use std::{path::Path, process::ExitCode};

use bendtwin_fuzz::TARGETS;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, folder] = arguments.as_slice() else {
        eprintln!("usage: seeds TARGET FOLDER");
        return ExitCode::FAILURE;
    };
    let Some(target) = TARGETS.iter().find(|target| target.name == name) else {
        eprintln!("there is no target `{name}`");
        return ExitCode::FAILURE;
    };
    for (index, bytes) in (target.seeds)().iter().enumerate() {
        let path = Path::new(folder).join(format!("seed-{index:03}"));
        if let Err(error) = std::fs::write(&path, bytes) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
