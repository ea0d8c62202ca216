//! The surface of a twin for the eye: triangles that its nodes carry, and tubes along them.
//!
//! The skin is what a fit compares with the recording: points without a topology. The surface is what people
//! look at: closed, coloured, and no finer than they can see.

use crate::{
    Point, Skin,
    geometry::{Vector, add, cross, dot, scaled, sub, unit, wide},
};

/// Most vertices and triangles of a surface: readers of files know how much work there may be.
pub const MOST_SURFACE: usize = 1_000_000;
/// Vertices around a tube at each of its nodes.
const AROUND: u32 = 8;
/// Largest radius of a tube [m].
const MOST_RADIUS_M: f32 = 10.0;

/// Triangles and tubes that nodes carry. V is the number of vertices that are carried as skin points are; those
/// of the tubes follow them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// The nodes that carry each vertex, and where it is at rest, V points.
    pub carriers: Skin,
    /// Corners, counter-clockwise seen from outside, shape [F, 3].
    pub triangles: Vec<[u32; 3]>,
    /// Colour of each vertex as in images (sRGB), shape [V, 3]; empty if they are not known.
    pub colors: Vec<[u8; 3]>,
    /// Tubes, in a twin of a cable.
    pub tubes: Vec<Tube>,
}

/// A tube along nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Tube {
    /// Nodes, at least 2; the last is the first where the tube is closed.
    pub nodes: Vec<u32>,
    /// Radius [m].
    pub radius_m: f32,
}

impl Surface {
    /// Number of all vertices, those of tubes included.
    pub fn vertex_count(&self) -> usize {
        self.carriers.len() + self.tubes.iter().map(Tube::vertex_count).sum::<usize>()
    }

    /// Positions of all vertices [m], from those of nodes, shape [N, 3].
    pub fn positions(&self, nodes: &[Point]) -> Vec<Point> {
        let mut positions = self.carriers.positions(nodes);
        for tube in &self.tubes {
            tube.add_positions(nodes, &mut positions);
        }
        positions
    }

    /// All triangles, those of tubes included.
    pub fn faces(&self) -> Vec<[u32; 3]> {
        let mut faces = self.triangles.clone();
        let mut first = self.carriers.len() as u32;
        for tube in &self.tubes {
            tube.add_faces(first, &mut faces);
            first += tube.vertex_count() as u32;
        }
        faces
    }

    /// Checks that lengths agree, nodes and vertices exist and numbers are in range.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, node_count: usize) -> Result<(), String> {
        self.carriers.check(node_count).map_err(|why| format!("of the surface: {why}"))?;
        let vertices = self.carriers.len();
        if let Some(i) = self.triangles.iter().flatten().find(|i| **i as usize >= vertices) {
            return Err(format!("a triangle has the corner {i} of {vertices} vertices"));
        }
        let colors = self.colors.len();
        if colors != 0 && colors != vertices {
            return Err(format!(
                "{colors} colours for {vertices} vertices of the surface: one each, or none"
            ));
        }
        for tube in &self.tubes {
            if tube.nodes.len() < 2 || tube.nodes.iter().any(|i| *i as usize >= node_count) {
                return Err(format!("a tube does not run along two or more of {node_count} nodes"));
            }
            if !(tube.radius_m > 0.0 && tube.radius_m <= MOST_RADIUS_M) {
                return Err(format!(
                    "the radius of a tube is {} m: above 0 and up to {MOST_RADIUS_M} are possible",
                    tube.radius_m
                ));
            }
        }
        let size = self.vertex_count().max(self.triangles.len());
        if size > MOST_SURFACE {
            return Err(format!("the surface has {size} parts, at most {MOST_SURFACE} may be"));
        }
        Ok(())
    }
}

impl Tube {
    fn is_closed(&self) -> bool {
        self.nodes.len() > 3 && self.nodes.first() == self.nodes.last()
    }

    /// Nodes with vertices around them: of a closed tube the last is the first.
    fn sections(&self) -> &[u32] {
        &self.nodes[..self.nodes.len() - usize::from(self.is_closed())]
    }

    /// Vertices around the nodes, and one at each end.
    fn vertex_count(&self) -> usize {
        self.sections().len() * AROUND as usize + if self.is_closed() { 0 } else { 2 }
    }

    /// Appends the positions of the vertices. The axes around a node are those around the one before,
    /// turned as little as possible (double reflection, Wang et al. 2008, "Computation of rotation
    /// minimizing frames").
    fn add_positions(&self, nodes: &[Point], positions: &mut Vec<Point>) {
        let sections = self.sections();
        let place = |k: usize| wide(nodes[sections[k] as usize]);
        let last = sections.len() - 1;
        let tangent = |k: usize| {
            let [before, after] = match self.is_closed() {
                true => [(k + last) % (last + 1), (k + 1) % (last + 1)],
                false => [k.saturating_sub(1), (k + 1).min(last)],
            };
            unit_or(sub(place(after), place(before)), [0.0, 0.0, 1.0])
        };
        let mut along = tangent(0);
        let mut across = any_normal(along);
        let radius = f64::from(self.radius_m);
        for k in 0..sections.len() {
            if k > 0 {
                let (step, next) = (sub(place(k), place(k - 1)), tangent(k));
                let moved = reflected(across, step);
                across = reflected(moved, sub(next, reflected(along, step)));
                // Rounding, and steps of no length, must not add up.
                across = sub(across, scaled(next, dot(across, next)));
                across = unit_or(across, any_normal(next));
                along = next;
            }
            let other = cross(along, across);
            for spoke in 0..AROUND {
                let angle = f64::from(spoke) * std::f64::consts::TAU / f64::from(AROUND);
                let offset =
                    add(scaled(across, radius * angle.cos()), scaled(other, radius * angle.sin()));
                positions.push(add(place(k), offset).map(|x| x as f32));
            }
        }
        if !self.is_closed() {
            positions.extend([place(0), place(last)].map(|p| p.map(|x| x as f32)));
        }
    }

    /// Appends the triangles; `first` is the number of the tube's first vertex.
    fn add_faces(&self, first: u32, faces: &mut Vec<[u32; 3]>) {
        let sections = self.sections().len() as u32;
        let vertex =
            |section: u32, spoke: u32| first + section % sections * AROUND + spoke % AROUND;
        let spans = if self.is_closed() { sections } else { sections - 1 };
        for section in 0..spans {
            for spoke in 0..AROUND {
                let [a, b] = [vertex(section, spoke), vertex(section, spoke + 1)];
                let [c, d] = [vertex(section + 1, spoke), vertex(section + 1, spoke + 1)];
                faces.extend([[a, b, d], [a, d, c]]);
            }
        }
        if self.is_closed() {
            return;
        }
        let ends = first + sections * AROUND;
        for spoke in 0..AROUND {
            let [start, next] = [vertex(0, spoke), vertex(0, spoke + 1)];
            faces.push([ends, next, start]);
            let [start, next] = [vertex(sections - 1, spoke), vertex(sections - 1, spoke + 1)];
            faces.push([ends + 1, start, next]);
        }
    }
}

/// A vector reflected at the plane through the origin that is perpendicular to `at`.
fn reflected(v: Vector, at: Vector) -> Vector {
    let square = dot(at, at);
    if square > 0.0 { sub(v, scaled(at, 2.0 * dot(at, v) / square)) } else { v }
}

fn unit_or(v: Vector, other: Vector) -> Vector {
    unit(v).unwrap_or(other)
}

/// A unit vector perpendicular to another.
fn any_normal(along: Vector) -> Vector {
    let axis = if along[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    unit_or(sub(axis, scaled(along, dot(along, axis))), [0.0, 1.0, 0.0])
}

#[cfg(test)]
mod tests;
