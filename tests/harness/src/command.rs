//! The `bendtwin` command.

use std::{
    ffi::OsStr,
    path::PathBuf,
    process::{Command, Output},
};

use serde_json::Value;

/// The binary: `BENDTWIN_BIN`, or `bendtwin` in the target folder that this program was built into.
pub fn binary() -> PathBuf {
    if let Some(path) = std::env::var_os("BENDTWIN_BIN") {
        return path.into();
    }
    // Tests are built into a folder of the target folder, programs into the target folder itself.
    let this = std::env::current_exe().unwrap();
    let mut paths = this.ancestors().skip(1).take(2).map(|folder| folder.join("bendtwin"));
    let found = paths.find(|path| path.is_file());
    found.unwrap_or_else(|| panic!("no bendtwin near {}: run `cargo build` first", this.display()))
}

/// The command without settings from the environment.
pub fn bendtwin() -> Command {
    isolated(binary())
}

/// A program of the project without settings from the environment.
pub fn isolated(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    for variable in [
        "BENDTWIN_LOG",
        "BENDTWIN_SERVER",
        "BENDTWIN_TOKEN",
        "BENDTWIN_TOKEN_FILE",
        "BENDTWIN_CLIENT_TOKEN",
        "BENDTWIN_ALLOWED_HOSTS",
        "BENDTWIN_INSECURE",
        "BENDTWIN_PUBLISHED_LOCALLY",
        "BENDTWIN_PUBLIC_URL",
        "BENDTWIN_TLS_TERMINATED_BY_PROXY",
    ] {
        command.env_remove(variable);
    }
    command.env("NO_COLOR", "1");
    command
}

/// The command with a limit on the memory that it may write [MiB]. An allocation beyond that fails,
/// and the process aborts.
pub fn bendtwin_within(data_mib: u64) -> Command {
    let mut command = Command::new("sh");
    let limit = format!("ulimit -d {}; exec \"$0\" \"$@\"", data_mib << 10);
    command.args(["-c", &limit]).arg(binary());
    command.env_remove("BENDTWIN_LOG").env_remove("BENDTWIN_SERVER").env("NO_COLOR", "1");
    command
}

/// Runs `bendtwin` to its end.
pub fn run(arguments: &[&str]) -> Output {
    bendtwin().args(arguments).output().unwrap()
}

/// Runs `bendtwin`, which must succeed, and returns its output.
pub fn run_ok(arguments: &[&str]) -> String {
    let output = run(arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "bendtwin {}: {}\n{}{}",
        arguments.join(" "),
        output.status,
        text(&output.stdout),
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// Runs `bendtwin ... --json` and reads its last line.
pub fn run_json(arguments: &[&str]) -> Value {
    let text = run_ok(&[arguments, &["--json"]].concat());
    let last = text.trim().lines().last().unwrap_or_default();
    serde_json::from_str(&text)
        .or_else(|_| serde_json::from_str(last))
        .unwrap_or_else(|e| panic!("bendtwin {} --json: {e}\n{text}", arguments.join(" ")))
}
