//! From samples to pixels: the background, Gaussians by their coverage, and edges as the mean of their samples' light.

use bendtwin_splat::Image;

use super::{Background, Band, OBJECT, Object, Scene};
use crate::{
    light::{encoded, linear},
    raster::{NOTHING, Raster, SAMPLES, Sample},
};

/// Coverage from which Gaussians count as seen: that of the overlap of silhouettes.
const SEEN: f32 = 0.5;

/// A band whose samples have been drawn.
pub(super) struct Composition<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) raster: &'a Raster,
    pub(super) width: usize,
}

/// The Gaussians at a pixel.
struct Cover {
    /// Sum of colours by weights (sRGB, 0..1).
    color: [f32; 3],
    alpha: f32,
    /// Inverse depth [1/m].
    nearness: f32,
}

type Samples = [Sample; SAMPLES * SAMPLES];

impl Composition<'_> {
    /// Fills the pixels of the band.
    pub(super) fn fill(&self, band: &mut Band<'_>) {
        let image = match self.scene.object {
            Object::Gaussians(image) => Some(image),
            Object::Surface(_) => None,
        };
        let first = band.first_row * self.width;
        for (k, color) in band.colors.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let behind = self.behind(first + k);
            let mut samples = self.raster.pixel(k % self.width, k / self.width);
            let cover = image.and_then(|image| self.cover(image, first + k));
            *color = match &cover {
                Some(cover) => covered(&samples, cover, behind),
                None => mean(&samples, behind),
            };
            if band.depths.is_empty() && band.labels.is_empty() {
                continue;
            }
            if let Some(cover) = cover.filter(|cover| cover.alpha >= SEEN) {
                for sample in samples.iter_mut().filter(|s| s.nearness <= cover.nearness) {
                    *sample = Sample { nearness: cover.nearness, label: OBJECT, ..*sample };
                }
            }
            let (label, depth) = seen(&samples);
            if let Some(of) = band.labels.get_mut(k) {
                *of = label;
            }
            if let Some(of) = band.depths.get_mut(k) {
                *of = depth;
            }
        }
    }

    /// The background at a pixel.
    fn behind(&self, pixel: usize) -> [u8; 3] {
        match self.scene.background {
            Background::Color(color) => color,
            Background::Image(colors) => {
                colors.as_chunks::<3>().0.get(pixel).copied().unwrap_or_default()
            }
        }
    }

    /// The Gaussians at a pixel, if there are any.
    fn cover(&self, image: &Image, pixel: usize) -> Option<Cover> {
        let alpha = image.alpha[pixel];
        if alpha <= 0.0 {
            return None;
        }
        let brightness = self.scene.light.brightness;
        let color = image.color[pixel].map(|sum| match brightness {
            1.0 => sum,
            factor => {
                let light = linear_of(sum / alpha) * factor;
                f32::from(encoded(light)) / 255.0 * alpha
            }
        });
        Some(Cover { color, alpha, nearness: alpha / image.depth_m[pixel] })
    }
}

/// The light of a colour (sRGB, 0..1), which has less than 8 bits after the point.
fn linear_of(color: f32) -> f32 {
    linear([(255.0 * color + 0.5) as u8; 3])[0]
}

fn byte(color: f32) -> u8 {
    (255.0 * color + 0.5) as u8
}

/// Colour of samples before a background.
fn mean(samples: &Samples, behind: [u8; 3]) -> [u8; 3] {
    if samples.iter().all(|sample| sample.label == NOTHING) {
        return behind;
    }
    let mut sum = [0.0; 3];
    for sample in samples {
        let light = if sample.label == NOTHING { linear(behind) } else { sample.light };
        sum = [0, 1, 2].map(|k| sum[k] + light[k].min(1.0));
    }
    sum.map(|light| encoded(light / samples.len() as f32))
}

/// Colour of Gaussians between samples that are nearer and those that are farther away.
fn covered(samples: &Samples, cover: &Cover, behind: [u8; 3]) -> [u8; 3] {
    // Gaussians are blended as they were trained: in sRGB.
    let over = |color: [f32; 3]| -> [f32; 3] {
        [0, 1, 2].map(|k| cover.color[k] + (1.0 - cover.alpha) * color[k])
    };
    let shown = |color: [u8; 3]| color.map(|byte| f32::from(byte) / 255.0);
    if samples.iter().all(|sample| sample.label == NOTHING) {
        return over(shown(behind)).map(byte);
    }
    let mut sum = [0.0; 3];
    for sample in samples {
        let light = if sample.label == NOTHING {
            over(shown(behind)).map(linear_of)
        } else if sample.nearness > cover.nearness {
            sample.light
        } else {
            over(shown(sample.light.map(encoded))).map(linear_of)
        };
        sum = [0, 1, 2].map(|k| sum[k] + light[k].min(1.0));
    }
    sum.map(|light| encoded(light / samples.len() as f32))
}

/// Label that most samples have, the nearer of two that as many have, and the depth of its samples: that at the
/// centre of the pixel where all have the same plane.
fn seen(samples: &Samples) -> (u8, f32) {
    let [first, ..] = samples;
    let of = |label: u8| {
        let own = samples.iter().filter(|sample| sample.label == label);
        let (count, sum) = own.fold((0, 0.0), |(n, sum), sample| (n + 1, sum + sample.nearness));
        (count, sum / count as f32)
    };
    let mut best = (first.label, of(first.label));
    for label in samples.iter().skip(1).map(|sample| sample.label) {
        let (count, nearness) = of(label);
        if label != best.0 && (count, nearness) > best.1 {
            best = (label, (count, nearness));
        }
    }
    let (label, (_, nearness)) = best;
    (label, if label == NOTHING { 0.0 } else { 1.0 / nearness })
}
