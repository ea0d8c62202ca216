//! Twins and motion as files of other programs: the options for it, and twins from files.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use bendtwin_core::Twin;
use bendtwin_exchange::{Format, Motion, PointSet, Scene};
use bendtwin_mesh::{Limits, Mesh};
use clap::Args;

use crate::failure;

/// Points that are written in place of nodes.
#[derive(Debug, Default, PartialEq, Eq, Args)]
pub(crate) struct Points {
    /// Write the points of the skin instead of the nodes
    #[arg(long, conflicts_with = "mesh")]
    pub(crate) skin: bool,
    /// Write this mesh, carried by the nodes, instead of the nodes: GLB, OBJ or PLY, in the twin's
    /// coordinates at rest (metres, z up)
    #[arg(long, value_name = "FILE")]
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
        let points = match (&mesh, self.skin) {
            (Some(mesh), _) => PointSet::Mesh(mesh),
            (None, true) => PointSet::Skin,
            (None, false) => PointSet::Nodes,
        };
        let scene = Scene::new(name, twin, points, motion).map_err(failure::failed)?;
        bendtwin_exchange::write(&scene, format, path).map_err(failure::failed)
    }
}

/// The format of a file: the one that was said, or else that of its name.
pub(crate) fn format_of(path: &Path, said: Option<Format>) -> anyhow::Result<Format> {
    said.map_or_else(|| Format::of_path(path).map_err(failure::failed), Ok)
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
