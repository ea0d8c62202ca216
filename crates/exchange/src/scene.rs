//! The content of a file: a twin, the points of it that are wanted, and their motion.

use std::borrow::Cow;

use bendtwin_core::{
    Point, Surface, Twin,
    geometry::{bounds, length, sub},
};
use bendtwin_graph::{SurfacePoints, bind_points};
use bendtwin_mesh::Mesh;

use crate::{Error, Format};

/// Points of a twin that are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointSet<'a> {
    /// Nodes, and the springs between them as lines.
    Nodes,
    /// The points of its skin.
    Skin,
    /// The surface of the twin file, or one that is made here for a twin without.
    Surface,
    /// The vertices of a mesh that lies around the twin at rest, in its coordinates: they are
    /// carried by the nodes, as the skin is.
    Mesh(&'a Mesh),
}

/// Positions over time, shape [F, N, 3] and [F, C, 3].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Times of the frames since the rollout's start [s], shape [F].
    pub times_s: Vec<f64>,
    /// Nodes [m], shape [F, N, 3].
    pub nodes: Vec<Point>,
    /// Control points [m], shape [F, C, 3]; empty if they are not known.
    pub controls: Vec<Point>,
}

/// A twin at rest or in motion, ready to be written.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    name: String,
    twin: &'a Twin,
    points: PointSet<'a>,
    motion: Option<&'a Motion>,
    /// The points as nodes carry them, with the triangles on them; without vertices where the points are nodes.
    carried: Cow<'a, Surface>,
    /// Triangles on the points.
    triangles: Vec<[u32; 3]>,
    /// Springs between nodes, shape [E'].
    lines: Vec<[u32; 2]>,
}

impl<'a> Scene<'a> {
    /// A scene; `name` is for people.
    ///
    /// # Errors
    /// If the motion is not the twin's, or not finite, or the twin has no such points.
    pub fn new(
        name: &str,
        twin: &'a Twin,
        points: PointSet<'a>,
        motion: Option<&'a Motion>,
    ) -> Result<Self, Error> {
        let (n, c) = (twin.graph.node_count(), twin.graph.control_count());
        if let Some(motion) = motion {
            check(motion, n, c)?;
        }
        let carried = match points {
            PointSet::Nodes => Cow::Owned(Surface::default()),
            PointSet::Skin => Cow::Owned(Surface {
                carriers: twin.skin.clone(),
                colors: twin
                    .appearance
                    .as_ref()
                    .map_or_else(Vec::new, |look| look.skin_colors.clone()),
                ..Surface::default()
            }),
            PointSet::Surface => bendtwin_surface::of_twin(twin).unwrap_or_default(),
            PointSet::Mesh(mesh) => {
                check_place(mesh, &twin.graph.rest_positions)?;
                let observed_points = vec![u32::MAX; mesh.vertices.len()];
                let surface = SurfacePoints { positions: mesh.vertices.clone(), observed_points };
                let carriers = bind_points(&twin.graph, &twin.graph.rest_positions, &surface);
                // Without nodes there is nothing for triangles to be on.
                let has_carriers = !carriers.is_empty();
                let triangles = mesh.triangles.iter().filter(|_| has_carriers).copied().collect();
                Cow::Owned(Surface { carriers, triangles, ..Surface::default() })
            }
        };
        let missing = match points {
            PointSet::Nodes => (n == 0).then_some("nodes"),
            PointSet::Skin => carried.carriers.is_empty().then_some("skin"),
            PointSet::Surface => {
                (carried.vertex_count() == 0).then_some("points enough for a surface")
            }
            PointSet::Mesh(_) => carried.carriers.is_empty().then_some("nodes that carry a mesh"),
        };
        if let Some(missing) = missing {
            return Err(Error::NoPoints(missing));
        }
        let lines = match points {
            PointSet::Nodes => {
                twin.graph.springs.iter().filter(|s| (s[1] as usize) < n).copied().collect()
            }
            _ => Vec::new(),
        };
        let triangles = carried.faces();
        Ok(Self { name: name.to_owned(), twin, points, motion, carried, triangles, lines })
    }

    /// The points that a format is for: the surface where programs show them, unless a few nodes have none, and else
    /// the nodes.
    ///
    /// # Errors
    /// If the motion is not the twin's, or not finite, or the twin has no nodes.
    pub fn of_format(
        name: &str,
        twin: &'a Twin,
        format: Format,
        motion: Option<&'a Motion>,
    ) -> Result<Self, Error> {
        if format.shows() {
            match Self::new(name, twin, PointSet::Surface, motion) {
                Err(Error::NoPoints(_)) => {}
                scene => return scene,
            }
        }
        Self::new(name, twin, PointSet::Nodes, motion)
    }

    /// Name for people.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn twin(&self) -> &'a Twin {
        self.twin
    }

    pub(crate) fn points(&self) -> PointSet<'a> {
        self.points
    }

    pub(crate) fn motion(&self) -> Option<&'a Motion> {
        self.motion
    }

    /// Springs between nodes, as pairs of points; empty where the points are not nodes.
    pub(crate) fn lines(&self) -> &[[u32; 2]] {
        &self.lines
    }

    /// Triangles on the points; empty without a surface or a mesh.
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Colour of each point as in images (sRGB), shape [P, 3]; empty if they are not known.
    pub(crate) fn colors(&self) -> &[[u8; 3]] {
        if self.carried.tubes.is_empty() { &self.carried.colors } else { &[] }
    }

    /// Frames of the motion; 1 at rest.
    pub(crate) fn frame_count(&self) -> usize {
        self.motion.map_or(1, |m| m.times_s.len())
    }

    /// Times of the frames [s]; a single 0 at rest.
    pub(crate) fn times_s(&self) -> Cow<'a, [f64]> {
        self.motion.map_or(Cow::Owned(vec![0.0]), |m| Cow::Borrowed(&m.times_s[..]))
    }

    /// Number of points P.
    pub(crate) fn point_count(&self) -> usize {
        match self.points {
            PointSet::Nodes => self.twin.graph.node_count(),
            _ => self.carried.vertex_count(),
        }
    }

    /// Nodes in a frame [m], shape [N, 3]; at rest without a motion.
    fn nodes_at(&self, frame: usize) -> &'a [Point] {
        let n = self.twin.graph.node_count();
        self.motion
            .and_then(|m| m.nodes.get(frame * n..(frame + 1) * n))
            .unwrap_or(&self.twin.graph.rest_positions)
    }

    /// The points in a frame [m], shape [P, 3].
    pub(crate) fn points_at(&self, frame: usize) -> Cow<'a, [Point]> {
        let nodes = self.nodes_at(frame);
        match self.points {
            PointSet::Nodes => Cow::Borrowed(nodes),
            _ => Cow::Owned(self.carried.positions(nodes)),
        }
    }

    /// Control points in a frame [m], shape [C, 3]; empty if they are not known.
    pub(crate) fn controls_at(&self, frame: usize) -> &'a [Point] {
        let c = self.twin.graph.control_count();
        match self.motion {
            Some(motion) => motion.controls.get(frame * c..(frame + 1) * c).unwrap_or_default(),
            None => &self.twin.graph.control_rest,
        }
    }
}

/// The light of a colour of images (sRGB), each channel 0..=1.
pub(crate) fn linear(color: [u8; 3]) -> [f64; 3] {
    color.map(|channel| bendtwin_image_metrics::linear(f64::from(channel) / 255.0))
}

/// Refuses a mesh that lies apart from the nodes or is of another size: in other units or axes, it
/// would be carried along far away from them.
fn check_place(mesh: &Mesh, nodes: &[Point]) -> Result<(), Error> {
    let (Some(a), Some(b)) = (mesh.bounds(), bounds(nodes)) else { return Ok(()) };
    let size_m = |[low, high]: [Point; 2]| length(sub(low, high));
    let (mesh_m, twin_m) = (size_m(a), size_m(b));
    let centre = |[low, high]: [Point; 2]| std::array::from_fn(|i| (low[i] + high[i]) / 2.0);
    let apart_m = length(sub(centre(a), centre(b)));
    let sizes = mesh_m / twin_m.max(f32::MIN_POSITIVE);
    if apart_m > twin_m.max(mesh_m) || !(0.1..=10.0).contains(&sizes) {
        return Err(Error::MeshElsewhere { mesh_m, twin_m, apart_m });
    }
    Ok(())
}

fn check(motion: &Motion, nodes: usize, controls: usize) -> Result<(), Error> {
    let frames = motion.times_s.len();
    let shape = |what, found, needed| {
        if found == needed { Ok(()) } else { Err(Error::MotionShape { what, found, needed }) }
    };
    shape("frames", frames, frames.max(1))?;
    shape("node positions", motion.nodes.len(), frames * nodes)?;
    if !motion.controls.is_empty() {
        shape("control positions", motion.controls.len(), frames * controls)?;
    }
    let bad = |points: &[Point], width: usize| {
        let at = points.iter().position(|p| !p.iter().all(|x| x.is_finite()));
        at.and_then(|at| at.checked_div(width))
    };
    let time = motion.times_s.iter().position(|t| !t.is_finite());
    let bad = bad(&motion.nodes, nodes).or_else(|| bad(&motion.controls, controls)).or(time);
    bad.map_or(Ok(()), |frame| Err(Error::NotFinite { frame }))
}

#[cfg(test)]
mod tests;
