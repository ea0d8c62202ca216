//! `bendtwin fit show`: a fit with its settings, its losses and the errors of its twin.

use bendtwin_client::{Client, Fit, FitId, LossCurve, Quality};
use bendtwin_core::Category;
use bendtwin_eval::{TableStyle, format_table};
use serde::Serialize;
use serde_json::Value;

use super::{losses, settings, shown};
use crate::{global::Global, output};

/// All that there is of a fit.
#[derive(Debug, Serialize)]
pub(super) struct Details {
    #[serde(flatten)]
    pub(super) fit: Fit,
    /// Display name of the capture; none if it was deleted.
    pub(super) capture_display_name: Option<String>,
    pub(super) losses: Vec<LossCurve>,
    /// Quality table of the twin; none if there is no twin, or it was deleted.
    pub(super) quality: Option<Quality>,
}

impl Details {
    pub(super) async fn fetch(client: &Client, name: FitId) -> anyhow::Result<Self> {
        let fit = client.fits().get(name).await?;
        let losses = client.fits().losses(name).await?;
        let capture = unless_gone(client.captures().get(fit.capture).await)?;
        let twin = match fit.twin {
            Some(twin) => unless_gone(client.twins().get(twin).await)?,
            None => None,
        };
        let capture_display_name = capture.map(|c| c.display_name);
        Ok(Self { fit, capture_display_name, losses, quality: twin.map(|t| t.quality) })
    }

    fn text(&self, in_force: Option<&Value>) -> String {
        let mut text = shown(&self.fit, self.capture_display_name.as_deref());
        text += "\n\nsettings (* not the default; what is left open follows effort, capture and device)\n";
        text += &settings::table(&self.fit.job.settings, in_force);
        text += "\n\nlosses\n";
        text += &match self.losses.is_empty() {
            true => "  none yet".to_owned(),
            false => losses::table(&self.losses),
        };
        if let Some(quality) = &self.quality {
            text += &format!("\n\nerrors (mm)\n{}", format_table(quality, TableStyle::Plain));
        }
        if let Some(twin) = &self.fit.twin {
            text = text.trim_end().to_owned() + &format!("\n\nnext: bendtwin twin show {twin}");
        }
        text
    }
}

pub(super) async fn run(name: FitId, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    let details = Details::fetch(&client, name).await?;
    let in_force = match details.fit.twin {
        Some(twin) => unless_gone(client.twins().download(twin).await)?,
        None => None,
    };
    let in_force = in_force.map(|twin| serde_json::to_value(twin.provenance.settings));
    let in_force = in_force.transpose()?;
    output::print(global, &details, || details.text(in_force.as_ref()))
}

/// `None` for a resource that has been deleted since.
fn unless_gone<T>(
    found: Result<T, bendtwin_client::Error>,
) -> Result<Option<T>, bendtwin_client::Error> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(error) if error.category() == Category::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}
