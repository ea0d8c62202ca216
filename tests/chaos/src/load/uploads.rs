//! A client that uploads captures in pieces, and leaves some uploads for later.

use std::{sync::Arc, time::Duration};

use base64::{Engine as _, prelude::BASE64_STANDARD};
use rand::RngExt as _;
use reqwest::{Method, RequestBuilder, header::HeaderMap};
use tokio::time::sleep;

use crate::{
    honest::{Answer, Refusal, send},
    ledger::Begun,
    run::Run,
};

/// Most uploads that are left for later.
const LEFT: usize = 20;

pub(super) async fn client(run: Arc<Run>, number: u64) {
    let mut random = run.chance(number);
    while run.is_under_load() {
        let archive = random.random_range(0..run.references.archives.len());
        let Some(path) = begin(&run, archive).await else { continue };
        let length = run.references.archives[archive].content.len() as u64;
        let leaves = random.random_bool(0.2) && run.ledger.things().uploads.len() < LEFT;
        let pieces = random.random_range(2..5);
        for piece in 1..=pieces {
            if leaves && piece == pieces {
                break;
            }
            if send_until(&run, &path, length * piece / pieces).await.is_none() {
                break;
            }
            sleep(Duration::from_millis(random.random_range(0..300))).await;
        }
        sleep(Duration::from_millis(random.random_range(500..1500))).await;
    }
}

fn tus(run: &Run, method: &str, path: &str) -> RequestBuilder {
    let method = Method::from_bytes(method.as_bytes()).unwrap_or(Method::HEAD);
    run.http().request(method, path).header("tus-resumable", "1.0.0")
}

fn header(headers: &HeaderMap, name: &str) -> Answer<String> {
    let value = headers.get(name).and_then(|v| v.to_str().ok()).map(str::to_owned);
    value.ok_or_else(|| Refusal::Final(format!("no {name}"), format!("{headers:?}")))
}

async fn begin(run: &Run, archive: usize) -> Option<String> {
    let length = run.references.archives[archive].content.len();
    let request_id = BASE64_STANDARD.encode(run.fresh("upload"));
    let path = run.expect("a resumable upload", async || {
        let request = tus(run, "POST", "/v1/uploads")
            .header("upload-length", length)
            .header("upload-metadata", format!("request_id {request_id}"));
        header(&send(request).await?.0, "location")
    });
    let path = path.await?;
    run.ledger.received(&path, archive, 0);
    Some(path)
}

/// Sends the content up to an offset, from where the server says that it is; the capture, if that
/// was all.
pub(crate) async fn send_until(run: &Run, path: &str, end: u64) -> Option<()> {
    let Begun { archive, .. } = run.ledger.things().uploads.get(path)?.clone();
    let whole = &run.references.archives[archive].content;
    let answer = run.insist("a piece of an upload", async || {
        let (headers, _) = send(tus(run, "HEAD", path)).await?;
        let offset: u64 = header(&headers, "upload-offset")?.parse().unwrap_or(0);
        let acknowledged = run.ledger.things().uploads.get(path).map_or(0, |u| u.offset);
        if offset < acknowledged {
            let case = format_args!("{path}: {acknowledged} bytes were acknowledged, not {offset}");
            run.tally.broken("an acknowledged offset holds", case);
        }
        if offset >= end {
            return Ok((offset, header(&headers, "bendtwin-capture").ok()));
        }
        let piece = whole.slice(offset as usize..end as usize);
        let request = tus(run, "PATCH", path)
            .header("upload-offset", offset)
            .header("content-type", "application/offset+octet-stream")
            .body(piece);
        let (headers, _) = send(request).await?;
        let offset = header(&headers, "upload-offset")?.parse().unwrap_or(0);
        Ok((offset, header(&headers, "bendtwin-capture").ok()))
    });
    let (offset, capture) = match answer.await? {
        Ok(answer) => answer,
        Err(refusal) => {
            let begun = run.ledger.things().uploads.get(path).map_or(0, |u| u.offset);
            run.ledger.upload_ended(path);
            // One without bytes is not worth keeping for long, and the clock may have stepped on.
            if begun == 0 && (refusal.is("UPLOAD_GONE") || refusal.is("410 Gone")) {
                run.tally.count("honest calls: uploads without bytes that had expired");
            } else {
                let case = format_args!("{path} after {begun} bytes: {refusal:?}");
                run.tally.broken("an upload can be resumed", case);
            }
            return None;
        }
    };
    run.ledger.received(path, archive, offset);
    run.tally.count("acknowledged: pieces of uploads");
    if offset == whole.len() as u64 {
        match capture {
            Some(name) => {
                run.ledger.capture(&name, &run.references.archives[archive].digest, false);
                run.tally.count("acknowledged: captures");
            }
            None => run.tally.broken("the last byte makes the capture", path),
        }
        run.ledger.upload_ended(path);
    }
    Some(())
}
