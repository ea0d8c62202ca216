//! The console: anyone may load it, and it may do no more than it needs.

use bendtwin_server::ClientTokenPolicy;
use reqwest::{Response, StatusCode, header::HeaderMap};

use crate::harness::{Server, read};

async fn get(server: &Server, path: &str, headers: &[(&str, &str)]) -> Response {
    let request = server.http.get(server.url(path));
    let request = headers.iter().fold(request, |r, (name, value)| r.header(*name, *value));
    request.send().await.unwrap()
}

fn text<'a>(headers: &'a HeaderMap, name: &str) -> &'a str {
    headers.get(name).map(|value| value.to_str().unwrap()).unwrap_or_default()
}

/// Addresses of the files that the page loads.
fn loaded(page: &str) -> Vec<String> {
    let names = page.split("\"./").skip(1).filter_map(|rest| rest.split('"').next());
    names.map(|name| format!("/{name}")).collect()
}

#[tokio::test]
async fn the_page_and_its_files_need_no_token_and_the_api_still_does() {
    let server = Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await;
    let page = get(&server, "/", &[]).await;
    assert_eq!(page.status(), 200);
    assert_eq!(text(page.headers(), "content-type"), "text/html; charset=utf-8");
    assert_eq!(text(page.headers(), "cache-control"), "no-cache");
    let page = page.text().await.unwrap();
    let files = loaded(&page);
    assert!(files.iter().any(|f| f.ends_with(".js")) && files.iter().any(|f| f.ends_with(".css")));
    assert!(!page.contains("style=") && !page.contains("<script>") && !page.contains("://"));
    for path in files {
        let file = get(&server, &path, &[]).await;
        assert_eq!(file.status(), 200, "{path}");
        assert!(text(file.headers(), "cache-control").contains("immutable"), "{path}");
        assert!(!file.bytes().await.unwrap().is_empty(), "{path}");
    }
    for path in ["/v1/captures", "/v1/workers", "/metrics", "/index.html", "/assets", "//"] {
        assert_eq!(get(&server, path, &[]).await.status(), 401, "{path}");
    }
    for path in ["/assets/", "/assets/nothing.js", "/assets/../v1/fits", "/assets/a/b"] {
        let (status, problem) = read(get(&server, path, &[]).await).await;
        assert!([401, 404].contains(&status), "{path}: {problem}");
        assert_eq!(problem["reason"] == "NO_SUCH_ROUTE", status == 404, "{path}: {problem}");
    }
}

#[tokio::test]
async fn addresses_without_the_mark_lead_to_their_pages() {
    let server = Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await;
    let http =
        reqwest::Client::builder().redirect(reqwest::redirect::Policy::none()).build().unwrap();
    for path in
        ["/captures", "/twins/1234/play", "/fits?state=failed", "/captures/1/playback?twin=2"]
    {
        let response = http.get(server.url(path)).send().await.unwrap();
        assert_eq!(response.status(), 303, "{path}");
        assert_eq!(text(response.headers(), "location"), format!("/#{path}"));
    }
    for path in ["/captures2", "/twin", "/v1/twins/1"] {
        assert_eq!(get(&server, path, &[]).await.status(), 401, "{path}");
    }
}

/// The page of the API, and all that is not a page.
#[tokio::test]
async fn other_responses_are_closed_to_strange_content_too() {
    let server = Server::start().await;
    let page = get(&server, "/docs", &[]).await;
    let policy = text(page.headers(), "content-security-policy").to_owned();
    let page = page.text().await.unwrap();
    let (_, rest) = policy.split_once("script-src 'nonce-").unwrap();
    let nonce = &rest[..rest.find('\'').unwrap()];
    assert!(nonce.len() >= 32 && policy.starts_with("default-src 'none'"), "{policy}");
    assert!(!policy.contains("unsafe"), "{policy}");
    for part in ["script", "style"] {
        let opened = page.matches(&format!("<{part}")).count();
        assert_eq!(page.matches(&format!("<{part} nonce=\"{nonce}\"")).count(), opened);
    }
    let again = get(&server, "/docs", &[]).await;
    assert!(
        !text(again.headers(), "content-security-policy").contains(nonce),
        "a new one each time"
    );
    for path in ["/docs", "/openapi.json", "/v1/captures", "/v1/nothing", "/healthz"] {
        let response = get(&server, path, &[]).await;
        assert_eq!(text(response.headers(), "x-content-type-options"), "nosniff", "{path}");
        assert!(!response.headers().contains_key("strict-transport-security"), "{path}");
    }
}

#[tokio::test]
async fn the_page_may_talk_to_its_server_alone() {
    let server = Server::start().await;
    for path in
        ["/".to_owned(), loaded(&get(&server, "/", &[]).await.text().await.unwrap())[0].clone()]
    {
        let headers = get(&server, &path, &[]).await.headers().clone();
        let policy = text(&headers, "content-security-policy");
        for rule in [
            "default-src 'self'",
            "connect-src 'self'",
            "object-src 'none'",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
            "require-trusted-types-for 'script'",
        ] {
            assert!(policy.split("; ").any(|r| r == rule), "{path}: {rule} is not in {policy}");
        }
        assert!(!policy.contains("unsafe") && !policy.contains("http"), "{policy}");
        assert_eq!(text(&headers, "x-content-type-options"), "nosniff");
        assert_eq!(text(&headers, "referrer-policy"), "no-referrer");
        assert_eq!(text(&headers, "cross-origin-opener-policy"), "same-origin");
        assert_eq!(text(&headers, "cross-origin-resource-policy"), "same-origin");
    }
    // Other sites may not load it either.
    let foreign = get(&server, "/", &[("origin", "http://evil.example")]).await;
    assert_eq!(foreign.status(), StatusCode::FORBIDDEN);
}

#[tokio::test]
async fn files_come_compressed_or_not_and_only_once() {
    let server = Server::start().await;
    let plain = get(&server, "/", &[]).await;
    let compressed = get(&server, "/", &[("accept-encoding", "br, gzip")]).await;
    let tags = [&plain, &compressed].map(|r| text(r.headers(), "etag").to_owned());
    assert_ne!(tags[0], tags[1]);
    for response in [&plain, &compressed] {
        assert_eq!(text(response.headers(), "vary"), "accept-encoding");
    }
    assert_eq!(text(compressed.headers(), "content-encoding"), "gzip");
    assert_eq!(text(plain.headers(), "content-encoding"), "");
    assert!(plain.bytes().await.unwrap().starts_with(b"<!doctype html>"));
    assert!(compressed.bytes().await.unwrap().starts_with(&[0x1f, 0x8b]));
    let again = get(&server, "/", &[("if-none-match", &tags[0])]).await;
    assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
    assert!(text(again.headers(), "content-security-policy").contains("'self'"));
    let other = get(&server, "/", &[("if-none-match", &tags[1])]).await;
    assert_eq!(other.status(), 200);
    let head = server.http.head(server.url("/")).send().await.unwrap();
    assert_eq!((head.status().as_u16(), text(head.headers(), "etag")), (200, tags[0].as_str()));
    assert!(head.bytes().await.unwrap().is_empty());
    let post = server.http.post(server.url("/")).send().await.unwrap();
    assert_eq!(read(post).await.1["reason"], "METHOD_NOT_ALLOWED");
}

/// A script that shows a wrong token gets an answer, and its user no window that asks for a password.
#[tokio::test]
async fn a_browser_asks_for_a_password_only_where_none_was_shown() {
    let server = Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await;
    for (shown, asks) in [(None, true), (Some("Bearer wrong"), false), (Some("Basic YTpi"), true)] {
        let headers: Vec<_> = shown.map(|value| ("authorization", value)).into_iter().collect();
        let refused = get(&server, "/v1/fits", &headers).await;
        assert_eq!(refused.status(), 401);
        let challenges = refused.headers().get_all("www-authenticate").iter();
        let challenges: Vec<_> = challenges.map(|v| v.to_str().unwrap()).collect();
        assert!(challenges[0].starts_with("Bearer"), "{challenges:?}");
        assert_eq!(challenges.iter().any(|c| c.starts_with("Basic")), asks, "{shown:?}");
    }
}
