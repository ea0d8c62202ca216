//! Plain HTTP calls, and requests that no HTTP library would send.

use std::time::Duration;

use reqwest::{Client, Method, RequestBuilder, Response, StatusCode};
use serde_json::Value;
use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpStream,
};

use crate::waiting::within;

const DEADLINE: Duration = Duration::from_secs(60);

/// A server's HTTP side.
#[derive(Clone, Debug)]
pub struct Http {
    url: String,
    client: Client,
}

impl Http {
    /// The server at `http://host:port`.
    pub fn new(url: &str) -> Self {
        // A connection a request: the server closes one whose body it refused to read, and the next
        // request on that connection would lose the race.
        let client = Client::builder().pool_max_idle_per_host(0).build().unwrap();
        Self { url: url.to_owned(), client }
    }

    /// True if the server answers at all.
    pub async fn is_up(&self) -> bool {
        self.is_ok("/healthz").await
    }

    /// True if the server says that it is ready, which takes a worker.
    pub async fn is_ready(&self) -> bool {
        self.is_ok("/readyz").await
    }

    async fn is_ok(&self, path: &str) -> bool {
        self.request(Method::GET, path)
            .timeout(Duration::from_secs(5))
            .send()
            .await
            .is_ok_and(|reply| reply.status() == StatusCode::OK)
    }

    /// A request of this path, with a deadline.
    pub fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.client.request(method, format!("{}{path}", self.url)).timeout(DEADLINE)
    }

    /// The answer to a GET.
    pub async fn get(&self, path: &str) -> Response {
        self.request(Method::GET, path).send().await.unwrap()
    }

    /// The JSON that a GET answers with.
    pub async fn get_json(&self, path: &str) -> Value {
        let reply = self.get(path).await;
        assert_eq!(reply.status(), StatusCode::OK, "{path}");
        reply.json().await.unwrap()
    }

    /// Sends raw bytes and returns the status of the first reply, if there was one.
    pub async fn send_raw(&self, bytes: &[u8]) -> Option<u16> {
        let address = self.url.strip_prefix("http://").unwrap();
        let mut stream = TcpStream::connect(address).await.unwrap();
        // The server may answer and close before it has read everything.
        stream.write_all(bytes).await.ok();
        stream.shutdown().await.ok();
        let mut reply = Vec::new();
        within("an answer to raw bytes", DEADLINE, stream.read_to_end(&mut reply)).await.ok();
        let line = String::from_utf8_lossy(&reply).into_owned();
        line.strip_prefix("HTTP/1.1 ")?.get(..3)?.parse().ok()
    }
}
