//! Preparation of a model on the host, as a device would need it, without a device: for timing and
//! for counting kernels.

use std::{
    collections::hash_map::DefaultHasher,
    hash::{Hash, Hasher},
};

use bendtwin_engine::{Error, Model};

use crate::{
    device::{Capabilities, specialization::WorldParts},
    plan::{
        choice::{Purpose, Shapes, choose},
        layouts::Layouts,
    },
};

/// Chip, as far as a choice of launches asks.
#[derive(Clone, Copy, Debug)]
pub struct Chip {
    /// Multiprocessors.
    pub processors: u32,
    /// Shared memory that a block can have [bytes].
    pub shared_bytes: u32,
    /// Blocks of the largest cluster; 1 without clusters.
    pub cluster: u32,
}

impl Chip {
    /// NVIDIA H100 and H200 (SXM).
    pub const HOPPER: Self = Self { processors: 132, shared_bytes: 227 << 10, cluster: 16 };
}

/// The launch of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prepared {
    /// The team of blocks that simulates an instance.
    pub team: String,
    /// Equal for launches that share a compiled kernel, in one process.
    pub kernel: u64,
}

/// Cuts a checked model's graph for a batch of instances with separate graphs, and chooses its
/// forward launch.
///
/// # Errors
/// If no team can hold the model.
pub fn prepare(model: &Model, chip: &Chip, batch: usize) -> Result<Prepared, Error> {
    let layouts = Layouts::new(model.graph.clone());
    let first = model.params.spring_dashpot.first();
    let shapes = Shapes {
        layouts: &layouts,
        uniform_dashpot: model.params.spring_dashpot.iter().all(|d| Some(d) == first),
        team: None,
    };
    let Chip { processors, shared_bytes, cluster } = *chip;
    let capabilities = Capabilities { processors, shared_bytes, cluster };
    let world = WorldParts::default();
    let plan = choose(&capabilities, &shapes, model, Purpose::Forward, world, batch, 1)?;
    let mut hasher = DefaultHasher::new();
    plan.specialization.hash(&mut hasher);
    Ok(Prepared { team: plan.team.to_string(), kernel: hasher.finish() })
}
