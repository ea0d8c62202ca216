//! Depth, colour and masks that do not lie on one grid, and numbers of depth that mean something
//! else: mistakes while streams are set up.

use std::sync::Arc;

use bendtwin_capture::raw::{ColorImage, DepthImage, Image, Mask};

use crate::{
    Broken,
    Expected::Found,
    Make, broken,
    footage::{FRAMES, Footage},
};

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    [depth(), color(), masks(), numbers()].concat()
}

fn footage(name: &'static str, code: &'static str, change: fn(&mut Footage)) -> Broken {
    broken(name, Found(code), Make::Footage(change))
}

fn depth() -> Vec<Broken> {
    vec![
        footage("depth of a wider field of view", "DEPTH_MISALIGNED", |f| {
            each_depth(f, 0..3, |d| zoomed(d, 0.0, 1.43));
        }),
        footage("depth of a narrower field of view", "DEPTH_MISALIGNED", |f| {
            each_depth(f, 0..3, |d| zoomed(d, 0.0, 0.7));
        }),
        footage("depth that lies three pixels beside colour", "DEPTH_MISALIGNED", |f| {
            each_depth(f, 0..3, |d| moved(d, 0.0, [3, 0]));
        }),
        footage("one camera's depth five pixels too low", "DEPTH_MISALIGNED", |f| {
            each_depth(f, 1..2, |d| moved(d, 0.0, [0, 5]));
        }),
        footage("mirrored depth", "DEPTH_MISALIGNED", |f| {
            each_depth(f, 0..3, |d| flipped(d, [true, false]));
        }),
        footage("one camera's depth upside down", "DEPTH_MISALIGNED", |f| {
            each_depth(f, 2..3, |d| flipped(d, [false, true]));
        }),
        footage("depth of a camera that was mounted upside down", "DEPTH_MISALIGNED", |f| {
            each_depth(f, 0..1, |d| flipped(d, [true, true]));
        }),
    ]
}

fn color() -> Vec<Broken> {
    vec![
        footage("colour mirrored against depth and masks", "COLOR_MISALIGNED", |f| {
            each_color(f, 0..3, |c| flipped(c, [true, false]));
        }),
        footage("one camera's colour turned by half a turn", "COLOR_MISALIGNED", |f| {
            each_color(f, 1..2, |c| flipped(c, [true, true]));
        }),
        footage("colour upside down", "COLOR_MISALIGNED", |f| {
            each_color(f, 0..3, |c| flipped(c, [false, true]));
        }),
        footage("a colour stream that froze", "COLOR_FROZEN", |f| {
            f.reels[1].color = vec![f.reels[1].color[0].clone(); FRAMES];
        }),
    ]
}

fn masks() -> Vec<Broken> {
    vec![
        footage("mirrored masks", "MASKS_MISALIGNED", |f| {
            each_mask(f, 0..3, |m| flipped(m, [true, false]));
        }),
        footage("masks that lie five pixels beside the images", "MASKS_MISALIGNED", |f| {
            each_mask(f, 0..3, |m| moved(m, false, [-5, 0]));
        }),
        footage("masks of the middle of the images", "MASKS_MISALIGNED", |f| {
            each_mask(f, 0..3, |m| zoomed(m, false, 0.8));
        }),
        footage("one camera's masks of turned images", "MASKS_MISALIGNED", |f| {
            each_mask(f, 2..3, |m| flipped(m, [true, true]));
        }),
    ]
}

fn numbers() -> Vec<Broken> {
    vec![
        footage("65535 where nothing was measured", "DEPTH_FILLED", |f| {
            speckled(f, 65.535);
        }),
        footage("the largest number of tenths of millimetres for no depth", "DEPTH_FILLED", |f| {
            speckled(f, 6.5535);
        }),
        footage("depth in tenths of a millimetre", "DEPTH_UNITS", |f| {
            (0..3).for_each(|c| f.change_depth(c, |z| 10.0 * z));
        }),
        footage("depth of a single camera in tenths of a millimetre", "SCALE_TOO_LARGE", |f| {
            f.about.cameras.truncate(1);
            f.reels.truncate(1);
            f.change_depth(0, |z| 10.0 * z);
        }),
        footage("one camera's depth in tenths of a millimetre", "DEPTH_SCALE", |f| {
            f.change_depth(0, |z| 10.0 * z);
        }),
        footage("disparities for depth", "DEPTH_INVERTED", |f| {
            (0..3).for_each(|c| f.change_depth(c, |z| if z > 0.0 { 7.0 / z } else { 0.0 }));
        }),
        footage("depth of half of the image", "DEPTH_SPARSE", |f| {
            each_depth(f, 0..3, |d| {
                let mut half = d.clone();
                let middle = d.width * 9 / 16;
                half.pixels.chunks_mut(d.width).for_each(|row| row[..middle].fill(0.0));
                half
            });
        }),
        footage("one camera without a single depth", "DEPTH_SPARSE", |f| {
            f.change_depth(1, |_| 0.0);
        }),
        footage("depth that ends before the object", "DEPTH_EMPTY", |f| {
            (0..3).for_each(|c| f.change_depth(c, |z| if z < 0.3 { z } else { 0.0 }));
        }),
        footage("negative depth", "DEPTH_EMPTY", |f| {
            (0..3).for_each(|c| f.change_depth(c, |z| -z));
        }),
    ]
}

/// Puts a number in place of every seventh depth.
fn speckled(footage: &mut Footage, value: f32) {
    each_depth(footage, 0..3, |d| {
        let mut filled = d.clone();
        filled.pixels.iter_mut().step_by(7).for_each(|z| *z = value);
        filled
    });
}

fn each_depth(
    footage: &mut Footage,
    cameras: std::ops::Range<usize>,
    change: impl Fn(&DepthImage) -> DepthImage,
) {
    for depth in footage.reels[cameras].iter_mut().flat_map(|r| r.depth.iter_mut().flatten()) {
        *depth = Arc::new(change(depth));
    }
}

fn each_color(
    footage: &mut Footage,
    cameras: std::ops::Range<usize>,
    change: impl Fn(&ColorImage) -> ColorImage,
) {
    for color in footage.reels[cameras].iter_mut().flat_map(|r| r.color.iter_mut().flatten()) {
        *color = Arc::new(change(color));
    }
}

fn each_mask(
    footage: &mut Footage,
    cameras: std::ops::Range<usize>,
    change: impl Fn(&Mask) -> Mask,
) {
    for reel in &mut footage.reels[cameras] {
        for mask in reel.object.iter_mut().chain(&mut reel.hand).flatten() {
            *mask = Arc::new(change(mask));
        }
    }
}

/// The image of which each pixel shows what was at another place.
fn warped<P: Copy>(image: &Image<P>, blank: P, from: impl Fn([f64; 2]) -> [f64; 2]) -> Image<P> {
    let mut out = Image::filled(image.width, image.height, blank);
    for (i, pixel) in out.pixels.iter_mut().enumerate() {
        let [x, y] = from([(i % image.width) as f64, (i / image.width) as f64]).map(f64::round);
        if x >= 0.0 && y >= 0.0 {
            *pixel = image.get(x as usize, y as usize).unwrap_or(blank);
        }
    }
    out
}

/// A field of view `times` times as wide.
fn zoomed<P: Copy>(image: &Image<P>, blank: P, times: f64) -> Image<P> {
    let center = [image.width, image.height].map(|n| (n as f64 - 1.0) / 2.0);
    warped(image, blank, |at| std::array::from_fn(|a| center[a] + times * (at[a] - center[a])))
}

fn moved<P: Copy>(image: &Image<P>, blank: P, by: [i32; 2]) -> Image<P> {
    warped(image, blank, |at| [at[0] - f64::from(by[0]), at[1] - f64::from(by[1])])
}

fn flipped<P: Copy>(image: &Image<P>, axes: [bool; 2]) -> Image<P> {
    let last = [image.width, image.height].map(|n| n as f64 - 1.0);
    warped(image, image.pixels[0], |at| {
        std::array::from_fn(|a| if axes[a] { last[a] - at[a] } else { at[a] })
    })
}
