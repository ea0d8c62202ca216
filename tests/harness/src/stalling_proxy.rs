//! A proxy that fails as real connections do: after a number of bytes it passes nothing on, without
//! closing.

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::{TcpListener, TcpStream},
};

const CHUNK: usize = 64 << 10;

/// A proxy of a server for the clients of a test.
pub struct StallingProxy {
    url: String,
    accepting: tokio::task::JoinHandle<()>,
}

impl StallingProxy {
    /// A proxy of `server` (`http://host:port`) that passes on `bytes` bytes from all clients
    /// together.
    pub async fn to(server: &str, bytes: u64) -> Self {
        let server = server.strip_prefix("http://").unwrap().to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let left = Arc::new(AtomicU64::new(bytes));
        let accepting = tokio::spawn(async move {
            while let Ok((client, _)) = listener.accept().await {
                let Ok(server) = TcpStream::connect(&server).await else { continue };
                tokio::spawn(pass(client, server, left.clone()));
            }
        });
        Self { url, accepting }
    }

    /// The proxy's address, for clients.
    pub fn url(&self) -> &str {
        &self.url
    }
}

impl Drop for StallingProxy {
    fn drop(&mut self) {
        self.accepting.abort();
    }
}

async fn pass(client: TcpStream, server: TcpStream, left: Arc<AtomicU64>) {
    let (mut from_client, mut to_client) = client.into_split();
    let (mut from_server, mut to_server) = server.into_split();
    let back = tokio::io::copy(&mut from_server, &mut to_client);
    let there = async {
        let mut chunk = vec![0; CHUNK];
        while let Ok(read @ 1..) = from_client.read(&mut chunk).await {
            let take = |left: u64| left.checked_sub(read as u64);
            if left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, take).is_err() {
                // Neither data nor an end.
                std::future::pending::<()>().await;
            }
            if to_server.write_all(&chunk[..read]).await.is_err() {
                return;
            }
        }
    };
    tokio::select! {
        _ = back => {}
        () = there => {}
    }
}
