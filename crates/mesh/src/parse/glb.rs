//! Binary glTF 2.0: one JSON chunk and one chunk of data. Node transforms are applied, all
//! primitives become triangles.

mod accessor;
mod document;
mod scene;

use nalgebra::{Matrix3, Matrix4};

use self::{
    accessor::Data,
    document::{Document, Primitive},
};
use super::damaged;
use crate::{Error, Limits, Mesh, Vec3, point};

const JSON_CHUNK: &[u8] = b"JSON";
const DATA_CHUNK: &[u8] = b"BIN\0";
/// Three bytes of JSON make a node of fifty times their size.
const MAX_JSON_BYTES: usize = 4 << 20;

pub(super) fn read(at: &str, bytes: &[u8], limits: &Limits) -> Result<Mesh, Error> {
    let (json, binary) = chunks(at, bytes)?;
    if json.len() > MAX_JSON_BYTES {
        return Err(Error::TooLarge {
            at: at.to_owned(),
            bytes: json.len() as u64,
            limit: MAX_JSON_BYTES as u64,
        });
    }
    let document: Document = serde_json::from_slice(json)
        .map_err(|e| damaged(at, format!("its JSON is not as specified: {e}")))?;
    document.check(at)?;
    let data = Data { at, document: &document, binary };
    let mut mesh = Mesh::default();
    let mut parts = 0_usize;
    scene::visit(at, &document, |index, transform| {
        let entry = document
            .meshes
            .get(index)
            .ok_or_else(|| damaged(at, "a node shows a mesh that is not there"))?;
        // Many nodes may show one mesh of many parts: empty ones, too, take time.
        parts = parts.saturating_add(entry.primitives.len());
        limits.allow_triangles(parts)?;
        entry.primitives.iter().try_for_each(|p| append(&data, p, transform, &mut mesh, limits))
    })?;
    Ok(mesh)
}

/// The JSON and the data.
fn chunks<'a>(at: &str, bytes: &'a [u8]) -> Result<(&'a [u8], &'a [u8]), Error> {
    let cut_off = || damaged(at, "it is cut off");
    let (header, rest) = bytes.split_at_checked(12).ok_or_else(cut_off)?;
    if &header[..4] != b"glTF" {
        return Err(damaged(at, "it does not start as a GLB file"));
    }
    if number(&header[4..]) != 2 {
        return Err(damaged(at, "it is not glTF 2.0"));
    }
    let claimed = number(&header[8..]);
    if claimed > bytes.len() {
        let (claimed, present) = (claimed as u64, bytes.len() as u64);
        return Err(Error::Absurd { at: at.to_owned(), claimed, present });
    }
    let (json, rest) = chunk(rest, JSON_CHUNK).ok_or_else(cut_off)?;
    // A scene without data has no second chunk.
    let data = chunk(rest, DATA_CHUNK).map_or(&[][..], |(data, _)| data);
    Ok((json, data))
}

fn chunk<'a>(bytes: &'a [u8], kind: &[u8]) -> Option<(&'a [u8], &'a [u8])> {
    let (header, rest) = bytes.split_at_checked(8)?;
    (&header[4..] == kind).then_some(())?;
    rest.split_at_checked(number(header))
}

/// The first four bytes as a number.
fn number(bytes: &[u8]) -> usize {
    bytes.iter().take(4).rev().fold(0, |n, b| n << 8 | usize::from(*b))
}

fn append(
    data: &Data<'_>,
    primitive: &Primitive,
    transform: &Matrix4<f64>,
    mesh: &mut Mesh,
    limits: &Limits,
) -> Result<(), Error> {
    const TRIANGLES: u32 = 4;
    const STRIP: u32 = 5;
    const FAN: u32 = 6;
    let mode = primitive.mode.unwrap_or(TRIANGLES);
    // Points and lines have no surface.
    if !(TRIANGLES..=FAN).contains(&mode) {
        return Ok(());
    }
    let positions = data.positions(primitive)?;
    let first = mesh.vertices.len();
    limits.allow_vertices(first.saturating_add(positions.count))?;
    let (linear, shift) = (linear(transform), transform.column(3).xyz());
    mesh.vertices.extend((0..positions.count).map(|i| {
        let [x, y, z] = positions.vector(i);
        point(linear * Vec3::new(x, y, z) + shift)
    }));

    let indices = primitive.indices.map(|i| data.indices(i)).transpose()?;
    let count = indices.as_ref().map_or(positions.count, |i| i.count);
    let triangles = match mode {
        TRIANGLES => count / 3,
        _ => count.saturating_sub(2),
    };
    limits.allow_triangles(mesh.triangles.len().saturating_add(triangles))?;
    let at = |slot: usize| indices.as_ref().map_or(slot as u64, |i| i.index(slot));
    // A mirrored part shows its inside.
    let mirrored = linear.determinant() < 0.0;
    for t in 0..triangles {
        let [a, mut b, mut c] = match mode {
            TRIANGLES => [at(3 * t), at(3 * t + 1), at(3 * t + 2)],
            STRIP if t % 2 == 1 => [at(t + 1), at(t), at(t + 2)],
            STRIP => [at(t), at(t + 1), at(t + 2)],
            _ => [at(0), at(t + 1), at(t + 2)],
        };
        if mirrored {
            std::mem::swap(&mut b, &mut c);
        }
        let mut triangle = [0; 3];
        for (corner, index) in triangle.iter_mut().zip([a, b, c]) {
            if index >= positions.count as u64 {
                return Err(Error::IndexRange {
                    at: data.at.to_owned(),
                    vertex: index as i64,
                    vertices: positions.count,
                });
            }
            *corner = u32::try_from(first as u64 + index)
                .map_err(|_| damaged(data.at, "it has too many vertices"))?;
        }
        mesh.triangles.push(triangle);
    }
    Ok(())
}

fn linear(transform: &Matrix4<f64>) -> Matrix3<f64> {
    transform.fixed_view::<3, 3>(0, 0).into_owned()
}
