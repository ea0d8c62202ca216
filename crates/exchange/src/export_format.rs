//! The formats of a twin alone: those that a [`Scene`](crate::Scene) is written in, and a web page, which needs the
//! template of its caller.

use std::{fmt, path::Path, str::FromStr};

use crate::{Error, Format};

/// A format that a twin is exported in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// A web page ([`web_page`](crate::web_page())).
    Html,
    /// A format of scenes.
    Of(Format),
}

impl ExportFormat {
    /// The format of a file by the end of its name, in any case.
    ///
    /// # Errors
    /// If the name has no known extension.
    pub fn of_path(path: &Path) -> Result<Self, Error> {
        let is_page = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html"));
        if is_page { Ok(Self::Html) } else { Format::of_path(path).map(Self::Of) }
    }

    /// The usual end of a file's name.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Html => "html",
            Self::Of(format) => format.extensions().first().copied().unwrap_or_default(),
        }
    }
}

impl FromStr for ExportFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("html") {
            return Ok(Self::Html);
        }
        text.parse().map(Self::Of).map_err(|known| format!("{known}, html"))
    }
}

impl fmt::Display for ExportFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Html => f.write_str("html"),
            Self::Of(format) => f.write_str(format.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_web_page_is_chosen_by_the_name_or_explicitly() {
        let glb = ExportFormat::Of(Format::Glb);
        for (name, format) in
            [("rope.html", ExportFormat::Html), ("a.b.HTML", ExportFormat::Html), ("html.glb", glb)]
        {
            assert_eq!(ExportFormat::of_path(Path::new(name)).unwrap(), format, "{name}");
            assert_eq!(format.to_string().parse(), Ok(format));
        }
        assert_eq!((ExportFormat::Html.extension(), glb.extension()), ("html", "glb"));
        assert!("htm".parse::<ExportFormat>().unwrap_err().ends_with("mcap, html"));
    }
}
