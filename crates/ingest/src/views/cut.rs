//! The image plane of a camera's views, and cuts from recorded images onto it.

use bendtwin_capture::raw::{Camera, ColorImage, DepthImage, Distortion, Mask};
use bendtwin_core::{View, ViewCamera, views::Label};

/// Longest side of a whole image of views; larger ones are reduced [pixels].
const SIDE: usize = 848;
/// Margin around the object: a share of its size, and pixels.
const MARGIN: f64 = 0.15;
const MARGIN_PIXELS: f64 = 12.0;
/// Largest depth that millimetres in 16 bits can say [m].
const FARTHEST_M: f32 = 65.0;

/// A pinhole whose pixels have known places in recorded images.
pub(super) struct Grid {
    /// Recorded pixels to a pixel, along each axis.
    reduction: usize,
    size: [u32; 2],
    focal: [f64; 2],
    centre: [f64; 2],
    distortion: Distortion,
    /// Focal lengths and principal point of the recorded images.
    recorded: [[f64; 2]; 2],
}

impl Grid {
    pub(super) fn new(camera: &Camera) -> Self {
        let reduction = camera.width.max(camera.height).div_ceil(SIDE).max(1);
        let k = reduction as f64;
        let i = camera.intrinsics;
        // The middle of the first k pixels becomes the middle of the first pixel.
        let centre = [i.cx, i.cy].map(|c| (c - 0.5 * (k - 1.0)) / k);
        let side = |pixels: usize| u32::try_from(pixels / reduction).unwrap_or(u32::MAX);
        Self {
            reduction,
            size: [side(camera.width), side(camera.height)],
            focal: [i.fx / k, i.fy / k],
            centre,
            distortion: camera.distortion,
            recorded: [[i.fx, i.fy], [i.cx, i.cy]],
        }
    }

    /// The camera of the views, without any.
    pub(super) fn camera(&self, camera: &Camera) -> ViewCamera {
        let pose = |pose: &bendtwin_capture::raw::Pose| {
            let (r, t) = (pose.rotation, pose.translation);
            std::array::from_fn(|j| {
                let moved: f64 = (0..3).map(|i| r[i][j] * t[i]).sum();
                [r[0][j], r[1][j], r[2][j], -moved]
            })
        };
        ViewCamera {
            name: camera.name.clone(),
            size: self.size,
            focal: self.focal,
            centre: self.centre,
            world_to_camera: camera.poses.iter().map(pose).collect(),
            views: Vec::new(),
        }
    }

    /// Place in the recorded image of a place on this plane.
    fn recorded_at(&self, place: [f64; 2]) -> [f64; 2] {
        let axis = |a: usize| (place[a] - self.centre[a]) / self.focal[a];
        let [u, v] = self.distortion.distort([axis(0), axis(1)]);
        let [focal, centre] = self.recorded;
        [focal[0] * u + centre[0], focal[1] * v + centre[1]]
    }

    /// Place on this plane of a place in the recorded image.
    fn place_of(&self, recorded: [f64; 2]) -> [f64; 2] {
        let [focal, centre] = self.recorded;
        let axis = |a: usize| (recorded[a] - centre[a]) / focal[a];
        let [x, y] = self.distortion.undistort([axis(0), axis(1)]);
        [self.focal[0] * x + self.centre[0], self.focal[1] * y + self.centre[1]]
    }

    /// Corner and size of the part around what a mask shows; none if it shows nothing.
    pub(super) fn around(&self, mask: &Mask) -> Option<([u32; 2], [u32; 2])> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for row in 0..mask.height {
            let shown = mask.row(row);
            let Some(first) = shown.iter().position(|m| *m) else { continue };
            let last = shown.iter().rposition(|m| *m).unwrap_or(first);
            for column in [first, last] {
                let place = self.place_of([column as f64, row as f64]);
                for axis in 0..2 {
                    low[axis] = low[axis].min(place[axis]);
                    high[axis] = high[axis].max(place[axis]);
                }
            }
        }
        let (mut corner, mut size) = ([0; 2], [0; 2]);
        for axis in 0..2 {
            let margin = MARGIN * (high[axis] - low[axis]) + MARGIN_PIXELS;
            let most = f64::from(self.size[axis]);
            // Nothing shown, or a lens that puts it nowhere.
            if !margin.is_finite() || low[axis] >= most || high[axis] < 0.0 {
                return None;
            }
            let first = (low[axis] - margin).floor().clamp(0.0, most);
            corner[axis] = first as u32;
            size[axis] =
                ((high[axis] + margin).ceil() + 1.0).clamp(first, most) as u32 - corner[axis];
        }
        (size[0] > 0 && size[1] > 0).then_some((corner, size))
    }

    /// Fills a view from the images of its frame.
    pub(super) fn cut(
        &self,
        mut view: View,
        color: &ColorImage,
        object: &Mask,
        hand: Option<&Mask>,
        depth: Option<&DepthImage>,
    ) -> View {
        let [left, top] = view.corner;
        for row in top..top + view.size[1] {
            for column in left..left + view.size[0] {
                let place = [column, row].map(f64::from);
                let at = self.recorded_at(place);
                view.colors.push(self.color(color, place, at));
                let [x, y] = at.map(|c| c.round());
                let inside = x >= 0.0 && y >= 0.0;
                let [x, y] = if inside { [x as usize, y as usize] } else { [usize::MAX; 2] };
                let shown = |mask: &Mask| mask.get(x, y) == Some(true);
                view.labels.push(match (hand.is_some_and(shown), shown(object)) {
                    (true, _) => Label::Hand,
                    (false, true) => Label::Object,
                    (false, false) => Label::Background,
                });
                let metres = depth.and_then(|d| d.get(x, y)).filter(|d| *d < FARTHEST_M);
                view.depths_mm.push((1e3 * metres.unwrap_or_default()).round() as u16);
            }
        }
        view
    }

    /// The colour of a pixel: the mean of those that it stands for, between pixels where a lens bends.
    fn color(&self, image: &ColorImage, place: [f64; 2], at: [f64; 2]) -> [u8; 3] {
        let k = self.reduction;
        if k == 1 && self.distortion == Distortion::None {
            return image.get(at[0].round() as usize, at[1].round() as usize).unwrap_or_default();
        }
        let mut sum = [0.0; 3];
        for part in 0..k * k {
            let within = [part % k, part / k];
            let shift = within.map(|p| (p as f64 + 0.5) / k as f64 - 0.5);
            let sample =
                between(image, self.recorded_at([place[0] + shift[0], place[1] + shift[1]]));
            sum.iter_mut().zip(sample).for_each(|(s, c)| *s += c);
        }
        sum.map(|s| (s / (k * k) as f64).round() as u8)
    }
}

/// The colour at a place between pixels; that of the border beyond it.
fn between(image: &ColorImage, [x, y]: [f64; 2]) -> [f64; 3] {
    let last = |side: usize| side.saturating_sub(1) as f64;
    let (x, y) = (x.clamp(0.0, last(image.width)), y.clamp(0.0, last(image.height)));
    let (column, row) = (x.floor(), y.floor());
    let (right, down) = (x - column, y - row);
    let (column, row) = (column as usize, row as usize);
    let mut sum = [0.0; 3];
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let share =
            if dx == 1 { right } else { 1.0 - right } * if dy == 1 { down } else { 1.0 - down };
        if share > 0.0 {
            let pixel = image.get(column + dx, row + dy).unwrap_or_default();
            sum.iter_mut().zip(pixel).for_each(|(s, c)| *s += share * f64::from(c));
        }
    }
    sum
}
