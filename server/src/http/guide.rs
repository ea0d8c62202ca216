//! `/guide.html` and `/guide/…`: the page *From cameras to a twin*, to which messages about something
//! missing refer, from `docs/use/cameras.md`, so that it fits this build and works without a network.

use std::{collections::HashMap, sync::LazyLock};

use axum::{
    Router,
    extract::Path,
    http::{HeaderName, header},
    response::{IntoResponse, Response},
    routing::get,
};
use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd, html};

use super::no_such_route;
use crate::app::App;

const TEXT: &str = include_str!("../../embedded/use/cameras.md");

/// Declares the files that the page shows or links to, each by its path from `docs/use`.
macro_rules! files {
    ($($path:literal $media_type:literal,)*) => {
        /// Path from `docs/use`, media type, content.
        const FILES: &[(&str, &str, &[u8])] =
            &[$(($path, $media_type, include_bytes!(concat!("../../embedded/use/", $path)))),*];
    };
}

files! {
    "../pictures/cameras-setup.svg" "image/svg+xml",
    "../pictures/console-play.png" "image/png",
    "scripts/calibrate_charuco.py" "text/plain; charset=utf-8",
    "scripts/masks_sam2.py" "text/plain; charset=utf-8",
    "scripts/masks_sam3.py" "text/plain; charset=utf-8",
    "scripts/record_realsense.py" "text/plain; charset=utf-8",
}

/// Nothing runs, and nothing comes from elsewhere.
const HEADERS: [(HeaderName, &str); 4] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; img-src 'self'; style-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-cache"),
];

static PAGE: LazyLock<String> = LazyLock::new(page);
/// Files of the page by their names.
static BY_NAME: LazyLock<HashMap<&str, (&str, &[u8])>> = LazyLock::new(|| {
    FILES.iter().map(|(path, kind, content)| (name_of(path), (*kind, *content))).collect()
});

pub(super) fn router() -> Router<App> {
    let page = || async { answer("text/html; charset=utf-8", PAGE.as_str()) };
    Router::new().route("/guide.html", get(page)).route("/guide/{file}", get(file))
}

async fn file(Path(name): Path<String>) -> Response {
    match (name.as_str(), BY_NAME.get(name.as_str())) {
        ("style.css", _) => answer("text/css; charset=utf-8", include_str!("guide/style.css")),
        (_, Some((media_type, content))) => answer(media_type, *content),
        (_, None) => no_such_route().into_response(),
    }
}

fn answer(media_type: &'static str, content: impl IntoResponse) -> Response {
    let mut response = content.into_response();
    let headers = HEADERS.into_iter().chain([(header::CONTENT_TYPE, media_type)]);
    for (name, value) in headers {
        response.headers_mut().insert(name, axum::http::HeaderValue::from_static(value));
    }
    response
}

/// The last part of a path.
fn name_of(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// The page: headings have ids, as where Markdown is shown elsewhere; links lead to what is served
/// here, and text is left of those to other documents.
fn page() -> String {
    let is_here = |path: &str| FILES.iter().any(|(here, ..)| *here == path);
    let mut title = None;
    let mut left = Vec::new();
    let parser = Parser::new_ext(TEXT, Options::ENABLE_TABLES);
    let mut events: Vec<Event<'_>> = Vec::new();
    for event in parser {
        match event {
            Event::Start(Tag::Link { dest_url, .. })
                if !dest_url.starts_with('#') && !is_here(&dest_url) =>
            {
                left.push(true);
            }
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                left.push(false);
                let dest_url = served(&dest_url);
                events.push(Event::Start(Tag::Link { link_type, dest_url, title, id }));
            }
            Event::End(TagEnd::Link) => {
                if left.pop() == Some(false) {
                    events.push(event);
                }
            }
            Event::Start(Tag::Image { link_type, dest_url, title, id }) => {
                let dest_url = served(&dest_url);
                events.push(Event::Start(Tag::Image { link_type, dest_url, title, id }));
            }
            other => events.push(other),
        }
    }
    for index in 0..events.len() {
        let text = heading(&events[index..]);
        if let (Event::Start(Tag::Heading { id, .. }), Some(text)) = (&mut events[index], text) {
            *id = Some(slug(&text).into());
            title.get_or_insert(text);
        }
    }
    let mut body = String::new();
    html::push_html(&mut body, events.into_iter());
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n\
         <link rel=\"stylesheet\" href=\"guide/style.css\">\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n",
        title.unwrap_or_default()
    )
}

/// The address of a file here; other links stay.
fn served<'a>(path: &CowStr<'a>) -> CowStr<'a> {
    if path.starts_with('#') { path.clone() } else { format!("guide/{}", name_of(path)).into() }
}

/// The text of the heading that begins these events.
fn heading(events: &[Event<'_>]) -> Option<String> {
    matches!(events.first(), Some(Event::Start(Tag::Heading { .. }))).then(|| {
        let inside = events.iter().take_while(|e| !matches!(e, Event::End(TagEnd::Heading(_))));
        inside
            .filter_map(|e| if let Event::Text(text) = e { Some(&**text) } else { None })
            .collect()
    })
}

fn slug(text: &str) -> String {
    let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_have_ids_and_nothing_leads_away() {
        let page = page();
        for section in ["recording", "depth", "calibration", "ground", "masks", "fit-and-play"] {
            assert!(page.contains(&format!("id=\"{section}\"")), "{section}");
        }
        assert!(page.contains("<title>From cameras to a twin</title>"));
        assert!(!page.contains(".md\"") && !page.contains("\"../"), "{page}");
    }

    #[test]
    fn all_pictures_and_scripts_are_served() {
        let served: Vec<&str> = page_links().collect();
        assert!(served.len() >= FILES.len(), "{served:?}");
        for name in served {
            assert!(name == "style.css" || BY_NAME.contains_key(name), "{name}");
        }
    }

    /// Names of the files that the page refers to.
    fn page_links() -> impl Iterator<Item = &'static str> {
        let parts = PAGE.split("\"guide/").skip(1);
        parts.filter_map(|rest| rest.split('"').next())
    }
}
