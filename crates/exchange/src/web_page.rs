//! The web page of a twin: one HTML file that shows and simulates it, without a server and without a network.
//! The program of the page is part of the console; the caller brings it as a template.

use std::borrow::Cow;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_core::Twin;
use bendtwin_surface::of_twin;

use crate::Error;

/// Places in the template for the name of the twin, as text, and for its file, as base64.
const NAME: &str = "{{name}}";
const FILE: &str = "{{twin}}";

/// The page of a twin, from the content of its file; `name` is for people. A twin without a surface gets one, if it
/// has points enough.
///
/// # Errors
/// If the content is not a twin.
pub fn web_page(template: &str, name: &str, content: &[u8]) -> Result<Vec<u8>, Error> {
    let mut twin = Twin::decode(content)?;
    let mut shown = Cow::Borrowed(content);
    if twin.surface.is_none() {
        twin.surface = of_twin(&twin).map(Cow::into_owned);
        shown = Cow::Owned(twin.encode()?);
    }
    let file = BASE64_STANDARD.encode(&*shown);
    // The file first: a name may contain the place of the file, but base64 contains no place.
    let page = template.replacen(FILE, &file, 1).replacen(NAME, &escaped(name), 1);
    Ok(page.into_bytes())
}

/// Text that an element may contain.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests;
