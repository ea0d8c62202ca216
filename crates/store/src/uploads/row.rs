//! The row of an upload.

use bendtwin_core::ids::{CaptureId, UploadId};
use jiff::Timestamp;
use uuid::Uuid;

use crate::{Digest, Error, Result, owners::request_ids, sql::row::row, store::clock::from_micros};

/// State of an upload.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UploadState {
    /// Bytes are missing, or the capture is about to be made.
    Receiving,
    /// Complete; the id of its capture.
    Stored(CaptureId),
    /// Terminated, expired or refused; the reason.
    Gone(String),
}

/// A resumable upload.
#[derive(Clone, Debug, PartialEq)]
pub struct ResumableUpload {
    /// Id of the upload.
    pub id: UploadId,
    /// State of the upload.
    pub state: UploadState,
    /// Display name of the capture.
    pub display_name: String,
    /// Idempotency key for the upload and its capture, if given.
    pub request_id: Option<String>,
    /// Metadata of the client, verbatim.
    pub metadata: String,
    /// BLAKE3 that the client declared.
    pub expected_digest: Option<Digest>,
    /// Size of the whole; none while the client does not know it.
    pub length_bytes: Option<u64>,
    /// Number of bytes that are stored durably.
    pub offset_bytes: u64,
    /// Time of creation.
    pub created: Timestamp,
    /// Time at which it is ended unless more bytes arrive, or forgotten if it has ended.
    pub expires: Timestamp,
    /// Owner of the key with which it was begun; empty if that is not known.
    pub owner: String,
    /// Bytes set aside in the quota of its owner while its size is not known, with those that have
    /// arrived; fewer than these mean none beyond them.
    pub(crate) reserved_bytes: u64,
    /// Digest of complete content that is becoming a capture.
    pub(crate) digest: Option<Digest>,
    /// Number of times that a server has claimed it, where several may.
    pub(crate) lease_epoch: i64,
}

impl ResumableUpload {
    /// True if all bytes have arrived.
    pub fn is_whole(&self) -> bool {
        self.length_bytes == Some(self.offset_bytes)
    }

    /// The error that bytes which were acknowledged are not there.
    pub(crate) fn lost(&self) -> Error {
        let digest = self.digest.map_or_else(|| "?".to_owned(), |d| d.to_hex().to_string());
        Error::ContentLost { name: self.id.to_string(), digest }
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
        owner: String,
        lease_epoch: i64,
        reserved_bytes: i64,
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
            request_id: row.request_id.as_deref().map(request_ids::given).map(str::to_owned),
            metadata: row.metadata,
            owner: row.owner,
            lease_epoch: row.lease_epoch,
            reserved_bytes: row.reserved_bytes.max(0) as u64,
        })
    }
}
