//! `bendtwin eval --leave-out`: how well recordings of an object predict each other.

mod comparison;

use std::{path::PathBuf, sync::Arc};

use bendtwin_core::{CancelToken, FitSettings, Observer as _};
use bendtwin_engine::Backend;
use serde_json::json;

use self::comparison::{LeaveOneOut, LeftOut, left_out_table};
use super::{Eval, local::BarObserver};
use crate::{failure::Failed, global::Global, observation, output};

/// Fits the recordings at all paths, each left out in turn, and prints the table.
pub(super) async fn run(
    args: Arc<Eval>,
    settings: FitSettings,
    backend: Arc<dyn Backend>,
    cancel: CancelToken,
    global: &Global,
) -> anyhow::Result<()> {
    let quiet = global.json;
    let work = move || left_out(&args, settings, backend, &cancel, quiet);
    let results = tokio::task::spawn_blocking(work).await??;
    let document = json!({
        "left_out": results.iter().map(row).collect::<Vec<_>>(),
    });
    output::print(global, &document, || left_out_table(&results))
}

/// A recording left out, with the errors that it is judged by.
fn row(left: &LeftOut) -> serde_json::Value {
    let mut row = serde_json::to_value(left).unwrap_or_default();
    row["one_m"] = json!(left.one_m());
    row["all_m"] = json!(left.all_m());
    row
}

fn left_out(
    args: &Eval,
    settings: FitSettings,
    backend: Arc<dyn Backend>,
    cancel: &CancelToken,
    quiet: bool,
) -> anyhow::Result<Vec<LeftOut>> {
    let read = |path: &PathBuf| observation::read(path, cancel, quiet);
    let captures = args.paths.iter().map(read).collect::<Result<Vec<_>, _>>().map_err(Failed)?;
    let captures = captures.into_iter().map(|(capture, _)| capture).collect();
    let study = LeaveOneOut::new(captures, settings, backend).map_err(Failed)?;
    let (fits, mut bar, mut shown) = (study.fits(), BarObserver::new(quiet), None);
    let results = study.run(
        &mut |fit, progress| {
            if shown != Some(fit) {
                bar.print(&format!("fit {} of {fits}", fit + 1));
                shown = Some(fit);
            }
            bar.progress(progress);
        },
        cancel,
    );
    bar.finish();
    results.map_err(|fault| Failed(fault).into())
}
