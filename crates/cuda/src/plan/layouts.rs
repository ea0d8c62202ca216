//! Layouts of one graph by how it is cut, on the host: the choice of a team compares several, and
//! only those that it takes go to the device.

use std::sync::Arc;

use bendtwin_core::Graph;
use bendtwin_engine::Error;

use crate::{
    device::{memo::Memo, team::Team},
    plan::layout::{Incidence, Layout},
};

/// Cut of a graph into a number of blocks, for about this many threads each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Cut {
    pub(crate) blocks: u32,
    pub(crate) threads: u32,
}

impl Cut {
    /// The cut for a team.
    pub(crate) fn of(team: &Team) -> Self {
        Self { blocks: team.blocks, threads: team.threads }
    }
}

/// Layouts of a graph, each made at first use.
pub(crate) struct Layouts {
    graph: Arc<Graph>,
    /// Incidence, the same for every cut.
    incidence: Memo<(), Arc<Incidence>>,
    made: Memo<Cut, Arc<Layout>>,
}

impl Layouts {
    /// Layouts of a checked graph.
    pub(crate) fn new(graph: Arc<Graph>) -> Self {
        Self { graph, incidence: Memo::default(), made: Memo::default() }
    }

    /// The layout for a cut.
    ///
    /// # Errors
    /// If a block would see more nodes than its indices can name.
    pub(crate) fn of(&self, cut: Cut) -> Result<Arc<Layout>, Error> {
        self.made.get_or_make(cut, || {
            let make = || Ok::<_, Error>(Arc::new(Incidence::new(&self.graph)));
            let incidence = self.incidence.get_or_make((), make)?;
            let layout = Layout::cut(&self.graph, &incidence, cut.blocks as usize, cut.threads)?;
            Ok(Arc::new(layout))
        })
    }
}
