//! Pictures of the states of a session: their memory, and their turns at the processor, a few slots at a time.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
};

use bendtwin_budget::Share;
use bendtwin_contract::picture;
use bendtwin_engine::backend;
use bendtwin_proto::v1::{RenderSessionRequest, RenderedSession};
use bendtwin_rollout::Pictures;

use crate::{
    budget,
    rollout::{
        error::Error,
        service::{Inner, Unary},
    },
};

impl Inner {
    /// Takes pictures of slots; with the memory of the reply.
    pub(super) async fn render(
        &self,
        request: RenderSessionRequest,
        call: &Unary,
    ) -> Result<(RenderedSession, Share), Error> {
        let session = self.sessions.get(&request.name)?;
        let slots = session.distinct(&request.slots, 0..session.slots())?;
        let count = slots.len() as u64;
        picture::check_pictures(&request, count, &self.limits())?;
        let warm = self.twins.get(session.setup.twin).await?;
        let memory = picture::memory_bytes(&request, count);
        // The look of a twin is made with its first picture, beside the tasks of the runtime.
        let read = call.blocking(move |cancel| {
            Ok(Arc::new(Pictures::new(&session, &warm, slots, request, cancel)?))
        });
        let pictures = read.await?;
        let painter = Arc::clone(&self.painter);
        let threads = painter.threads();
        let bytes = memory.saturating_add(pictures.drawing_bytes(threads));
        let purpose = "the pictures: take smaller ones, or of fewer slots together";
        let share = budget::take(&self.memory.rollouts, bytes, purpose).await?;
        let backend = call.backend(&self.device);
        call.blocking(move |cancel| {
            let together = pictures.together(threads);
            let mut drawn = Vec::with_capacity(pictures.len());
            while drawn.len() < pictures.len() {
                if cancel.is_cancelled() {
                    return Err(backend::Error::Cancelled.into());
                }
                let slots = drawn.len()..pictures.len().min(drawn.len() + together);
                let (pictures, painter) = (Arc::clone(&pictures), Arc::clone(&painter));
                let cancel = cancel.clone();
                let turn = backend.on_processor(move || {
                    let draw = || pictures.draw(slots, &painter, &cancel);
                    // A fault in a picture must not end the device.
                    catch_unwind(AssertUnwindSafe(draw))
                })?;
                drawn.extend(turn.map_err(|_| Error::Panicked)??);
            }
            Ok((pictures.reply(drawn), share))
        })
        .await
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use bendtwin_backends::{Choice, Options};
    use bendtwin_contract_kit::{hanging, picture};
    use bendtwin_core::{Appearance, CancelToken, Skin, Splats, ids::TwinId};
    use bendtwin_proto::v1::{Fidelity, RenderSessionRequest, Tensor};
    use bendtwin_rollout::{Painter, Pictures, Session, Setup, Starts, Wanted, Warm};

    /// Pictures of the hanging chain with Gaussians at its nodes, by a painter.
    fn taken(painter: &Painter) -> Vec<u8> {
        let mut twin = hanging::twin();
        let count = twin.graph.node_count();
        let splats = Splats {
            carriers: Skin::at_nodes(&(0..count as u32).collect::<Vec<_>>()),
            scales_m: vec![[0.05, 0.03, 0.04]; count],
            rotations: vec![[0.0, 0.0, 0.0, 1.0]; count],
            opacities: vec![0.9; count],
            colors: vec![[0.9, 0.3, 0.1]; count],
        };
        twin.appearance = Some(Appearance { skin_colors: Vec::new(), splats: Some(splats) });
        let wanted = Wanted::read(None, &twin.graph, 1).unwrap();
        let Wanted::Ready(Starts::Shared(start)) = wanted else { panic!("there is no rest") };
        let warm = Warm::load(TwinId::generate(), twin, &*bendtwin_engine::cpu(), None).unwrap();
        let setup = Setup {
            twin: warm.id(),
            owner: String::new(),
            capture: String::new(),
            fidelity: Fidelity::Exact,
            world: None,
            grasps: Vec::new(),
            idle: Duration::from_secs(60),
        };
        let session = Session::new(setup, vec![start; 3], None);
        let mut camera = picture::camera();
        // Below the chain, looking up.
        camera.pose = Some(Tensor::pack(&[7], &[0.0_f32, 0.0, -0.3, 0.0, 0.0, 0.0, 1.0]));
        let request = RenderSessionRequest { cameras: vec![camera; 2], ..picture::sound() };
        let cancel = CancelToken::default();
        let pictures = Pictures::new(&session, &warm, vec![0, 1, 2], request, &cancel).unwrap();
        let drawn = pictures.draw(0..3, painter, &cancel).unwrap();
        let reply = pictures.reply(drawn);
        reply.cameras.iter().flat_map(|camera| camera.colors.clone().unwrap().data).collect()
    }

    #[test]
    #[ignore = "needs a CUDA device"]
    fn a_gpu_draws_the_gaussians_that_the_processor_draws() {
        let open = || {
            let options = Options { choice: Choice::Cuda, ..Options::default() };
            bendtwin_backends::rasteriser(&options).map_err(|e| e.to_string())
        };
        let device = taken(&Painter::new(2, Some(std::sync::Arc::new(open))));
        let processor = taken(&Painter::new(2, None));
        assert_eq!(device.len(), processor.len());
        let off = device.iter().zip(&processor).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off.unwrap() <= 2, "{off:?}");
    }
}
