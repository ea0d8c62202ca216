//! Twins and their predicted motion in the formats of other programs, and PhysTwin's results as
//! twins.
//!
//! A [`Scene`] is a twin, the selected points of it, and positions over time if it moves;
//! [`write()`] puts it into a file in a [`Format`], which follows the file's name or is given
//! explicitly, and is never silently another. `docs/formats/exchange.md` says what each format
//! carries and what is lost. [`of_phystwin`] imports twins. This crate simulates nothing: motion
//! comes from the caller.

mod error;
mod export_format;
mod format;
mod gltf;
mod mcap;
mod mujoco;
mod npz;
mod obj;
mod phystwin;
mod ply;
mod scene;
pub mod splats;
#[cfg(test)]
mod testing;
mod usd;
mod web_page;

use std::{
    fs::File,
    io::{BufWriter, Seek, Write},
    path::Path,
};

pub use self::{
    error::Error,
    export_format::ExportFormat,
    format::Format,
    phystwin::of_phystwin,
    scene::{Motion, PointSet, Scene},
    web_page::web_page,
};

/// Writes a scene to a file, or to a folder where [`Format::PlySequence`] is not named `.zip`.
///
/// # Errors
/// If the format cannot carry the scene, or the disk fails. Nothing is created in the first case.
pub fn write(scene: &Scene<'_>, format: Format, path: &Path) -> Result<(), Error> {
    check(scene, format)?;
    let io = |source| Error::Io { at: path.display().to_string(), source };
    if format == Format::PlySequence && !Format::is_archive(path) {
        return ply::write_folder(scene, path);
    }
    let mut file = BufWriter::new(File::create(path).map_err(io)?);
    encode(scene, format, &mut file).map_err(|error| error.of_file(path))?;
    file.flush().map_err(io)
}

/// Writes a scene as one file's content.
///
/// # Errors
/// If the format cannot carry the scene, or writing fails.
pub fn encode(
    scene: &Scene<'_>,
    format: Format,
    out: &mut (impl Write + Seek),
) -> Result<(), Error> {
    check(scene, format)?;
    match format {
        Format::Twin => out.write_all(&scene.twin().encode()?)?,
        Format::Ply => ply::write(scene, 0, out)?,
        Format::Splats => {
            let gaussians = splats::of_twin(scene.twin()).ok_or(Error::NoSplats)?;
            splats::write_ply(&gaussians, out)?;
        }
        Format::PlySequence => ply::write_archive(scene, out)?,
        Format::Obj => obj::write(scene, out)?,
        Format::Glb => gltf::write(scene, out)?,
        Format::Npz => npz::write(scene, out)?,
        Format::Usda => usd::write(scene, out)?,
        Format::Usdz => usd::write_package(scene, out)?,
        Format::Mujoco => mujoco::write(scene, out)?,
        Format::Mcap => mcap::write(scene, out)?,
    }
    Ok(())
}

/// Refuses what a format cannot carry.
fn check(scene: &Scene<'_>, format: Format) -> Result<(), Error> {
    let moves = scene.motion().is_some();
    match format {
        Format::Twin | Format::Splats if moves => Err(Error::NoMotion { format }),
        Format::Ply | Format::Obj if scene.frame_count() > 1 => Err(Error::NoMotion { format }),
        Format::Glb if scene.frame_count() > gltf::MAX_FRAMES => {
            let (frames, limit) = (scene.frame_count(), gltf::MAX_FRAMES);
            Err(Error::TooManyFrames { format, frames, limit })
        }
        Format::Splats if splats::of_twin(scene.twin()).is_none() => Err(Error::NoSplats),
        Format::Twin | Format::Mujoco | Format::Splats
            if !matches!(scene.points(), PointSet::Nodes) =>
        {
            Err(Error::NodesOnly { format })
        }
        _ => Ok(()),
    }
}
