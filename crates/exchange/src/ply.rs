//! Binary PLY: one state as vertices, with springs as edges or a mesh as faces; a sequence is one
//! file for each frame.

use std::{
    fs,
    io::{BufWriter, Seek, Write},
    path::Path,
};

use zip::{ZipWriter, write::SimpleFileOptions};

use crate::{Error, PointSet, Scene};

/// Writes one frame.
///
/// Vertices have `x y z` [m], and `red green blue` if their colours are known; nodes also the `kind`, `object`
/// and `mass` of the twin file. Springs between nodes are edges; faces are those of the surface or the mesh.
pub(crate) fn write(scene: &Scene<'_>, frame: usize, out: &mut impl Write) -> Result<(), Error> {
    out.write_all(header(scene, frame).as_bytes())?;
    let graph = &scene.twin().graph;
    let is_nodes = matches!(scene.points(), PointSet::Nodes);
    for (i, point) in scene.points_at(frame).iter().enumerate() {
        out.write_all(bytemuck::bytes_of(point))?;
        if is_nodes {
            out.write_all(&[graph.kinds[i] as u8])?;
            out.write_all(&graph.object_ids[i].to_le_bytes())?;
            out.write_all(&graph.masses[i].to_le_bytes())?;
        }
        if let Some(color) = scene.colors().get(i) {
            out.write_all(color)?;
        }
    }
    out.write_all(bytemuck::cast_slice(scene.lines()))?;
    for corners in scene.triangles() {
        out.write_all(&[3])?;
        out.write_all(bytemuck::bytes_of(corners))?;
    }
    Ok(())
}

fn header(scene: &Scene<'_>, frame: usize) -> String {
    let mut text = format!(
        "ply\nformat binary_little_endian 1.0\ncomment bendtwin: metres, z up, {:.6} s\n",
        scene.times_s()[frame]
    );
    text += &format!("element vertex {}\n", scene.point_count());
    text += "property float x\nproperty float y\nproperty float z\n";
    if matches!(scene.points(), PointSet::Nodes) {
        text += "property uchar kind\nproperty uint object\nproperty float mass\n";
    }
    if !scene.colors().is_empty() {
        text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    }
    if !scene.lines().is_empty() {
        text += &format!("element edge {}\n", scene.lines().len());
        // With more than their ends, trimesh refuses the file.
        text += "property int vertex1\nproperty int vertex2\n";
    }
    if !scene.triangles().is_empty() {
        text += &format!("element face {}\n", scene.triangles().len());
        text += "property list uchar int vertex_indices\n";
    }
    text + "end_header\n"
}

/// Name of a frame's file.
fn name(frame: usize) -> String {
    format!("frame_{frame:06}.ply")
}

/// Writes a file for each frame into a folder, which is made.
pub(crate) fn write_folder(scene: &Scene<'_>, folder: &Path) -> Result<(), Error> {
    let io = |at: &Path, source| Error::Io { at: at.display().to_string(), source };
    fs::create_dir_all(folder).map_err(|e| io(folder, e))?;
    for frame in 0..scene.frame_count() {
        let path = folder.join(name(frame));
        let mut file = BufWriter::new(fs::File::create(&path).map_err(|e| io(&path, e))?);
        write(scene, frame, &mut file).map_err(|e| e.of_file(&path))?;
        file.flush().map_err(|e| io(&path, e))?;
    }
    Ok(())
}

/// Writes a ZIP archive with a file for each frame.
pub(crate) fn write_archive(scene: &Scene<'_>, out: &mut (impl Write + Seek)) -> Result<(), Error> {
    let mut archive = ZipWriter::new(out);
    for frame in 0..scene.frame_count() {
        archive.start_file(name(frame), SimpleFileOptions::default())?;
        let mut file = BufWriter::new(&mut archive);
        write(scene, frame, &mut file)?;
        file.flush()?;
    }
    archive.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests;
