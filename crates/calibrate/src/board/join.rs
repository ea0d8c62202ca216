//! Joins the views of all cameras: a pose for each camera in the world of the board.

use nalgebra::Isometry3;

use super::{
    Observation,
    adjust::Poses,
    layout::Board,
    pnp::{self, MIN_CORNERS},
    views::{Rest, Views},
};
use crate::{lens::Lens, statistics::median};

/// Most resting places of the board that are used.
const MOST_RESTS: usize = 40;
/// Images of which a mean counts at most: what they have in common does not average out.
const MOST_WEIGHT: f64 = 10.0;
/// A corner farther than this from where the poses have it is left out [px], if it is also...
const FAR_PX: f64 = 2.0;
/// ...this many times as far as the median.
const FAR_RATIO: f64 = 5.0;

/// Poses of all cameras.
pub(crate) struct Joined {
    pub(crate) poses: Poses,
    /// Corners by which they were found.
    pub(crate) seen: Vec<Observation>,
    /// The first frame of each of the board's poses; the first lies at z = 0.
    pub(crate) frames: Vec<usize>,
    /// Root mean square distance of corners for each camera [px].
    pub(crate) reprojection_px: Vec<f64>,
    /// `true` if the board rests in all views that were used.
    pub(crate) rests: bool,
}

/// Cameras that cannot be joined with the others, and those without a usable view.
#[derive(Debug)]
pub(crate) struct Apart {
    pub(crate) cameras: Vec<usize>,
    /// `true` if these have views, but at other times than the others.
    pub(crate) at_other_times: bool,
}

/// A camera's view of the board at one time.
struct View {
    camera: usize,
    rest: usize,
    /// From the board to the camera.
    pose: Isometry3<f64>,
}

/// Finds the poses of all cameras.
pub(crate) fn join(board: &Board, lenses: &[Lens], views: &Views) -> Result<Joined, Apart> {
    let all = views.rests();
    let still = views.frames.len() == 1;
    let steady: Vec<&Rest> = all.iter().filter(|rest| rest.frames > 1 || still).collect();
    let with_steady = join_rests(board, lenses, &steady);
    match with_steady {
        Ok(joined) => Ok(Joined { rests: true, ..joined }),
        Err(_) => join_rests(board, lenses, &all.iter().collect::<Vec<_>>()),
    }
}

fn join_rests(board: &Board, lenses: &[Lens], rests: &[&Rest]) -> Result<Joined, Apart> {
    let mut order: Vec<&Rest> = rests.to_vec();
    let cameras_of = |rest: &Rest| rest.seen.iter().filter(|s| s.len() >= MIN_CORNERS).count();
    order.sort_by_key(|rest| std::cmp::Reverse((cameras_of(rest), rest.frames)));
    order.truncate(MOST_RESTS);
    let mut views = Vec::new();
    for (index, rest) in order.iter().enumerate() {
        for (camera, seen) in rest.seen.iter().enumerate() {
            let points: Vec<_> = seen.iter().map(|(s, _)| board.corners[s.corner]).collect();
            let pixels: Vec<_> = seen.iter().map(|(s, _)| s.at).collect();
            if let Some(pose) = pnp::pose(&lenses[camera], &points, &pixels) {
                views.push(View { camera, rest: index, pose });
            }
        }
    }
    let (cameras, boards) = connect(lenses.len(), order.len(), &views)?;
    // Views at places of the board that no joined camera saw say nothing.
    let kept: Vec<usize> = (0..order.len()).filter(|rest| boards[*rest].is_some()).collect();
    let mut seen = Vec::new();
    for view in views.iter().filter(|view| boards[view.rest].is_some()) {
        let index = kept.binary_search(&view.rest).unwrap_or_default();
        for (corner, count) in &order[view.rest].seen[view.camera] {
            seen.push(Observation {
                camera: view.camera,
                board: index,
                point: board.corners[corner.corner],
                at: corner.at,
                weight: count.min(MOST_WEIGHT),
            });
        }
    }
    let mut poses = Poses { cameras, boards: boards.into_iter().flatten().collect() };
    poses.adjust(lenses, &seen);
    let distance = |poses: &Poses, o: &Observation| {
        poses.residual(lenses, o).map_or(f64::INFINITY, |[x, y]| x.hypot(y))
    };
    let usual = median(seen.iter().map(|o| distance(&poses, o))).unwrap_or_default();
    let far = FAR_PX.max(FAR_RATIO * usual);
    let before = seen.len();
    seen.retain(|o| distance(&poses, o) < far);
    if seen.len() < before {
        poses.adjust(lenses, &seen);
    }
    let of = |camera: usize| -> Vec<Observation> {
        seen.iter().filter(|o| o.camera == camera).copied().collect()
    };
    let own: Vec<Vec<Observation>> = (0..lenses.len()).map(of).collect();
    let lost: Vec<usize> = (0..lenses.len()).filter(|c| own[*c].len() < MIN_CORNERS).collect();
    if !lost.is_empty() {
        return Err(Apart { cameras: lost, at_other_times: false });
    }
    Ok(Joined {
        reprojection_px: own.iter().map(|own| poses.rms(lenses, own)).collect(),
        frames: kept.iter().map(|rest| order[*rest].first).collect(),
        poses,
        seen,
        rests: false,
    })
}

type Motions = Vec<Isometry3<f64>>;
type KnownMotions = Vec<Option<Isometry3<f64>>>;

/// First poses: the board at its first place is the world, a camera is placed by a board whose pose is
/// known, a board by such a camera.
fn connect(cameras: usize, rests: usize, views: &[View]) -> Result<(Motions, KnownMotions), Apart> {
    let mut camera_poses: KnownMotions = vec![None; cameras];
    let mut boards: KnownMotions = vec![None; rests];
    if let Some(first) = boards.first_mut() {
        *first = Some(Isometry3::identity());
    }
    loop {
        let mut found = false;
        for view in views {
            match (camera_poses[view.camera], boards[view.rest]) {
                (None, Some(board)) => {
                    camera_poses[view.camera] = Some(view.pose * board.inverse());
                    found = true;
                }
                (Some(camera), None) => {
                    boards[view.rest] = Some(camera.inverse() * view.pose);
                    found = true;
                }
                _ => {}
            }
        }
        if !found {
            break;
        }
    }
    let missing: Vec<usize> = (0..cameras).filter(|c| camera_poses[*c].is_none()).collect();
    if missing.is_empty() {
        return Ok((camera_poses.into_iter().flatten().collect(), boards));
    }
    let at_other_times =
        missing.iter().all(|camera| views.iter().any(|view| view.camera == *camera));
    Err(Apart { cameras: missing, at_other_times })
}
