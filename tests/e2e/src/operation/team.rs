//! The set-up of a server for a team: docs/run/team.md, command by command.

use std::{net::TcpListener, process::Command, time::Duration};

use crate::{
    harness::{command::binary, process::Processes, until},
    rules::workspace::root,
};

/// Longest time for the whole page.
const PAGE: Duration = Duration::from_secs(300);

/// The indented blocks of a page as a script, which ends at the first command that fails. A command
/// after `!` is one that is refused.
fn script(page: &str) -> String {
    let mut script = String::from("set -euo pipefail\n");
    let mut is_block = false;
    for line in page.lines() {
        // Within a block an empty line is part of it, and after one a paragraph needs no indent.
        is_block = line.strip_prefix("    ").is_some() || (is_block && line.is_empty());
        let Some(code) = line.strip_prefix("    ").filter(|_| is_block) else {
            script.push('\n');
            continue;
        };
        let refused = code.trim_start().strip_prefix("! ");
        match refused {
            Some(command) => {
                script.push_str(&format!("if {command}; then echo 'was not refused'; exit 1; fi"));
            }
            None => script.push_str(code),
        }
        script.push('\n');
    }
    script
}

#[tokio::test]
async fn a_team_is_set_up_as_the_page_says() {
    let page = std::fs::read_to_string(root().join("docs/run/team.md")).unwrap();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let folder = tempfile::Builder::new().prefix("bendtwin-e2e-").tempdir().unwrap();
    let processes = Processes::new(folder.path());
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("page.sh"), script(&page).replace("7070", &port.to_string())).unwrap();

    let program = binary();
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&folders).collect::<Vec<_>>();
    let folders = program.parent().map(Into::into).into_iter().chain(folders);
    let mut shell = Command::new("bash");
    shell
        .args(["-x", "page.sh"])
        .current_dir(folder.path())
        .env_clear()
        .env("PATH", std::env::join_paths(folders).unwrap())
        .env("HOME", folder.path())
        .env("NO_COLOR", "1");
    let mut shell = processes.start(&mut shell, &path("log"));
    let status = until("the end of the page", PAGE, async || shell.try_wait().unwrap()).await;
    let log = std::fs::read_to_string(path("log")).unwrap();
    let server = std::fs::read_to_string(path("server.log")).unwrap_or_default();
    assert!(status.success(), "{log}\n== server\n{server}");
}
