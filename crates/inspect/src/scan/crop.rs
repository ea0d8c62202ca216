//! The part of an image that the masks show, on a coarser grid if it is large. Cameras are compared
//! by crops of a few frames, and pictures are drawn from them, so memory does not grow with a
//! recording.

use bendtwin_capture::raw::{Camera, ColorImage, DepthImage, Mask};

use crate::vector::{Vector, cross, distance, dot, scaled, seen_at, sub, unit};

/// Most cells of a crop.
const MAX_CELLS: usize = 60_000;
/// Neighbours that are farther apart than this share of their depth, per pixel between them, are
/// not on one surface.
const MAX_STEP_SHARE: f64 = 0.02;
/// Neighbours that are nearer than this are on one surface in any case [m].
const MIN_STEP_M: f64 = 0.01;

/// Content of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    Nothing,
    Object,
    Manipulator,
}

/// Masks, depth and colour of one camera in one frame.
#[derive(Clone, Debug)]
pub(crate) struct Crop {
    pub(crate) frame: usize,
    /// True if the object reaches the image's border, so that part of it is not in view.
    pub(crate) at_border: bool,
    /// Pixels from cell to cell.
    pub(crate) stride: usize,
    /// Column and row of the first cell.
    pub(crate) origin: [usize; 2],
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Shape [height, width].
    pub(crate) labels: Vec<Label>,
    /// Metres, 0 where nothing was measured, shape [height, width].
    pub(crate) depth: Vec<f32>,
    /// Shape [height, width].
    pub(crate) color: Vec<[u8; 3]>,
}

/// A spot of a surface as one camera saw it: place, normal, colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surfel {
    pub(crate) label: Label,
    /// In the camera's axes [m].
    pub(crate) at: Vector,
    /// Towards the camera, in its axes; zero at rims.
    pub(crate) normal: Vector,
    pub(crate) color: [u8; 3],
}

impl Crop {
    /// `None` if the masks are empty.
    pub(crate) fn of(
        frame: usize,
        object: &Mask,
        manipulator: Option<&Mask>,
        depth: &DepthImage,
        color: Option<&ColorImage>,
    ) -> Option<Self> {
        let label = |column: usize, row: usize| {
            let holds = |m: &Mask| m.get(column, row) == Some(true);
            match (holds(object), manipulator.is_some_and(holds)) {
                (true, _) => Label::Object,
                (false, true) => Label::Manipulator,
                (false, false) => Label::Nothing,
            }
        };
        let mut low = [usize::MAX; 2];
        let mut high = [0; 2];
        for mask in std::iter::once(object).chain(manipulator) {
            for row in 0..mask.height {
                let pixels = mask.row(row);
                let Some(first) = pixels.iter().position(|&p| p) else { continue };
                let last = pixels.iter().rposition(|&p| p).unwrap_or(first);
                low = [low[0].min(first), low[1].min(row)];
                high = [high[0].max(last), high[1].max(row)];
            }
        }
        if low[0] == usize::MAX {
            return None;
        }
        let (columns, rows) = (high[0] - low[0] + 1, high[1] - low[1] + 1);
        let stride = ((columns * rows) as f64 / MAX_CELLS as f64).sqrt().ceil().max(1.0) as usize;
        let (width, height) = (columns.div_ceil(stride), rows.div_ceil(stride));
        let sides = |row: usize| [(0, row), (object.width.saturating_sub(1), row)];
        let ends = |column: usize| [(column, 0), (column, object.height.saturating_sub(1))];
        let mut border = (0..object.height).flat_map(sides).chain((0..object.width).flat_map(ends));
        let mut crop = Self {
            frame,
            at_border: border.any(|(column, row)| object.get(column, row) == Some(true)),
            stride,
            origin: low,
            width,
            height,
            labels: Vec::with_capacity(width * height),
            depth: Vec::with_capacity(width * height),
            color: Vec::with_capacity(width * height),
        };
        for y in 0..height {
            for x in 0..width {
                let (column, row) = (low[0] + x * stride, low[1] + y * stride);
                crop.labels.push(label(column, row));
                let metres = depth.get(column, row).filter(|d| d.is_finite() && *d > 0.0);
                crop.depth.push(metres.unwrap_or(0.0));
                let pixel = color.and_then(|c| c.get(column, row));
                crop.color.push(pixel.unwrap_or([128; 3]));
            }
        }
        Some(crop)
    }

    /// The pixel at the middle of a cell.
    pub(crate) fn pixel(&self, cell: usize) -> [f64; 2] {
        let (x, y) = (cell % self.width, cell / self.width);
        [(self.origin[0] + x * self.stride) as f64, (self.origin[1] + y * self.stride) as f64]
    }

    /// The cell nearest to a pixel.
    pub(crate) fn cell(&self, pixel: [f64; 2]) -> Option<usize> {
        let place = |a: usize, end: usize| {
            let at = ((pixel[a] - self.origin[a] as f64) / self.stride as f64).round();
            (at >= 0.0 && at < end as f64).then_some(at as usize)
        };
        Some(place(1, self.height)? * self.width + place(0, self.width)?)
    }

    /// True if a mask shows anything within a radius around a pixel [px].
    pub(crate) fn is_near_mask(&self, pixel: [f64; 2], radius: f64) -> bool {
        let reach = radius.max(self.stride as f64);
        [-1.0, 0.0, 1.0].into_iter().any(|dy| {
            [-1.0, 0.0, 1.0].into_iter().any(|dx| {
                let at = [pixel[0] + dx * reach, pixel[1] + dy * reach];
                self.cell(at).is_some_and(|c| self.labels.get(c) != Some(&Label::Nothing))
            })
        })
    }

    /// Depth and label of a cell that both are known.
    pub(crate) fn surface(&self, cell: usize) -> Option<(Label, f64)> {
        let (label, depth) = (*self.labels.get(cell)?, *self.depth.get(cell)?);
        (label != Label::Nothing && depth > 0.0).then_some((label, f64::from(depth)))
    }

    /// The place of a cell's surface in the camera's axes [m].
    pub(crate) fn place(&self, camera: &Camera, cell: usize) -> Option<Vector> {
        let (_, depth) = self.surface(cell)?;
        Some(seen_at(camera, self.pixel(cell), depth))
    }

    /// At most `most` surfels, evenly taken.
    pub(crate) fn surfels(&self, camera: &Camera, most: usize) -> Vec<Surfel> {
        let known: Vec<usize> =
            (0..self.labels.len()).filter(|&c| self.surface(c).is_some()).collect();
        // A step that is no divisor of the width, or whole columns would never be taken.
        let step = known.len().div_ceil(most.max(1)).max(1);
        let surfel = |&cell: &usize| {
            let (label, _) = self.surface(cell)?;
            let at = self.place(camera, cell)?;
            let normal = self.normal(camera, cell).unwrap_or([0.0; 3]);
            let color = self.color.get(cell).copied().unwrap_or_default();
            Some(Surfel { label, at, normal, color })
        };
        known.iter().step_by(step).filter_map(surfel).collect()
    }

    /// The normal of a cell's surface from its four neighbours, towards the camera; `None` at rims.
    pub(crate) fn normal(&self, camera: &Camera, cell: usize) -> Option<Vector> {
        let (x, y) = (cell % self.width, cell / self.width);
        let reach = if self.stride == 1 { 2 } else { 1 };
        if x < reach || y < reach || x + reach >= self.width || y + reach >= self.height {
            return None;
        }
        let here = self.place(camera, cell)?;
        let neighbour = |c: usize| {
            let there = self.place(camera, c)?;
            let limit = MAX_STEP_SHARE * here[2] * (reach * self.stride) as f64;
            (distance(here, there) < limit.max(MIN_STEP_M)).then_some(there)
        };
        let across = sub(neighbour(cell + reach)?, neighbour(cell - reach)?);
        let down =
            sub(neighbour(cell + reach * self.width)?, neighbour(cell - reach * self.width)?);
        let normal = unit(cross(across, down))?;
        Some(if dot(normal, here) > 0.0 { scaled(normal, -1.0) } else { normal })
    }
}
