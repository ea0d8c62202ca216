//! Fit jobs as users see them: created, read, cancelled.

mod since;

use std::time::Duration;

use bendtwin_core::{
    FitSettings, ModelLoss,
    ids::{CaptureId, FitId},
    settings::memory::{self, CaptureSize, GraphSize},
    views::MOST_PIXELS,
};
use bendtwin_store::{Job, NewFit, Page, Requirements};
use futures::StreamExt as _;
use serde::Deserialize;

use super::{
    App, Error, Result,
    labels::{self, Listing, ORDERS},
    requirements,
};
use crate::{access::Scope, audit, context::Context, dispatch::FitRoom};

/// Longest wait for the report of a capture: a fit is queued while its content is away, and a worker
/// checks its memory again.
const REPORT_PATIENCE: Duration = Duration::from_secs(2);
/// Largest report that is read for the size of its capture [bytes].
const LARGEST_REPORT: u64 = 8 << 20;

/// Kind of a capture with images, as its report says it.
const RECORDING: &str = "recording";

const PRIORITIES: std::ops::RangeInclusive<i32> = -100..=100;

/// A requested fit.
#[derive(Clone, Debug, Default)]
pub(crate) struct FitOrder {
    pub(crate) capture: String,
    /// Settings as JSON; empty means the defaults.
    pub(crate) settings_json: String,
    pub(crate) priority: i32,
    pub(crate) request_id: String,
    /// Empty means the capture's.
    pub(crate) display_name: String,
    pub(crate) requirements: Requirements,
}

impl App {
    /// Queues a fit.
    pub(crate) async fn create_fit(&self, order: FitOrder) -> Result<Job> {
        let done: Result<Job> = async {
            let FitOrder { capture, settings_json, priority, request_id, .. } = order;
            let (display_name, mut requirements) = (order.display_name, order.requirements);
            if !PRIORITIES.contains(&priority) {
                return Err(Error::invalid("priority", format!("is {priority}: use -100..=100")));
            }
            let context = Context::current();
            let most = context.caller.most_priority();
            if priority > most {
                return Err(Error::PriorityTooHigh { priority, most });
            }
            self.require_room(0)?;
            let display_name = labels::display_name(display_name)?;
            requirements::check(&requirements)?;
            let capture = self.reach(Scope::FitsWrite, &capture).await?;
            let settings = settings(&settings_json, self.options.limits.json_bytes)?;
            self.check_time(&settings, context.caller.quotas.fit_run_s)?;
            if let Some(twin) = &settings.start_from {
                // Unknown names are reported before the fit waits.
                let twin = self.reach(Scope::FitsWrite, twin).await?;
                self.store.twins().get(twin).await?;
            }
            self.check_memory(capture, &settings).await?;
            let (settings, version) = since::for_workers(&settings)?;
            requirements.version = version;
            let new = NewFit {
                capture,
                settings,
                priority,
                request_id: super::request_id(request_id)?,
                creator: context.caller.creator(),
                trace_parent: context.trace_parent(),
                display_name,
                requirements,
            };
            let fit = self.store.jobs().create_fit(new).await?;
            tracing::info!(fit = %fit.id, capture = %fit.capture, "fit queued");
            Ok(fit)
        }
        .await;
        audit::made("CreateFit", &done, |fit| fit.id.to_string());
        done
    }

    /// Refuses a time limit that the fit would not live to see: with one within the bounds it ends with
    /// a twin. `of_key` is the bound of the key [s].
    fn check_time(&self, settings: &FitSettings, of_key: Option<u64>) -> Result<()> {
        let of_server = self.options.queue.fit_run_s;
        let most = of_key.map_or(of_server, |of_key| of_server.min(of_key as f64));
        match settings.within_s {
            Some(within) if within > most => Err(Error::invalid(
                "settings.within_s",
                format!("is {within}: a fit may run for {most} s here"),
            )),
            _ => Ok(()),
        }
    }

    /// Refuses a fit that no worker has the memory for. Before the capture has been read, or while
    /// no worker has said what it has, nothing is refused: a worker checks it again.
    async fn check_memory(&self, capture: CaptureId, settings: &FitSettings) -> Result<()> {
        let rooms = self.dispatch.fit_rooms();
        let Some(largest) = rooms.iter().max_by_key(|room| room.bytes) else { return Ok(()) };
        let size = tokio::time::timeout(REPORT_PATIENCE, self.capture_size(capture)).await;
        let Ok(Some(size)) = size else { return Ok(()) };
        let needed = |room: &FitRoom| {
            let settings = settings.filled(size.conditions(room.lanes));
            let graph = GraphSize::largest(&settings, &size);
            memory::estimate(&settings, &size, &graph, room.lanes).total()
        };
        if rooms.iter().any(|room| needed(room) <= room.bytes) {
            return Ok(());
        }
        let FitRoom { bytes, lanes } = *largest;
        let filled = settings.filled(size.conditions(lanes));
        let advice = memory::what_would_fit(&filled, &size, lanes, bytes);
        Err(Error::FitTooLarge(memory::refusal(needed(largest), bytes, &advice)))
    }

    /// The size of a capture by its report; `None` without a report, or if the report lacks it.
    async fn capture_size(&self, capture: CaptureId) -> Option<CaptureSize> {
        let mut content = self.store.captures().report_content(capture, false).await.ok()?;
        if content.size_bytes > LARGEST_REPORT {
            return None;
        }
        let mut json = Vec::new();
        while let Some(chunk) = content.chunks.next().await {
            json.extend_from_slice(&chunk.ok()?);
        }
        let report: Report = serde_json::from_slice(&json).ok()?;
        let view_pixels = report.most_view_pixels();
        let observed = report.observed?;
        Some(CaptureSize {
            points: observed.point_count,
            completed: observed.completed_count,
            interior: observed.interior_count,
            controls: observed.control_count,
            // Those of the first sequence; a worker knows all of them.
            frames: report.frame_count,
            longest: report.frame_count,
            sequences: 1,
            edges: 0,
            view_pixels,
        })
    }

    pub(crate) async fn fit(&self, name: &str) -> Result<Job> {
        let id: FitId = self.reach(Scope::FitsRead, name).await?;
        Ok(self.store.jobs().get(id).await?)
    }

    pub(crate) async fn fits(&self, listing: Listing) -> Result<Page<Job>> {
        Ok(self.store.jobs().fits(&listing.query(Scope::FitsRead, &ORDERS)?).await?)
    }

    pub(crate) async fn fit_losses(&self, name: &str) -> Result<Vec<ModelLoss>> {
        Ok(self.store.jobs().losses(self.reach(Scope::FitsRead, name).await?).await?)
    }

    pub(crate) async fn cancel_fit(&self, name: &str) -> Result<Job> {
        let done: Result<Job> = async {
            let id: FitId = self.reach(Scope::FitsWrite, name).await?;
            Ok(self.store.jobs().cancel(id).await?)
        }
        .await;
        audit::changed("CancelFit", name, &done);
        done
    }
}

/// The part of a capture's report that gives its size.
#[derive(Deserialize)]
struct Report {
    #[serde(default)]
    kind: String,
    frame_count: u64,
    #[serde(default)]
    cameras: Vec<Camera>,
    observed: Option<Observed>,
}

#[derive(Deserialize)]
struct Camera {
    width: u64,
    height: u64,
}

impl Report {
    /// Most pixels that the views of the recording may have: parts of all of its images.
    fn most_view_pixels(&self) -> u64 {
        if self.kind != RECORDING {
            return 0;
        }
        let images = self.cameras.iter().map(|c| c.width.saturating_mul(c.height));
        let frame = images.fold(0, u64::saturating_add);
        frame.saturating_mul(self.frame_count).min(MOST_PIXELS as u64)
    }
}

#[derive(Deserialize)]
struct Observed {
    point_count: u64,
    control_count: u64,
    completed_count: u64,
    interior_count: u64,
}

fn settings(json: &str, limit: usize) -> Result<FitSettings> {
    let settings: FitSettings = super::read_settings(json, limit)?;
    settings.validate().map_err(Error::Settings)?;
    Ok(settings)
}
