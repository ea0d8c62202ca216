//! Shell scripts stand in for the child.

use std::path::PathBuf;

use super::*;
use crate::{
    job::{Job, checkpoints, report},
    server_client::ServerClient,
};
use bendtwin_proto::worker::v1::Lease;

/// Runs a script as if it were the child; its argument, the folder, is in `$2`.
async fn run(script: &str) -> Result<Ended, Fault> {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let program: PathBuf = folder.path().join("child");
    std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o700)).unwrap();
    // Nothing listens there: a report that cannot be sent is not waited for.
    let server = ServerClient::new("http://127.0.0.1:1", "token").unwrap();
    let job = Job::new(server, String::new(), &Lease::default());
    let stop = crate::job::stop::Stop::default();
    let (progress, reporter) = report::start(job.clone(), stop.clone());
    let (checkpoints, saver) = checkpoints::start(job, stop);
    let ended =
        Child { program: &program, folder: folder.path() }.run(&progress, &checkpoints).await;
    reporter.abort();
    saver.abort();
    ended
}

#[tokio::test]
async fn the_last_word_counts_and_noise_does_not() {
    let ended =
        run(r#"echo noise; echo '{"checkpoint":1}'; echo '{"observed":{"verdict":"good"}}'"#).await;
    assert_eq!(ended, Ok(Ended::Observed { verdict: Verdict::Good }));
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
    let Ended::OutOfMemory { fault } = ended else { panic!("{ended:?}") };
    let refused = r#"echo '{"refused":{"verdict":"unusable","fault":{"category":"INVALID_ARGUMENT","reason":"X","message":"a: out of memory"}}}'"#;
    assert_eq!(run(refused).await, Ok(Ended::OutOfMemory { fault: fault.clone() }));
    assert_eq!(fault.reason, "INGEST_OUT_OF_MEMORY");
    assert!(fault.message.contains("--ingest-memory-mib"));
}
