//! An upload as it is stored.

use bendtwin_core::ids::{CaptureId, UploadId};
use jiff::Timestamp;
use uuid::Uuid;

use crate::{Digest, Error, Result, clock::from_micros, row::row};

/// Where an upload stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UploadState {
    /// Bytes are missing, or all are here and the capture is about to be made.
    Receiving,
    /// Whole, and this capture.
    Stored(CaptureId),
    /// Terminated, expired or refused, and why.
    Gone(String),
}

/// An upload that can be resumed.
#[derive(Clone, Debug, PartialEq)]
pub struct ResumableUpload {
    /// Its id.
    pub id: UploadId,
    /// Where it stands.
    pub state: UploadState,
    /// A person's name for the capture.
    pub display_name: String,
    /// Makes creation of the upload and of its capture idempotent, if given.
    pub request_id: Option<String>,
    /// What the client wrote about it, verbatim.
    pub metadata: String,
    /// BLAKE3 that the client declared.
    pub expected_digest: Option<Digest>,
    /// Size of the whole; none while the client does not know it.
    pub length_bytes: Option<u64>,
    /// Bytes that are here for good.
    pub offset_bytes: u64,
    /// When it was created.
    pub created: Timestamp,
    /// When it is given up unless more arrives, or forgotten if it has ended.
    pub expires: Timestamp,
    /// Digest of whole content whose way into a capture has begun.
    pub(crate) digest: Option<Digest>,
}

impl ResumableUpload {
    /// Whether every byte is here.
    pub fn is_whole(&self) -> bool {
        self.length_bytes == Some(self.offset_bytes)
    }
}

row! {
    pub(super) struct Row {
        id: String,
        state: String,
        display_name: String,
        request_id: Option<String>,
        expected_digest: Option<String>,
        metadata: String,
        length_bytes: Option<i64>,
        offset_bytes: i64,
        digest: Option<String>,
        capture: Option<String>,
        why: Option<String>,
        created_at: i64,
        expires_at: i64,
    }
}

impl TryFrom<Row> for ResumableUpload {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let corrupt = |fault: &str| Error::CorruptRow {
            name: format!("uploads/{}", row.id),
            fault: fault.to_owned(),
        };
        let digest = |text: Option<&String>, field: &str| {
            text.map(|hex| Digest::from_hex(hex).map_err(|_| corrupt(field))).transpose()
        };
        let state = match (row.state.as_str(), &row.capture, &row.why) {
            ("receiving", ..) => UploadState::Receiving,
            ("stored", Some(capture), _) => {
                let uuid = Uuid::try_parse(capture).map_err(|_| corrupt("capture"))?;
                UploadState::Stored(uuid.into())
            }
            ("gone", _, why) => UploadState::Gone(why.clone().unwrap_or_default()),
            _ => return Err(corrupt("state")),
        };
        Ok(Self {
            id: Uuid::try_parse(&row.id).map_err(|_| corrupt("id"))?.into(),
            state,
            expected_digest: digest(row.expected_digest.as_ref(), "expected_digest")?,
            digest: digest(row.digest.as_ref(), "digest")?,
            length_bytes: row.length_bytes.map(|n| n.max(0) as u64),
            offset_bytes: row.offset_bytes.max(0) as u64,
            created: from_micros(row.created_at),
            expires: from_micros(row.expires_at),
            display_name: row.display_name,
            request_id: row.request_id,
            metadata: row.metadata,
        })
    }
}
