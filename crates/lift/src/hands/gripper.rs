//! Grippers whose motion a robot recorded: control points on their fingers, which move with the
//! recorded poses and openings.

use bendtwin_capture::raw::Gripper;
use bendtwin_core::{Point, settings::ingest::ControlSettings};
use nalgebra::{Matrix3, Vector3};

use super::{
    Controls,
    body::fill,
    by_frame,
    contact::{Contact, holding},
    dealt,
};
use crate::{Error, evidence::HandEvidence, rigid::Rigid};

/// Places along the length and the breadth of a pad from which control points are chosen.
const PLACES: [usize; 2] = [9, 9];

/// Control points on grippers, over `frames` frames.
pub(crate) fn controls(
    grippers: &[Gripper],
    frames: usize,
    contact: &Contact,
    settings: &ControlSettings,
) -> Result<Controls, Error> {
    let mut made =
        Controls { points: Vec::new(), hands: Vec::new(), longest_gap: 0, findings: Vec::new() };
    let mut columns: Vec<Vec<Point>> = Vec::new();
    for (index, gripper) in grippers.iter().enumerate() {
        let places = places(gripper);
        let tips: Vec<Point> = places.iter().map(|place| place.at(0.0)).collect();
        let poses: Vec<Option<Rigid>> = (0..frames)
            .map(|f| gripper.poses.get(f).copied().flatten().map(|p| rigid(&p)))
            .collect();
        let filled_frames = poses.iter().filter(|pose| pose.is_none()).count();
        let Some((poses, gap)) = fill(poses, &tips) else {
            return Err(Error::Inconsistent(format!("gripper {} has no pose", gripper.name)));
        };
        let widths = filled(&gripper.widths_m, frames);
        let motion =
            |place: &Place| (0..frames).map(|f| poses[f].apply(place.at(widths[f]))).collect();
        let moving: Vec<Vec<Point>> = places.iter().map(motion).collect();
        let starts: Vec<Point> = moving.iter().filter_map(|place| place.first().copied()).collect();
        let wanted = dealt(settings, index, grippers.len());
        let (picked, distances_m) = contact.choose(&starts, wanted);
        made.longest_gap = made.longest_gap.max(gap);
        made.hands.push(HandEvidence {
            controls: picked.len(),
            holding: holding(&distances_m),
            rigid: gripper.widths_m.is_empty(),
            filled_frames,
            ..HandEvidence::default()
        });
        columns.extend(picked.into_iter().map(|i| moving[i].clone()));
    }
    made.points = by_frame(&columns, frames);
    Ok(made)
}

/// Whether every gripper has a pose, by frame.
pub(crate) fn known(grippers: &[Gripper], frames: usize) -> Vec<bool> {
    let has = |frame: usize| {
        grippers.iter().all(|gripper| gripper.poses.get(frame).is_some_and(Option::is_some))
    };
    (0..frames).map(has).collect()
}

/// A place on a finger, in the axes of its gripper.
struct Place {
    /// Where it is with closed fingers [m].
    closed: Point,
    /// +1 on the finger that opens along y, -1 on the other, 0 between fingers whose opening is not
    /// known.
    side: f32,
}

impl Place {
    /// Where it is at a distance of the fingers [m].
    fn at(&self, width_m: f64) -> Point {
        let [x, y, z] = self.closed;
        [x, y + self.side * width_m as f32 / 2.0, z]
    }
}

fn places(gripper: &Gripper) -> Vec<Place> {
    let [along, across] = PLACES;
    let share = |i: usize, count: usize| i as f64 / (count - 1) as f64;
    let sides: &[f32] = if gripper.widths_m.is_empty() { &[0.0] } else { &[-1.0, 1.0] };
    let mut places = Vec::with_capacity(sides.len() * along * across);
    for &side in sides {
        for i in 0..along {
            for j in 0..across {
                let z = -share(i, along) * gripper.pad.length_m;
                let x = (share(j, across) - 0.5) * gripper.pad.breadth_m;
                places.push(Place { closed: [x as f32, 0.0, z as f32], side });
            }
        }
    }
    places
}

/// Openings in all frames: unknown ones lie between those around.
fn filled(widths_m: &[f64], frames: usize) -> Vec<f64> {
    let known: Vec<(usize, f64)> =
        widths_m.iter().copied().enumerate().filter(|(_, width)| !width.is_nan()).collect();
    let at = |frame: usize| {
        let next = known.partition_point(|(f, _)| *f < frame);
        let (before, after) = (next.checked_sub(1).and_then(|i| known.get(i)), known.get(next));
        match (before, after) {
            (Some(&(a, from)), Some(&(b, to))) => {
                from + (to - from) * (frame - a) as f64 / (b - a) as f64
            }
            (Some(&(_, width)), None) | (None, Some(&(_, width))) => width,
            (None, None) => 0.0,
        }
    };
    (0..frames).map(at).collect()
}

fn rigid(pose: &bendtwin_capture::raw::Pose) -> Rigid {
    let rotation = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
    Rigid { rotation, translation: Vector3::from(pose.translation) }
}

#[cfg(test)]
mod tests {
    use bendtwin_capture::raw::{Pad, Pose};

    use super::*;

    fn gripper(widths_m: Vec<f64>) -> Gripper {
        let lifted = |z: f64| Pose { translation: [0.0, 0.0, z], ..Pose::IDENTITY };
        Gripper {
            name: "left".to_owned(),
            poses: vec![Some(lifted(0.0)), None, Some(lifted(0.02))],
            widths_m,
            pad: Pad { length_m: 0.02, breadth_m: 0.02 },
        }
    }

    fn made(gripper: Gripper) -> Controls {
        let object = vec![[0.0, 0.02, 0.0], [0.0, -0.02, 0.0]];
        let contact = Contact::new(object, Vec::new());
        let settings = ControlSettings { count: 8, ..ControlSettings::default() };
        controls(&[gripper], 3, &contact, &settings).unwrap()
    }

    #[test]
    fn fingers_move_with_pose_and_opening() {
        let made = made(gripper(vec![0.04, 0.04, 0.02]));
        assert_eq!((made.hands[0].controls, made.hands[0].filled_frames), (8, 1));
        let (first, middle, last) = (&made.points[..8], &made.points[8..16], &made.points[16..]);
        for ((a, b), c) in first.iter().zip(middle).zip(last) {
            assert!((a[1].abs() - 0.02).abs() < 1e-6 && (b[1].abs() - 0.02).abs() < 1e-6);
            assert!((c[1].abs() - 0.01).abs() < 1e-6);
            assert!((b[2] - a[2] - 0.01).abs() < 1e-6 && (c[2] - a[2] - 0.02).abs() < 1e-6);
        }
        assert!(first.iter().any(|p| p[1] > 0.0) && first.iter().any(|p| p[1] < 0.0));
    }

    #[test]
    fn without_an_opening_control_points_lie_between_the_fingers() {
        let made = made(gripper(Vec::new()));
        assert!(made.points.iter().all(|p| p[1] == 0.0));
        assert!(made.hands[0].rigid);
    }

    #[test]
    fn unknown_openings_lie_between_known_ones() {
        let widths = filled(&[f64::NAN, 0.04, f64::NAN, 0.02, f64::NAN], 5);
        let wanted = [0.04, 0.04, 0.03, 0.02, 0.02];
        assert!(widths.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{widths:?}");
        assert_eq!(filled(&[], 2), [0.0, 0.0]);
    }

    #[test]
    fn frames_without_a_pose_are_known() {
        assert_eq!(known(&[gripper(Vec::new())], 3), [true, false, true]);
    }
}
