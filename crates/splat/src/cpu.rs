//! The CPU rasteriser: it defines the correct result. Threads take whole tiles; a tile's pixels are
//! computed in chunks of lanes. Sums have a fixed order for any number of threads: a Gaussian
//! has a separate place for each tile that it touches, and these are added in the order of tiles.

// Lanes are one index over several arrays.
#![allow(clippy::needless_range_loop)]

mod backward;
mod bins;
mod forward;
mod pixels;
mod projection;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use self::{
    backward::back_tile,
    bins::{Bins, Tile},
    forward::{TileImage, render_tile},
    pixels::{LANES, ROW, SIDE},
    projection::{GaussianBar, SplatBar, project_adjoint},
};
use crate::{Camera, Error, Gaussians, GaussiansBar, Image, ImageBar, Rasteriser, check_input};

/// Gaussians whose derivatives a thread sums at a time.
const PIECE: usize = 256;

/// The CPU rasteriser, on the threads of rayon's current pool.
#[derive(Debug, Default)]
pub struct Cpu {
    last: Option<Frame>,
}

/// A rendering, with what its adjoint needs.
#[derive(Debug)]
struct Frame {
    gaussians: Gaussians,
    camera: Camera,
    bins: Bins,
    /// Images of the tiles with intersections, in their order.
    images: Vec<TileImage>,
}

impl Frame {
    fn new(gaussians: &Gaussians, camera: &Camera) -> Result<Self, Error> {
        let bins = Bins::new(gaussians, camera)?;
        let arch = Arch::new();
        let of_tile = |tile: &Tile| arch.dispatch(RenderTile { bins: &bins, tile, camera });
        let images = bins.tiles.par_iter().map(of_tile).collect();
        Ok(Self { gaussians: gaussians.clone(), camera: *camera, bins, images })
    }

    fn image(&self) -> Image {
        let (width, height) = (self.camera.width, self.camera.height);
        let mut image = Image::black(width, height);
        for (tile, own) in self.bins.tiles.iter().zip(&self.images) {
            let [left, top] = tile.origin.map(|x| x as usize);
            for row in 0..SIDE.min(height as usize - top) {
                let columns = SIDE.min(width as usize - left);
                let first = (top + row) * width as usize + left;
                for column in 0..columns {
                    let (k, l) = (row * ROW + column / LANES, column % LANES);
                    let pixel = first + column;
                    image.color[pixel] = [0, 1, 2].map(|c| own.color[c][k][l]);
                    image.alpha[pixel] = own.alpha[k][l];
                    image.depth_m[pixel] = own.depth_m[k][l];
                }
            }
        }
        image
    }

    fn gradients(&self, bar: &ImageBar) -> GaussiansBar {
        let bins = &self.bins;
        let mut slots = vec![SplatBar::default(); bins.entries.len()];
        let mut parts = Vec::with_capacity(bins.tiles.len());
        let mut rest = slots.as_mut_slice();
        for tile in &bins.tiles {
            let (part, after) = rest.split_at_mut((tile.end - tile.first) as usize);
            parts.push(part);
            rest = after;
        }
        let arch = Arch::new();
        let work = bins.tiles.par_iter().zip(&self.images).zip(parts);
        work.for_each(|((tile, image), out)| {
            arch.dispatch(BackTile { bins, tile, camera: &self.camera, image, bar, out });
        });

        let of_splat = |s: usize| {
            let mut sum = SplatBar::default();
            bins.places_of(s).iter().for_each(|&place| sum.add(&slots[place as usize]));
            let index = bins.indices[s] as usize;
            (sum, project_adjoint(&self.gaussians, index, &self.camera, &sum))
        };
        let bars: Vec<(SplatBar, GaussianBar)> =
            (0..bins.splats.len()).into_par_iter().with_min_len(PIECE).map(of_splat).collect();
        let mut out = GaussiansBar::zeros(self.gaussians.len());
        for (&index, (splat, own)) in bins.indices.iter().zip(&bars) {
            let i = index as usize;
            out.means_m[i] = own.mean_m;
            out.scales_m[i] = own.scale_m;
            out.rotations[i] = own.rotation;
            out.opacities[i] = own.opacity;
            out.colors[i] = splat.color;
            out.screen[i] = splat.center[0].hypot(splat.center[1]);
        }
        out
    }
}

/// Work on a tile, compiled for the vector instructions of the processor. A closure would not be:
/// it is compiled by itself.
struct RenderTile<'a> {
    bins: &'a Bins,
    tile: &'a Tile,
    camera: &'a Camera,
}

impl WithSimd for RenderTile<'_> {
    type Output = TileImage;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> TileImage {
        render_tile(self.bins, self.tile, self.camera)
    }
}

/// The adjoint of it.
struct BackTile<'a> {
    bins: &'a Bins,
    tile: &'a Tile,
    camera: &'a Camera,
    image: &'a TileImage,
    bar: &'a ImageBar,
    out: &'a mut [SplatBar],
}

impl WithSimd for BackTile<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        back_tile(self.bins, self.tile, self.camera, self.image, self.bar, self.out);
    }
}

impl Cpu {
    /// The rendering of these Gaussians, which may be the last one.
    fn frame(&mut self, gaussians: &Gaussians, camera: &Camera) -> Result<&Frame, Error> {
        let kept = self.last.take().filter(|f| f.camera == *camera && f.gaussians == *gaussians);
        let frame = match kept {
            Some(frame) => frame,
            None => Frame::new(gaussians, camera)?,
        };
        Ok(self.last.insert(frame))
    }
}

impl Rasteriser for Cpu {
    fn render(&mut self, gaussians: &Gaussians, camera: &Camera) -> Result<Image, Error> {
        check_input(gaussians, camera, None)?;
        self.frame(gaussians, camera).map(Frame::image)
    }

    fn gradients(
        &mut self,
        gaussians: &Gaussians,
        camera: &Camera,
        bar: &ImageBar,
    ) -> Result<GaussiansBar, Error> {
        check_input(gaussians, camera, Some(bar))?;
        self.frame(gaussians, camera).map(|frame| frame.gradients(bar))
    }

    fn name(&self) -> String {
        "CPU".into()
    }
}
