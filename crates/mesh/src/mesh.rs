//! A triangle mesh as plain data.

use bendtwin_core::{Point, geometry::bounds};

use crate::{Error, Limits, Similarity, Vec3, vec3};

/// Triangles on shared vertices. Nothing is promised of its topology: it may be open, in several
/// parts, or intersect itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions in the mesh's own axes and unit, shape [V, 3].
    pub vertices: Vec<Point>,
    /// Corners, counter-clockwise seen from outside if the maker took care, shape [F, 3].
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The mesh moved by `similarity`.
    pub fn moved(&self, similarity: &Similarity) -> Self {
        Self {
            vertices: self.vertices.iter().map(|v| similarity.apply(*v)).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Area of all triangles [unit²].
    pub fn area(&self) -> f64 {
        self.corners().map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum()
    }

    /// Lowest and highest corner of the box around the vertices; `None` without vertices.
    pub fn bounds(&self) -> Option<[Point; 2]> {
        bounds(&self.vertices)
    }

    /// Corners of the triangles whose vertices exist; [`Mesh::check`] makes that all of them.
    pub(crate) fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.triangles.iter().filter_map(|t| {
            let [a, b, c] = t.map(|i| self.vertices.get(i as usize).map(|v| vec3(*v)));
            Some([a?, b?, c?])
        })
    }

    /// Refuses what no later step could use: no triangles, coordinates that are not finite, missing
    /// corners.
    pub(crate) fn check(&self, at: &str, limits: &Limits) -> Result<(), Error> {
        limits.allow_vertices(self.vertices.len())?;
        limits.allow_triangles(self.triangles.len())?;
        // Far beyond any unit of length; products of such coordinates still fit into f32.
        let usable = |v: &Point| v.iter().all(|x| x.is_finite() && x.abs() < 1e9);
        if let Some(vertex) = self.vertices.iter().position(|v| !usable(v)) {
            return Err(Error::NotFinite { at: at.to_owned(), vertex });
        }
        let vertices = self.vertices.len();
        if let Some(&i) = self.triangles.iter().flatten().find(|i| **i as usize >= vertices) {
            return Err(Error::IndexRange { at: at.to_owned(), vertex: i.into(), vertices });
        }
        if self.area() <= 0.0 {
            return Err(Error::Empty(at.to_owned()));
        }
        Ok(())
    }
}
