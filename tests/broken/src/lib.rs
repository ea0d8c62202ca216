//! Recordings with one fault each, and the diagnosis expected of each; and healthy ones of many kinds
//! ([`healthy`]), which have none.
//!
//! All are derived from one healthy simulated recording. [`all`] lists the faults: in the camera
//! data ([`footage`]), in files ([`files`]), their names ([`naming`]) and masks ([`masks`]), in
//! archives ([`archives`]), and in recordings of robots ([`robots`]). A user of this crate
//! calls [`Broken::make`] and compares the diagnosis with the expected one.

pub mod archives;
pub mod calibration;
pub mod clocks;
pub mod files;
pub mod footage;
pub mod grids;
pub mod healthy;
pub mod masks;
pub mod naming;
pub mod robots;
pub mod starts;
pub mod streams;

use std::path::PathBuf;

use bendtwin_capture::raw::Recording;
use tempfile::TempDir;

pub use self::footage::Footage;

/// A recording with one fault.
#[derive(Clone, Debug)]
pub struct Broken {
    /// The fault.
    pub name: &'static str,
    /// The expected diagnosis.
    pub expected: Expected,
    /// The way to make it.
    make: Make,
}

/// A diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// Cannot be opened: reason of the error.
    Refused(&'static str),
    /// Some of its files cannot be decoded: the reader's reason for the first.
    Damaged(&'static str),
    /// Code of the first finding of the report.
    Found(&'static str),
    /// No fault: it is read as what it is. Code of a remark.
    Sound(&'static str),
    /// Code of any finding: relevant, but other recordings of its kind have it too.
    Noticed(&'static str),
}

/// A broken recording, ready for inspection.
#[derive(Debug)]
pub enum Sample {
    /// A folder or an archive, which exists as long as the guard.
    Stored(TempDir, PathBuf),
    /// Already opened.
    Opened(Box<Recording>),
}

#[derive(Clone, Copy, Debug)]
enum Make {
    /// Changes files of a PhysTwin case in a folder.
    Case(fn(&mut files::FileMap)),
    /// Changes files of a raw bundle in a folder.
    Bundle(fn(&mut files::FileMap)),
    /// Makes a file from those of a case.
    Archive(fn(&files::FileMap) -> Vec<u8>),
    /// Changes a folder with a case.
    Folder(fn(&std::path::Path)),
    /// Changes messages of a robot's recording.
    Robot(fn(&mut robots::Robot)),
    /// Changes the camera data.
    Footage(fn(&mut Footage)),
}

impl Broken {
    /// Makes it.
    pub fn make(&self) -> Sample {
        match self.make {
            Make::Case(change) => files::stored(files::case(), change),
            Make::Bundle(change) => files::stored(files::bundle(), change),
            Make::Archive(pack) => archives::stored(&pack(files::case())),
            Make::Folder(change) => files::changed_folder(change),
            Make::Robot(change) => robots::stored(change),
            Make::Footage(change) => {
                let mut footage = footage::healthy();
                change(&mut footage);
                Sample::Opened(Box::new(footage.recording()))
            }
        }
    }
}

/// Every broken recording.
pub fn all() -> Vec<Broken> {
    [
        calibration::all(),
        grids::all(),
        streams::all(),
        clocks::all(),
        starts::all(),
        files::all(),
        naming::all(),
        masks::all(),
        robots::all(),
        archives::all(),
    ]
    .concat()
}

fn broken(name: &'static str, expected: Expected, make: Make) -> Broken {
    Broken { name, expected, make }
}
