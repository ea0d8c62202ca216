//! A load balancer as Kubernetes or HAProxy is one: connections go to servers that say that they are
//! ready, by chance, and those of a server that does not answer any more are closed.

use std::time::Duration;

use bendtwin_harness::http::Http;
use rand::RngExt as _;
use reqwest::Method;
use tokio::{
    io::copy_bidirectional,
    net::{TcpListener, TcpStream},
    sync::watch,
    task::JoinHandle,
    time::{sleep, timeout},
};

/// Interval between checks of a server, and the longest time for its answer.
const INTERVAL: Duration = Duration::from_millis(300);
const ANSWER: Duration = Duration::from_millis(1500);
/// Longest time for a connection to a server.
const CONNECT: Duration = Duration::from_secs(2);
/// Looks without an answer after which a server is gone.
const MISSED: u32 = 2;

/// Health of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Health {
    Ready,
    Unready,
    Gone,
}

/// A server behind it.
#[derive(Clone, Debug)]
struct Backend {
    address: String,
    health: watch::Receiver<Health>,
}

/// The balancer, with tasks that end with it.
pub(super) struct Balancer {
    address: String,
    tasks: Vec<JoinHandle<()>>,
}

impl Balancer {
    /// A balancer of servers (`http://host:port`).
    pub(super) async fn start(urls: Vec<String>) -> anyhow::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0").await?;
        let address = listener.local_addr()?.to_string();
        let (mut tasks, mut backends) = (Vec::new(), Vec::new());
        for url in urls {
            let (tell, health) = watch::channel(Health::Unready);
            let address = url.trim_start_matches("http://").to_owned();
            tasks.push(tokio::task::spawn_local(look(url, tell)));
            backends.push(Backend { address, health });
        }
        tasks.push(tokio::task::spawn_local(accept(listener, backends)));
        Ok(Self { address, tasks })
    }

    /// `host:port`.
    pub(super) fn address(&self) -> &str {
        &self.address
    }
}

impl Drop for Balancer {
    fn drop(&mut self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }
}

/// Looks after a server.
async fn look(url: String, tell: watch::Sender<Health>) {
    let (http, mut missed) = (Http::new(&url), 0);
    loop {
        let asked = http.request(Method::GET, "/readyz").timeout(ANSWER).send().await;
        missed = if asked.is_ok() { 0 } else { missed + 1 };
        let health = match asked {
            Ok(answer) if answer.status().is_success() => Health::Ready,
            Err(_) if missed >= MISSED => Health::Gone,
            _ => Health::Unready,
        };
        tell.send_if_modified(|before| std::mem::replace(before, health) != health);
        sleep(INTERVAL).await;
    }
}

async fn accept(listener: TcpListener, backends: Vec<Backend>) {
    while let Ok((client, _)) = listener.accept().await {
        tokio::task::spawn_local(pass(client, backends.clone()));
    }
}

/// Passes a connection on to a server, if one takes it.
async fn pass(mut client: TcpStream, mut backends: Vec<Backend>) {
    // Ready ones first, in an order of chance; then those that say why not.
    let first = rand::rng().random_range(0..backends.len());
    backends.rotate_left(first);
    backends.sort_by_key(|backend| *backend.health.borrow() != Health::Ready);
    for mut backend in backends {
        let connected = timeout(CONNECT, TcpStream::connect(&backend.address)).await;
        let Ok(Ok(mut server)) = connected else { continue };
        client.set_nodelay(true).ok();
        server.set_nodelay(true).ok();
        tokio::select! {
            _ = copy_bidirectional(&mut client, &mut server) => {}
            _ = backend.health.wait_for(|health| *health == Health::Gone) => {}
        }
        return;
    }
}
