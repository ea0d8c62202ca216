//! The surface of a fit's twin, in the colours of its skin.

use std::borrow::Cow;

use bendtwin_core::{Point, Twin};
use bendtwin_surface::surface_of;

use super::{Outcome, Run};

impl Run<'_> {
    /// Gives the twin of an outcome its surface. The axial one is only compared with it.
    pub(super) fn wrap(&self, Outcome { twin, .. }: &mut Outcome) {
        let colors = match &twin.appearance {
            Some(look) => Cow::Borrowed(&look.skin_colors),
            None => Cow::Owned(recorded_colors(twin, &self.job.capture.object.colors)),
        };
        let surface = surface_of(twin, &colors);
        twin.surface = surface;
    }
}

/// The colour of each skin point: that of the nearest one that is a tracked point of a known colour. Empty if the
/// recording has no colours.
fn recorded_colors(twin: &Twin, recorded: &[Point]) -> Vec<[u8; 3]> {
    let of_point = |observed: &u32| recorded.get(*observed as usize);
    let observed = &twin.skin.observed_points;
    let known: Vec<usize> =
        (0..observed.len()).filter(|m| of_point(&observed[*m]).is_some()).collect();
    if known.is_empty() {
        return Vec::new();
    }
    let positions = twin.skin.positions(&twin.graph.rest_positions);
    let tree = bendtwin_near::PointTree::new(known.iter().map(|m| positions[*m]));
    let nearest = |p: &Point| tree.closest(*p).map_or(known[0], |near| known[near.number as usize]);
    let bytes = |color: &Point| color.map(|x| (255.0 * x).round().clamp(0.0, 255.0) as u8);
    let color = |m: usize| of_point(&observed[m]).map(bytes).unwrap_or_default();
    positions.iter().map(|p| color(nearest(p))).collect()
}
