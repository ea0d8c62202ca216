//! A loaded twin, which answers immediately.

use std::sync::{Arc, Mutex};

use bendtwin_budget::Share;
use bendtwin_core::{Twin, ids::TwinId};
use bendtwin_engine::{Backend, Loaded, Model, backend};

use crate::{pictures::look::Looks, twin::planner::PlannersWarm};

/// A twin on a device.
pub struct Warm {
    pub(crate) id: TwinId,
    pub(crate) twin: Twin,
    pub(crate) loaded: Loaded,
    /// The fast variant, once a request has asked for it.
    pub(super) fast: Mutex<Option<Loaded>>,
    /// The planner's twin, once a request has asked for it.
    pub(super) planner: Mutex<Option<Arc<PlannersWarm>>>,
    /// Members of the twin, as many as requests have asked for.
    pub(super) members: Mutex<Vec<Loaded>>,
    /// How it looks, once a picture has been taken.
    pub(crate) look: Looks,
    /// Memory of it all, where that is counted.
    _share: Option<Share>,
}

impl Warm {
    /// Loads a twin, in memory that was taken for it.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn load(
        id: TwinId,
        twin: Twin,
        backend: &dyn Backend,
        share: Option<Share>,
    ) -> Result<Self, backend::Error> {
        let loaded = backend.load(Arc::new(Model::from(&twin)))?;
        Ok(Self::new(id, twin, loaded, share))
    }

    /// A twin with its model on a device.
    pub(crate) fn new(id: TwinId, twin: Twin, loaded: Loaded, share: Option<Share>) -> Self {
        Self {
            id,
            twin,
            loaded,
            fast: Mutex::default(),
            planner: Mutex::default(),
            members: Mutex::default(),
            look: Looks::default(),
            _share: share,
        }
    }

    /// Id of the twin.
    pub fn id(&self) -> TwinId {
        self.id
    }

    /// The twin.
    pub fn twin(&self) -> &Twin {
        &self.twin
    }
}
