//! Knowledge of a camera about places in space in the first frame, where twins start: from its masks
//! and its cleaned depth.

use bendtwin_capture::raw::{Camera, DepthImage, Image, Recording, Region};
use bendtwin_core::{CancelToken, Point, settings::ingest::IngestSettings};

use crate::{
    Error,
    error::check,
    survey::clean::{Label, clean},
};

/// Pixels beyond a mask that may still be what it shows: segmenters leave out rims.
const RIM_PX: i64 = 1;
/// A place this far in front of the measured surface may still lie on it [m].
const SLACK_M: f64 = 0.004;

/// A camera's first frame.
pub(crate) struct FirstView<'a> {
    camera: &'a Camera,
    depth: DepthImage,
    /// Labels by the masks.
    shown: Image<Label>,
    /// Labels of those pixels whose depth is that of what the masks show.
    labels: Image<Label>,
}

/// Knowledge of a camera about a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    /// Nothing: it is out of view, or something without a mask stands in front.
    Unknown,
    /// The camera looks through it.
    Empty,
    /// Behind what a mask shows, or on it.
    Behind(Label),
}

/// The first frame of every camera that has masks and depth of it.
pub(crate) fn first_views<'a>(
    recording: &'a Recording,
    settings: &IngestSettings,
    cancel: &CancelToken,
) -> Result<Vec<FirstView<'a>>, Error> {
    let mut views = Vec::new();
    for (index, camera) in recording.cameras.iter().enumerate() {
        check(cancel)?;
        let mut frames = recording.source.frames(index)?;
        let Some(depth) = frames.depth(0)? else { continue };
        let Some(object) = frames.mask(0, Region::Object)? else { continue };
        let manipulator = frames.mask(0, Region::Manipulator)?;
        let count = camera.width.saturating_mul(camera.height);
        let sizes = [Some(depth.pixels.len()), Some(object.pixels.len())];
        let sizes = sizes.into_iter().chain([manipulator.as_ref().map(|m| m.pixels.len())]);
        if depth.width != camera.width || sizes.flatten().any(|size| size != count) {
            continue;
        }
        let mut shown = Image::filled(camera.width, camera.height, Label::None);
        // A hand is in front of what it holds.
        for (mask, label) in
            [(Some(&object), Label::Object), (manipulator.as_ref(), Label::Manipulator)]
        {
            let pixels = mask.into_iter().flat_map(|m| &m.pixels);
            shown.pixels.iter_mut().zip(pixels).filter(|(_, m)| **m).for_each(|(l, _)| *l = label);
        }
        let labels =
            clean(&depth, Some(&object), manipulator.as_ref(), &camera.intrinsics, &settings.masks)
                .labels;
        views.push(FirstView { camera, depth, shown, labels });
    }
    Ok(views)
}

impl FirstView<'_> {
    /// The surface that masks and depth show of a label [m].
    #[cfg(test)]
    pub(crate) fn surface(&self, label: Label) -> Vec<Point> {
        let width = self.camera.width;
        let of_label = self.labels.pixels.iter().enumerate().filter(|(_, l)| **l == label);
        let place = |at: usize| {
            let pixel = [(at % width) as f64, (at / width) as f64];
            self.camera.unproject(pixel, f64::from(self.depth.pixels[at]), 0)
        };
        of_label.map(|(at, _)| place(at)).collect()
    }

    /// The camera's knowledge of a place.
    pub(crate) fn sight(&self, place: Point) -> Sight {
        let Some(([u, v], depth_m)) = self.camera.project(place, 0) else { return Sight::Unknown };
        let (u, v) = (u.round(), v.round());
        let inside =
            u >= 0.0 && v >= 0.0 && u < self.camera.width as f64 && v < self.camera.height as f64;
        if !inside {
            return Sight::Unknown;
        }
        let (column, row) = (u as usize, v as usize);
        let at = row * self.camera.width + column;
        let measured_m = f64::from(self.depth.pixels[at]);
        match self.labels.pixels[at] {
            Label::None => {}
            _ if depth_m < measured_m - SLACK_M => return Sight::Empty,
            label => return Sight::Behind(label),
        }
        match self.shown_near(column, row) {
            // Of a rim the depth is not known: the place may lie in front of it.
            Label::Object | Label::Manipulator => Sight::Unknown,
            // Something that no mask shows stands in front.
            Label::None if measured_m > 0.0 && measured_m < depth_m - SLACK_M => Sight::Unknown,
            Label::None => Sight::Empty,
        }
    }

    /// Label that masks give to a pixel or one next to it.
    fn shown_near(&self, column: usize, row: usize) -> Label {
        let (column, row) = (column as i64, row as i64);
        let around = -RIM_PX..=RIM_PX;
        let pixels =
            around.clone().flat_map(|y| around.clone().map(move |x| (column + x, row + y)));
        pixels
            .filter_map(|(x, y)| self.shown.get(usize::try_from(x).ok()?, usize::try_from(y).ok()?))
            .find(|label| *label != Label::None)
            .unwrap_or(Label::None)
    }
}
