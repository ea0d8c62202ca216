//! Twins as files of other programs (docs/formats/exchange.md).

use std::{io::Cursor, sync::Arc};

use bendtwin_budget::Share;
use bendtwin_core::{Twin as TwinFile, ids::TwinId};
use bendtwin_exchange::{Error as ExchangeError, ExportFormat, Format, Scene, encode, web_page};

use super::{App, Error, Result};
use crate::{access::Scope, twin_page::twin_page_template};

/// A file of another program, and its memory.
pub(crate) struct Exported {
    pub(crate) bytes: Vec<u8>,
    /// Name of the file: that of the twin, in letters that every header and file system takes.
    pub(crate) file_name: String,
    pub(crate) held: Arc<Share>,
}

impl App {
    /// A twin at rest in the format of another program, named by the word that `bendtwin twin export --format` takes.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an unknown word, [`Error::Export`] if the format cannot carry the twin.
    pub(crate) async fn export_as(&self, name: &str, format: &str) -> Result<Exported> {
        let twin = self.reach(Scope::TwinsRead, name).await?;
        let format: ExportFormat = format
            .parse()
            .map_err(|known: String| Error::invalid("format", format!("is unknown: {known}")))?;
        let _turn = self.drawing.turn().await;
        let read = self.read_twin(twin, move |row, twin| {
            let name = match row.labels.display_name.as_str() {
                "" => row.id.to_string(),
                name => name.to_owned(),
            };
            let bytes = match format {
                ExportFormat::Html => page(&name, twin)?,
                ExportFormat::Of(format) => file(&name, twin, format)?,
            };
            Ok((bytes, stem(&row.labels.display_name, row.id)))
        });
        let (bytes, stem) = read.await?;
        let held = Arc::new(self.memory.reply(bytes.len() as u64).await?);
        Ok(Exported { bytes, file_name: format!("{stem}.{}", format.extension()), held })
    }
}

/// The name of a twin as that of a file without its end; the id where nothing is left of it.
fn stem(display_name: &str, id: TwinId) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    let plain = display_name.replace(|c| !is_plain(c), "-");
    match plain.trim_matches('-') {
        "" => id.uuid().to_string(),
        plain => plain.to_owned(),
    }
}

/// The web page of a twin.
fn page(name: &str, twin: &TwinFile) -> Result<Vec<u8>> {
    let template = twin_page_template()
        .map_err(|e| Error::Internal(format!("the page of a twin is damaged: {e}")))?;
    Ok(web_page(&template, name, &twin.encode()?)?)
}

/// The file of another program.
fn file(name: &str, twin: &TwinFile, format: Format) -> Result<Vec<u8>, ExchangeError> {
    let mut file = Cursor::new(Vec::new());
    encode(&Scene::of_format(name, twin, format, None)?, format, &mut file)?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_after_their_twin() {
        let id = TwinId::generate();
        assert_eq!(stem("a toy/../2", id), "a-toy----2");
        assert_eq!(stem("\"; x=\"\r\n", id), "x");
        assert_eq!(stem("веревка", id), id.uuid().to_string());
    }
}
