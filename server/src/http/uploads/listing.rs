//! Uploads for people and programs that look on. No part of tus: the sender is not disturbed.

use axum::{
    Json,
    extract::State,
    http::header,
    response::{IntoResponse, Response},
};
use bendtwin_store::{PageRequest, ResumableUpload, UploadState};
use serde::{Deserialize, Serialize};

use super::super::{
    Result,
    extract::{Id, Params},
};
use crate::app::App;

/// An upload that can be resumed.
#[derive(Serialize)]
pub(super) struct Upload {
    /// `uploads/{uuid}`
    name: String,
    /// RECEIVING, STORED or GONE.
    state: &'static str,
    display_name: String,
    /// Bytes that are stored durably.
    offset_bytes: u64,
    /// Size of the whole; null while the client does not know it.
    length_bytes: Option<u64>,
    /// `captures/{uuid}` once it is stored.
    capture: Option<String>,
    /// Reason for which it is gone.
    why: Option<String>,
    /// RFC 3339.
    create_time: String,
    /// Time at which it is abandoned unless more bytes arrive, or forgotten if it has ended.
    expire_time: String,
}

impl From<ResumableUpload> for Upload {
    fn from(upload: ResumableUpload) -> Self {
        let (state, capture, why) = match upload.state {
            UploadState::Receiving => ("RECEIVING", None, None),
            UploadState::Stored(capture) => ("STORED", Some(capture.to_string()), None),
            UploadState::Gone(why) => ("GONE", None, Some(why)),
        };
        Self {
            name: upload.id.to_string(),
            state,
            display_name: upload.display_name,
            offset_bytes: upload.offset_bytes,
            length_bytes: upload.length_bytes,
            capture,
            why,
            create_time: upload.created.to_string(),
            expire_time: upload.expires.to_string(),
        }
    }
}

/// A page of uploads, newest first.
#[derive(Serialize)]
pub(super) struct Uploads {
    uploads: Vec<Upload>,
    /// Empty on the last page.
    next_page_token: String,
}

/// Selection of a page.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Paging {
    /// 0 means 50; more than 1000 counts as 1000.
    #[serde(default)]
    page_size: u32,
    /// `next_page_token` of the previous page.
    #[serde(default)]
    page_token: String,
}

/// List uploads
pub(super) async fn list(
    State(app): State<App>,
    Params(paging): Params<Paging>,
) -> Result<Response> {
    let page =
        app.uploads(&PageRequest { size: paging.page_size, token: paging.page_token }).await?;
    let uploads = page.items.into_iter().map(Upload::from).collect();
    let listed = Uploads { uploads, next_page_token: page.next_token };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(listed)).into_response())
}

/// One upload
pub(super) async fn get(State(app): State<App>, Id(id): Id) -> Result<Response> {
    let upload = app.upload(&id).await?;
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(Upload::from(upload))).into_response())
}
