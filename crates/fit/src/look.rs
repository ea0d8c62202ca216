//! Twins drawn into the views of a recording: their likeness to it, and videos beside it.

use std::io::Write;

use bendtwin_appearance::{
    ComparedPair, Dressed, Motion, Scene, compared_pairs, score, side_by_side,
};
use bendtwin_core::{CancelToken, Capture, FitSettings, Twin, Views, quality::RenderedScore};
use bendtwin_engine::{Backend, backend};
use bendtwin_eval::{Trajectory, predict};
use bendtwin_splat::{OpenRasteriser, Rasteriser};

use crate::Error;

/// Opens the file of a camera's video, by the index of the camera.
pub type OpenVideo<'a> = &'a mut dyn FnMut(usize) -> std::io::Result<Box<dyn Write>>;

/// Views and tools for the look of a twin.
#[derive(Clone)]
pub struct Look<'a> {
    /// Views of the capture's first recording.
    pub views: &'a Views,
    /// Opens the rasteriser that draws them.
    pub rasteriser: OpenRasteriser,
}

/// A twin that is drawn into the views of a recording.
#[derive(Clone, Copy)]
pub struct LookInput<'a> {
    /// The twin with its appearance.
    pub twin: &'a Twin,
    /// The twin with its nodes as they move in the recording: the twin itself in its own recording.
    pub moved: &'a Twin,
    /// The recording.
    pub capture: &'a Capture,
    /// Backend that predicts the motion.
    pub backend: &'a dyn Backend,
}

impl Look<'_> {
    /// Likeness of the renderings of a twin to the recording: of its Gaussians, else of its coloured
    /// skin. None if it has neither.
    ///
    /// # Errors
    /// If the twin does not fit the capture, on cancellation, or if backend or rasteriser fail.
    pub fn score(
        &self,
        drawn: LookInput<'_>,
        per_frame: bool,
        cancel: &CancelToken,
    ) -> Result<Option<RenderedScore>, Error> {
        let scored = self.in_scene(drawn, cancel, &mut |scene, rasteriser| {
            score(scene, rasteriser, per_frame, &mut || !cancel.is_cancelled())
        })?;
        Ok(scored.flatten())
    }

    /// Writes a video for each camera that has views, and returns the cameras that have one. None if
    /// the twin has neither Gaussians nor a coloured skin.
    ///
    /// # Errors
    /// Those of [`Look::score`], and if a file cannot be written.
    pub fn videos(
        &self,
        drawn: LookInput<'_>,
        open: OpenVideo<'_>,
        cancel: &CancelToken,
    ) -> Result<Option<Vec<usize>>, Error> {
        let mut keep_going = || !cancel.is_cancelled();
        self.in_scene(drawn, cancel, &mut |scene, rasteriser| {
            let mut written = Vec::new();
            for (index, camera) in self.views.cameras.iter().enumerate() {
                if camera.views.is_empty() {
                    continue;
                }
                let failed = |e: std::io::Error| bendtwin_picture::Error::Write(e.to_string());
                let mut out = open(index).map_err(failed)?;
                let fps = drawn.capture.fps;
                if side_by_side(scene, index, fps, rasteriser, &mut out, &mut keep_going)? {
                    written.push(index);
                }
                out.flush().map_err(failed)?;
            }
            Ok(written)
        })
    }

    /// Hands every image that the measures compare to `write`, with its rendering, together with the
    /// PNG file of both. None if the twin has neither Gaussians nor a coloured skin.
    ///
    /// # Errors
    /// Those of [`Look::score`], and if `write` fails.
    pub fn pairs(
        &self,
        drawn: LookInput<'_>,
        write: &mut dyn FnMut(&ComparedPair, &[u8]) -> std::io::Result<()>,
        cancel: &CancelToken,
    ) -> Result<Option<()>, Error> {
        self.in_scene(drawn, cancel, &mut |scene, rasteriser| {
            compared_pairs(scene, rasteriser, &mut |pair| {
                let file = pair.canvas.to_png()?;
                let written = write(&pair, &file);
                written.map_err(|e| bendtwin_picture::Error::Write(e.to_string()))?;
                Ok(!cancel.is_cancelled())
            })
        })
    }

    /// Calls `work` with the twin's Gaussians and its predicted motion. Cancelled work is an error, since
    /// its result may be half of one.
    fn in_scene<T>(
        &self,
        drawn: LookInput<'_>,
        cancel: &CancelToken,
        work: &mut dyn FnMut(
            &Scene<'_>,
            &mut dyn Rasteriser,
        ) -> Result<T, bendtwin_appearance::Error>,
    ) -> Result<Option<T>, Error> {
        let Some(appearance) = &drawn.twin.appearance else { return Ok(None) };
        let predicted = Predicted::new(drawn.moved, drawn.capture, drawn.backend, cancel)?;
        let Some(predicted) = predicted else { return Ok(None) };
        let own = |settings: &FitSettings| settings.appearance.held_out_cameras.clone();
        // Cameras of other recordings are others.
        let is_own = std::ptr::eq(drawn.twin, drawn.moved);
        let settings = drawn.twin.provenance.settings.as_ref().filter(|_| is_own);
        let held_out = settings.map(own).unwrap_or_default();
        let open = (self.rasteriser)();
        let mut rasteriser = open.map_err(bendtwin_appearance::Error::Device)?;
        let dressed = Dressed::in_appearance(drawn.twin, appearance)?;
        let scene = Scene {
            dressed: &dressed,
            motion: predicted.motion(),
            views: self.views,
            held_out: &held_out,
        };
        let done = work(&scene, &mut *rasteriser)?;
        if cancel.is_cancelled() {
            return Err(backend::Error::Cancelled.into());
        }
        Ok(Some(done))
    }
}

/// The predicted motion of a capture's first sequence.
pub(crate) struct Predicted {
    trajectory: Trajectory,
    train_frame_count: usize,
}

impl Predicted {
    pub(crate) fn new(
        twin: &Twin,
        capture: &Capture,
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, Error> {
        let trajectory = predict(backend, twin, capture, cancel)?.into_iter().next();
        let sequence = capture.sequences.first();
        Ok(trajectory.zip(sequence).map(|(trajectory, sequence)| Self {
            trajectory,
            train_frame_count: sequence.train_frame_count,
        }))
    }

    pub(crate) fn motion(&self) -> Motion<'_> {
        Motion {
            start_frame: self.trajectory.start_frame,
            node_count: self.trajectory.node_count,
            positions: &self.trajectory.positions,
            train_frame_count: self.train_frame_count,
        }
    }
}
