//! Pages of lists.

use crate::Error;

/// Request for a part of a list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PageRequest {
    /// Most entries of the page, up to 1000; 0 leaves it to the server.
    pub size: u32,
    /// The previous page's `next`; empty for the first page.
    pub token: String,
}

/// A part of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page<T> {
    /// The entries, newest first.
    pub items: Vec<T>,
    /// Request for the next page; none on the last one.
    pub next: Option<String>,
}

impl<T> Page<T> {
    pub(crate) fn new<W>(
        items: Vec<W>,
        next: String,
        convert: impl Fn(W) -> Result<T, Error>,
    ) -> Result<Self, Error> {
        let items = items.into_iter().map(convert).collect::<Result<_, _>>()?;
        Ok(Self { items, next: (!next.is_empty()).then_some(next) })
    }
}

/// All pages one after another.
pub(crate) async fn all<T, F>(fetch: impl Fn(PageRequest) -> F) -> Result<Vec<T>, Error>
where
    F: Future<Output = Result<Page<T>, Error>>,
{
    let mut items = Vec::new();
    let mut request = PageRequest { size: 1000, token: String::new() };
    loop {
        let page = fetch(request.clone()).await?;
        items.extend(page.items);
        match page.next {
            Some(token) => request.token = token,
            None => return Ok(items),
        }
    }
}
