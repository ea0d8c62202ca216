//! Arrays of numpy in a ZIP archive: every tensor of the twin file under its own name, its metadata
//! as JSON, and the motion.

use std::io::{Seek, Write};

use bendtwin_capture::npy;
use safetensors::{Dtype, SafeTensors};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::{Error, Scene};

/// The member with the twin's metadata, the JSON document of the twin file.
const METADATA: &str = "twin.json";

/// Writes the archive: `times_s` [F], `positions` [F, P, 3] and `controls` [F, C, 3] with F = 1 and
/// time 0 for a twin at rest, beside the arrays of the twin file.
pub(crate) fn write(scene: &Scene<'_>, out: &mut (impl Write + Seek)) -> Result<(), Error> {
    let mut archive = ZipWriter::new(out);
    // What numpy itself writes; compressed, the arrays could not be mapped.
    let options =
        SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    let mut member = |name: &str, content: &[u8]| -> Result<(), Error> {
        archive.start_file(name, options)?;
        archive.write_all(content)?;
        Ok(())
    };
    let frames = scene.frame_count();
    let times: Vec<u8> = scene.times_s().iter().flat_map(|t| t.to_le_bytes()).collect();
    member("times_s.npy", &npy::write("<f8", &[frames], &times))?;
    let (points, controls) = (scene.point_count(), scene.controls_at(0).len());
    let mut bytes = Vec::new();
    for frame in 0..frames {
        bytes.extend_from_slice(bytemuck::cast_slice(&scene.points_at(frame)));
    }
    member("positions.npy", &npy::write("<f4", &[frames, points, 3], &bytes))?;
    bytes.clear();
    for frame in 0..frames {
        bytes.extend_from_slice(bytemuck::cast_slice(scene.controls_at(frame)));
    }
    member("controls.npy", &npy::write("<f4", &[frames, controls, 3], &bytes))?;
    if !scene.triangles().is_empty() {
        let (triangles, count) = (scene.triangles(), scene.triangles().len());
        let bytes = bytemuck::cast_slice(triangles);
        member("triangles.npy", &npy::write("<u4", &[count, 3], bytes))?;
    }

    let file = scene.twin().encode()?;
    let damaged = |e: safetensors::SafeTensorError| std::io::Error::other(e);
    let (_, header) = SafeTensors::read_metadata(&file).map_err(damaged)?;
    let metadata = header.metadata().iter().flat_map(|m| m.values()).next();
    member(METADATA, metadata.map_or(b"{}", |json| json.as_bytes()))?;
    let tensors = SafeTensors::deserialize(&file).map_err(damaged)?;
    let mut names = tensors.names();
    names.sort_unstable();
    for name in names {
        let tensor = tensors.tensor(name).map_err(damaged)?;
        let descr = match tensor.dtype() {
            Dtype::F32 => "<f4",
            Dtype::U32 => "<u4",
            // The twin file has one other type.
            _ => "|u1",
        };
        let array = npy::write(descr, tensor.shape(), tensor.data());
        member(&format!("{name}.npy"), &array)?;
    }
    archive.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests;
