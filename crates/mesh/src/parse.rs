//! Reads meshes. Bytes are hostile: every count is checked against the bytes left before anything
//! is allocated for it.

mod glb;
mod obj;
mod ply;

use crate::{Error, Limits, Mesh};

/// Reads a mesh; the extension of `name` selects the format: `glb`, `obj` or `ply`.
///
/// All parts are merged, polygons become fans of triangles, a scene's transforms are applied;
/// materials, textures, bones and animations are left out. Axes and unit stay those of the file.
///
/// # Errors
/// If the format is not known, the file is damaged, compressed or beyond the limits, or there are
/// no triangles.
pub fn parse(name: &str, bytes: &[u8], limits: &Limits) -> Result<Mesh, Error> {
    let size = bytes.len() as u64;
    if size > limits.file_bytes {
        return Err(Error::TooLarge { at: name.to_owned(), bytes: size, limit: limits.file_bytes });
    }
    let extension = name.rsplit_once('.').map(|(_, e)| e.to_ascii_lowercase());
    let mut mesh = match extension.as_deref() {
        Some("glb") => glb::read(name, bytes, limits),
        Some("obj") => obj::read(name, bytes, limits),
        Some("ply") => ply::read(name, bytes, limits),
        Some("gltf") => Err(Error::External { at: name.to_owned() }),
        _ => Err(Error::Format(name.to_owned())),
    }?;
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    mesh.check(name, limits)?;
    Ok(mesh)
}

/// Triangles of a polygon around its first corner.
fn fan(mesh: &mut Mesh, corners: &[u32], limits: &Limits) -> Result<(), Error> {
    if let [first, rest @ ..] = corners {
        limits.allow_triangles(mesh.triangles.len() + rest.len().saturating_sub(1))?;
        mesh.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    }
    Ok(())
}

fn damaged(at: &str, fault: impl Into<String>) -> Error {
    Error::Damaged { at: at.to_owned(), fault: fault.into() }
}

#[cfg(test)]
mod tests;
