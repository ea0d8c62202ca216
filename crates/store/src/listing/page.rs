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

/// Place of a row in the order of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) id: String,
    /// The key that comes before the id in the order; empty if none does.
    pub(crate) key: String,
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

    /// The place that the page's rows come after; none for the first page. `listing` ties a token
    /// to one listing, its filters and its order.
    pub(crate) fn place(&self, listing: &str) -> Result<Option<Place>> {
        if self.token.is_empty() {
            return Ok(None);
        }
        let mut parts = self.token.splitn(3, '-');
        let (id, tag) = parts.next().zip(parts.next()).ok_or(Error::InvalidPageToken)?;
        let id = Uuid::try_parse(id).map_err(|_| Error::InvalidPageToken)?;
        let key = text_of(parts.next().unwrap_or_default()).ok_or(Error::InvalidPageToken)?;
        if tag != tag_of(listing, id, &key) {
            return Err(Error::InvalidPageToken);
        }
        Ok(Some(Place { id: id.to_string(), key }))
    }

    /// The id that the page's rows come after in a list that is newest first, as text that sorts
    /// above every id where there is no token.
    pub(crate) fn before(&self, listing: &str) -> Result<String> {
        const ABOVE_ALL: &str = "~";
        Ok(self.place(listing)?.map_or_else(|| ABOVE_ALL.to_owned(), |place| place.id))
    }
}

/// A page, newest first unless another order was requested.
#[derive(Clone, Debug)]
pub struct Page<T> {
    /// The rows.
    pub items: Vec<T>,
    /// Token of the next page; empty on the last.
    pub next_token: String,
    /// Rows of all pages, up to 10,000; `None` where they are not counted, and behind the first page.
    pub total: Option<u32>,
}

impl<T> Page<T> {
    /// The page with the number of rows of all pages.
    pub(crate) fn of(self, total: Option<u32>) -> Self {
        Self { total, ..self }
    }

    /// A page of items that are not rows, each with another key, in the order of the keys.
    pub(crate) fn of_sorted(
        items: Vec<T>,
        request: &PageRequest,
        listing: &str,
        key: impl Fn(&T) -> String,
    ) -> Result<Self> {
        let items = match request.place(listing)? {
            None => items,
            Some(place) => items.into_iter().filter(|item| key(item) > place.key).collect(),
        };
        Ok(Self::cut(items, request, listing, |item| (Uuid::nil(), key(item))))
    }

    /// Cuts the surplus row that [`PageRequest::fetch`] asked for. `place` are the id of a row and
    /// the key before it in the order.
    pub(crate) fn cut(
        mut items: Vec<T>,
        request: &PageRequest,
        listing: &str,
        place: impl Fn(&T) -> (Uuid, String),
    ) -> Self {
        let size = request.size() as usize;
        let more = items.len() > size;
        items.truncate(size);
        let next_token = match items.last() {
            Some(last) if more => {
                let (id, key) = place(last);
                let tag = tag_of(listing, id, &key);
                let end = if key.is_empty() { String::new() } else { format!("-{}", hex(&key)) };
                format!("{}-{tag}{end}", id.simple())
            }
            _ => String::new(),
        };
        Self { items, next_token, total: None }
    }
}

fn tag_of(listing: &str, id: Uuid, key: &str) -> String {
    let mut hash = blake3::Hasher::new();
    hash.update(listing.as_bytes()).update(id.as_bytes()).update(key.as_bytes());
    hash.finalize().to_hex()[..8].to_owned()
}

/// Text in hexadecimal digits.
fn hex(text: &str) -> String {
    text.bytes().map(|byte| format!("{byte:02x}")).collect()
}

fn text_of(hex: &str) -> Option<String> {
    let digits: Option<Vec<u8>> = hex
        .as_bytes()
        .chunks(2)
        .map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok())
        .collect();
    String::from_utf8(digits?).ok()
}
