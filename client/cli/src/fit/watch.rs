//! Following a fit with a progress bar.

use anyhow::Context as _;
use bendtwin_client::{Client, Fit, FitId, JobState};
use bendtwin_core::{Category, Fault};
use futures::StreamExt as _;

use crate::{failure::Failed, progress::FitBar, signals};

/// Follows a fit until it has ended, well or not.
pub(crate) async fn watch(client: &Client, name: FitId, quiet: bool) -> anyhow::Result<Fit> {
    let mut bar = FitBar::new(quiet);
    let mut states = client.fits().watch(name);
    let mut last: Option<Fit> = None;
    while let Some(fit) = states.next().await {
        let fit = fit?;
        let before = last.as_ref().map(|f| (f.job.state, f.job.attempts));
        match fit.job.state {
            JobState::Queued if before.is_none() => bar.print("waiting for a worker"),
            JobState::Queued if before.is_some_and(|(state, _)| state == JobState::Running) => {
                bar.print("the worker is gone; waiting for another one");
            }
            _ => {}
        }
        if let Some(progress) = &fit.job.progress {
            bar.show(progress);
        }
        last = Some(fit);
    }
    bar.finish();
    last.context("the server sent no state of the fit")
}

/// Like [`watch`], until a person interrupts it: the fit continues at the server, as a message
/// says.
pub(super) async fn watch_here(client: &Client, name: FitId, quiet: bool) -> anyhow::Result<Fit> {
    tokio::select! {
        fit = watch(client, name, quiet) => fit,
        () = signals::shutdown().cancelled_owned() => Err(Failed(unwatched(name)).into()),
    }
}

/// The end of a watch that a person interrupted.
fn unwatched(name: FitId) -> Fault {
    Fault {
        category: Category::Cancelled,
        reason: "WATCH_INTERRUPTED".to_owned(),
        message: format!(
            "no longer watched: {name} continues at the server. Follow it with `bendtwin fit watch \
             {name}`, or stop it with `bendtwin fit cancel {name}`"
        ),
    }
}

/// Fails unless the fit has a twin.
pub(crate) fn ended_well(fit: &Fit) -> anyhow::Result<()> {
    match fit.job.state {
        JobState::Succeeded => Ok(()),
        state => {
            let fault = fit.job.fault.clone().unwrap_or_else(|| Fault {
                category: Category::Cancelled,
                reason: "FIT_DID_NOT_SUCCEED".to_owned(),
                message: format!("the fit is {}", state.as_str()),
            });
            Err(Failed(fault).into())
        }
    }
}
