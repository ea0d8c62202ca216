//! Files that are added to captures after their upload. Of their content the server knows as little as
//! of a capture's: workers read it with the next ingest. Only a calibration is compared with its
//! format, so that a file of another program is refused immediately, with the way out.

use bendtwin_core::{capture_files::CALIBRATION_FORMAT, ids::CaptureId};
use bendtwin_proto::v1::SupplementMetadata;
use bendtwin_store::{Content, NewSupplement, Overview, Staged, SupplementKind};
use serde::Deserialize;

use super::super::{self as app, App, Body, Error, Result, receive::Receiving};
use crate::{access::Scope, context::Context};

/// The head of a calibration: the rest is for its readers.
#[derive(Deserialize)]
struct CalibrationHead {
    format: String,
    version: u32,
}

/// Parses a kind of supplement.
pub(in crate::app) fn kind(word: &str) -> Result<SupplementKind> {
    word.parse().map_err(|_| {
        let kinds = SupplementKind::ALL.map(SupplementKind::as_str).join(" or ");
        Error::invalid("kind", format!("must be {kinds}"))
    })
}

impl App {
    /// Receives and stores a file.
    pub(super) async fn receive_supplement(
        &self,
        metadata: SupplementMetadata,
        body: Body,
    ) -> Result<Overview> {
        let SupplementMetadata { name, kind, digest } = metadata;
        let capture: CaptureId = self.reach(Scope::CapturesWrite, &name).await?;
        let kind = self::kind(&kind)?;
        let digest = app::digest(&digest)?;
        self.require_room(0)?;
        self.store.captures().admit_supplement(capture, kind).await?;
        let limit = match kind {
            SupplementKind::Masks => self.options.limits.capture_bytes,
            SupplementKind::Calibration => self.options.limits.json_bytes as u64,
        };
        let _buffers = self.memory.upload().await?;
        let receiving = Receiving::Upload { jobs: 0, limit, is_repetition: false };
        let content = self.receive(body, receiving, digest).await?;
        if content.size_bytes() == 0 {
            return Err(Error::invalid("content", "is empty: send the file"));
        }
        if kind == SupplementKind::Calibration {
            self.check_calibration(&content).await?;
        }
        let bytes = content.size_bytes();
        let creator = Context::current().caller.creator();
        let new = NewSupplement { capture, kind, content, creator };
        let store = self.store.clone();
        self.change(async move { store.captures().add_supplement(new).await }).await?;
        tracing::info!(%capture, %kind, bytes, "supplement stored");
        Ok(self.store.captures().overview(capture).await?)
    }

    /// Removes a file.
    pub(super) async fn remove_supplement(&self, name: &str, kind: &str) -> Result<()> {
        let capture: CaptureId = self.reach(Scope::CapturesWrite, name).await?;
        let kind = self::kind(kind)?;
        let store = self.store.clone();
        self.change(async move { store.captures().delete_supplement(capture, kind).await }).await?;
        tracing::info!(%capture, %kind, "supplement deleted");
        Ok(())
    }

    /// A file that was added to a capture.
    pub(crate) async fn supplement(
        &self,
        name: &str,
        kind: &str,
    ) -> Result<(CaptureId, SupplementKind, Content)> {
        let capture = self.reach(Scope::CapturesRead, name).await?;
        let kind = self::kind(kind)?;
        let content = self.store.captures().supplement_content(capture, kind).await?;
        Ok((capture, kind, content))
    }

    /// Refuses a file that is no calibration document.
    async fn check_calibration(&self, content: &Staged) -> Result<()> {
        let _share = self.memory.report(content.size_bytes()).await?;
        let bytes = content.bytes().await?;
        let head: Option<CalibrationHead> = serde_json::from_slice(&bytes).ok();
        if head.is_some_and(|head| head.format == CALIBRATION_FORMAT && head.version > 0) {
            return Ok(());
        }
        let fault = format!(
            "is no document of the format `{CALIBRATION_FORMAT}`: make one with `bendtwin capture \
             calibrate`, which also reads the files of Kalibr, OpenCV, ROS and COLMAP \
             (docs/use/cameras.md#calibration)"
        );
        Err(Error::invalid("content", fault))
    }
}
