//! Device memory of a rasteriser: arrays by Gaussian, by pixel and by intersection, which grow to
//! the next power of two and are kept.

use std::sync::Arc;

use bendtwin_engine::Error;
use bendtwin_splat::{Camera, Gaussians, GaussiansBar, Image, ImageBar};
use bytemuck::Pod;
use cudarc::driver::CudaStream;

use super::sort::{Pairs, histogram_len};
use crate::device::{
    args::{Extent, Pointer, Splat, SplatSet},
    memory::Buffer,
    queue::Queue,
    staging::Upload,
};

/// Fewest entries of an array.
const LEAST: usize = 1 << 10;
/// Floats of a Gaussian, and of its derivatives.
const NUMBERS: usize = 14;
const BARS: usize = NUMBERS + 1;
/// Floats of an intersection's derivatives, as in `splat.cuh`.
const MOMENTS: usize = 10;

/// First float of each parameter in arrays of Gaussians, in this order: quaternions, which are read
/// four floats at a time, means, scales, colours, opacities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SetLayout {
    pub(super) means: usize,
    pub(super) scales: usize,
    pub(super) colors: usize,
    pub(super) opacities: usize,
    pub(super) end: usize,
}

impl SetLayout {
    pub(super) fn of(count: usize) -> Self {
        Self {
            means: 4 * count,
            scales: 7 * count,
            colors: 10 * count,
            opacities: 13 * count,
            end: NUMBERS * count,
        }
    }
}

/// The arrays. G is the number of Gaussians, P of pixels, T of tiles, K of intersections; each
/// array has as many entries at least.
pub(super) struct Memory {
    stream: Arc<CudaStream>,
    /// Bytes that all may have together.
    limit: u64,
    /// Gaussians as [`SetLayout`] says, shape [G, 14], on the device and here.
    pub(super) numbers: Buffer<f32>,
    sent: Upload,
    /// Projected Gaussians, shape [G].
    pub(super) splats: Buffer<Splat>,
    pub(super) extents: Buffer<Extent>,
    /// Tiles that each touches, by index, shape [G].
    pub(super) counts: Buffer<u32>,
    /// First intersection of each, by depth, shape [G].
    pub(super) offsets: Buffer<u32>,
    /// Depths and indices, shape [G].
    pub(super) depths: Pairs,
    /// Histograms of sorts.
    pub(super) histograms: Buffer<u32>,
    /// Sum of a scan.
    pub(super) total: Buffer<u64>,
    /// Tiles and intersections, shape [K].
    pub(super) tiles: Pairs,
    /// Gaussian of each intersection, shape [K].
    pub(super) owners: Buffer<u32>,
    /// Gaussians by tile and depth, shape [K].
    pub(super) entries: Buffer<u32>,
    /// Entries of each tile, shape [T]; exactly so long.
    pub(super) ranges: Buffer<[u32; 2]>,
    /// The image, shape [P]; exactly so long.
    pub(super) color: Buffer<[f32; 3]>,
    pub(super) alpha: Buffer<f32>,
    pub(super) depth: Buffer<f32>,
    /// d loss / d image: colours, coverage, depths, shape [P, 5].
    image_bar: Buffer<f32>,
    sent_bar: Upload,
    /// d loss / d intersections, shape [K, 10].
    pub(super) moments: Buffer<f32>,
    /// d loss / d Gaussians, shape [G, 15]; exactly so long.
    pub(super) bars: Buffer<f32>,
}

impl Memory {
    pub(super) fn new(stream: &Arc<CudaStream>, limit: u64) -> Result<Self, Error> {
        let words = || Buffer::<u32>::empty(stream, 0);
        let pairs =
            || Ok::<_, Error>(Pairs { keys: [words()?, words()?], values: [words()?, words()?] });
        Ok(Self {
            limit,
            numbers: Buffer::empty(stream, 0)?,
            sent: Upload::default(),
            splats: Buffer::empty(stream, 0)?,
            extents: Buffer::empty(stream, 0)?,
            counts: words()?,
            offsets: words()?,
            depths: pairs()?,
            histograms: words()?,
            total: Buffer::empty(stream, 1)?,
            tiles: pairs()?,
            owners: words()?,
            entries: words()?,
            ranges: Buffer::empty(stream, 0)?,
            color: Buffer::empty(stream, 0)?,
            alpha: Buffer::empty(stream, 0)?,
            depth: Buffer::empty(stream, 0)?,
            image_bar: Buffer::empty(stream, 0)?,
            sent_bar: Upload::default(),
            moments: Buffer::empty(stream, 0)?,
            bars: Buffer::empty(stream, 0)?,
            stream: stream.clone(),
        })
    }

    /// Bytes of all arrays.
    fn bytes(&self) -> u64 {
        let pairs = |p: &Pairs| p.keys.iter().chain(&p.values).map(bytes).sum::<u64>();
        let words = [&self.counts, &self.offsets, &self.histograms, &self.owners, &self.entries];
        let floats =
            [&self.numbers, &self.alpha, &self.depth, &self.image_bar, &self.moments, &self.bars];
        words.into_iter().map(bytes).sum::<u64>()
            + floats.into_iter().map(bytes).sum::<u64>()
            + pairs(&self.depths)
            + pairs(&self.tiles)
            + bytes(&self.splats)
            + bytes(&self.extents)
            + bytes(&self.ranges)
            + bytes(&self.color)
    }

    /// Allocates space for `count` Gaussians.
    pub(super) fn hold_set(&mut self, count: usize) -> Result<(), Error> {
        let limit = self.limit.saturating_sub(self.bytes());
        let Self { stream, .. } = self;
        let mut room = Room { stream, left: limit };
        room.grow(&mut self.numbers, NUMBERS * count)?;
        room.grow(&mut self.splats, count)?;
        room.grow(&mut self.extents, count)?;
        room.grow(&mut self.counts, count)?;
        room.grow(&mut self.offsets, count)?;
        room.grow_pairs(&mut self.depths, count)?;
        room.grow(&mut self.histograms, histogram_len(count))
    }

    /// Allocates memory for an image.
    pub(super) fn hold_image(&mut self, pixels: usize, tiles: usize) -> Result<(), Error> {
        let limit = self.limit.saturating_sub(self.bytes());
        let Self { stream, .. } = self;
        let mut room = Room { stream, left: limit };
        room.fit(&mut self.ranges, tiles)?;
        room.fit(&mut self.color, pixels)?;
        room.fit(&mut self.alpha, pixels)?;
        room.fit(&mut self.depth, pixels)
    }

    /// Allocates space for `count` intersections.
    pub(super) fn hold_intersections(&mut self, count: usize) -> Result<(), Error> {
        let limit = self.limit.saturating_sub(self.bytes());
        let Self { stream, .. } = self;
        let mut room = Room { stream, left: limit };
        room.grow_pairs(&mut self.tiles, count)?;
        room.grow(&mut self.owners, count)?;
        room.grow(&mut self.entries, count)?;
        room.grow(&mut self.histograms, histogram_len(count))
    }

    /// Allocates memory for derivatives.
    pub(super) fn hold_bars(
        &mut self,
        gaussians: usize,
        intersections: usize,
        pixels: usize,
    ) -> Result<(), Error> {
        let limit = self.limit.saturating_sub(self.bytes());
        let Self { stream, .. } = self;
        let mut room = Room { stream, left: limit };
        room.grow(&mut self.image_bar, 5 * pixels)?;
        room.grow(&mut self.moments, MOMENTS * intersections)?;
        room.fit(&mut self.bars, BARS * gaussians)
    }

    /// Copies Gaussians to the device.
    pub(super) fn upload(&mut self, queue: &Queue, gaussians: &Gaussians) -> Result<(), Error> {
        queue.send(&mut self.sent, &parts(gaussians), &self.numbers)
    }

    /// True if these Gaussians are those that were copied last.
    pub(super) fn holds(&self, gaussians: &Gaussians) -> bool {
        self.sent.holds(&parts(gaussians))
    }

    /// Copies derivatives by an image to the device.
    pub(super) fn upload_bar(&mut self, queue: &Queue, bar: &ImageBar) -> Result<(), Error> {
        let parts = [bar.color.as_flattened(), &bar.alpha, &bar.depth_m];
        queue.send(&mut self.sent_bar, &parts, &self.image_bar)
    }

    /// Gaussians as kernels have them.
    pub(super) fn set(&self, count: usize) -> SplatSet {
        let layout = SetLayout::of(count);
        SplatSet {
            rotations: self.numbers.address().cast(),
            means: self.numbers.at(layout.means),
            scales: self.numbers.at(layout.scales),
            colors: self.numbers.at(layout.colors),
            opacities: self.numbers.at(layout.opacities),
            count: count as u32,
            pad: 0,
        }
    }

    /// Derivatives by colours, coverage and depths.
    pub(super) fn image_bars(&self, pixels: usize) -> [Pointer<f32>; 3] {
        [0, 3, 4].map(|first| self.image_bar.at(first * pixels))
    }

    /// The image; waits for it.
    pub(super) fn image(&self, queue: &Queue, camera: &Camera) -> Result<Image, Error> {
        Ok(Image {
            width: camera.width,
            height: camera.height,
            color: queue.fetch(&self.color)?,
            alpha: queue.fetch(&self.alpha)?,
            depth_m: queue.fetch(&self.depth)?,
        })
    }

    /// Derivatives by Gaussians; waits for them.
    pub(super) fn gradients(&self, queue: &Queue, count: usize) -> Result<GaussiansBar, Error> {
        let all = queue.fetch(&self.bars)?;
        let at = SetLayout::of(count);
        Ok(GaussiansBar {
            rotations: all[..at.means].as_chunks().0.to_vec(),
            means_m: all[at.means..at.scales].as_chunks().0.to_vec(),
            scales_m: all[at.scales..at.colors].as_chunks().0.to_vec(),
            colors: all[at.colors..at.opacities].as_chunks().0.to_vec(),
            opacities: all[at.opacities..at.end].to_vec(),
            screen: all[at.end..].to_vec(),
        })
    }
}

/// Parameters of Gaussians, in the order of [`SetLayout`].
fn parts(gaussians: &Gaussians) -> [&[f32]; 5] {
    [
        gaussians.rotations.as_flattened(),
        gaussians.means_m.as_flattened(),
        gaussians.scales_m.as_flattened(),
        gaussians.colors.as_flattened(),
        &gaussians.opacities,
    ]
}

fn bytes<T>(buffer: &Buffer<T>) -> u64 {
    (buffer.len() * size_of::<T>()) as u64
}

/// Rest of the limit while arrays grow.
struct Room<'a> {
    stream: &'a Arc<CudaStream>,
    left: u64,
}

impl Room<'_> {
    /// Makes an array longer, if it is shorter; its content is lost.
    fn grow<T: Pod>(&mut self, buffer: &mut Buffer<T>, len: usize) -> Result<(), Error> {
        if buffer.len() >= len {
            return Ok(());
        }
        self.replace(buffer, len.next_power_of_two().max(LEAST))
    }

    /// Makes an array exactly so long; its content may be lost.
    fn fit<T: Pod>(&mut self, buffer: &mut Buffer<T>, len: usize) -> Result<(), Error> {
        if buffer.len() == len { Ok(()) } else { self.replace(buffer, len) }
    }

    fn grow_pairs(&mut self, pairs: &mut Pairs, len: usize) -> Result<(), Error> {
        let mut arrays = pairs.keys.iter_mut().chain(&mut pairs.values);
        arrays.try_for_each(|array| self.grow(array, len))
    }

    /// The old array is freed first, behind the work that uses it.
    fn replace<T: Pod>(&mut self, buffer: &mut Buffer<T>, len: usize) -> Result<(), Error> {
        self.left += bytes(buffer);
        *buffer = Buffer::empty(self.stream, 0)?;
        let needed = (len * size_of::<T>()) as u64;
        if needed > self.left {
            return Err(Error::OutOfMemory { needed, available: self.left });
        }
        *buffer = Buffer::empty(self.stream, len)?;
        self.left -= needed;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
