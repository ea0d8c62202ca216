//! Views of a recording: its images cut out around the object, without distortion, labelled, as the
//! appearance of a twin is made from them. Large images are reduced, and of long recordings frames
//! are left out, until all fits into a bound.

mod cut;

use bendtwin_capture::raw::{Frames, Recording, Region};
use bendtwin_core::{View, ViewCamera, Views, views::MOST_PIXELS};
use rayon::prelude::*;

use self::cut::Grid;

/// Most pixels of the views of one camera.
const MOST_PIXELS_OF_CAMERA: usize = 10 << 20;
/// Most recorded pixels that are read: a bound on time.
const MOST_READ: usize = 3_000_000_000;

/// The views of a recording's frames in which its masks show the object; none if there are no such
/// frames. `tell` gets the share that is done, 0..=1.
///
/// Images that cannot be read are left out.
pub fn views(recording: &Recording, tell: &mut dyn FnMut(f64)) -> Option<Views> {
    let recording = &recording.usable();
    let grids: Vec<Grid> = recording.cameras.iter().map(Grid::new).collect();
    let sources = (0..grids.len()).map(|camera| recording.source.frames(camera).ok());
    let mut sources: Vec<Option<Box<dyn Frames + '_>>> = sources.collect();
    let pixels: usize = recording.cameras.iter().map(|c| c.width.saturating_mul(c.height)).sum();
    let frames = recording.frame_count;
    let mut every = frames.saturating_mul(pixels).div_ceil(MOST_READ).max(1);
    // By frame and camera.
    let mut rows: Vec<Vec<Option<View>>> = Vec::new();
    let mut frame = 0;
    while frame < frames {
        let cut = |(source, grid): (&mut Option<Box<dyn Frames + '_>>, &Grid)| {
            source.as_mut().and_then(|source| read(&mut **source, grid, frame))
        };
        rows.push(sources.par_iter_mut().zip(&grids).map(cut).collect());
        while exceeds(&rows) {
            // A single one that is too large goes, too.
            let first = usize::from(rows.len() == 1);
            rows = rows.into_iter().skip(first).step_by(2).collect();
            every *= 2;
        }
        frame = rows.len() * every;
        tell(frame.min(frames) as f64 / frames as f64);
        if rows.is_empty() {
            return None;
        }
    }
    let mut cameras: Vec<ViewCamera> =
        recording.cameras.iter().zip(&grids).map(|(camera, grid)| grid.camera(camera)).collect();
    for row in rows {
        for (camera, view) in cameras.iter_mut().zip(row) {
            camera.views.extend(view);
        }
    }
    let seen = cameras.iter().any(|camera| !camera.views.is_empty());
    seen.then_some(Views { cameras })
}

/// The views of one frame; none if no camera sees the object in it.
pub fn views_of_frame(recording: &Recording, frame: usize) -> Option<Views> {
    let recording = &recording.usable();
    let cameras = recording.cameras.iter().enumerate().map(|(index, camera)| {
        let grid = Grid::new(camera);
        let source = recording.source.frames(index).ok();
        let view = source.and_then(|mut source| read(&mut *source, &grid, frame));
        ViewCamera { views: view.into_iter().collect(), ..grid.camera(camera) }
    });
    let cameras: Vec<ViewCamera> = cameras.collect();
    let seen = cameras.iter().any(|camera| !camera.views.is_empty());
    seen.then_some(Views { cameras })
}

/// True if the views of these frames take more than may be.
fn exceeds(rows: &[Vec<Option<View>>]) -> bool {
    let pixels = |view: &Option<View>| view.as_ref().map_or(0, |v| v.labels.len());
    let cameras = rows.first().map_or(0, Vec::len);
    let of_camera = |camera: usize| rows.iter().map(|row| pixels(&row[camera])).sum::<usize>();
    let sizes: Vec<usize> = (0..cameras).map(of_camera).collect();
    sizes.iter().sum::<usize>() > MOST_PIXELS || sizes.iter().any(|s| *s > MOST_PIXELS_OF_CAMERA)
}

/// The view of a frame, if its image and its mask were recorded and show the object.
fn read(source: &mut dyn Frames, grid: &Grid, frame: usize) -> Option<View> {
    let object = source.mask(frame, Region::Object).ok()??;
    let (corner, size) = grid.around(&object)?;
    let color = source.color(frame).ok()??;
    let hand = source.mask(frame, Region::Manipulator).ok().flatten();
    let depth = source.depth(frame).ok().flatten();
    let view = View { frame: u32::try_from(frame).ok()?, corner, size, ..View::default() };
    Some(grid.cut(view, &color, &object, hand.as_ref(), depth.as_ref()))
}

#[cfg(test)]
mod tests;
