//! Limits on the size of a mesh.

use crate::Error;

/// Caps on what a reader accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the file.
    pub file_bytes: u64,
    /// Vertices of all parts together, each as often as a scene shows it.
    pub vertices: usize,
    /// Triangles of all parts together.
    pub triangles: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { file_bytes: 256 << 20, vertices: 2_000_000, triangles: 4_000_000 }
    }
}

impl Limits {
    pub(crate) fn allow_vertices(&self, count: usize) -> Result<(), Error> {
        allow("vertices", count, self.vertices)
    }

    pub(crate) fn allow_triangles(&self, count: usize) -> Result<(), Error> {
        allow("triangles", count, self.triangles)
    }
}

fn allow(what: &'static str, count: usize, limit: usize) -> Result<(), Error> {
    if count > limit { Err(Error::TooMany { what, count, limit }) } else { Ok(()) }
}
