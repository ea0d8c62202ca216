//! Geometry of a twin.

use bendtwin_core::{Point, Skin};
use bendtwin_proto::v1::{Tensor, TwinGeometry, twin_geometry};

use crate::Error;

/// Nodes, springs and control points of a twin: N nodes, C control points. The twin's file
/// ([`Twins::download`](crate::Twins::download)) has everything else.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// The rest shape [m], shape [N].
    pub rest_positions: Vec<Point>,
    /// 0 observed surface, 1 completed surface, 2 interior; shape [N]. Surface nodes come first.
    pub kinds: Vec<u8>,
    /// Springs between endpoints; from N on these are control points. Shape [E].
    pub edges: Vec<[u32; 2]>,
    /// Masses [kg], in units of a node if `mass_kg` is not known; shape [N].
    pub masses: Vec<f32>,
    /// Control points at rest [m], shape [C].
    pub controls: Vec<Point>,
    /// The hand of the capture that each control point belongs to, shape [C].
    pub hands: Vec<u32>,
    /// Nodes that control points hold exactly, as pairs of node and control point.
    pub pins: Vec<[u32; 2]>,
    /// Nodes of each rod, in their order.
    pub rods: Vec<Vec<u32>>,
    /// Number of surface nodes.
    pub surface_count: usize,
    /// Frames per second.
    pub fps: f64,
    /// Mass of the object, if it is known [kg].
    pub mass_kg: Option<f64>,
    /// Mean length of springs between nodes [m].
    pub spacing_m: f64,
    /// Points of the surface that the nodes carry.
    pub skin: Skin,
    /// Number of fits: the twin and its members.
    pub fits: usize,
    /// The part of the object that each node belongs to, by its place among the regions of the quality
    /// table's `identifiability`, shape [N]; empty without such a report.
    pub node_regions: Vec<u8>,
    /// Standard deviation of each skin point that the recordings leave [m], root mean square over the
    /// motions of that report; empty without one.
    pub skin_sd_m: Vec<f32>,
}

impl TryFrom<TwinGeometry> for Geometry {
    type Error = Error;
    fn try_from(wire: TwinGeometry) -> Result<Self, Error> {
        let points = |tensor: Option<Tensor>, name| -> Result<Vec<Point>, Error> {
            let tensor = tensor.unwrap_or_default();
            Ok(tensor.unpack_points(name).map_err(Error::malformed)?.1)
        };
        let numbers = |tensor: Option<Tensor>, name| -> Result<Vec<u32>, Error> {
            let tensor = tensor.unwrap_or_default();
            Ok(tensor.unpack::<u32>(name).map_err(Error::malformed)?.1)
        };
        let pairs = |tensor: Option<Tensor>, name| -> Result<Vec<[u32; 2]>, Error> {
            Ok(numbers(tensor, name)?.as_chunks::<2>().0.to_vec())
        };
        let kinds = wire.kinds.unwrap_or_default();
        let masses = wire.masses.unwrap_or_default();
        let rest_positions = points(wire.rest_positions, "rest_positions")?;
        let nodes = rest_positions.len();
        Ok(Self {
            rest_positions,
            kinds: kinds.unpack::<u8>("kinds").map_err(Error::malformed)?.1,
            edges: pairs(wire.edges, "edges")?,
            masses: masses.unpack::<f32>("masses").map_err(Error::malformed)?.1,
            controls: points(wire.controls, "controls")?,
            hands: numbers(wire.hands, "hands")?,
            pins: pairs(wire.pins, "pins")?,
            rods: rods(
                &numbers(wire.rod_starts, "rod_starts")?,
                &numbers(wire.rod_nodes, "rod_nodes")?,
            )?,
            surface_count: wire.surface_count as usize,
            fps: wire.fps,
            mass_kg: wire.mass_kg,
            spacing_m: wire.spacing_m,
            skin: skin(wire.skin.unwrap_or_default(), nodes)?,
            fits: wire.fits.max(1) as usize,
            node_regions: numbers_if_any(wire.node_regions, "node_regions")?,
            skin_sd_m: numbers_if_any(wire.skin_sd, "skin_sd")?,
        })
    }
}

/// Lists of nodes that follow one another, each from its start to the next.
fn rods(starts: &[u32], nodes: &[u32]) -> Result<Vec<Vec<u32>>, Error> {
    let rod = |ends: &[u32]| nodes.get(ends[0] as usize..ends[1] as usize).map(<[u32]>::to_vec);
    let rods: Option<Vec<_>> = starts.windows(2).map(rod).collect();
    rods.ok_or_else(|| Error::malformed("rods without nodes"))
}

/// The skin of a twin with `nodes` nodes, which can be placed without further checks.
pub(super) fn skin(wire: twin_geometry::Skin, nodes: usize) -> Result<Skin, Error> {
    let numbers = |tensor: Option<Tensor>, name| -> Result<Vec<u32>, Error> {
        Ok(tensor.unwrap_or_default().unpack::<u32>(name).map_err(Error::malformed)?.1)
    };
    let weights = wire.weights.unwrap_or_default();
    let offsets = wire.offsets.unwrap_or_default();
    let mut starts = vec![0u32];
    for count in numbers(wire.weight_counts, "skin.weight_counts")? {
        let last = starts.last().copied().unwrap_or_default();
        starts.push(last.saturating_add(count));
    }
    let skin = Skin {
        observed_points: numbers(wire.observed_points, "skin.observed_points")?,
        starts,
        nodes: numbers(wire.weight_nodes, "skin.weight_nodes")?,
        weights: weights.unpack::<f32>("skin.weights").map_err(Error::malformed)?.1,
        frames: numbers(wire.frames, "skin.frames")?.as_chunks::<3>().0.to_vec(),
        offsets_m: offsets.unpack_points("skin.offsets").map_err(Error::malformed)?.1,
    };
    skin.check(nodes).map_err(|fault| Error::malformed(format!("skin: {fault}")))?;
    Ok(skin)
}

/// The numbers of a tensor that a server of an earlier version does not have.
fn numbers_if_any<T: bendtwin_proto::tensor::Element>(
    tensor: Option<Tensor>,
    name: &str,
) -> Result<Vec<T>, Error> {
    tensor.map_or(Ok(Vec::new()), |t| Ok(t.unpack(name).map_err(Error::malformed)?.1))
}
