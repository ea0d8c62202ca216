//! What does not change over a recording: cameras, their backdrops, and the table. And what a frame
//! shows in front of them: cells that may be object or hand.

use bendtwin_core::{Point, geometry::Vector};
use rayon::prelude::*;

use crate::{
    Error,
    backdrop::{Against, Backdrop},
    cells::{Cells, NONE},
    colors::bin,
    looks::Looks,
    part::{BACKGROUND, HAND, OBJECT, PARTS, Shares},
    table::Table,
    view::{Lens, View},
};

/// Evidence for the background by what lies behind, as logarithms. The backdrop in another colour may be
/// something thin, or a shadow.
const BEFORE: f32 = -2.0;
const SAME: f32 = 1.0;
const RECOLOURED: f32 = 0.0;
const SETTLED: f32 = 4.0;
/// Evidence by the height above the table: on it, above it, below it.
const ON_TABLE: f32 = 2.0;
const ABOVE: f32 = -1.0;
const BELOW: f32 = 3.0;
/// Evidence up to which a pixel may be object or hand, and up to which it may by a colour that speaks
/// for it at least this much.
const OPEN: f32 = 1.6;
const OPEN_BY_COLOR: f32 = 4.5;
const BY_COLOR: f32 = 1.5;

/// No recording is farther from its origin [m]: beyond, cells could not be counted.
const WORLD_M: f32 = 1e5;

/// Cameras and what stands still in front of them.
pub(crate) struct Scene<'a> {
    pub(crate) lenses: Vec<Lens<'a>>,
    pub(crate) backdrops: Vec<Backdrop>,
    pub(crate) table: Option<Table>,
}

/// A box along the world's axes, outside of which nothing is sought.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    low: Point,
    high: Point,
}

impl Reach {
    /// Around points, with a margin [m]; `None` without points.
    pub(crate) fn around(points: impl IntoIterator<Item = Point>, margin_m: f32) -> Option<Self> {
        let mut reach: Option<Self> = None;
        for p in points {
            let known = reach.unwrap_or(Self { low: p, high: p });
            reach = Some(Self {
                low: std::array::from_fn(|a| known.low[a].min(p[a])),
                high: std::array::from_fn(|a| known.high[a].max(p[a])),
            });
        }
        let Self { low, high } = reach?;
        Some(Self { low: low.map(|x| x - margin_m), high: high.map(|x| x + margin_m) })
    }

    fn holds(&self, p: Point) -> bool {
        (0..3).all(|a| (self.low[a]..=self.high[a]).contains(&p[a]) && p[a].abs() < WORLD_M)
    }
}

/// A frame in front of the scene.
pub(crate) struct Shot {
    pub(crate) views: Vec<Option<View>>,
    pub(crate) cells: Cells,
    /// Cell of each pixel, [`NONE`] if it has none. Shape [camera][height, width].
    pub(crate) of_pixel: Vec<Vec<u32>>,
    /// Evidence of each pixel for the background apart from its colour. Shape as `of_pixel`.
    pub(crate) evidence: Vec<Vec<f32>>,
}

/// A pixel that may be object or hand.
struct Open {
    at: usize,
    place: Point,
}

impl Scene<'_> {
    /// Centres of all cameras.
    pub(crate) fn eyes(&self, frame: usize) -> Vec<Vector> {
        self.lenses.iter().map(|lens| lens.camera.pose(frame).translation).collect()
    }

    /// Evidence of a pixel for the background apart from its colour, as a logarithm.
    fn evidence(&self, camera: usize, at: usize, depth: f32, color: [u8; 3], place: Point) -> f32 {
        let behind = match self.backdrops[camera].compare(at, depth, color) {
            Against::Unknown => 0.0,
            Against::Before => BEFORE,
            Against::Same => SAME,
            Against::Recoloured => RECOLOURED,
            Against::Settled => SETTLED,
        };
        let Some(table) = self.table.filter(|_| depth > 0.0) else { return behind };
        let thick = table.thickness_m;
        let by_height = match table.height(place) {
            h if h < -2.0 * thick => BELOW,
            h if h < thick => ON_TABLE,
            h if h < 2.0 * thick => 0.0,
            _ => ABOVE,
        };
        behind + by_height
    }

    /// What a frame shows. `marked` are the marked pixels of each camera, with their parts: they have
    /// cells wherever depth was measured.
    pub(crate) fn shoot(
        &self,
        views: Vec<Option<View>>,
        looks: &Looks,
        reach: &Reach,
        marked: &[Vec<(usize, usize)>],
    ) -> Shot {
        let looked: Vec<(Vec<f32>, Vec<Open>)> = views
            .par_iter()
            .enumerate()
            .map(|(camera, view)| match view {
                Some(view) => self.look(camera, view, looks, reach, &marked[camera]),
                None => (Vec::new(), Vec::new()),
            })
            .collect();
        let mut cells = Cells::default();
        let mut shot_of_pixel = Vec::new();
        let mut evidence = Vec::new();
        for ((view, lens), (of_camera, open)) in views.iter().zip(&self.lenses).zip(looked) {
            let mut of_pixel = vec![NONE; lens.len()];
            if let Some(view) = view {
                for Open { at, place } in open {
                    of_pixel[at] = cells.add(place, view.colors[at], of_camera[at]);
                }
            }
            shot_of_pixel.push(of_pixel);
            evidence.push(of_camera);
        }
        cells.settle();
        Shot { views, cells, of_pixel: shot_of_pixel, evidence }
    }

    fn look(
        &self,
        camera: usize,
        view: &View,
        looks: &Looks,
        reach: &Reach,
        marked: &[(usize, usize)],
    ) -> (Vec<f32>, Vec<Open>) {
        let lens = &self.lenses[camera];
        let place_of = lens.places(view.frame);
        let mut open = Vec::new();
        let mut evidence = vec![0.0; lens.len()];
        let mut is_forced = vec![false; lens.len()];
        marked.iter().for_each(|(at, _)| is_forced[*at] = true);
        for at in 0..lens.len() {
            let (depth, color) = (view.depths[at], view.colors[at]);
            let place = place_of(at, depth);
            let e = self.evidence(camera, at, depth, color, place);
            evidence[at] = e;
            if depth == 0.0 || (e > OPEN_BY_COLOR && !is_forced[at]) || !reach.holds(place) {
                continue;
            }
            let by_color = || {
                let logs = looks.logs(bin(color));
                logs[OBJECT].max(logs[HAND]) - logs[BACKGROUND] > BY_COLOR
            };
            if e <= OPEN || is_forced[at] || by_color() {
                open.push(Open { at, place });
            }
        }
        (evidence, open)
    }

    /// Says of all pixels that show the backdrop, and not object or hand, that this is the
    /// background at all times.
    pub(crate) fn settle(&mut self, shot: &Shot, labels: &[Vec<u8>]) {
        for (camera, (backdrop, labels)) in self.backdrops.iter_mut().zip(labels).enumerate() {
            let Some(view) = &shot.views[camera] else { continue };
            for (at, label) in labels.iter().enumerate() {
                let shown = backdrop.compare(at, view.depths[at], view.colors[at]);
                // What was out of reach is not known.
                let was_looked_at =
                    shot.of_pixel[camera][at] != NONE || shot.evidence[camera][at] > OPEN;
                if usize::from(*label) == BACKGROUND && shown == Against::Same && was_looked_at {
                    backdrop.settle(at);
                }
            }
        }
    }
}

impl Shot {
    /// Means of the logarithms of the densities of each cell's colours in the parts.
    pub(crate) fn color_logs(&self, looks: &Looks) -> Vec<Shares> {
        let mut logs = vec![[0.0; PARTS]; self.cells.len()];
        for (view, of_pixel) in self.views.iter().zip(&self.of_pixel) {
            let Some(view) = view else { continue };
            for (at, cell) in of_pixel.iter().enumerate().filter(|(_, cell)| **cell != NONE) {
                let of_color = looks.logs(bin(view.colors[at]));
                let sum = &mut logs[*cell as usize];
                (0..PARTS).for_each(|k| sum[k] += of_color[k]);
            }
        }
        for (logs, cell) in logs.iter_mut().zip(&self.cells.cells) {
            *logs = logs.map(|l| l / cell.count.max(1.0));
        }
        logs
    }
}

/// Reads a frame of all cameras side by side.
pub(crate) fn read(
    lenses: &[Lens<'_>],
    readers: &mut [Box<dyn bendtwin_capture::raw::Frames + '_>],
    frame: usize,
) -> Result<Vec<Option<View>>, Error> {
    let both = readers.par_iter_mut().zip(lenses);
    both.map(|(reader, lens)| lens.read(reader.as_mut(), frame)).collect()
}
