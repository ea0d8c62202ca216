//! Seeding of points: well inside a region, on one surface, where texture has two directions,
//! spread evenly.

use bendtwin_capture::raw::{ColorImage, DepthImage, Mask, Region};
use rayon::prelude::*;

use crate::{FlowSettings, matching::patch::Patch, view::View};

/// A place from which a point is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seed {
    /// Column and row.
    pub(crate) at: [f64; 2],
    /// Root mean square of the gradient in its weakest direction [grey levels of 255 per px].
    pub(crate) texture: f32,
}

/// Least distance of a seed from the outline of its region [px].
pub(crate) const MIN_INSET_PX: u8 = 3;

/// The seeds in one region of one view.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seeds {
    /// Best texture first.
    pub(crate) seeds: Vec<Seed>,
    /// Texture of every place that was tried, good or not, ascending [grey levels of 255 per px].
    pub(crate) textures: Vec<f32>,
}

impl Seeds {
    /// Median over all places, good or not [grey levels of 255 per px].
    pub(crate) fn median_texture(&self) -> Option<f64> {
        self.textures.get(self.textures.len() / 2).copied().map(f64::from)
    }
}

/// Number of spots of the object in an image from which [`crate::track`] would start with its default
/// settings; 0 also if the images differ in size.
pub fn seed_count(
    color: &ColorImage,
    depth: &DepthImage,
    object: &Mask,
    manipulator: Option<&Mask>,
) -> usize {
    let size = (color.width, color.height);
    let fits = |width, height, pixels| (width, height) == size && pixels == width * height;
    let alike = fits(color.width, color.height, color.pixels.len())
        && fits(depth.width, depth.height, depth.pixels.len())
        && [Some(object), manipulator]
            .into_iter()
            .flatten()
            .all(|m| fits(m.width, m.height, m.pixels.len()));
    if !alike {
        return 0;
    }
    let settings = FlowSettings::default();
    let view = View::new(color, depth, object, manipulator, &settings);
    seeds(&view, Region::Object, &settings).seeds.len()
}

/// Seeds in `region`: best first, none nearer to a better one than the minimum distance, which
/// grows until there are no more than allowed.
pub(crate) fn seeds(view: &View, region: Region, settings: &FlowSettings) -> Seeds {
    let Some(level) = view.layer(region).and_then(|layer| layer.levels.first()) else {
        return Seeds::default();
    };
    let most = most(region, settings);
    let places = places(view, region, settings);
    // As many as there is room for on a hexagonal grid of that distance.
    let spacing = settings.min_distance_px.max((places.len() as f64 / most.max(1) as f64).sqrt());
    // Texture is a mean over a window: it need not be known at every pixel of large images.
    let stride = (spacing / 3.0).floor().max(1.0);
    let on_grid = |at: &&[f64; 2]| at[0] % stride == 0.0 && at[1] % stride == 0.0;
    let tried: Vec<_> = places.iter().filter(on_grid).collect();
    let mut found: Vec<Seed> = tried
        .par_iter()
        .map(|&&at| {
            let patch = Patch::cut(level, at, settings.window_px);
            Seed { at, texture: 255.0 * patch.texture() }
        })
        .collect();
    let mut textures: Vec<_> = found.iter().map(|seed| seed.texture).collect();
    textures.sort_by(f32::total_cmp);
    found.retain(|seed| f64::from(seed.texture) >= settings.min_texture);
    // Stable: equal ones stay in reading order.
    found.sort_by(|a, b| b.texture.total_cmp(&a.texture));
    Seeds { seeds: spread(&found, view.size(), spacing, most), textures }
}

/// Places in `region` whether textured or not, evenly spread.
pub(crate) fn evenly(view: &View, region: Region, settings: &FlowSettings) -> Vec<[f64; 2]> {
    let places = places(view, region, settings);
    let most = most(region, settings);
    let spacing = settings.min_distance_px.max((places.len() as f64 / most.max(1) as f64).sqrt());
    let all: Vec<_> = places.into_iter().map(|at| Seed { at, texture: 0.0 }).collect();
    spread(&all, view.size(), spacing, most).into_iter().map(|seed| seed.at).collect()
}

fn most(region: Region, settings: &FlowSettings) -> usize {
    match region {
        Region::Object => settings.max_object_points,
        Region::Manipulator => settings.max_manipulator_points,
    }
}

/// Pixels well inside a region, on one surface.
fn places(view: &View, region: Region, settings: &FlowSettings) -> Vec<[f64; 2]> {
    let jump = settings.depth_jump_m as f32;
    let mut places = view.places(region, MIN_INSET_PX, usize::MAX);
    places.retain(|&at| view.is_smooth(at, region, jump));
    places
}

/// The first of each neighbourhood.
fn spread(found: &[Seed], [width, height]: [usize; 2], spacing: f64, most: usize) -> Vec<Seed> {
    let cells = [(width as f64 / spacing) as usize + 1, (height as f64 / spacing) as usize + 1];
    let mut grid: Vec<Vec<[f64; 2]>> = vec![Vec::new(); cells[0] * cells[1]];
    let mut kept = Vec::new();
    for seed in found {
        if kept.len() == most {
            break;
        }
        let [column, row] = [(seed.at[0] / spacing) as usize, (seed.at[1] / spacing) as usize];
        let rows = row.saturating_sub(1)..(row + 2).min(cells[1]);
        let near = rows
            .flat_map(|r| {
                (column.saturating_sub(1)..(column + 2).min(cells[0]))
                    .map(move |c| r * cells[0] + c)
            })
            .flat_map(|cell| &grid[cell])
            .any(|o| (o[0] - seed.at[0]).hypot(o[1] - seed.at[1]) < spacing);
        if !near {
            grid[row * cells[0] + column].push(seed.at);
            kept.push(*seed);
        }
    }
    kept
}
