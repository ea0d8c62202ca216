//! What people state about captures: at the upload, in an update, and to select a list. Messages of
//! the contract are checked and become what the store takes. A new fact is added here.

use bendtwin_proto::v1::{Capture, CaptureMetadata, ListCapturesRequest, UpdateCaptureRequest};
use bendtwin_store::{CaptureChange, CaptureFacts, ListQuery, OrderKey, PageRequest};

use super::super::{
    App, Result,
    ingests::Ingest,
    labels::{self, GivenLabels, Listing, Mask},
    requirements,
};
use crate::access::Scope;

/// Orders of captures.
const ORDERS: [(&str, OrderKey); 2] =
    [("create_time", OrderKey::CreateTime), ("name", OrderKey::Name)];

impl App {
    /// The facts that accompany an upload, in one piece or resumable.
    pub(in crate::app) fn capture_facts(&self, metadata: CaptureMetadata) -> Result<CaptureFacts> {
        let asked = requirements::of(metadata.ingest_requirements);
        let Ingest { settings, requirements } = self.ingest(&metadata.ingest_json, asked)?;
        Ok(CaptureFacts {
            display_name: labels::display_name(metadata.display_name)?,
            recorded_by: labels::line("recorded_by", metadata.recorded_by)?,
            ingest: settings,
            requirements,
        })
    }
}

/// The change that an update requests.
pub(super) fn change(request: UpdateCaptureRequest) -> Result<CaptureChange> {
    let UpdateCaptureRequest { capture, update_mask, add_tags, remove_tags } = request;
    let Capture { display_name, note, tags, recorded_by, .. } = capture.unwrap_or_default();
    let mut mask = Mask::new(update_mask);
    let given = GivenLabels { display_name, note, tags, add_tags, remove_tags };
    let labels = given.change(&mut mask)?;
    let recorded_by = mask.changed("recorded_by", recorded_by);
    let recorded_by = recorded_by.map(|text| labels::line("recorded_by", text)).transpose()?;
    let change = CaptureChange { labels, recorded_by };
    mask.finish()?;
    Ok(change)
}

/// The list that is requested.
pub(super) fn query(request: ListCapturesRequest) -> Result<ListQuery> {
    let listing = Listing {
        page: PageRequest { size: request.page_size, token: request.page_token },
        search: request.search,
        tag: request.tag,
        owner: request.owner,
        order_by: request.order_by,
        ..Listing::default()
    };
    let recorded_by = labels::line("recorded_by", request.recorded_by)?;
    Ok(ListQuery { recorded_by, ..listing.query(Scope::CapturesRead, &ORDERS)? })
}
