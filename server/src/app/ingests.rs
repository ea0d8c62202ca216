//! Ingests: repeated or stopped by users, ended by workers; and their results. Settings are checked
//! here, of the content only the head.

use bendtwin_core::{
    Category, Fault, capture_files::MAX_PLAYBACK_BYTES, ids::CaptureId,
    settings::ingest::IngestSettings,
};
use bendtwin_store::{
    AttemptEnd, Blobs, Content, Digest, IngestOutcome, IngestResult, Lease, NewIngest, NewReport,
    Observation, Overview, Requirements, Staged, Upload,
};
use bytes::Bytes;
use futures::{StreamExt, stream::BoxStream};

use super::{App, Error, Result, jobs::results, requirements};
use crate::{access::Scope, audit, context::Context};

/// Longest verdict.
const MAX_VERDICT: usize = 32;

/// Wishes for an ingest.
pub(super) struct Ingest {
    /// The settings in force as canonical JSON: equal settings are equal text.
    pub(super) settings: String,
    /// Worker that it asks for.
    pub(super) requirements: Requirements,
}

/// A chunk of an ingest's result.
#[derive(Debug)]
pub(crate) enum IngestPart {
    Observation(Bytes),
    Playback(Bytes),
    Masks(Bytes),
    Report(Bytes),
    Page(Bytes),
}

/// The result of an ingest, as its worker sends it.
pub(crate) struct IngestUpload {
    pub(crate) verdict: String,
    /// BLAKE3 in hex; checked if not empty.
    pub(crate) observation_digest: String,
    pub(crate) playback_digest: String,
    pub(crate) masks_digest: String,
    pub(crate) report_digest: String,
    pub(crate) page_digest: String,
    /// The fault of a capture that cannot be fitted.
    pub(crate) fault: Option<Fault>,
    /// True if the ingest was to end with masks, and did.
    pub(crate) masks_only: bool,
    pub(crate) body: BoxStream<'static, Result<IngestPart>>,
}

/// The files of a result.
struct ResultFiles {
    observation: Option<Staged>,
    playback: Option<Staged>,
    masks: Option<Staged>,
    json: Staged,
    html: Staged,
}

/// The upload of a part, begun with its first chunk.
async fn begin<'a>(
    blobs: &Blobs,
    upload: &'a mut Option<Upload>,
    limit: u64,
) -> Result<&'a mut Upload> {
    match upload {
        Some(begun) => Ok(begun),
        none => Ok(none.insert(blobs.upload(limit).await?)),
    }
}

impl App {
    /// Runs the ingest of a capture again. Empty settings mean the defaults.
    pub(crate) async fn ingest_capture(
        &self,
        name: &str,
        settings_json: &str,
        requirements: Requirements,
        request_id: String,
    ) -> Result<Overview> {
        let done: Result<Overview> = async {
            let context = Context::current();
            let Ingest { settings, requirements } = self.ingest(settings_json, requirements)?;
            let new = NewIngest {
                capture: self.reach(Scope::CapturesWrite, name).await?,
                settings,
                requirements,
                request_id: super::request_id(request_id)?,
                creator: context.caller.creator(),
                trace_parent: context.trace_parent(),
            };
            let id = self.store.jobs().create_ingest(new).await?.capture;
            tracing::info!(capture = %id, "ingest queued again");
            Ok(self.store.captures().overview(id).await?)
        }
        .await;
        audit::changed("IngestCapture", name, &done);
        done
    }

    /// Asks the ingest of a capture to stop.
    pub(crate) async fn cancel_ingest(&self, name: &str) -> Result<Overview> {
        let done: Result<Overview> = async {
            let id: CaptureId = self.reach(Scope::CapturesWrite, name).await?;
            let ingest = self.store.jobs().ingest_of(id).await?;
            self.store.jobs().cancel(ingest.id).await?;
            Ok(self.store.captures().overview(id).await?)
        }
        .await;
        audit::changed("CancelIngest", name, &done);
        done
    }

    /// The report of a capture, as a document or as a page.
    pub(crate) async fn capture_report(&self, name: &str, page: bool) -> Result<Content> {
        let id = self.reach(Scope::CapturesRead, name).await?;
        Ok(self.store.captures().report_content(id, page).await?)
    }

    /// The observation of a capture, which its ingest made.
    pub(crate) async fn observation(
        &self,
        name: &str,
    ) -> Result<(CaptureId, Observation, Content)> {
        let id: CaptureId = self.reach(Scope::CapturesRead, name).await?;
        let (observation, content) = self.store.captures().observation_content(id).await?;
        Ok((id, observation, content))
    }

    /// The playback of a capture, which its ingest made.
    pub(crate) async fn playback(&self, name: &str) -> Result<(CaptureId, Content)> {
        let id: CaptureId = self.reach(Scope::CapturesRead, name).await?;
        Ok((id, self.store.captures().playback_content(id).await?))
    }

    /// The masks of a capture, which its ingest made of strokes.
    pub(crate) async fn masks(&self, name: &str) -> Result<(CaptureId, Content)> {
        let id: CaptureId = self.reach(Scope::CapturesRead, name).await?;
        Ok((id, self.store.captures().masks_content(id).await?))
    }

    /// Stores the result of an ingest, which ends its attempt.
    pub(crate) async fn end_ingest(&self, lease: Lease, upload: IngestUpload) -> Result<()> {
        let verdict = upload.verdict.clone();
        let is_word = |b: u8| b.is_ascii_lowercase() || b == b'_';
        if verdict.is_empty() || verdict.len() > MAX_VERDICT || !verdict.bytes().all(is_word) {
            return Err(Error::invalid("verdict", "must be one lower-case word"));
        }
        let (fault, masks_only) = (upload.fault.clone(), upload.masks_only);
        self.store.jobs().check_lease(lease).await?;
        let ResultFiles { observation, playback, masks, json, html } =
            self.receive_parts(upload).await?;
        self.check_report(&json, &verdict).await?;
        if let Some(observation) = &observation {
            results::check_observation(observation).await?;
        }
        if let Some(playback) = &playback {
            results::check_playback(playback).await?;
        }
        if let Some(masks) = &masks {
            results::check_masks(masks).await?;
        }
        let report = NewReport { verdict, json, html };
        let outcome = match (observation, fault, masks_only) {
            (Some(observation), None, false) => IngestOutcome::Observed(Box::new(observation)),
            (None, None, true) => IngestOutcome::Masked,
            (None, Some(fault), false) => {
                let end = match fault.category {
                    // Another attempt would do no better.
                    Category::InvalidArgument
                    | Category::FailedPrecondition
                    | Category::ResourceExhausted => AttemptEnd::FailedForGood(fault),
                    _ => AttemptEnd::Failed(fault),
                };
                IngestOutcome::Refused(end)
            }
            _ => {
                let fault = "must be there, or a fault, or masks alone, and only one of these";
                return Err(Error::invalid("observation", fault));
            }
        };
        let result = IngestResult { outcome, playback, masks, report };
        let store = self.store.clone();
        let end = async move { store.jobs().end_ingest(lease, result).await };
        let job = self.change(end).await?;
        self.record_end(lease.worker, &job);
        Ok(())
    }

    /// Receives observation, playback and masks, if any, and the report as a document and as a page.
    async fn receive_parts(&self, upload: IngestUpload) -> Result<ResultFiles> {
        let IngestUpload { report_digest, page_digest, mut body, .. } = upload;
        let limits = &self.options.limits;
        let blobs = self.store.blobs();
        let mut observation: Option<Upload> = None;
        let mut playback: Option<Upload> = None;
        let mut masks: Option<Upload> = None;
        let mut report = blobs.upload(limits.report_bytes).await?;
        let mut page = blobs.upload(limits.report_bytes).await?;
        let idle = limits.upload_idle();
        loop {
            match tokio::time::timeout(idle, body.next()).await {
                Err(_) => return Err(Error::UploadIdle(idle)),
                Ok(None) => break,
                Ok(Some(part)) => match part? {
                    IngestPart::Observation(chunk) => {
                        let begun = begin(blobs, &mut observation, limits.capture_bytes).await?;
                        begun.write(chunk).await?;
                    }
                    IngestPart::Playback(chunk) => {
                        let begun = begin(blobs, &mut playback, MAX_PLAYBACK_BYTES).await?;
                        begun.write(chunk).await?;
                    }
                    IngestPart::Masks(chunk) => {
                        let begun = begin(blobs, &mut masks, limits.capture_bytes).await?;
                        begun.write(chunk).await?;
                    }
                    IngestPart::Report(chunk) => report.write(chunk).await?,
                    IngestPart::Page(chunk) => page.write(chunk).await?,
                },
            }
        }
        let expected = |hex: &str| -> Result<Option<Digest>> { super::digest(hex) };
        let finish = async |upload: Option<Upload>, hex: &str| match upload {
            Some(upload) => Ok::<_, Error>(Some(upload.finish(expected(hex)?).await?)),
            None => Ok(None),
        };
        Ok(ResultFiles {
            observation: finish(observation, &upload.observation_digest).await?,
            playback: finish(playback, &upload.playback_digest).await?,
            masks: finish(masks, &upload.masks_digest).await?,
            json: report.finish(expected(&report_digest)?).await?,
            html: page.finish(expected(&page_digest)?).await?,
        })
    }

    /// Wishes for an ingest, checked, with the settings in force.
    pub(super) fn ingest(&self, settings_json: &str, requirements: Requirements) -> Result<Ingest> {
        let limit = self.options.limits.json_bytes;
        let settings: IngestSettings = super::read_settings(settings_json, limit)?;
        settings.validate().map_err(Error::Settings)?;
        requirements::check(&requirements)?;
        let settings =
            serde_json::to_string(&settings).map_err(|e| Error::Internal(e.to_string()))?;
        Ok(Ingest { settings, requirements })
    }
}
