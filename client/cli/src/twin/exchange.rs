//! Twins and motion as files of other programs: the options for it, and twins from files.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use bendtwin_core::Twin;
use bendtwin_exchange::{Format, Motion, PointSet, Scene};
use bendtwin_mesh::{Limits, Mesh};
use clap::Args;

use crate::failure;

/// Points that are written: by default the surface in formats that are looked at, and else the nodes.
#[derive(Debug, Default, PartialEq, Eq, Args)]
pub(crate) struct Points {
    /// Write the nodes and the springs between them
    #[arg(long, group = "points")]
    pub(crate) nodes: bool,
    /// Write the points of the skin
    #[arg(long, group = "points")]
    pub(crate) skin: bool,
    /// Write the surface: triangles in the object's colours
    #[arg(long, group = "points")]
    pub(crate) surface: bool,
    /// Write this mesh, carried by the nodes: GLB, OBJ or PLY, in the twin's coordinates at rest
    /// (metres, z up)
    #[arg(long, value_name = "FILE", group = "points")]
    pub(crate) mesh: Option<PathBuf>,
}

impl Points {
    /// Writes a twin, or its motion.
    pub(crate) fn write(
        &self,
        name: &str,
        twin: &Twin,
        motion: Option<&Motion>,
        format: Format,
        path: &Path,
    ) -> anyhow::Result<()> {
        let mesh = self.mesh.as_deref().map(read_mesh).transpose()?;
        let asked = match &mesh {
            Some(mesh) => Some(PointSet::Mesh(mesh)),
            None if self.skin => Some(PointSet::Skin),
            None if self.surface => Some(PointSet::Surface),
            None => self.nodes.then_some(PointSet::Nodes),
        };
        let scene = match asked {
            Some(points) => Scene::new(name, twin, points, motion),
            None => Scene::of_format(name, twin, format, motion),
        }
        .map_err(failure::failed)?;
        bendtwin_exchange::write(&scene, format, path).map_err(failure::failed)
    }

    /// True if other points than nodes are asked for.
    pub(crate) fn are_others(&self) -> bool {
        self.skin || self.surface || self.mesh.is_some()
    }
}

/// The format of a file by its name.
pub(crate) fn format_of(path: &Path) -> anyhow::Result<Format> {
    Format::of_path(path).map_err(failure::failed)
}

fn read_mesh(path: &Path) -> anyhow::Result<Mesh> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    bendtwin_mesh::parse(&path.to_string_lossy(), &bytes, &Limits::default())
        .map_err(failure::failed)
}

/// Size of a file, or of the files in a folder [bytes].
pub(crate) fn size_of(path: &Path) -> anyhow::Result<u64> {
    if !path.is_dir() {
        return Ok(std::fs::metadata(path)?.len());
    }
    let mut sum = 0;
    for entry in std::fs::read_dir(path)? {
        sum += entry?.metadata()?.len();
    }
    Ok(sum)
}
