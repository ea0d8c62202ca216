//! Likeness of renderings to what cameras saw.

use bendtwin_core::{
    View, ViewCamera, Views,
    quality::{CameraScore, Likeness, RenderedScore},
};
use bendtwin_image_metrics::{Image as Compared, Pair, Whole, flip, iou, psnr, ssim};
use bendtwin_splat::{Camera, Gaussians, Image, Rasteriser};

use crate::{
    Dressed, Error, Motion, camera,
    target::{Rectangle, Target},
};

/// Coverage from which a pixel belongs to the silhouette.
const COVERED: f32 = 0.5;
/// Largest peak signal-to-noise ratio [dB]: that of equal images has no bound.
const MOST_PSNR_DB: f64 = 100.0;
/// Pixels around the object that windows of the measures reach over.
const MARGIN: f32 = 12.0;
/// Standard deviations from a mean at which a Gaussian ends.
const REACH: f32 = 3.5;

/// Gaussians, motion and views that are compared.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The Gaussians of a twin.
    pub dressed: &'a Dressed,
    /// The twin's predicted motion.
    pub motion: Motion<'a>,
    /// The views of the recording.
    pub views: &'a Views,
    /// Cameras, counted from 0, that its looks were made without.
    pub held_out: &'a [u32],
}

/// Renders every frame of the motion into every camera that has a view of it and compares the images.
/// `keep_going` is asked before each frame; `None` if it says no.
///
/// # Errors
/// If the rasteriser fails.
pub fn score(
    scene: &Scene<'_>,
    rasteriser: &mut dyn Rasteriser,
    per_frame: bool,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<Option<RenderedScore>, Error> {
    let cameras = &scene.views.cameras;
    let mut sums = vec![[Sum::default(); 2]; cameras.len()];
    let mut whole = [Sum::default(); 2];
    let mut frames = Vec::new();
    let is_held_out = |camera: usize| scene.held_out.iter().any(|h| *h as usize == camera);
    for frame in scene.motion.frames() {
        if !keep_going() {
            return Ok(None);
        }
        let Some(nodes) = scene.motion.at(frame) else { continue };
        let number = u32::try_from(frame).unwrap_or(u32::MAX);
        let gaussians = scene.dressed.at(nodes)?;
        let span = usize::from(frame >= scene.motion.train_frame_count);
        let mut of_frame = Sum::default();
        for (index, camera) in cameras.iter().enumerate() {
            let Some(view) = camera.view(number) else { continue };
            let likeness = compare(&gaussians, camera, view, rasteriser)?;
            sums[index][span].add(&likeness);
            if !is_held_out(index) {
                whole[span].add(&likeness);
                of_frame.add(&likeness);
            }
        }
        if per_frame {
            frames.push(of_frame.mean());
        }
    }
    let [train, future] = whole.map(|sum| sum.mean());
    let of_camera = |(index, camera): (usize, &ViewCamera)| {
        let [train, future] = sums[index].map(|sum| sum.mean());
        CameraScore { name: camera.name.clone(), held_out: is_held_out(index), train, future }
    };
    Ok(Some(RenderedScore {
        gaussians: u32::try_from(scene.dressed.len()).unwrap_or(u32::MAX),
        train,
        future,
        cameras: cameras.iter().enumerate().map(of_camera).collect(),
        per_frame: frames,
    }))
}

/// Sums of likenesses.
#[derive(Clone, Copy, Default)]
struct Sum {
    sums: OfImage,
    count: u32,
}

/// IoU, PSNR, SSIM and FLIP of one image.
type OfImage = [f64; 4];

impl Sum {
    fn add(&mut self, likeness: &OfImage) {
        self.sums.iter_mut().zip(likeness).for_each(|(sum, x)| *sum += x);
        self.count += 1;
    }

    fn mean(self) -> Likeness {
        if self.count == 0 {
            return Likeness::default();
        }
        let [iou, psnr_db, ssim, flip] = self.sums.map(|sum| Some(sum / f64::from(self.count)));
        Likeness { iou, psnr_db, ssim, flip, lpips: None }
    }
}

/// Likeness of one image.
fn compare(
    gaussians: &Gaussians,
    camera: &ViewCamera,
    view: &View,
    rasteriser: &mut dyn Rasteriser,
) -> Result<OfImage, Error> {
    let whole = camera::whole(camera, view.frame);
    let area = around(gaussians, &whole, view);
    let [left, top] = area.corner;
    let image = rasteriser.render(gaussians, &whole.crop(left, top, area.size[0], area.size[1]))?;
    likeness(&image, &Target::new(view, area), whole.pixel_count())
}

fn likeness(image: &Image, target: &Target, whole: usize) -> Result<OfImage, Error> {
    let failed = |e: bendtwin_image_metrics::Error| Error::Compare(e.to_string());
    let [width, height] = target.area.size;
    let rendered = Compared::new(width, height, &image.color).map_err(failed)?;
    let recorded = Compared::new(width, height, &target.colors).map_err(failed)?;
    let pair = Pair::new(rendered, recorded, Some(&target.valid)).map_err(failed)?;
    let covered: Vec<bool> = image.alpha.iter().map(|a| *a > COVERED).collect();
    let of_whole = Whole::new(target.area.pixel_count(), whole).map_err(failed)?;
    Ok([
        iou(&covered, &target.object, Some(&target.valid)),
        of_whole.psnr(psnr(&pair)).min(MOST_PSNR_DB),
        of_whole.ssim(ssim(&pair)),
        of_whole.flip(flip(&pair)),
    ])
}

/// The part of an image that a view or a Gaussian reaches, with a margin.
pub(crate) fn around(gaussians: &Gaussians, camera: &Camera, view: &View) -> Rectangle {
    let (mut low, mut high) = ([0_i64; 2], [0_i64; 2]);
    for axis in 0..2 {
        low[axis] = i64::from(view.corner[axis]);
        high[axis] = low[axis] + i64::from(view.size[axis]);
    }
    for (mean, scales) in gaussians.means_m.iter().zip(&gaussians.scales_m) {
        let at = camera
            .world_to_camera
            .map(|row| row[0] * mean[0] + row[1] * mean[1] + row[2] * mean[2] + row[3]);
        if at[2] < 0.05 {
            continue;
        }
        let largest = scales.iter().copied().fold(0.0, f32::max);
        let focal = [camera.fx, camera.fy];
        let centre = [camera.cx, camera.cy];
        for axis in 0..2 {
            let place = focal[axis] * at[axis] / at[2] + centre[axis];
            let reach = REACH * largest * focal[axis] / at[2] + MARGIN;
            low[axis] = low[axis].min((place - reach) as i64);
            high[axis] = high[axis].max((place + reach) as i64 + 1);
        }
    }
    let size = [camera.width, camera.height];
    let within = |x: i64, axis: usize| x.clamp(0, i64::from(size[axis])) as u32;
    let corner = [within(low[0], 0), within(low[1], 1)];
    let size = [within(high[0], 0) - corner[0], within(high[1], 1) - corner[1]];
    Rectangle { corner, size }
}

#[cfg(test)]
mod tests;
