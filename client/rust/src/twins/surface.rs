//! Surface of a twin.

use bendtwin_core::{Surface, Tube};
use bendtwin_proto::v1::{Tensor, TwinSurface};

use super::geometry::skin;
use crate::Error;

/// Reads the wire form.
pub(super) fn read(wire: TwinSurface) -> Result<Surface, Error> {
    let numbers = |tensor: Option<Tensor>, name| -> Result<Vec<u32>, Error> {
        Ok(tensor.unwrap_or_default().unpack::<u32>(name).map_err(Error::malformed)?.1)
    };
    let colors = wire.colors.unwrap_or_default();
    let colors = colors.unpack::<u8>("colors").map_err(Error::malformed)?.1;
    let radii = wire.tube_radii.unwrap_or_default();
    let radii = radii.unpack::<f32>("tube_radii").map_err(Error::malformed)?.1;
    let nodes = numbers(wire.tube_nodes, "tube_nodes")?;
    let starts = numbers(wire.tube_starts, "tube_starts")?;
    let tubes = starts.windows(2).zip(radii).map(|(ends, radius_m)| {
        let along = nodes.get(ends[0] as usize..ends[1] as usize);
        let nodes = along.ok_or_else(|| Error::malformed("a tube of nodes that are missing"))?;
        Ok(Tube { nodes: nodes.to_vec(), radius_m })
    });
    let node_count = wire.node_count as usize;
    let surface = Surface {
        carriers: skin(wire.carriers.unwrap_or_default(), node_count)?,
        triangles: numbers(wire.triangles, "triangles")?.as_chunks::<3>().0.to_vec(),
        colors: colors.as_chunks::<3>().0.to_vec(),
        tubes: tubes.collect::<Result<_, Error>>()?,
    };
    surface.check(node_count).map_err(Error::malformed)?;
    Ok(surface)
}
