//! Shell scripts stand in for the child.

use std::path::PathBuf;

use super::*;
use crate::{
    job::{Attempt, LeasedJob},
    server_client::ServerClient,
};
use bendtwin_proto::worker::v1::Lease;

/// Runs a script as if it were the child; its argument, the folder, is in `$2`.
async fn run(script: &str) -> Result<ChildOutcome, Fault> {
    run_within(script, Duration::from_secs(60)).await
}

async fn run_within(script: &str, time: Duration) -> Result<ChildOutcome, Fault> {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let program: PathBuf = folder.path().join("child");
    std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o700)).unwrap();
    // Nothing listens there: a report that cannot be sent is not waited for.
    let server =
        ServerClient::new(&["http://127.0.0.1:1".to_owned()], "token", "key", None).unwrap();
    let job = LeasedJob::new(server, "", Lease::default());
    let drain = tokio_util::sync::CancellationToken::new();
    let attempt = Attempt::begin(job, &drain, Duration::ZERO);
    let child = Child { program: &program, folder: folder.path(), time };
    child.run(&attempt.progress, &attempt.checkpoints).await
}

#[tokio::test]
async fn the_last_word_counts_and_noise_does_not() {
    let ended =
        run(r#"echo noise; echo '{"checkpoint":1}'; echo '{"observed":{"verdict":"good"}}'"#).await;
    assert_eq!(ended, Ok(ChildOutcome::Observed { verdict: Verdict::Good }));
    let ended = run(r#"echo '{"masked":{"verdict":"usable"}}'"#).await;
    assert_eq!(ended, Ok(ChildOutcome::Masked { verdict: Verdict::Usable }));
    let ended =
        run(r#"echo '{"failed":{"category":"ABORTED","reason":"X","message":"m"}}'; exit 1"#).await;
    assert_eq!(ended.unwrap_err().reason, "X");
}

#[tokio::test]
async fn an_end_without_a_last_word_is_explained() {
    for script in ["exit 0", "exit 101", "kill -9 $$", "kill -SEGV $$", "echo '{\"obser'"] {
        let fault = run(script).await.unwrap_err();
        assert_eq!((fault.category, fault.reason.as_str()), (Category::Internal, "INGEST_CRASHED"));
    }
    let ended = run("echo memory allocation of 9 bytes failed >&2; kill -ABRT $$").await.unwrap();
    let ChildOutcome::Exceeded { fault } = ended else { panic!("{ended:?}") };
    let refused = r#"echo '{"refused":{"verdict":"unusable","fault":{"category":"INVALID_ARGUMENT","reason":"X","message":"a: out of memory"}}}'"#;
    assert_eq!(run(refused).await, Ok(ChildOutcome::Exceeded { fault: fault.clone() }));
    assert_eq!(fault.reason, "INGEST_OUT_OF_MEMORY");
    assert!(fault.message.contains("--ingest-memory-mib"));
}

#[tokio::test]
async fn an_end_that_does_not_come_in_time_is_made() {
    let marker = tempfile::tempdir().unwrap();
    let after = marker.path().join("after");
    // One that waits, and one whose processor time is up.
    let scripts = [
        (format!("while :; do :; done; echo > {}", after.display()), Duration::from_millis(200)),
        ("kill -XCPU $$".to_owned(), Duration::from_secs(60)),
    ];
    for (script, time) in scripts {
        let ChildOutcome::Exceeded { fault } = run_within(&script, time).await.unwrap() else {
            panic!("{script} was not ended")
        };
        assert_eq!(
            (fault.category, fault.reason.as_str()),
            (Category::ResourceExhausted, "INGEST_TIMEOUT")
        );
        assert!(fault.message.contains("--ingest-timeout-s"));
    }
    assert!(!after.exists());
}

/// The worker's token stands in its environment.
#[tokio::test]
async fn the_child_gets_next_to_nothing_of_the_environment() {
    let given = [&PASSED_VARIABLES[..], &["TMPDIR", "RAYON_NUM_THREADS"]].concat();
    let is_kept = |name: &str| !given.contains(&name);
    assert!(std::env::vars_os().any(|(name, _)| name.to_str().is_some_and(is_kept)));
    // The shell's own variables are among those that it prints.
    let names = r#"$(env | sed -n 's/^\([A-Za-z_][A-Za-z_0-9]*\)=.*/\1/p' | tr '\n' ' ')"#;
    let said = format!(
        r#"{{\"failed\":{{\"category\":\"ABORTED\",\"reason\":\"X\",\"message\":\"{names}$RAYON_NUM_THREADS\"}}}}"#
    );
    let fault = run(&format!(r#"echo "{said}""#)).await.unwrap_err();
    let (names, threads_given) = fault.message.rsplit_once(' ').unwrap();
    assert_eq!(threads_given, threads().to_string());
    let of_the_shell = ["PWD", "OLDPWD", "SHLVL", "_"];
    let passed: Vec<&str> =
        names.split(' ').filter(|n| is_kept(n) && !of_the_shell.contains(n)).collect();
    assert!(passed.is_empty(), "{passed:?}");
    assert!(names.split(' ').any(|n| n == "TMPDIR"), "{names}");
}
