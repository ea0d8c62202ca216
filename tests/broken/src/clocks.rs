//! Faults in the order and the times of frames, and in 2D tracks: mistakes of recorders and trackers.

use std::sync::Arc;

use crate::{
    Broken,
    Expected::{Found, Sound},
    Make, broken,
    footage::{FRAMES, Footage},
};

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    [frames(), times(), tracks()].concat()
}

fn footage(name: &'static str, code: &'static str, change: fn(&mut Footage)) -> Broken {
    broken(name, Found(code), Make::Footage(change))
}

fn frames() -> Vec<Broken> {
    vec![
        footage("a camera that starts six frames late", "FRAMES_DROPPED", |f| {
            f.retime(1, |frame| (frame >= 6).then_some(frame));
        }),
        footage("a camera that stops half-way", "CAMERA_RATE_UNCLEAR", |f| {
            f.retime(0, |frame| (frame < FRAMES / 2).then_some(frame));
        }),
        footage("a gap of eight frames in all cameras", "FRAMES_DROPPED", |f| {
            (0..3).for_each(|c| f.retime(c, |frame| (!(14..22).contains(&frame)).then_some(frame)));
        }),
        footage("colour without depth in every third frame", "FRAMES_DROPPED", |f| {
            f.reels[2].depth.iter_mut().skip(1).step_by(3).for_each(|d| *d = None);
        }),
        footage("every frame twice", "FRAMES_DUPLICATED", |f| {
            (0..3).for_each(|c| f.retime(c, |frame| Some(frame / 2)));
        }),
        footage("one camera at half the rate", "FRAMES_DUPLICATED", |f| {
            f.retime(2, |frame| Some(frame / 2 * 2));
        }),
        broken(
            "one camera at half the rate, with gaps",
            Sound("CAMERA_SLOWER"),
            Make::Footage(|f| f.retime(2, |frame| frame.is_multiple_of(2).then_some(frame))),
        ),
        broken(
            "one camera at two thirds of the rate, with gaps",
            Sound("CAMERA_SLOWER"),
            Make::Footage(|f| f.retime(1, |frame| (frame % 3 != 1).then_some(frame))),
        ),
        footage("frames in the order of their names", "MOTION_TOO_FAST", |f| {
            // 0, 1, 10, 11, ..., 19, 2, 20, ...
            let mut order: Vec<usize> = (0..FRAMES).collect();
            order.sort_by_key(usize::to_string);
            (0..3).for_each(|c| f.retime(c, |frame| order.get(frame).copied()));
        }),
        footage("a camera that runs backwards", "CAMERA_OFF", |f| {
            f.retime(1, |frame| Some(FRAMES - 1 - frame));
        }),
        footage("a camera that starts four frames early", "CAMERAS_SKEWED", |f| {
            f.about.cameras.iter_mut().for_each(|c| c.times_s.clear());
            f.retime(0, |frame| Some(frame.saturating_sub(4)));
        }),
        footage("two frames", "FEW_FRAMES", |f| {
            let points = f.about.truth_tracks.len() / FRAMES * 2;
            f.about.truth_tracks.truncate(points);
            (f.about.frame_count, f.about.train_frame_count) = (2, 2);
            f.about.cameras.iter_mut().for_each(|c| c.times_s.truncate(2));
            (0..3).for_each(|c| f.retime(c, Some));
        }),
    ]
}

fn times() -> Vec<Broken> {
    vec![
        footage("times in milliseconds", "FPS_MISMATCH", |f| {
            f.about.cameras.iter_mut().flat_map(|c| &mut c.times_s).for_each(|t| *t *= 1000.0);
        }),
        footage("a clock that is a second ahead", "CAMERAS_SKEWED", |f| {
            f.about.cameras[2].times_s.iter_mut().for_each(|t| *t += 1.0);
        }),
        footage("a frame rate that is no number", "FPS_INVALID", |f| f.about.fps = f64::NAN),
        footage("a frame rate below zero", "FPS_INVALID", |f| f.about.fps = -30.0),
        footage("the rate of a time-lapse", "FPS_IMPLAUSIBLE", |f| {
            f.about.cameras.iter_mut().for_each(|c| c.times_s.clear());
            f.about.fps = 0.5;
        }),
        footage("one frame for fitting", "SPLIT_EMPTY", |f| f.about.train_frame_count = 1),
    ]
}

fn tracks() -> Vec<Broken> {
    vec![
        footage("tracks of images a fifth as large", "TRACKS_OFF_OBJECT", |f| {
            (0..3).for_each(|c| f.change_tracks(c, |_, _, p, _| *p = [0.2 * p[0], 0.2 * p[1]]));
        }),
        footage("tracks from 0 to 1", "TRACKS_OFF_OBJECT", |f| {
            (0..3).for_each(|c| f.change_tracks(c, |_, _, p, _| *p = [p[0] / 160.0, p[1] / 120.0]));
        }),
        footage("mirrored tracks", "TRACKS_OFF_OBJECT", |f| {
            (0..3).for_each(|c| f.change_tracks(c, |_, _, p, _| p[0] = 159.0 - p[0]));
        }),
        footage("tracks of another camera", "TRACKS_OFF_OBJECT", |f| {
            let own = f.reels[0].tracks.take();
            f.reels[0].tracks = f.reels[1].tracks.take();
            f.reels[1].tracks = f.reels[2].tracks.take();
            f.reels[2].tracks = own;
        }),
        footage("tracks that nobody sees", "OBJECT_NOT_TRACKED", |f| {
            (0..3).for_each(|c| f.change_tracks(c, |_, _, _, visible| *visible = false));
        }),
        footage("tracks that end half-way", "TRACKS_LOST", |f| {
            (0..3).for_each(|c| {
                f.change_tracks(c, |frame, _, _, visible| *visible &= frame < FRAMES / 2);
            });
        }),
        footage("tracks of the hand alone", "OBJECT_NOT_TRACKED", |f| {
            for reel in &mut f.reels {
                let Some(tracks) = &mut reel.tracks else { continue };
                let Some(hand) = &reel.hand[0] else { continue };
                let on_hand = |p: &[f32; 2]| {
                    hand.get(p[0].round() as usize, p[1].round() as usize) == Some(true)
                };
                let own: Vec<bool> = tracks.points[..tracks.count].iter().map(on_hand).collect();
                let cells = tracks.visible.iter_mut().enumerate();
                cells.for_each(|(i, visible)| *visible &= own[i % own.len()]);
            }
        }),
        footage("a plain object without tracks", "OBJECT_NOT_TRACKED", |f| {
            for reel in &mut f.reels {
                reel.tracks = None;
                for (color, light) in reel.color.iter_mut().flatten().zip(100..) {
                    Arc::make_mut(color).pixels.fill([light; 3]);
                }
            }
        }),
    ]
}
