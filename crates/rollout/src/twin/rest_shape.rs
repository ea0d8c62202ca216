//! Rest shapes of simulations of which corrections have changed it.

use bendtwin_budget::Share;
use bendtwin_core::{Graph, Params};

/// A rest shape that is not the twin's own.
#[derive(Debug)]
pub struct RestShape {
    /// Rest lengths [m], shape [E].
    lengths_m: Vec<f32>,
    /// Rest angles [rad], shape [T].
    angles_rad: Vec<f32>,
    /// Memory of it; none in tests.
    _share: Option<Share>,
}

impl RestShape {
    /// The rest shape of these parameters, in memory that was taken for it.
    pub(crate) fn new(params: Params, share: Option<Share>) -> Self {
        let Params { rest_lengths_m: lengths_m, rest_angles_rad: angles_rad, .. } = params;
        Self { lengths_m, angles_rad, _share: share }
    }

    /// Memory of a rest shape of a twin [bytes].
    pub fn bytes(graph: &Graph) -> u64 {
        4 * (graph.springs.len() + graph.triplets.len()) as u64
    }

    /// Puts it in the place of that of other parameters of the twin.
    pub(crate) fn put_into(&self, params: &mut Params) {
        params.rest_lengths_m.clone_from(&self.lengths_m);
        params.rest_angles_rad.clone_from(&self.angles_rad);
    }
}
