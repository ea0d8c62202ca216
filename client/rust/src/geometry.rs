//! Geometry of a twin.

use bendtwin_core::Point;
use bendtwin_proto::v1::{Tensor, TwinGeometry};

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
    /// Number of surface nodes.
    pub surface_count: usize,
    /// Frames per second.
    pub fps: f64,
    /// Mass of the object, if it is known [kg].
    pub mass_kg: Option<f64>,
    /// Mean length of springs between nodes [m].
    pub spacing_m: f64,
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
        Ok(Self {
            rest_positions: points(wire.rest_positions, "rest_positions")?,
            kinds: kinds.unpack::<u8>("kinds").map_err(Error::malformed)?.1,
            edges: pairs(wire.edges, "edges")?,
            masses: masses.unpack::<f32>("masses").map_err(Error::malformed)?.1,
            controls: points(wire.controls, "controls")?,
            hands: numbers(wire.hands, "hands")?,
            pins: pairs(wire.pins, "pins")?,
            surface_count: wire.surface_count as usize,
            fps: wire.fps,
            mass_kg: wire.mass_kg,
            spacing_m: wire.spacing_m,
        })
    }
}
