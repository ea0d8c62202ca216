//! Ends of ingests, as a worker sends them.

use bendtwin_proto::{
    v1::Fault,
    worker::v1::{EndIngestRequest, IngestWrite, JobWrite, Lease, end_ingest_request::Part},
};
use tonic::Status;

use super::Worker;
use crate::results;

/// Results of an ingest.
#[derive(Clone, Default)]
pub(crate) struct Made {
    pub(crate) observation: Option<Vec<u8>>,
    pub(crate) playback: Option<Vec<u8>>,
    pub(crate) masks: Option<Vec<u8>>,
    /// True if the ingest was to end with the masks.
    pub(crate) masks_only: bool,
    pub(crate) fault: Option<Fault>,
}

impl Worker {
    /// Ends an ingest well.
    pub(crate) async fn observe(&mut self, lease: &Lease) -> Result<(), Status> {
        self.end_ingest(lease, Some(b"seen"), "good", None).await
    }

    pub(crate) async fn end_ingest(
        &mut self,
        lease: &Lease,
        observation: Option<&'static [u8]>,
        verdict: &str,
        fault: Option<Fault>,
    ) -> Result<(), Status> {
        let report = results::report(verdict);
        self.send_ingest(lease, observation.map(results::observation), report, verdict, fault).await
    }

    /// Ends an ingest with these very contents.
    pub(crate) async fn send_ingest(
        &mut self,
        lease: &Lease,
        observation: Option<Vec<u8>>,
        report: String,
        verdict: &str,
        fault: Option<Fault>,
    ) -> Result<(), Status> {
        let playback = observation.is_some().then(results::playback);
        let made = Made { observation, playback, fault, ..Made::default() };
        self.send_made(lease, made, report, verdict).await
    }

    /// Ends an ingest with these very results.
    pub(crate) async fn send_made(
        &mut self,
        lease: &Lease,
        made: Made,
        report: String,
        verdict: &str,
    ) -> Result<(), Status> {
        let page: &[u8] = b"<p>";
        let digest = |content: &[u8]| blake3::hash(content).to_hex().to_string();
        let of = |content: &Option<Vec<u8>>| content.as_deref().map(digest).unwrap_or_default();
        let Made { observation, playback, masks, masks_only, fault } = made;
        let end = IngestWrite {
            job: Some(JobWrite { digest: String::new(), ..self.write(lease, b"") }),
            verdict: verdict.to_owned(),
            observation_digest: of(&observation),
            playback_digest: of(&playback),
            masks_digest: of(&masks),
            report_digest: digest(report.as_bytes()),
            page_digest: digest(page),
            fault,
            masks_only,
        };
        let parts = std::iter::once(Part::Metadata(end))
            .chain(observation.map(|o| Part::Observation(o.into())))
            .chain(playback.map(|p| Part::Playback(p.into())))
            .chain(masks.map(|m| Part::Masks(m.into())))
            .chain([Part::Report(report.into()), Part::Page(page.into())]);
        let parts: Vec<_> = parts.map(|part| EndIngestRequest { part: Some(part) }).collect();
        self.link.end_ingest(futures::stream::iter(parts)).await.map(drop)
    }
}
