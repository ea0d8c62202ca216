//! Formats of captures: the one place that knows what lies at a path, and as which format a folder is
//! read.

use std::path::Path;

use bendtwin_core::Finding;

use crate::{bundle, files::Contents, mocap, phystwin, raw, several};

/// Format of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// `recordings.json` beside folders, each of which is a capture of the same object.
    Recordings,
    /// BendTwin's own: `capture.json`, with points or with images.
    Bundle,
    /// A PhysTwin case with points.
    PhysTwin,
    /// Images and poses of cameras.
    Nerfstudio,
    /// A PhysTwin case with images alone.
    RawPhysTwin,
    /// Arrays of points with a document.
    MotionCapture,
    /// Markers as programs of motion capture export them.
    Markers,
    /// A file with the messages of a robot.
    Mcap,
}

impl Format {
    /// The format as which a folder is read; none if there is no capture in it.
    pub(crate) fn detect(contents: &Contents) -> Option<Self> {
        Self::all(contents).next()
    }

    /// `true` if a folder with these files is a capture.
    pub(crate) fn is_in(contents: &Contents) -> bool {
        Self::detect(contents).is_some()
    }

    /// Formats in a folder; the first is read.
    pub(crate) fn all(contents: &Contents) -> impl Iterator<Item = Self> {
        [
            (contents.has(several::MARKER), Self::Recordings),
            (contents.files.iter().any(|name| raw::is_mcap(name)), Self::Mcap),
            (contents.has(bundle::MARKER), Self::Bundle),
            (contents.has(phystwin::MARKER), Self::PhysTwin),
            (contents.has(raw::nerfstudio::MARKER), Self::Nerfstudio),
            (raw::is_case(contents), Self::RawPhysTwin),
            (mocap::packed(contents).is_some(), Self::MotionCapture),
            (mocap::has_markers(contents), Self::Markers),
        ]
        .into_iter()
        .filter_map(|(is_there, format)| is_there.then_some(format))
    }

    /// The format in words.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Recordings => "several recordings (`recordings.json`)",
            Self::Bundle => "a bundle (`capture.json`)",
            Self::PhysTwin => "a processed PhysTwin case (`final_data.pkl`)",
            Self::Nerfstudio => "nerfstudio (`transforms.json`)",
            Self::RawPhysTwin => "a raw PhysTwin case (`metadata.json` with `color`)",
            Self::MotionCapture => "motion capture (`.npz` with its `.json`)",
            Self::Markers => "markers of motion capture (C3D, CSV or TRC)",
            Self::Mcap => "an MCAP file",
        }
    }
}

/// What lies at a path, by what opens it.
pub(crate) enum Place<'p> {
    /// Arrays of motion capture in a separate file, which is no archive of files.
    Arrays(&'p Path),
    /// Markers of motion capture in a separate file.
    Markers(&'p Path),
    /// An MCAP file, which may be compressed as a whole.
    Mcap(&'p Path),
    /// A folder or an archive of files.
    Files(&'p Path),
}

impl<'p> Place<'p> {
    pub(crate) fn at(path: &'p Path) -> Self {
        let path = root(path);
        if is_npz(path) {
            Self::Arrays(path)
        } else if mocap::is_markers(path) {
            Self::Markers(path)
        } else if raw::is_mcap_at(path) {
            Self::Mcap(path)
        } else {
            Self::Files(path)
        }
    }
}

/// True for the arrays of motion capture, which are no archive of files.
pub fn is_npz(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"))
}

/// The folder or file to open: a person may point at the document inside the bundle.
pub fn root(path: &Path) -> &Path {
    match (path.file_name(), path.parent()) {
        (Some(name), Some(parent)) if name == bundle::MARKER && path.is_file() => {
            if parent.as_os_str().is_empty() { Path::new(".") } else { parent }
        }
        _ => path,
    }
}

/// The finding that says which format of several was read.
pub(crate) fn taken(contents: &Contents) -> Option<Finding> {
    // One of several recordings may lie beside the document that names them all.
    let mut formats = Format::all(contents).filter(|format| *format != Format::Recordings);
    let first = formats.next()?.words();
    let others = formats.map(Format::words).collect::<Vec<_>>().join(" and ");
    let message = format!("it was read as {first}; {others} in the same folder is passed over");
    let advice = "move the files of the first away to have the other read";
    let finding = Finding { advice: advice.into(), ..Finding::info("FORMAT_TAKEN", message) };
    (!others.is_empty()).then_some(finding)
}

#[cfg(test)]
mod tests;
