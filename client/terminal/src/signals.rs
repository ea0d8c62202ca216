//! Signals that end a process.

use std::{io::Read as _, time::Duration};

use bendtwin_core::CancelToken;
use tokio_util::sync::CancellationToken;

/// Time within which a second signal counts as the same one.
const SIGNAL_DEBOUNCE: Duration = Duration::from_secs(1);

/// A token that the first Ctrl-C or SIGTERM cancels; the second one ends the process immediately.
pub fn shutdown() -> CancellationToken {
    let token = CancellationToken::new();
    let cancel = token.clone();
    tokio::spawn(async move {
        interrupted().await;
        cancel.cancel();
        // A terminal and a process manager may both pass on the same Ctrl-C.
        tokio::time::sleep(SIGNAL_DEBOUNCE).await;
        interrupted().await;
        std::process::exit(130);
    });
    token
}

/// [`shutdown`] for computations.
pub fn cancellation() -> CancelToken {
    let (shutdown, cancel) = (shutdown(), CancelToken::default());
    let token = cancel.clone();
    tokio::spawn(async move {
        shutdown.cancelled().await;
        token.cancel();
    });
    cancel
}

/// Cancels the token when the standard input ends: the parent, which holds the pipe, is gone.
pub fn end_with_parent(token: CancellationToken) {
    // A thread, because a blocking read cannot be cancelled.
    std::thread::spawn(move || {
        let mut buffer = [0; 256];
        while matches!(std::io::stdin().read(&mut buffer), Ok(read) if read > 0) {}
        token.cancel();
    });
}

#[cfg(unix)]
async fn interrupted() {
    use tokio::signal::unix::{SignalKind, signal};
    match (signal(SignalKind::interrupt()), signal(SignalKind::terminate())) {
        (Ok(mut interrupt), Ok(mut terminate)) => tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        },
        _ => std::future::pending().await,
    }
}

#[cfg(not(unix))]
async fn interrupted() {
    if tokio::signal::ctrl_c().await.is_err() {
        std::future::pending::<()>().await;
    }
}
