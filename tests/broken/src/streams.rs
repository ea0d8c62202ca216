//! Faults in time, depth, masks and tracks: mistakes while recording and segmenting.

use std::sync::Arc;

use bendtwin_capture::raw::Mask;

use crate::{
    Broken,
    Expected::{Found, Noticed, Sound},
    Make, broken,
    footage::{FRAMES, Footage},
};

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    [time(), depth(), masks(), tracks()].concat()
}

fn footage(name: &'static str, code: &'static str, change: fn(&mut Footage)) -> Broken {
    broken(name, Found(code), Make::Footage(change))
}

fn time() -> Vec<Broken> {
    vec![
        footage("a quarter of a camera's frames dropped", "FRAMES_DROPPED", |f| {
            f.retime(1, |frame| (frame % 4 != 2).then_some(frame));
        }),
        footage("a quarter of all frames dropped", "FRAMES_DROPPED", |f| {
            (0..3).for_each(|c| f.retime(c, |frame| ((frame + c) % 4 != 2).then_some(frame)));
        }),
        broken(
            "a camera of half the rate, with gaps",
            Sound("CAMERA_SLOWER"),
            Make::Footage(|f| f.retime(1, |frame| (frame % 2 == 0).then_some(frame))),
        ),
        footage("frames repeated where others were dropped", "FRAMES_DUPLICATED", |f| {
            f.retime(2, |frame| Some(if frame % 4 == 3 { frame - 1 } else { frame }));
        }),
        footage("a camera that lags by 200 ms", "CAMERAS_SKEWED", |f| {
            without_times(f);
            // The others started earlier.
            [0, 2].into_iter().for_each(|c| f.retime(c, |frame| Some((frame + 6).min(FRAMES - 1))));
            shorten(f, FRAMES - 6);
        }),
        broken(
            "a camera that closes up what it drops",
            Found("CAMERAS_SKEWED"),
            Make::Footage(|f| {
                without_times(f);
                f.retime(2, |frame| Some((frame * 4 / 3).min(FRAMES - 1)));
                shorten(f, FRAMES * 3 / 4);
            }),
        ),
        footage("frames that come late", "FRAMES_LATE", |f| {
            for camera in &mut f.about.cameras {
                let late =
                    |i: usize| if i >= 12 { 0.12 } else { 0.0 } + if i >= 24 { 0.1 } else { 0.0 };
                camera.times_s.iter_mut().enumerate().for_each(|(i, t)| *t += late(i));
            }
        }),
        footage("half the frame rate", "FPS_MISMATCH", |f| {
            f.about.cameras.iter_mut().flat_map(|c| &mut c.times_s).for_each(|t| *t *= 2.0);
        }),
        footage("the time of a frame for its rate", "FPS_IMPLAUSIBLE", |f| {
            without_times(f);
            f.about.fps = 1.0 / f.about.fps;
        }),
        footage("one frame", "ONE_FRAME", |f| shorten(f, 1)),
        footage("six frames", "FEW_FRAMES", |f| shorten(f, 6)),
        footage("no frame for fitting", "SPLIT_EMPTY", |f| f.about.train_frame_count = 0),
        footage("a camera without frames", "CAMERA_EMPTY", |f| f.retime(2, |_| None)),
        footage("no frames at all", "CAMERA_EMPTY", |f| (0..3).for_each(|c| f.retime(c, |_| None))),
        broken(
            "one camera",
            Noticed("SINGLE_CAMERA"),
            Make::Footage(|f| {
                f.about.cameras.truncate(1);
                f.reels.truncate(1);
            }),
        ),
    ]
}

fn depth() -> Vec<Broken> {
    vec![
        footage("depth all zero", "DEPTH_EMPTY", |f| {
            (0..3).for_each(|c| f.change_depth(c, |_| 0.0));
        }),
        footage("depth that is NaN where nothing was measured", "DEPTH_NOT_FINITE", |f| {
            (0..3).for_each(|c| f.change_depth(c, |z| if z > 0.0 { z } else { f32::NAN }));
        }),
        footage("two thirds of the object without depth", "DEPTH_SPARSE", |f| {
            for depth in f.reels.iter_mut().flat_map(|r| r.depth.iter_mut().flatten()) {
                let pixels = Arc::make_mut(depth).pixels.iter_mut();
                pixels.enumerate().filter(|(i, _)| i % 3 != 0).for_each(|(_, z)| *z = 0.0);
            }
        }),
        footage("a depth stream that froze", "DEPTH_FROZEN", |f| {
            f.reels[1].depth = vec![f.reels[1].depth[0].clone(); FRAMES];
        }),
        footage("depth whose rows start elsewhere", "DEPTH_MISALIGNED", |f| {
            for depth in f.reels.iter_mut().flat_map(|r| r.depth.iter_mut().flatten()) {
                let width = depth.width;
                for row in Arc::make_mut(depth).pixels.chunks_exact_mut(width) {
                    row.rotate_right(10);
                }
            }
        }),
    ]
}

fn masks() -> Vec<Broken> {
    vec![
        footage("no masks", "MASKS_MISSING", |f| {
            for reel in &mut f.reels {
                reel.object = vec![None; FRAMES];
                reel.hand = vec![None; FRAMES];
            }
        }),
        footage("empty masks", "OBJECT_NOT_SEEN", |f| change_masks(f, 0..FRAMES, |_, _| false)),
        footage("masks that are empty in some frames", "OBJECT_MASK_EMPTY", |f| {
            change_masks(f, 14..18, |_, _| false);
        }),
        footage("masks of everything but the object", "MASK_COVERS_IMAGE", |f| {
            change_masks(f, 0..FRAMES, |_, shown| !shown);
        }),
        footage("masks of object and hand swapped in one camera", "MASKS_SWAPPED", |f| {
            let reel = &mut f.reels[1];
            std::mem::swap(&mut reel.object, &mut reel.hand);
        }),
        footage("a mask that takes in the table", "MASK_JUMPS", |f| {
            for frame in [9, 20, 27] {
                change_masks(f, frame..frame + 1, |i, shown| {
                    shown || (i / 160 > 70 && i % 160 > 40 && i % 160 < 110)
                });
            }
        }),
        footage("the hand counted as object, too", "MASKS_OVERLAP", |f| {
            for reel in &mut f.reels {
                for (object, hand) in reel.object.iter_mut().zip(&reel.hand) {
                    let (Some(object), Some(hand)) = (object, hand) else { continue };
                    let pixels = Arc::make_mut(object).pixels.iter_mut().zip(&hand.pixels);
                    pixels.for_each(|(o, h)| *o |= *h);
                }
            }
        }),
        footage("no masks of the hand", "MANIPULATOR_NOT_SEEN", |f| {
            f.reels.iter_mut().for_each(|r| r.hand = vec![None; FRAMES]);
        }),
    ]
}

fn tracks() -> Vec<Broken> {
    let tracks = |name, code, change: fn(&mut Footage)| footage(name, code, change);
    vec![
        tracks("tracks as row, column", "TRACKS_TRANSPOSED", |f| {
            (0..3).for_each(|c| f.change_tracks(c, |_, _, p, _| *p = [p[1], p[0]]));
        }),
        tracks("tracks of images twice as large", "TRACKS_OFF_OBJECT", |f| {
            (0..3).for_each(|c| f.change_tracks(c, |_, _, p, _| *p = [2.0 * p[0], 2.0 * p[1]]));
        }),
        tracks("tracks that get lost", "TRACKS_LOST", |f| {
            (0..3).for_each(|c| {
                f.change_tracks(c, |frame, n, _, visible| *visible &= n % 36 >= 2 * frame);
            });
        }),
        tracks("tracks that stand still", "TRACKS_STILL", |f| {
            for reel in &mut f.reels {
                if let Some(t) = &mut reel.tracks {
                    t.points = t.points[..t.count].repeat(FRAMES);
                    t.visible = t.visible[..t.count].repeat(FRAMES);
                }
            }
        }),
        tracks("visible tracks that are NaN", "TRACKS_NOT_FINITE", |f| {
            (0..3).for_each(|c| {
                f.change_tracks(c, |frame, n, p, _| {
                    if frame > 5 && n % 4 == 0 {
                        *p = [f32::NAN; 2];
                    }
                });
            });
        }),
        broken(
            "no tracks",
            Noticed("TRACKS_MISSING"),
            Make::Footage(|f| {
                f.reels.iter_mut().for_each(|r| r.tracks = None);
            }),
        ),
    ]
}

fn without_times(footage: &mut Footage) {
    footage.about.cameras.iter_mut().for_each(|c| c.times_s.clear());
}

fn shorten(footage: &mut Footage, frames: usize) {
    let about = &mut footage.about;
    let points = about.truth_tracks.len() / about.frame_count * frames;
    about.truth_tracks.truncate(points);
    about.frame_count = frames;
    about.train_frame_count = frames;
    about.cameras.iter_mut().for_each(|c| c.times_s.truncate(frames));
    (0..footage.reels.len()).for_each(|c| footage.retime(c, Some));
}

/// Changes the object's masks, given the index of a pixel and its value.
fn change_masks(
    footage: &mut Footage,
    frames: std::ops::Range<usize>,
    change: impl Fn(usize, bool) -> bool,
) {
    for reel in &mut footage.reels {
        for mask in reel.object[frames.clone()].iter_mut().flatten() {
            let pixels = Mask::clone(mask).pixels;
            let changed = pixels.into_iter().enumerate().map(|(i, shown)| change(i, shown));
            Arc::make_mut(mask).pixels = changed.collect();
        }
    }
}
