//! The address of a server, and the server that answers at the address of the client.

use std::{io::ErrorKind, net::SocketAddr};

use bendtwin_client::{Category, Client, Readiness, Worker, token};
use bendtwin_core::BUILD;
use bendtwin_server::Options;
use tokio::net::TcpListener;

use super::check::Check;
use crate::global::{DEFAULT_SERVER, Global};

/// The check of the address on which a server listens or is to listen.
pub(super) async fn address(listen: SocketAddr) -> Check {
    const NAME: &str = "address";
    match TcpListener::bind(listen).await {
        Ok(_) => Check::ok(NAME, format!("{listen} is free for `bendtwin server`")),
        Err(error) if error.kind() == ErrorKind::AddrInUse => match readiness(listen).await {
            Ok(found) => Check::ok(NAME, format!("{} listens on {listen}", found.build)),
            Err(error) if error.reason() == "TLS_REQUIRED" => {
                Check::ok(NAME, format!("a server of BendTwin listens on {listen}, with TLS"))
            }
            Err(_) => {
                let advice = "stop it, or start the server with another --listen";
                Check::problem(NAME, format!("another program listens on {listen}: {advice}"))
            }
        },
        Err(error) => Check::problem(NAME, format!("nothing can listen on {listen}: {error}")),
    }
}

/// The state of the server at an address of this machine, if it is one of BendTwin.
async fn readiness(listen: SocketAddr) -> Result<Readiness, bendtwin_client::Error> {
    let ip = match listen.ip() {
        ip if ip.is_unspecified() => "127.0.0.1".to_owned(),
        ip if ip.is_ipv6() => format!("[{ip}]"),
        ip => ip.to_string(),
    };
    let url = format!("http://{ip}:{}", listen.port());
    Client::connect(&url).await?.readiness().await
}

/// Connects to the server that commands talk to. Where nothing else says what to show to a server with these
/// options on this machine, the token in its file.
async fn connect(global: &Global, options: &Options) -> anyhow::Result<Client> {
    let client = global.connect().await?;
    if global.token()?.is_some() || !is_own(client.url(), options.listen) {
        return Ok(client);
    }
    match token::read(&options.client_token_path()) {
        Ok(token) => {
            Ok(Client::connect_with(client.url(), Some(&token), global.ca.as_deref()).await?)
        }
        Err(_) => Ok(client),
    }
}

/// True for the URL of a server on this machine, at the port of this address: no other one may get its token.
fn is_own(url: &str, listen: SocketAddr) -> bool {
    token::local_port(url) == Some(listen.port())
}

/// Checks of the server that commands talk to. If none answers, a problem if its address was given, otherwise a
/// note: a machine may have no server.
pub(super) async fn server(global: &Global, options: &Options) -> Vec<Check> {
    const NAME: &str = "server";
    let client = match connect(global, options).await {
        Ok(client) => client,
        Err(error) => {
            let make = if global.server == DEFAULT_SERVER { Check::note } else { Check::problem };
            return vec![make(NAME, format!("{error:#}"))];
        }
    };
    let found = match client.readiness().await {
        Ok(found) => found,
        Err(error) => return vec![Check::problem(NAME, error.to_string())],
    };
    let mut checks = vec![build(NAME, &format!("the server at {}", client.url()), &found.build)];
    for check in found.checks {
        let make = if check.ok { Check::ok } else { Check::problem };
        checks.push(make(NAME, check.message));
    }
    match client.workers().all().await {
        Ok(workers) => checks.extend(workers.iter().map(worker)),
        Err(error) if error.category() == Category::Unauthenticated => {
            checks.push(Check::problem("token", error.to_string()));
        }
        Err(error) => checks.push(Check::problem(NAME, error.to_string())),
    }
    checks
}

fn worker(worker: &Worker) -> Check {
    let who = format!("{} on {} ({})", worker.name, worker.device, worker.backend);
    build("worker", &who, &worker.build)
}

/// The check of another program's version against this one's.
fn build(name: &'static str, who: &str, build: &str) -> Check {
    if build == BUILD {
        return Check::ok(name, format!("{who} is {build}"));
    }
    let advice = "use one version everywhere";
    Check::note(name, format!("{who} is {build}, this program {BUILD}: {advice}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::check::State;

    #[tokio::test]
    async fn an_address_that_another_program_has_is_a_problem() {
        let taken = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address_taken = taken.local_addr().unwrap();
        tokio::spawn(async move {
            while let Ok((socket, _)) = taken.accept().await {
                drop(socket);
            }
        });
        let check = address(address_taken).await;
        assert_eq!(check.state, State::Problem);
        assert!(check.message.contains("another program"), "{}", check.message);
        assert_eq!(address("127.0.0.1:0".parse().unwrap()).await.state, State::Ok);
    }

    #[test]
    fn the_token_of_a_server_goes_to_no_other() {
        let listen = "0.0.0.0:7070".parse().unwrap();
        for own in ["http://127.0.0.1:7070", "https://localhost:7070/", "http://[::1]:7070"] {
            assert!(is_own(own, listen), "{own}");
        }
        for other in [
            "http://127.0.0.1:7071",
            "http://10.0.0.4:7070",
            "https://twin.example:7070",
            "http://localhost.example:7070",
            "http://127.0.0.1@twin.example:7070",
            "127.0.0.1:7070",
        ] {
            assert!(!is_own(other, listen), "{other}");
        }
    }

    #[test]
    fn another_version_is_noted() {
        assert_eq!(build("server", "it", BUILD).state, State::Ok);
        assert_eq!(build("server", "it", "bendtwin 99.0.0").state, State::Note);
    }
}
