//! The formats, and how a file's name selects them.

use std::{fmt, path::Path, str::FromStr};

use crate::Error;

/// A format that twins and motion are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The twin file itself (docs/formats/twin.md).
    Twin,
    /// Gaussians of the appearance at rest, as PLY of Gaussian splatting.
    Splats,
    /// A state as binary PLY.
    Ply,
    /// A binary PLY for each frame, in a ZIP archive or a folder.
    PlySequence,
    /// A state as Wavefront OBJ.
    Obj,
    /// Binary glTF; motion as morph targets.
    Glb,
    /// Arrays of numpy: all that the twin file has, and the motion.
    Npz,
    /// USD as text; motion as time samples.
    Usda,
    /// The same in a package of one file.
    Usdz,
    /// A model of MuJoCo; motion as keyframes.
    Mujoco,
    /// Messages for Foxglove.
    Mcap,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Twin,
        // Before the format whose extension is the end of this one's.
        Self::Splats,
        Self::Ply,
        Self::PlySequence,
        Self::Obj,
        Self::Glb,
        Self::Npz,
        Self::Usda,
        Self::Usdz,
        Self::Mujoco,
        Self::Mcap,
    ];

    /// Name that `--format` takes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Twin => "twin",
            Self::Splats => "splats",
            Self::Ply => "ply",
            Self::PlySequence => "ply-sequence",
            Self::Obj => "obj",
            Self::Glb => "glb",
            Self::Npz => "npz",
            Self::Usda => "usda",
            Self::Usdz => "usdz",
            Self::Mujoco => "mujoco",
            Self::Mcap => "mcap",
        }
    }

    /// Ends of names by which the format is recognized, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Twin => &["safetensors", "twin"],
            Self::Splats => &["splat.ply"],
            Self::Ply => &["ply"],
            Self::PlySequence => &["zip"],
            Self::Obj => &["obj"],
            Self::Glb => &["glb"],
            Self::Npz => &["npz"],
            Self::Usda => &["usda"],
            Self::Usdz => &["usdz"],
            Self::Mujoco => &["xml", "mjcf"],
            Self::Mcap => &["mcap"],
        }
    }

    /// The format of a file by its name's end, in any case; a folder is a PLY sequence.
    ///
    /// # Errors
    /// If the name has no known extension.
    pub fn of_path(path: &Path) -> Result<Self, Error> {
        let name = path.to_string_lossy();
        if name.ends_with(std::path::is_separator) || path.is_dir() {
            return Ok(Self::PlySequence);
        }
        let found = Self::ALL.into_iter().find(|f| f.extensions().iter().any(|e| is(path, e)));
        found.ok_or_else(|| Error::UnknownFormat { name: name.into_owned() })
    }

    /// True if a PLY sequence of this name is one file.
    pub(crate) fn is_archive(path: &Path) -> bool {
        is(path, "zip") && !path.is_dir()
    }

    /// True if it holds more than one state.
    pub fn holds_motion(self) -> bool {
        !matches!(self, Self::Twin | Self::Splats | Self::Ply | Self::Obj)
    }

    /// True if it is read by programs that show it: then the surface is written unless other points are asked for.
    pub fn shows(self) -> bool {
        matches!(
            self,
            Self::Ply | Self::PlySequence | Self::Obj | Self::Glb | Self::Usda | Self::Usdz
        )
    }

    /// All formats with their extensions, for messages.
    pub(crate) fn list() -> String {
        Self::named(|_| true)
    }

    /// Formats that hold motion, for messages.
    pub(crate) fn list_of_motion() -> String {
        Self::named(Self::holds_motion)
    }

    fn named(of: impl Fn(Self) -> bool) -> String {
        let names = Self::ALL.into_iter().filter(|f| of(*f)).map(|f| {
            let mut ends: Vec<_> = f.extensions().iter().map(|e| format!(".{e}")).collect();
            if f == Self::PlySequence {
                ends.push("a folder/".to_owned());
            }
            format!("{} ({f})", ends.join(" or "))
        });
        let names: Vec<_> = names.collect();
        format!("name it {}", names.join(", "))
    }
}

fn is(path: &Path, extension: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let stem = name.strip_suffix(extension).and_then(|rest| rest.strip_suffix('.'));
    stem.is_some_and(|stem| !stem.is_empty())
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = || Self::ALL.map(Self::name).join(", ");
        let found = Self::ALL.into_iter().find(|f| f.name().eq_ignore_ascii_case(text));
        found.ok_or_else(|| format!("known formats are {}", names()))
    }
}

#[cfg(test)]
mod tests;
