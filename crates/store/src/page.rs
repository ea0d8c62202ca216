//! Paging by key: a token names the last row of the page before, so pages
//! neither repeat nor skip rows while others come and go.

use uuid::Uuid;

use crate::{Error, Result};

/// Request for a page.
#[derive(Clone, Debug, Default)]
pub struct PageRequest {
    /// Most rows of the page; 0 means [`PageRequest::DEFAULT_SIZE`], and [`PageRequest::MAX_SIZE`]
    /// is the upper bound.
    pub size: u32,
    /// Token of the previous page; empty for the first.
    pub token: String,
}

impl PageRequest {
    /// Rows of a page without a given size.
    pub const DEFAULT_SIZE: u32 = 50;
    /// Most rows of a page.
    pub const MAX_SIZE: u32 = 1000;

    fn size(&self) -> u32 {
        match self.size {
            0 => Self::DEFAULT_SIZE,
            n => n.min(Self::MAX_SIZE),
        }
    }

    /// Rows to ask the database for: one more than the page, to know whether it is the last.
    pub(crate) fn fetch(&self) -> i64 {
        i64::from(self.size()) + 1
    }

    /// The id that the page's rows come after (newest first), as text that sorts
    /// above every id where there is no token. `listing` ties a token to one
    /// listing and filter.
    pub(crate) fn before(&self, listing: &str) -> Result<String> {
        const ABOVE_ALL: &str = "~";
        if self.token.is_empty() {
            return Ok(ABOVE_ALL.to_owned());
        }
        let (id, tag) = self.token.split_once('-').ok_or(Error::InvalidPageToken)?;
        let id = Uuid::try_parse(id).map_err(|_| Error::InvalidPageToken)?;
        if tag != tag_of(listing, id) {
            return Err(Error::InvalidPageToken);
        }
        Ok(id.to_string())
    }
}

/// One page, newest first.
#[derive(Clone, Debug)]
pub struct Page<T> {
    /// The rows.
    pub items: Vec<T>,
    /// Token of the next page; empty on the last.
    pub next_token: String,
}

impl<T> Page<T> {
    /// Cuts the surplus row that [`PageRequest::fetch`] asked for.
    pub(crate) fn cut(
        mut items: Vec<T>,
        request: &PageRequest,
        listing: &str,
        id: impl Fn(&T) -> Uuid,
    ) -> Self {
        let size = request.size() as usize;
        let more = items.len() > size;
        items.truncate(size);
        let next_token = match items.last() {
            Some(last) if more => {
                let id = id(last);
                format!("{}-{}", id.simple(), tag_of(listing, id))
            }
            _ => String::new(),
        };
        Self { items, next_token }
    }
}

fn tag_of(listing: &str, id: Uuid) -> String {
    let hash = blake3::Hasher::new().update(listing.as_bytes()).update(id.as_bytes()).finalize();
    hash.to_hex()[..8].to_owned()
}
