//! Sizes and motions of labels, so that a person can tell which is which.

use std::collections::BTreeMap;

use super::parts::{Part, Stored, sample};
use crate::{files::Files, raw::Camera};

/// Images of each part that are looked at.
const LOOKED_AT: usize = 5;

/// Pixels of all labels of an image beyond which their sizes are left out.
const MOST_PIXELS: usize = 1 << 28;

/// Pixels of a label in one image: their number, and the sums of columns and rows.
type Pixels = [f64; 3];

/// Each label with its share of the image and the motion of its centre; empty if none can be read.
pub(super) fn in_words(files: &Files<'_>, camera: &Camera, parts: &[Part]) -> Vec<String> {
    let size = [camera.width, camera.height];
    if size[0].saturating_mul(size[1]).saturating_mul(parts.len()) > MOST_PIXELS {
        return Vec::new();
    }
    let mut seen: BTreeMap<&str, Vec<Pixels>> = BTreeMap::new();
    let mut last = "";
    for part in parts {
        let Stored::Images(images) = &part.stored else { continue };
        // All labels of the same images are read together.
        if part.is_one_of && part.at == last {
            continue;
        }
        last = &part.at;
        for labelled in sample(files, images, camera, LOOKED_AT) {
            let mut pixels: BTreeMap<&str, Pixels> = BTreeMap::new();
            labelled.each(size, |label, index| {
                let own = if part.is_one_of {
                    parts.iter().find(|p| p.label == label).map(|p| p.label.as_str())
                } else {
                    Some(part.label.as_str())
                };
                let Some(own) = own else { return };
                let sums = pixels.entry(own).or_default();
                sums[0] += 1.0;
                sums[1] += (index % size[0]) as f64;
                sums[2] += (index / size[0]) as f64;
            });
            for (label, sums) in pixels {
                seen.entry(label).or_default().push(sums);
            }
        }
    }
    let whole = (size[0] * size[1]).max(1) as f64;
    let in_words = |part: &Part| {
        let images = seen.get(part.label.as_str())?;
        let mean = images.iter().map(|p| p[0]).sum::<f64>() / images.len() as f64;
        let centres = images.iter().map(|[n, x, y]| [x / n, y / n]);
        let first = centres.clone().next()?;
        let moved = centres.map(|c| (c[0] - first[0]).hypot(c[1] - first[1])).fold(0.0, f64::max);
        let share = 100.0 * mean / whole;
        Some(format!("{} ({share:.1} % of the image, moving {moved:.0} pixels)", part.label))
    };
    parts.iter().filter_map(in_words).collect()
}
