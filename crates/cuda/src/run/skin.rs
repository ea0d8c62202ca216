//! Skins of scored instances, and d loss / d their points at frame ends on its way to the nodes.

use std::sync::Arc;

use bendtwin_engine::{Error, backend::Instance};

use crate::{
    device::{
        args::{ObjectiveArgs, Pointer, SeedSkinArgs, SkinArgs},
        kernels,
        memory::{Buffer, end_of},
        queue::Queue,
        specialization::THREADS,
    },
    plan::{resident::resident, skin::DeviceSkinByNode},
    run::objective::{DeviceObjective, skin_frames},
};

/// Skins of instances whose objectives have terms there.
pub(crate) struct Skins {
    /// Arguments by instance, empty without such terms.
    args: Vec<SkinArgs>,
    /// d loss / d skin of each instance, shape [frames with terms at the skin, 3, M]; empty without
    /// gradients.
    bars: Buffer<f32>,
    bar_starts: Vec<usize>,
    /// Most points of an instance, and most frames with terms at the skin.
    most: [usize; 2],
    /// Keeps alive what the arguments point to.
    _by_node: Vec<Arc<DeviceSkinByNode>>,
}

/// Bytes that d loss / d skin of an instance takes.
pub(crate) fn bytes_of(instance: &Instance) -> u64 {
    let points = instance.model.model().skin.len() as u64;
    12 * points * skin_frames(&instance.objective.terms).len() as u64
}

impl Skins {
    /// Skins of these instances with their objectives, and for gradients if they are `seeded`.
    pub(crate) fn new(
        queue: &Queue,
        instances: &[Instance],
        objectives: &[Arc<DeviceObjective>],
        seeded: bool,
    ) -> Result<Self, Error> {
        let (mut all, mut by_nodes) = (Vec::with_capacity(instances.len()), Vec::new());
        let (mut bar_starts, mut most) = (vec![0], [0; 2]);
        for (instance, objective) in instances.iter().zip(objectives) {
            let (model, frames) = (instance.model.model(), objective.skin_frame_count());
            let mut args = SkinArgs::default();
            let mut count = 0;
            if frames > 0 {
                let resident = resident(&instance.model)?;
                args = resident.skin.args();
                if seeded {
                    let nodes = model.graph.node_count();
                    let by_node = resident.skin.by_node(&resident.device, nodes)?;
                    args = by_node.add_to(args);
                    by_nodes.push(by_node);
                    count = 3 * model.skin.len() * frames;
                    most = [most[0].max(model.skin.len()), most[1].max(frames)];
                }
            }
            all.push(args);
            bar_starts.push(end_of(&bar_starts) + count);
        }
        let bars = Buffer::empty(&queue.stream, end_of(&bar_starts))?;
        Ok(Self { args: all, bars, bar_starts, most, _by_node: by_nodes })
    }

    /// The skin of an instance, and d loss / d its points.
    pub(crate) fn of(&self, index: usize) -> (SkinArgs, Pointer<f32>) {
        (self.args[index], self.bars.at(self.bar_starts[index]))
    }

    /// Computes d loss / d skin of instances that have been scored.
    pub(crate) fn seed(
        &self,
        queue: &Queue,
        objectives: Pointer<ObjectiveArgs>,
        count: u32,
    ) -> Result<(), Error> {
        let [points, frames] = self.most.map(|most| most as u32);
        let launch = queue.grid(points.div_ceil(THREADS), frames, count);
        // SAFETY: the objectives are those of instances that this was made for, with room for all
        // points in all frames with terms at the skin.
        unsafe { kernels::seed_skin(&launch, &SeedSkinArgs { objectives }) }
    }
}
