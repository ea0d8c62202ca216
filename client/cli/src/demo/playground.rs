//! `bendtwin demo --open`: the fitted rope in a browser, where it can be dragged.

use anyhow::Context as _;
use serde_json::json;

use super::{server::Connection, steps::DemoRun};
use crate::{
    access::console::{login_address, open_browser},
    output,
};

impl DemoRun {
    /// Steps 2 to 5, the last of which is a page.
    pub(super) async fn open_playground(&mut self, connection: &Connection) -> anyhow::Result<()> {
        let (_, capture) = self.record(connection).await?;
        let fit = self.bending_fit(connection, capture).await?;
        let twin = fit.twin.context("the fit has no twin")?;
        let Connection { url, token, .. } = connection;
        let address = login_address(url, &format!("/{twin}/play"), Some(token));
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
