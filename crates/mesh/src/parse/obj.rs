//! Wavefront OBJ: `v` and `f` lines; everything else is passed over.

use super::{damaged, fan};
use crate::{Error, Limits, Mesh};

pub(super) fn read(at: &str, bytes: &[u8], limits: &Limits) -> Result<Mesh, Error> {
    let mut mesh = Mesh::default();
    let mut corners = Vec::new();
    // A backslash at the end joins lines.
    let mut joined: Vec<u8> = Vec::new();
    for raw in bytes.split(|b| *b == b'\n') {
        let raw = raw.trim_ascii_end();
        if let Some(part) = raw.strip_suffix(b"\\") {
            joined.extend_from_slice(part);
            joined.push(b' ');
            continue;
        }
        let whole;
        let line = if joined.is_empty() {
            raw
        } else {
            joined.extend_from_slice(raw);
            whole = std::mem::take(&mut joined);
            &whole[..]
        };
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => {
                let mut coordinate = || number(words.next());
                match (coordinate(), coordinate(), coordinate()) {
                    (Some(x), Some(y), Some(z)) => mesh.vertices.push([x, y, z]),
                    _ => return Err(damaged(at, "a `v` line has not three numbers")),
                }
                limits.allow_vertices(mesh.vertices.len())?;
            }
            Some(b"f") => {
                corners.clear();
                for word in words {
                    corners.push(corner(at, word, mesh.vertices.len())?);
                }
                fan(&mut mesh, &corners, limits)?;
            }
            _ => {}
        }
    }
    Ok(mesh)
}

fn number(word: Option<&[u8]>) -> Option<f32> {
    std::str::from_utf8(word?).ok()?.parse().ok()
}

/// `7`, `7/2`, `7//3` or `-1`: vertices count from one, or backwards from the last one so far.
fn corner(at: &str, word: &[u8], vertices: usize) -> Result<u32, Error> {
    let vertex = word.split(|b| *b == b'/').next().unwrap_or_default();
    let index: i64 = std::str::from_utf8(vertex)
        .ok()
        .and_then(|v| v.parse().ok())
        .ok_or_else(|| damaged(at, "an `f` line has a corner that is no number"))?;
    let from_zero = if index < 0 { index.saturating_add(vertices as i64) } else { index - 1 };
    // A face may name a vertex that comes later: the range is checked at the end.
    u32::try_from(from_zero).map_err(|_| Error::IndexRange {
        at: at.to_owned(),
        vertex: index,
        vertices,
    })
}
