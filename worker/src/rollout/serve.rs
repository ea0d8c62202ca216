//! The model of a twin that answers a request: the exact one, or the fast one, which is made when
//! it is first asked for.

use std::{collections::HashSet, sync::Arc};

use bendtwin_core::{FastVariant, Fidelity};
use bendtwin_engine::{Backend as _, Loaded, fidelity::Reduction};
use bendtwin_proto::rollout;

use super::{error::Error, rest_shape::RestShape, warm::Warm};
use crate::device::{Device, Priority};

/// A twin and the model of it that answers.
#[derive(Clone)]
pub(super) struct Served {
    pub(super) warm: Arc<Warm>,
    pub(super) loaded: Loaded,
    /// The variant, if the fast one answers.
    pub(super) fast: Option<FastVariant>,
    /// Rest shapes that are not the twin's: one for all instances, or one for each; empty: none.
    pub(super) rests: Vec<Option<Arc<RestShape>>>,
}

impl Served {
    /// The model that follows a twin as finely as asked for.
    pub(super) async fn choose(
        warm: Arc<Warm>,
        fidelity: Fidelity,
        device: &Device,
    ) -> Result<Self, Error> {
        match fidelity {
            Fidelity::Exact => Ok(Self::exact(warm)),
            Fidelity::Fast => Self::fast(warm, device).await,
        }
    }

    /// The exact model.
    pub(super) fn exact(warm: Arc<Warm>) -> Self {
        let loaded = warm.loaded.clone();
        Self { warm, loaded, fast: None, rests: Vec::new() }
    }

    /// Number of rest shapes that are not the twin's.
    pub(super) fn distinct_rests(&self) -> usize {
        self.rests.iter().flatten().map(Arc::as_ptr).collect::<HashSet<_>>().len()
    }

    async fn fast(warm: Arc<Warm>, device: &Device) -> Result<Self, Error> {
        let missing = || rollout::Error::NoFastVariant { twin: warm.id.to_string() };
        let fast = warm.twin.quality.fast.ok_or_else(missing)?;
        let load = || async {
            let backend = device.backend(Priority::Interactive);
            let exact = Arc::clone(warm.loaded.model());
            let load = move || backend.load(Arc::new(Reduction::from(&fast).apply(&exact)));
            let loaded = tokio::task::spawn_blocking(load).await.map_err(|_| Error::Panicked)??;
            tracing::info!(twin = %warm.id, substeps = fast.substeps, "fast variant loaded");
            Ok::<_, Error>(loaded)
        };
        let loaded = warm.fast.get_or_try_init(load).await?.clone();
        Ok(Self { warm, loaded, fast: Some(fast), rests: Vec::new() })
    }
}
