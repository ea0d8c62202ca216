//! Objects and hands that are not seen when they have to be, labels that change, and meshes: mistakes
//! while segmenting and cutting.

use std::{ops::Range, sync::Arc};

use bendtwin_capture::raw::{Mask, MeshFile};

use crate::{
    Broken,
    Expected::Found,
    Make, broken,
    footage::{FRAMES, Footage},
};

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    [hands(), objects(), labels(), meshes()].concat()
}

fn footage(name: &'static str, code: &'static str, change: fn(&mut Footage)) -> Broken {
    broken(name, Found(code), Make::Footage(change))
}

fn hands() -> Vec<Broken> {
    vec![
        footage("a hand that enters late", "HAND_NOT_TRACKED", |f| hide_hand(f, 0..9)),
        footage("no mask of the hand in the first frame", "HAND_NOT_TRACKED", |f| {
            hide_hand(f, 0..1);
        }),
        footage("a hand that is lost half-way", "HAND_LOST", |f| hide_hand(f, FRAMES / 2..FRAMES)),
        footage("masks of the hand in the first frame only", "HAND_LOST", |f| {
            hide_hand(f, 1..FRAMES);
        }),
        footage("a hand that releases and leaves", "HAND_LOST", |f| {
            hide_hand(f, FRAMES - 8..FRAMES);
        }),
        footage("a hand that is hidden for ten frames", "HAND_LOST", |f| hide_hand(f, 12..22)),
        footage("no depth on the hand, a glove that is black", "MANIPULATOR_NOT_SEEN", |f| {
            for reel in &mut f.reels {
                for (depth, hand) in reel.depth.iter_mut().zip(&reel.hand) {
                    let (Some(depth), Some(hand)) = (depth, hand) else { continue };
                    let pixels = Arc::make_mut(depth).pixels.iter_mut().zip(&hand.pixels);
                    pixels.filter(|(_, shown)| **shown).for_each(|(z, _)| *z = 0.0);
                }
            }
        }),
    ]
}

fn objects() -> Vec<Broken> {
    vec![
        footage("an object that enters late", "OBJECT_NOT_TRACKED", |f| hide_object(f, 0..3, 0..8)),
        footage("no mask of the object in the first frame", "OBJECT_NOT_TRACKED", |f| {
            hide_object(f, 0..3, 0..1);
        }),
        footage("masks of the object in the first frame only", "MASKS_NOT_FOLLOWED", |f| {
            hide_object(f, 0..3, 1..FRAMES);
        }),
        footage("one mask for each camera, as a click leaves it", "MASKS_NOT_FOLLOWED", |f| {
            for reel in &mut f.reels {
                reel.object[1..].fill(None);
                reel.hand[1..].fill(None);
            }
        }),
        footage("an object that is lost half-way", "OBJECT_MASK_EMPTY", |f| {
            hide_object(f, 0..3, FRAMES / 2..FRAMES);
        }),
        footage("an object that leaves the views at the end", "OBJECT_MASK_EMPTY", |f| {
            hide_object(f, 0..3, FRAMES * 4 / 5..FRAMES);
        }),
        footage("one camera whose masks are black", "OBJECT_MASK_EMPTY", |f| {
            hide_object(f, 1..2, 0..FRAMES);
        }),
        footage("one camera that loses the object half-way", "OBJECT_MASK_EMPTY", |f| {
            hide_object(f, 2..3, FRAMES / 2..FRAMES);
        }),
        footage("a cut before anything moves", "NOTHING_MOVES", |f| {
            (0..3).for_each(|c| f.retime(c, |frame| Some(frame % 2)));
        }),
        footage("no depth in the first frame of any camera", "FRAMES_DROPPED", |f| {
            f.reels.iter_mut().for_each(|r| r.depth[0] = None);
        }),
    ]
}

fn labels() -> Vec<Broken> {
    vec![
        footage("numbers of masks that are exchanged half-way", "MASKS_SWAPPED", |f| {
            for reel in &mut f.reels {
                let second = FRAMES / 2..FRAMES;
                reel.object[second.clone()].swap_with_slice(&mut reel.hand[second]);
            }
        }),
        footage("masks that are exchanged in one camera for a while", "MASKS_SWAPPED", |f| {
            let reel = &mut f.reels[2];
            reel.object[10..20].swap_with_slice(&mut reel.hand[10..20]);
        }),
        footage("one mask for object and hand", "MASKS_OVERLAP", |f| {
            for reel in &mut f.reels {
                for (object, hand) in reel.object.iter_mut().zip(&mut reel.hand) {
                    let (Some(object), Some(hand)) = (object, hand) else { continue };
                    let pixels = object.pixels.iter().zip(&hand.pixels).map(|(o, h)| *o || *h);
                    let both = Arc::new(Mask { pixels: pixels.collect(), ..Mask::clone(object) });
                    (*object, *hand) = (both.clone(), both);
                }
            }
        }),
        footage("the hand's mask for the object's, too", "MASKS_OVERLAP", |f| {
            f.reels.iter_mut().for_each(|r| r.object = r.hand.clone());
        }),
        footage("masks of the hand that show everything else", "MASK_COVERS_IMAGE", |f| {
            for reel in &mut f.reels {
                for (object, hand) in reel.object.iter().zip(&mut reel.hand) {
                    let (Some(object), Some(hand)) = (object, hand) else { continue };
                    let pixels = object.pixels.iter().map(|o| !*o).collect();
                    *hand = Arc::new(Mask { pixels, ..Mask::clone(hand) });
                }
            }
        }),
        footage("masks that are white", "MASK_COVERS_IMAGE", |f| {
            for mask in f.reels.iter_mut().flat_map(|r| r.object.iter_mut().flatten()) {
                Arc::make_mut(mask).pixels.fill(true);
            }
        }),
        footage("masks that flicker", "MASK_JUMPS", |f| {
            for reel in &mut f.reels {
                for mask in reel.object.iter_mut().step_by(3).flatten() {
                    let mask = Arc::make_mut(mask);
                    mask.pixels.iter_mut().step_by(2).for_each(|shown| *shown = false);
                }
            }
        }),
        footage("a hand that is masked far from the object", "NO_CONTACT", |f| {
            // The mask shows a spot of the table instead.
            f.about.cameras.truncate(1);
            f.reels.truncate(1);
            for mask in f.reels.iter_mut().flat_map(|r| r.hand.iter_mut().flatten()) {
                let mask = Arc::make_mut(mask);
                let (width, height) = (mask.width, mask.height);
                mask.pixels.fill(false);
                for row in height - 12..height - 2 {
                    mask.pixels[row * width + 2..row * width + 14].fill(true);
                }
            }
        }),
    ]
}

fn meshes() -> Vec<Broken> {
    fn with_mesh(footage: &mut Footage, name: &str, bytes: &[u8]) {
        let (name, bytes) = (name.to_owned(), bytes.to_vec());
        footage.about.mesh = Some(MeshFile { name, bytes, to_world: None });
    }
    vec![
        footage("a mesh that was cut off", "MESH_UNUSABLE", |f| {
            let bytes = f.about.mesh.as_ref().map(|m| m.bytes.clone()).unwrap_or_default();
            with_mesh(f, "object.glb", &bytes[..bytes.len() / 2]);
        }),
        footage("a page for a mesh", "MESH_UNUSABLE", |f| {
            with_mesh(f, "object.obj", b"<!DOCTYPE html><title>404 Not Found</title>");
        }),
        footage("a mesh without triangles", "MESH_UNUSABLE", |f| {
            with_mesh(f, "object.obj", b"v 0 0 0\nv 0 0 1\nv 0 1 0\n");
        }),
        footage("a mesh with a corner that it lacks", "MESH_UNUSABLE", |f| {
            with_mesh(f, "object.obj", b"v 0 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 9\n");
        }),
    ]
}

fn hide_hand(footage: &mut Footage, frames: Range<usize>) {
    for mask in footage.reels.iter_mut().flat_map(|r| r.hand[frames.clone()].iter_mut().flatten()) {
        Arc::make_mut(mask).pixels.fill(false);
    }
}

fn hide_object(footage: &mut Footage, cameras: Range<usize>, frames: Range<usize>) {
    let reels = footage.reels[cameras].iter_mut();
    for mask in reels.flat_map(|r| r.object[frames.clone()].iter_mut().flatten()) {
        Arc::make_mut(mask).pixels.fill(false);
    }
}
