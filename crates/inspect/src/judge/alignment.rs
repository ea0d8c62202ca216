//! Judge of the grids of depth, colour and masks: all three must show one thing at one pixel. The
//! scan registers depth and colour onto the outlines of the masks; here the frames vote.

use bendtwin_core::Severity;

use super::{Assessment, Context, depth::is_sparse, named};
use crate::{
    Code, Finding,
    scan::{
        CameraScan,
        outline::{Fit, OutlineFit},
    },
    statistics::median,
    thresholds::AlignmentThresholds,
};

/// The image that lies on another grid than the other two.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Image {
    Depth,
    Masks,
    Color,
}

/// A camera's image on another grid.
#[derive(Clone, Copy, Debug)]
struct Misaligned {
    camera: usize,
    image: Image,
    mirrored: [bool; 2],
    /// Pixels of the masks per pixel of depth.
    scale: f64,
    shift_px: [f64; 2],
    /// Distance by which what the masks show is moved [px].
    moved_px: f64,
    is_bad: bool,
}

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    if let Some(finding) = inverted(context) {
        assessment.findings.push(finding);
        return;
    }
    let found: Vec<Misaligned> = context
        .scans
        .iter()
        .enumerate()
        .filter_map(|(camera, scan)| misaligned(context, camera, scan))
        .collect();
    for image in [Image::Depth, Image::Masks, Image::Color] {
        let own: Vec<&Misaligned> = found.iter().filter(|m| m.image == image).collect();
        assessment.findings.extend(finding(context, image, &own));
    }
}

/// Finding of numbers that are larger where things are nearer.
fn inverted(context: &Context<'_>) -> Option<Finding> {
    let limits = &context.thresholds.alignment;
    let is_inverted = |scan: &CameraScan| {
        let share = median(scan.outlines.iter().map(|o| o.forward_share));
        share.is_some_and(|share| share > limits.min_forward_share)
    };
    let cameras: Vec<usize> = (0..context.scans.len())
        .filter(|c| context.scans.get(*c).is_some_and(is_inverted))
        .collect();
    let names: Vec<String> = cameras.iter().map(|c| named(context.recording, *c)).collect();
    (!cameras.is_empty()).then(|| {
        let message = format!(
            "depth of {} is larger on the object than on the background around it: numbers that fall with distance, \
             disparities for example, are no depth",
            names.join(", ")
        );
        Finding::error(Code::DepthInverted, message).cameras(cameras)
    })
}

fn misaligned(context: &Context<'_>, camera: usize, scan: &CameraScan) -> Option<Misaligned> {
    let limits = &context.thresholds.alignment;
    let width = context.recording.cameras.get(camera)?.width as f64;
    let middle =
        |of: &dyn Fn(&OutlineFit) -> Option<f64>| median(scan.outlines.iter().filter_map(of));
    let color = |of: fn(&Fit) -> f64| middle(&|o| o.color.as_ref().map(of));
    let share = middle(&|o| Some(o.depth.share))?;
    let gain = middle(&|o| Some(o.depth.share - o.depth.declared_share))?;
    let moved_px = middle(&|o| Some(o.depth.moved_px))?;
    // The edges of what is missing are no outlines, and pull the fit by a pixel or two.
    let min_moved_px = match is_sparse(context, scan) {
        true => limits.min_moved_sparse_px,
        false => limits.min_moved_px,
    };
    let is_off = share > limits.min_share && gain > limits.min_gain && moved_px > min_moved_px;
    if is_off && let Some(fit) = agreed(&scan.outlines, width, limits) {
        // Masks are drawn on colour; if they suit it better where depth is, they are what is off.
        let with_depth = middle(&|o| o.color_with_depth);
        let masks_are_off = with_depth
            .zip(color(|c| c.declared_share))
            .is_some_and(|(with, declared)| with > declared + limits.min_color_gain);
        let scale = 1.0 / fit.warp.scale;
        let mirrored = fit.warp.mirrored;
        let is_bad = mirrored != [false; 2]
            || (scale - 1.0).abs() > limits.bad_scale_error
            || moved_px > limits.bad_moved_widths * width;
        let image = if masks_are_off { Image::Masks } else { Image::Depth };
        let shift_px = fit.warp.shift_px;
        return Some(Misaligned { camera, image, mirrored, scale, shift_px, moved_px, is_bad });
    }
    let (mirrored, declared) = (color(|c| c.share)?, color(|c| c.declared_share)?);
    if mirrored > limits.min_share && mirrored > declared + limits.min_mirrored_gain {
        let fits = scan.outlines.iter().filter_map(|o| o.color);
        let warps: Vec<[bool; 2]> = fits.map(|c| c.warp.mirrored).collect();
        let mirrored = *warps.iter().max_by_key(|m| warps.iter().filter(|o| o == m).count())?;
        let moved_px = color(|c| c.moved_px)?;
        let (image, scale, shift_px) = (Image::Color, 1.0, [0.0; 2]);
        return Some(Misaligned {
            camera,
            image,
            mirrored,
            scale,
            shift_px,
            moved_px,
            is_bad: true,
        });
    }
    None
}

/// A frame's fit that most frames agree with; `None` if they do not agree.
fn agreed(outlines: &[OutlineFit], width: f64, limits: &AlignmentThresholds) -> Option<Fit> {
    let reach_px = limits.same_shift_px + limits.same_shift_widths * width;
    let same = |a: &Fit, b: &Fit| {
        let apart = |axis: usize| (a.warp.shift_px[axis] - b.warp.shift_px[axis]).abs();
        a.warp.mirrored == b.warp.mirrored
            && (a.warp.scale / b.warp.scale - 1.0).abs() < limits.same_scale
            && apart(0).hypot(apart(1)) < reach_px
    };
    let votes = |a: &Fit| outlines.iter().filter(|o| same(a, &o.depth)).count();
    let best = outlines.iter().map(|o| o.depth).max_by_key(votes)?;
    (votes(&best) as f64 >= limits.min_votes * outlines.len() as f64).then_some(best)
}

fn finding(context: &Context<'_>, image: Image, found: &[&Misaligned]) -> Option<Finding> {
    let worst = found.iter().max_by(|a, b| a.moved_px.total_cmp(&b.moved_px))?;
    let names: Vec<String> = found.iter().map(|m| named(context.recording, m.camera)).collect();
    let names = names.join(", ");
    let how = change(worst);
    let (code, message) = match image {
        Image::Depth => (
            Code::DepthMisaligned,
            format!(
                "depth of {names} is not aligned to colour: its edges lie on the outlines of the masks if it is {how} \
                 (the object moves by {:.1} px)",
                worst.moved_px
            ),
        ),
        Image::Masks => (
            Code::MasksMisaligned,
            format!(
                "the masks of {names} lie beside what colour and depth show, by {:.1} px: depth would suit them if it \
                 were {how}, colour likewise",
                worst.moved_px
            ),
        ),
        Image::Color => (
            Code::ColorMisaligned,
            format!("colour of {names} suits masks and depth if it is {how}"),
        ),
    };
    let is_bad = found.iter().any(|m| m.is_bad);
    let severity = if is_bad { Severity::Error } else { Severity::Warning };
    Some(
        Finding::new(severity, code, message)
            .cameras(found.iter().map(|m| m.camera))
            .number("moved_px", worst.moved_px)
            .number("scale", worst.scale),
    )
}

/// The change of an image that would align it, in words.
fn change(found: &Misaligned) -> String {
    let mut parts = Vec::new();
    match found.mirrored {
        [true, false] => parts.push("mirrored left to right".to_owned()),
        [false, true] => parts.push("mirrored top to bottom".to_owned()),
        [true, true] => parts.push("turned by 180 degrees".to_owned()),
        [false, false] => {}
    }
    if (found.scale - 1.0).abs() > 0.02 {
        let (word, times) = if found.scale > 1.0 {
            ("enlarged", found.scale)
        } else {
            ("made smaller", 1.0 / found.scale)
        };
        parts.push(format!("{word} {times:.2} times"));
    }
    // A warp takes a pixel of the masks to one of the image, which moves the other way.
    let [x, y] = found.shift_px.map(|s| -s);
    let nothing_else = parts.is_empty();
    for (px, [less, more]) in [(x, ["left", "right"]), (y, ["up", "down"])] {
        if px.abs() > 1.0 || (nothing_else && px.abs() >= x.abs().max(y.abs())) {
            let way = if px < 0.0 { less } else { more };
            parts.push(format!("moved {way} by {:.1} px", px.abs()));
        }
    }
    parts.join(" and ")
}
