//! The checkpoint from which a job resumes. It only saves work: a lost or damaged one is ignored,
//! and the job starts again.

use bendtwin_core::Category;
use bendtwin_proto::worker::v1::Lease;
use bytes::Bytes;

use super::{LeasedJob, checkpoints::MAX_BYTES};
use crate::artifact::{self, FetchError};

impl LeasedJob {
    /// True if there is a checkpoint.
    pub(crate) fn has_checkpoint(&self) -> bool {
        self.lease.has_checkpoint
    }

    /// Fetches the checkpoint; `None` without a usable one.
    ///
    /// # Errors
    /// If the server cannot be reached or another worker has the job: the checkpoint may be there.
    pub(crate) async fn fetch_checkpoint(&self) -> Result<Option<Bytes>, FetchError> {
        if !self.has_checkpoint() {
            return Ok(None);
        }
        let fetched = artifact::fetch(&self.server, self.name(), MAX_BYTES).await;
        match fetched.and_then(|content| checked(&self.lease, content)) {
            Ok(content) => Ok(Some(content)),
            Err(error) if is_of_no_use(&error) => {
                tracing::warn!("the job begins anew without its checkpoint: {error}");
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}

fn checked(lease: &Lease, content: Bytes) -> Result<Bytes, FetchError> {
    let (name, expected) = (format!("checkpoint of {}", lease.job), &lease.checkpoint_digest);
    let found = blake3::hash(&content).to_hex().to_string();
    // Servers before this field do not say.
    if expected.is_empty() || expected.eq_ignore_ascii_case(&found) {
        return Ok(content);
    }
    Err(FetchError::Digest { name, found, expected: expected.clone() })
}

/// True if no later attempt would get it.
fn is_of_no_use(error: &FetchError) -> bool {
    match error {
        FetchError::Server { fault, .. } => {
            let is_gone = matches!(fault.category, Category::DataLoss | Category::NotFound);
            // Part of the disk that cannot be read any more.
            is_gone || fault.reason == "FILES_FAILED"
        }
        FetchError::TooLarge { .. } | FetchError::Digest { .. } => true,
        FetchError::Stale | FetchError::Disk { .. } => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bendtwin_core::Fault;

    fn server(category: Category, reason: &str) -> FetchError {
        let fault = Fault { category, reason: reason.to_owned(), message: String::new() };
        FetchError::Server { name: "fits/1".to_owned(), fault }
    }

    #[test]
    fn what_is_lost_or_damaged_is_left_aside() {
        for lost in [
            server(Category::DataLoss, "CONTENT_LOST"),
            server(Category::NotFound, "NOT_FOUND"),
            server(Category::Internal, "FILES_FAILED"),
            FetchError::TooLarge { name: "fits/1".to_owned(), limit: 1 },
        ] {
            assert!(is_of_no_use(&lost), "{lost}");
        }
        for passing in [
            server(Category::Unavailable, "STOPPING"),
            server(Category::Internal, "DATABASE_FAILED"),
            FetchError::Stale,
        ] {
            assert!(!is_of_no_use(&passing), "{passing}");
        }
    }

    #[test]
    fn another_content_than_the_one_that_was_saved_is_damaged() {
        let content = Bytes::from_static(b"half way");
        let digest = blake3::hash(&content).to_hex().to_string();
        let lease = |checkpoint_digest| Lease { checkpoint_digest, ..Lease::default() };
        assert!(checked(&lease(digest.clone()), content.clone()).is_ok());
        assert!(checked(&lease(String::new()), content).is_ok());
        let flipped = checked(&lease(digest), Bytes::from_static(b"halg way")).unwrap_err();
        assert!(matches!(flipped, FetchError::Digest { .. }) && is_of_no_use(&flipped));
    }
}
