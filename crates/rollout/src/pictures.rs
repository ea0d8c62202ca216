//! Pictures of the states of a session: what a request asks for, drawn a few slots at a time, so that the caller can
//! take turns with others.

pub(crate) mod look;
mod painter;
mod request;
mod row;

use std::{ops::Range, sync::Arc};

use bendtwin_appearance::Dressed;
use bendtwin_core::CancelToken;
use bendtwin_engine::{backend, model::State};
use bendtwin_proto::v1::{
    RenderSessionRequest, RenderedSession, Tensor, render_session_request::Look,
    rendered_session::Pictures as Wire,
};
use bendtwin_render::{Mesh, Object, Picture, Scene, draw, scratch_bytes};
use bendtwin_splat::{Camera, Cpu, Gaussians, Image, Rasteriser};
use rayon::prelude::*;

pub use self::painter::Painter;
use self::request::Asked;
use crate::{error::Error, session::Session, twin::warm::Warm};

/// Memory of the slots that are drawn together, at most if more than one is [bytes].
const TOGETHER_BYTES: usize = 256 << 20;
/// Pixels for each thread of the slots that are drawn together: some tens of milliseconds.
const THREAD_PIXELS: usize = 1 << 17;
/// Slots for each thread that are drawn together: with more of them, threads idle less at their end.
const THREAD_SLOTS: usize = 4;
/// Memory of a Gaussian while it is drawn, and of each tile under it, and of a pixel of their image [bytes].
const GAUSSIAN_BYTES: usize = 512;
const INTERSECTION_BYTES: usize = 16;
const IMAGE_PIXEL_BYTES: usize = 64;

/// The look of a twin in the pictures of a request.
enum Dress {
    Surface(Arc<Mesh>),
    Gaussians(Arc<Dressed>),
}

/// Pictures to be taken of slots of a session.
pub struct Pictures {
    asked: Asked,
    dress: Dress,
    slots: Vec<usize>,
    /// The state of each slot.
    states: Vec<Arc<State>>,
}

/// The pictures of a slot, one for each camera.
pub type SlotPictures = Vec<Picture>;

impl Pictures {
    /// The pictures that a checked request asks for of these slots, in the states of this moment.
    ///
    /// # Errors
    /// If the twin does not have the look, a tensor is not what the check saw, or the points of a convex mesh have no
    /// hull.
    pub fn new(
        session: &Session,
        warm: &Warm,
        slots: Vec<usize>,
        request: RenderSessionRequest,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let look = bendtwin_contract::picture::look(&request)?;
        let gaussians = match look {
            Look::Surface => None,
            Look::Unspecified | Look::Gaussians => warm.look.gaussians(&warm.twin)?,
        };
        let dress = match gaussians {
            Some(gaussians) => Dress::Gaussians(gaussians),
            None if look == Look::Gaussians => {
                return Err(Error::NoGaussians { twin: warm.id.to_string() });
            }
            None => Dress::Surface(warm.look.mesh(&warm.twin)),
        };
        let asked = Asked::read(request, cancel)?;
        let states = session.states(&slots).0.into_iter().map(|start| start.state).collect();
        Ok(Self { asked, dress, slots, states })
    }

    /// Number of slots.
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// True without slots.
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// Number of slots to draw together on a number of threads.
    pub fn together(&self, threads: usize) -> usize {
        let most = TOGETHER_BYTES / self.slot_bytes().max(1);
        let in_time = threads * THREAD_PIXELS / self.asked.slot_pixels().max(1);
        (threads * THREAD_SLOTS).min(most).min(in_time).clamp(1, self.len().max(1))
    }

    /// Memory that drawing takes on a number of threads, beside that of the pictures [bytes].
    pub fn drawing_bytes(&self, threads: usize) -> u64 {
        let width = self.asked.cameras.iter().map(|camera| camera.width).max().unwrap_or(0);
        let bytes = self.together(threads) * self.slot_bytes() + threads * scratch_bytes(width);
        bytes as u64
    }

    /// Memory of the state of a slot while it is drawn [bytes].
    fn slot_bytes(&self) -> usize {
        match &self.dress {
            Dress::Surface(mesh) => mesh.posed_bytes(),
            Dress::Gaussians(dressed) => {
                let tile = bendtwin_splat::constants::TILE_PX;
                let of = |w: u32, h: u32| w.div_ceil(tile) as usize * h.div_ceil(tile) as usize;
                let cameras = &self.asked.cameras;
                let tiles = cameras.iter().map(|c| of(c.width, c.height)).max().unwrap_or(0);
                let most = bendtwin_splat::constants::MOST_INTERSECTIONS;
                let intersections = dressed.len().saturating_mul(tiles).min(most);
                dressed.len() * GAUSSIAN_BYTES
                    + intersections * INTERSECTION_BYTES
                    + self.asked.slot_pixels() * IMAGE_PIXEL_BYTES
            }
        }
    }

    /// Draws the pictures of some of the slots.
    ///
    /// # Errors
    /// If Gaussians cannot be drawn, or on cancellation.
    pub fn draw(
        &self,
        slots: Range<usize>,
        painter: &Painter,
        cancel: &CancelToken,
    ) -> Result<Vec<SlotPictures>, Error> {
        match &self.dress {
            Dress::Surface(mesh) => painter.install(|| {
                let each = slots.into_par_iter();
                each.map(|slot| self.of_surface(slot, mesh, cancel)).collect()
            }),
            Dress::Gaussians(dressed) if painter.has_device() => {
                self.of_gaussians_on_device(slots, dressed, painter, cancel)
            }
            Dress::Gaussians(dressed) => painter.install(|| {
                let of_slot = |slot: usize| {
                    let gaussians = dressed.at(&self.states[slot].positions)?;
                    let images = self.images(slot, &gaussians, &mut Cpu::default(), cancel)?;
                    self.of_images(slot, &images, cancel)
                };
                slots.into_par_iter().map(of_slot).collect()
            }),
        }
    }

    /// Moves Gaussians on the threads, draws one image after another on the device, and puts them into pictures on the
    /// threads.
    fn of_gaussians_on_device(
        &self,
        slots: Range<usize>,
        dressed: &Dressed,
        painter: &Painter,
        cancel: &CancelToken,
    ) -> Result<Vec<SlotPictures>, Error> {
        let first = slots.start;
        let placed: Vec<Gaussians> = painter.install(|| {
            let each = slots.clone().into_par_iter();
            each.map(|slot| dressed.at(&self.states[slot].positions)).collect::<Result<_, _>>()
        })?;
        let images: Vec<Vec<Image>> = painter.on_device(|rasteriser| {
            let each = slots.zip(&placed);
            each.map(|(slot, placed)| self.images(slot, placed, rasteriser, cancel)).collect()
        })?;
        painter.install(|| {
            let each = images.par_iter().enumerate();
            each.map(|(k, images)| self.of_images(first + k, images, cancel)).collect()
        })
    }

    /// The cameras of a slot.
    fn cameras(&self, slot: usize) -> impl Iterator<Item = Camera> + '_ {
        self.asked.cameras.iter().map(move |camera| camera.of(slot))
    }

    /// Renderings of Gaussians by each camera.
    fn images(
        &self,
        slot: usize,
        gaussians: &Gaussians,
        rasteriser: &mut dyn Rasteriser,
        cancel: &CancelToken,
    ) -> Result<Vec<Image>, Error> {
        let one = |camera: Camera| {
            if cancel.is_cancelled() {
                return Err(backend::Error::Cancelled.into());
            }
            let image = rasteriser.render(gaussians, &camera);
            image.map_err(|error| bendtwin_appearance::Error::from(error).into())
        };
        self.cameras(slot).map(one).collect()
    }

    fn of_images(
        &self,
        slot: usize,
        images: &[Image],
        cancel: &CancelToken,
    ) -> Result<SlotPictures, Error> {
        self.of_objects(slot, images.iter().map(Object::Gaussians), cancel)
    }

    fn of_surface(
        &self,
        slot: usize,
        mesh: &Mesh,
        cancel: &CancelToken,
    ) -> Result<SlotPictures, Error> {
        let posed = mesh.at(&self.states[slot].positions, &self.asked.light(slot));
        self.of_objects(slot, std::iter::repeat(Object::Surface(&posed)), cancel)
    }

    /// The pictures of a slot, given the object for each camera.
    fn of_objects<'a>(
        &self,
        slot: usize,
        objects: impl Iterator<Item = Object<'a>>,
        cancel: &CancelToken,
    ) -> Result<SlotPictures, Error> {
        let (props, light) = (self.asked.props_of(slot), self.asked.light(slot));
        let each = self.asked.cameras.iter().zip(objects).map(|(asked, object)| {
            let camera = asked.of(slot);
            let background = asked.background_of(slot);
            let scene = Scene { camera: &camera, object, props: &props, light: &light, background };
            let drawn = draw(&scene, self.asked.wanted, &|| cancel.is_cancelled());
            drawn.ok_or_else(|| backend::Error::Cancelled.into())
        });
        each.collect()
    }

    /// The reply, from the pictures of all slots in their order.
    pub fn reply(&self, drawn: Vec<SlotPictures>) -> RenderedSession {
        let count = drawn.len();
        let mut drawn: Vec<_> = drawn.into_iter().map(Vec::into_iter).collect();
        let Asked { cameras, wanted, .. } = &self.asked;
        let cameras = cameras.iter().map(|camera| {
            let of_camera: Vec<Picture> = drawn.iter_mut().filter_map(Iterator::next).collect();
            let size = [count, camera.height as usize, camera.width as usize];
            let colors = joined(&of_camera, |picture| &picture.colors);
            let depths = || joined(&of_camera, |picture| &picture.depths);
            let labels = || joined(&of_camera, |picture| &picture.labels);
            Wire {
                colors: Some(Tensor::pack(&[size[0], size[1], size[2], 3], &colors)),
                depths: wanted.depths.then(|| Tensor::pack(&size, &depths())),
                labels: wanted.labels.then(|| Tensor::pack(&size, &labels())),
            }
        });
        let cameras = cameras.collect();
        RenderedSession { cameras, slots: self.slots.iter().map(|slot| *slot as u32).collect() }
    }
}

/// The pixels of pictures, one after another.
fn joined<T: Copy>(pictures: &[Picture], of: impl Fn(&Picture) -> &[T]) -> Vec<T> {
    pictures.iter().map(of).collect::<Vec<_>>().concat()
}
