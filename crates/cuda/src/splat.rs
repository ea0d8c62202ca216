//! Images of Gaussians and their gradients on a device, with the results of the CPU rasteriser
//! within rounding, and the same bits each time: no sum is made by atomic additions of floats.
//!
//! Gaussians are sorted by depth once; intersections with tiles, made in that order, are sorted by
//! tile with a stable sort. A block draws a tile. Backward every intersection has a place for the
//! sums over its tile, and a Gaussian adds up its own in the order of tiles.

mod memory;
mod sort;

use std::sync::Arc;

use bendtwin_splat::{
    Camera, Error, Gaussians, GaussiansBar, Image, ImageBar, Rasteriser, check_input,
    constants::{MOST_INTERSECTIONS, TILE_PX},
};

use self::memory::{Memory, SetLayout};
use crate::{
    Options,
    device::{
        Device,
        args::{
            SplatAdjointArgs, SplatBackwardArgs, SplatCamera, SplatCountsArgs, SplatExpandArgs,
            SplatForwardArgs, SplatProjectArgs, SplatRangesArgs, SplatScanArgs,
        },
        kernels,
        queue::Queue,
        specialization::THREADS,
    },
};

/// A rasteriser on a CUDA device. Its memory there is kept between calls and grows as needed.
pub struct CudaRasteriser {
    queue: Queue,
    memory: Memory,
    last: Option<Rendering>,
}

/// A rendering that is on the device, with what its adjoint needs.
struct Rendering {
    camera: Camera,
    /// Intersections of Gaussians and tiles.
    intersections: usize,
    /// True if the sorted intersections are in the second pair of arrays.
    is_swapped: bool,
}

/// An error of the device, as an error of rendering.
fn failed(error: bendtwin_engine::Error) -> Error {
    match error {
        bendtwin_engine::Error::OutOfMemory { needed, available } => {
            Error::OutOfMemory { needed, available }
        }
        bendtwin_engine::Error::Device(why) => Error::Device(why),
        other => Error::Device(other.to_string()),
    }
}

/// Blocks with a thread for each of `count` elements.
fn blocks(count: usize) -> u32 {
    count.div_ceil(THREADS as usize) as u32
}

impl CudaRasteriser {
    /// A rasteriser on the device of these options, within their limit of memory.
    ///
    /// # Errors
    /// [`Error::Device`] with one line that says what is missing: a driver, NVRTC, or a device.
    pub fn new(options: &Options) -> Result<Self, Error> {
        let device = Device::open(options).map_err(failed)?;
        Self::on(&device).map_err(failed)
    }

    fn on(device: &Arc<Device>) -> Result<Self, bendtwin_engine::Error> {
        let queue = Queue::normal(device);
        let memory = Memory::new(&queue.stream, device.budget)?;
        Ok(Self { queue, memory, last: None })
    }

    /// Draws an image and leaves it on the device, where [`Rasteriser::gradients`] finds it; returns
    /// when it is done.
    ///
    /// # Errors
    /// Those of [`Rasteriser::render`].
    pub fn draw(&mut self, gaussians: &Gaussians, camera: &Camera) -> Result<(), Error> {
        check_input(gaussians, camera, None)?;
        let drawn = self.drawn(gaussians, camera)?;
        self.queue.synchronize().map_err(failed)?;
        self.last = Some(drawn);
        Ok(())
    }

    /// The rendering of these Gaussians, which may be the last one.
    fn drawn(&mut self, gaussians: &Gaussians, camera: &Camera) -> Result<Rendering, Error> {
        // Taken, so that a failure leaves no stale rendering.
        let kept = self.last.take().filter(|d| d.camera == *camera && self.memory.holds(gaussians));
        match kept {
            Some(drawn) => Ok(drawn),
            None => self.start(gaussians, camera),
        }
    }

    /// Launches a rendering.
    fn start(&mut self, gaussians: &Gaussians, camera: &Camera) -> Result<Rendering, Error> {
        let count = gaussians.len();
        let own = device_camera(camera);
        let tiles = own.tiles as usize;
        let memory = &mut self.memory;
        memory.hold_set(count).map_err(failed)?;
        memory.hold_image(camera.pixel_count(), tiles).map_err(failed)?;
        memory.upload(&self.queue, gaussians).map_err(failed)?;
        let intersections = self.order_by_depth(count, &own).map_err(failed)?;
        if intersections > MOST_INTERSECTIONS as u64 {
            return Err(Error::TooMany {
                what: "intersections of Gaussians and tiles",
                count: intersections as usize,
                most: MOST_INTERSECTIONS,
            });
        }
        let intersections = intersections as usize;
        let is_swapped = self.order_by_tile(count, intersections, &own).map_err(failed)?;
        self.forward(&own).map_err(failed)?;
        Ok(Rendering { camera: *camera, intersections, is_swapped })
    }

    /// Projects Gaussians and sorts them by depth; gives the number of intersections.
    fn order_by_depth(
        &self,
        count: usize,
        camera: &SplatCamera,
    ) -> Result<u64, bendtwin_engine::Error> {
        if count == 0 {
            return Ok(0);
        }
        let m = &self.memory;
        let project = SplatProjectArgs {
            set: m.set(count),
            camera: *camera,
            splats: m.splats.address(),
            extents: m.extents.address(),
            counts: m.counts.address(),
            keys: m.depths.keys[0].address(),
            indices: m.depths.values[0].address(),
        };
        let grid = self.queue.grid(blocks(count), 1, 1);
        // SAFETY: the arrays have `count` entries, and live as long as `self`, whose one stream has
        // all work on them.
        unsafe { kernels::splat_project(&grid, &project)? };
        // Four passes of eight bits end where they began.
        sort::sort(&self.queue, &m.depths, count, 32, &m.histograms, &m.total)?;
        let counts = SplatCountsArgs {
            counts: m.counts.address(),
            order: m.depths.values[0].address(),
            offsets: m.offsets.address(),
            count: count as u32,
            pad: 0,
        };
        let scan = SplatScanArgs {
            values: m.offsets.address(),
            total: m.total.address(),
            count: count as u32,
            pad: 0,
        };
        // SAFETY: as above; the order has indices below `count` only.
        unsafe {
            kernels::splat_counts(&grid, &counts)?;
            kernels::splat_scan(&self.queue.grid(1, 1, 1), &scan)?;
        }
        Ok(m.total.read()?[0])
    }

    /// Makes intersections and sorts them by tile; true if they end up in the second pair of
    /// arrays.
    fn order_by_tile(
        &mut self,
        count: usize,
        intersections: usize,
        camera: &SplatCamera,
    ) -> Result<bool, bendtwin_engine::Error> {
        self.memory.hold_intersections(intersections)?;
        let m = &self.memory;
        m.ranges.clear()?;
        if intersections == 0 {
            return Ok(false);
        }
        let expand = SplatExpandArgs {
            camera: *camera,
            splats: m.splats.address(),
            extents: m.extents.address(),
            counts: m.counts.address(),
            order: m.depths.values[0].address(),
            offsets: m.offsets.address(),
            keys: m.tiles.keys[0].address(),
            values: m.tiles.values[0].address(),
            owners: m.owners.address(),
            count: count as u32,
            pad: 0,
        };
        // SAFETY: the arrays of intersections have as many entries as the counts add up to.
        unsafe { kernels::splat_expand(&self.queue.grid(blocks(count), 1, 1), &expand)? };
        let bits = u32::BITS - (camera.tiles - 1).leading_zeros();
        let end = sort::sort(&self.queue, &m.tiles, intersections, bits, &m.histograms, &m.total)?;
        let ranges = SplatRangesArgs {
            keys: m.tiles.keys[end].address(),
            values: m.tiles.values[end].address(),
            owners: m.owners.address(),
            entries: m.entries.address(),
            ranges: m.ranges.address(),
            count: intersections as u32,
            pad: 0,
        };
        let grid = self.queue.grid(blocks(intersections), 1, 1);
        // SAFETY: keys are tiles of the camera, for each of which there is a range.
        unsafe { kernels::splat_ranges(&grid, &ranges)? };
        Ok(end == 1)
    }

    fn forward(&self, camera: &SplatCamera) -> Result<(), bendtwin_engine::Error> {
        let m = &self.memory;
        let args = SplatForwardArgs {
            camera: *camera,
            splats: m.splats.address(),
            entries: m.entries.address(),
            ranges: m.ranges.address(),
            color: m.color.address().cast(),
            alpha: m.alpha.address(),
            depth: m.depth.address(),
        };
        // SAFETY: ranges are within the entries, entries are indices of Gaussians, and the image
        // has a place for each of the camera's pixels.
        unsafe { kernels::splat_forward(&self.queue.grid(camera.tiles, 1, 1), &args) }
    }

    /// Launches the adjoint of a rendering of `count` Gaussians.
    fn backward(
        &mut self,
        drawn: &Rendering,
        count: usize,
        bar: &ImageBar,
    ) -> Result<(), bendtwin_engine::Error> {
        self.memory.hold_bars(count, drawn.intersections, drawn.camera.pixel_count())?;
        self.memory.upload_bar(&self.queue, bar)?;
        let m = &self.memory;
        let camera = device_camera(&drawn.camera);
        let [color_bar, alpha_bar, depth_bar] = m.image_bars(drawn.camera.pixel_count());
        let back = SplatBackwardArgs {
            camera,
            splats: m.splats.address(),
            entries: m.entries.address(),
            places: m.tiles.values[usize::from(drawn.is_swapped)].address(),
            ranges: m.ranges.address(),
            color: m.color.address().cast(),
            alpha: m.alpha.address(),
            depth: m.depth.address(),
            color_bar,
            alpha_bar,
            depth_bar,
            moments: m.moments.address(),
        };
        let layout = SetLayout::of(count);
        let adjoint = SplatAdjointArgs {
            set: m.set(count),
            camera,
            splats: m.splats.address(),
            counts: m.counts.address(),
            order: m.depths.values[0].address(),
            offsets: m.offsets.address(),
            moments: m.moments.address(),
            rotations: m.bars.address().cast(),
            means: m.bars.at(layout.means),
            scales: m.bars.at(layout.scales),
            colors: m.bars.at(layout.colors),
            opacities: m.bars.at(layout.opacities),
            screen: m.bars.at(layout.end),
        };
        // SAFETY: as for the forward kernels, whose arrays are as they left them; moments have a
        // place for each intersection, and bars for each parameter.
        unsafe {
            if drawn.intersections > 0 {
                kernels::splat_backward(&self.queue.grid(camera.tiles, 1, 1), &back)?;
            }
            kernels::splat_adjoint(&self.queue.grid(blocks(count), 1, 1), &adjoint)
        }
    }
}

/// A camera as kernels have it.
fn device_camera(camera: &Camera) -> SplatCamera {
    let columns = camera.width.div_ceil(TILE_PX);
    SplatCamera {
        rows: camera.world_to_camera,
        fx: camera.fx,
        fy: camera.fy,
        cx: camera.cx,
        cy: camera.cy,
        width: camera.width,
        height: camera.height,
        columns,
        tiles: columns * camera.height.div_ceil(TILE_PX),
    }
}

impl Rasteriser for CudaRasteriser {
    fn render(&mut self, gaussians: &Gaussians, camera: &Camera) -> Result<Image, Error> {
        check_input(gaussians, camera, None)?;
        let drawn = self.drawn(gaussians, camera)?;
        let image = self.memory.image(&self.queue, camera).map_err(failed)?;
        self.last = Some(drawn);
        Ok(image)
    }

    fn gradients(
        &mut self,
        gaussians: &Gaussians,
        camera: &Camera,
        bar: &ImageBar,
    ) -> Result<GaussiansBar, Error> {
        check_input(gaussians, camera, Some(bar))?;
        let drawn = self.drawn(gaussians, camera)?;
        if gaussians.is_empty() {
            return Ok(GaussiansBar::default());
        }
        self.backward(&drawn, gaussians.len(), bar).map_err(failed)?;
        let out = self.memory.gradients(&self.queue, gaussians.len()).map_err(failed)?;
        self.last = Some(drawn);
        Ok(out)
    }

    fn name(&self) -> String {
        self.queue.device.name.clone()
    }
}
