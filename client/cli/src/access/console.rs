//! `bendtwin console`: the console of a server in a browser, logged in.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use clap::Args;
use serde_json::json;

use crate::{global::Global, output};

/// Variables of which one is set where a window can be opened.
#[cfg(all(unix, not(target_os = "macos")))]
const DISPLAYS: [&str; 3] = ["DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME"];

#[derive(Debug, Args)]
pub(crate) struct Console {
    /// Print the address without opening a browser
    #[arg(long)]
    print: bool,
}

pub(crate) async fn run(args: Console, global: &Global) -> anyhow::Result<()> {
    // Nothing is opened that does not answer.
    global.connect().await?;
    let address = login_address(&global.server, "/", global.token()?.as_deref());
    output::print(global, &json!({ "address": address }), || address.clone())?;
    if !args.print
        && !global.json
        && let Err(fault) = open_browser(&address)
    {
        eprintln!("No browser was opened ({fault}): open this address yourself.");
    }
    Ok(())
}

/// Address of a page of the console that logs in. The token is behind the `#`, which browsers do not send, and the
/// page removes it from the address.
pub(crate) fn login_address(url: &str, page: &str, token: Option<&str>) -> String {
    let query = token.map(|token| format!("?token={token}")).unwrap_or_default();
    format!("{}/#{page}{query}", url.trim_end_matches('/'))
}

/// The address at which a browser on this machine reaches a server that listens here.
pub(crate) fn local(address: SocketAddr) -> SocketAddr {
    let ip = match address.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    SocketAddr::new(ip, address.port())
}

/// Opens the user's browser, where there is a screen for it.
pub(crate) fn open_browser(address: &str) -> Result<(), String> {
    #[cfg(all(unix, not(target_os = "macos")))]
    if DISPLAYS.iter().all(|name| std::env::var_os(name).is_none_or(|value| value.is_empty())) {
        return Err("this machine has no screen".to_owned());
    }
    open::that_detached(address).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_logs_in_where_there_is_a_token() {
        assert_eq!(login_address("http://a:1/", "/", Some("t0k")), "http://a:1/#/?token=t0k");
        assert_eq!(login_address("http://a:1", "/twins/1/play", None), "http://a:1/#/twins/1/play");
    }

    #[test]
    fn a_browser_is_not_sent_to_every_address_of_the_machine() {
        for (listens, opened) in
            [("0.0.0.0:7", "127.0.0.1:7"), ("[::]:7", "[::1]:7"), ("10.0.0.4:7", "10.0.0.4:7")]
        {
            assert_eq!(local(listens.parse().unwrap()).to_string(), opened);
        }
    }
}
