//! How a loaded twin looks: made when the first picture is taken, and kept with the twin.

use std::sync::{Arc, OnceLock};

use bendtwin_appearance::Dressed;
use bendtwin_core::{
    Point, Twin,
    geometry::{length, sub},
};
use bendtwin_render::Mesh;

use crate::error::Error;

/// Radius of the balls of a twin without a surface, over the distance of neighbouring nodes, and its bounds [m].
const BALL: f32 = 0.35;
const BALLS_M: [f32; 2] = [0.001, 0.02];
/// Nodes among which neighbours are looked for.
const MOST_COMPARED: usize = 256;

/// The looks of a twin. They take less memory than the twin's models.
#[derive(Default)]
pub(crate) struct Looks {
    mesh: OnceLock<Arc<Mesh>>,
    gaussians: OnceLock<Option<Arc<Dressed>>>,
}

impl Looks {
    /// The surface of the twin, or balls at its nodes if they have none.
    pub(super) fn mesh(&self, twin: &Twin) -> Arc<Mesh> {
        let make = || {
            Arc::new(match bendtwin_surface::of_twin(twin) {
                None => Mesh::of_balls(ball_m(twin)),
                Some(surface) => {
                    let colors = bendtwin_surface::vertex_colors(twin, &surface);
                    Mesh::new(surface.into_owned(), &colors)
                }
            })
        };
        Arc::clone(self.mesh.get_or_init(make))
    }

    /// The Gaussians of the twin, if it has any.
    ///
    /// # Errors
    /// If they do not fit the twin.
    pub(super) fn gaussians(&self, twin: &Twin) -> Result<Option<Arc<Dressed>>, Error> {
        if let Some(known) = self.gaussians.get() {
            return Ok(known.clone());
        }
        let splats = twin.appearance.as_ref().and_then(|look| look.splats.as_ref());
        let splats = splats.filter(|splats| !splats.scales_m.is_empty());
        let dressed = splats.map(|splats| Dressed::new(&twin.graph, splats)).transpose()?;
        Ok(self.gaussians.get_or_init(|| dressed.map(Arc::new)).clone())
    }
}

/// Radius of a ball at each node [m].
fn ball_m(twin: &Twin) -> f32 {
    let nodes = &twin.graph.rest_positions;
    let nodes = &nodes[..nodes.len().min(MOST_COMPARED)];
    let spacing = |(i, p): (usize, &Point)| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, q)| length(sub(*p, *q))).fold(f32::INFINITY, f32::min)
    };
    let mut spacings: Vec<f32> = nodes.iter().enumerate().map(spacing).collect();
    spacings.sort_by(f32::total_cmp);
    let median = spacings.get(spacings.len() / 2).copied().unwrap_or_default();
    (BALL * median).clamp(BALLS_M[0], BALLS_M[1])
}
