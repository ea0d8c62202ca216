//! Stanford PLY: ASCII, binary little-endian and binary big-endian.

mod header;

use self::header::{Element, Encoding, Property, Scalar};
use super::{damaged, fan};
use crate::{Error, Limits, Mesh};

pub(super) fn read(at: &str, bytes: &[u8], limits: &Limits) -> Result<Mesh, Error> {
    let (header, body) = header::read(at, bytes)?;
    let mut values = Values { at, encoding: header.encoding, left: body };
    let mut mesh = Mesh::default();
    for element in &header.elements {
        values.check_size(element)?;
        match element.name.as_str() {
            "vertex" => read_vertices(&mut values, element, &mut mesh, limits)?,
            "face" => read_faces(&mut values, element, &mut mesh, limits)?,
            "tristrips" => {
                return Err(Error::Unsupported {
                    at: at.to_owned(),
                    what: "triangle strips".to_owned(),
                });
            }
            _ => {
                for _ in 0..element.count {
                    for property in &element.properties {
                        values.property(property, |_| Ok(()))?;
                    }
                }
            }
        }
    }
    Ok(mesh)
}

fn read_vertices(
    values: &mut Values<'_>,
    element: &Element,
    mesh: &mut Mesh,
    limits: &Limits,
) -> Result<(), Error> {
    limits.allow_vertices(mesh.vertices.len().saturating_add(element.count))?;
    let axis = |p: &Property| ["x", "y", "z"].iter().position(|n| *n == p.name);
    let axes: Vec<Option<usize>> = element.properties.iter().map(axis).collect();
    if (0..3).any(|a| !axes.contains(&Some(a))) {
        return Err(damaged(values.at, "its vertices have no x, y and z"));
    }
    for _ in 0..element.count {
        let mut vertex = [0.0; 3];
        for (property, axis) in element.properties.iter().zip(&axes) {
            values.property(property, |value| {
                if let Some(a) = axis {
                    vertex[*a] = value as f32;
                }
                Ok(())
            })?;
        }
        mesh.vertices.push(vertex);
    }
    Ok(())
}

fn read_faces(
    values: &mut Values<'_>,
    element: &Element,
    mesh: &mut Mesh,
    limits: &Limits,
) -> Result<(), Error> {
    let mut corners: Vec<u32> = Vec::new();
    let at = values.at;
    for _ in 0..element.count {
        corners.clear();
        for property in &element.properties {
            let holds_corners = property.length.is_some()
                && matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
            values.property(property, |value| {
                if holds_corners {
                    if !(0.0..=f64::from(u32::MAX)).contains(&value) {
                        return Err(damaged(at, "a face names no vertex"));
                    }
                    corners.push(value as u32);
                }
                Ok(())
            })?;
        }
        fan(mesh, &corners, limits)?;
    }
    Ok(())
}

/// The numbers after the header, one after another.
struct Values<'a> {
    at: &'a str,
    encoding: Encoding,
    left: &'a [u8],
}

impl Values<'_> {
    /// Refuses an element that needs more bytes than are left, for any content of its lists.
    fn check_size(&self, element: &Element) -> Result<(), Error> {
        let least: usize = element
            .properties
            .iter()
            .map(|p| match self.encoding {
                // A digit and what separates it from the next one.
                Encoding::Ascii => 2,
                _ => p.length.unwrap_or(p.scalar).size(),
            })
            .sum();
        let claimed = (element.count as u64).saturating_mul(least as u64);
        // The last number of a file needs no separator.
        if claimed > self.left.len() as u64 + 1 {
            return Err(Error::Absurd {
                at: self.at.to_owned(),
                claimed,
                present: self.left.len() as u64,
            });
        }
        Ok(())
    }

    /// Hands the value of a property, or all values of a list, to `take`.
    fn property(
        &mut self,
        property: &Property,
        mut take: impl FnMut(f64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let Some(length) = property.length else { return take(self.next(property.scalar)?) };
        let count = self.next(length)?;
        if !(0.0..=self.left.len() as f64).contains(&count) {
            return Err(damaged(self.at, "a list claims more than there is"));
        }
        for _ in 0..count as usize {
            take(self.next(property.scalar)?)?;
        }
        Ok(())
    }

    fn next(&mut self, scalar: Scalar) -> Result<f64, Error> {
        let value = match self.encoding {
            Encoding::Ascii => self.word(),
            Encoding::Little => self.take(scalar.size()).map(|b| scalar.little(b)),
            Encoding::Big => self.take(scalar.size()).map(|b| scalar.big(b)),
        };
        value.ok_or_else(|| damaged(self.at, "it is cut off or holds what is no number"))
    }

    fn take(&mut self, size: usize) -> Option<[u8; 8]> {
        let (head, rest) = self.left.split_at_checked(size)?;
        self.left = rest;
        let mut out = [0; 8];
        out[..size].copy_from_slice(head);
        Some(out)
    }

    fn word(&mut self) -> Option<f64> {
        let text = self.left.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.left = rest;
        std::str::from_utf8(word).ok()?.parse().ok()
    }
}
