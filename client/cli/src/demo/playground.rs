//! `bendtwin demo --open`: the fitted rope in a browser, where it can be dragged.

use anyhow::Context as _;
use serde_json::json;

use super::{server::Connection, steps::DemoRun};
use crate::output;

/// Variables of which one is set where a window can be opened.
#[cfg(all(unix, not(target_os = "macos")))]
const DISPLAYS: [&str; 3] = ["DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME"];

impl DemoRun {
    /// Steps 2 to 5, the last of which is a page.
    pub(super) async fn open_playground(&mut self, connection: &Connection) -> anyhow::Result<()> {
        let (_, capture) = self.record(connection).await?;
        let fit = self.bending_fit(connection, capture).await?;
        let twin = fit.twin.context("the fit has no twin")?;
        let address = address(connection, &twin.to_string());
        self.step(
            "Open it in a browser: drag the hand, grasp the rope anywhere, change the world",
            "see docs/formats/play.md",
        );
        self.print(&format!("  {address}"));
        self.is_told = true;
        if self.quiet {
            self.report.insert("twin".to_owned(), json!(twin));
            self.report.insert("address".to_owned(), json!(address));
            let report = std::mem::take(&mut self.report);
            return output::line(&serde_json::Value::Object(report).to_string());
        }
        if let Err(fault) = open_browser(&address) {
            self.print(&format!("  no browser was opened ({fault}): open this address yourself"));
        }
        self.print("\nServer and worker stay until Ctrl-C.");
        Ok(())
    }
}

/// The page of a twin's playground. The token stands behind the `#`, which browsers do not send.
fn address(Connection { url, token, .. }: &Connection, twin: &str) -> String {
    format!("{url}/#/{twin}/play?token={token}")
}

/// Opens the user's browser, where there is a screen for it.
fn open_browser(address: &str) -> Result<(), String> {
    #[cfg(all(unix, not(target_os = "macos")))]
    if DISPLAYS.iter().all(|name| std::env::var_os(name).is_none_or(|value| value.is_empty())) {
        return Err("this machine has no screen".to_owned());
    }
    open::that_detached(address).map_err(|error| error.to_string())
}
