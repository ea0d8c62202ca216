//! Images with an orientation, and tracks of other trackers.

use super::{
    rigs::listed,
    spellings::{FileMap, message, metadata, opened},
    *,
};
use crate::{
    check::testing::pack,
    npy,
    raw::testing::{color_png, floats_npy, mask_png, png_file},
};

/// An image with an EXIF orientation before its pixels.
fn oriented(png: &[u8], orientation: u8) -> Vec<u8> {
    let mut exif = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
    let mut chunk = b"eXIf".to_vec();
    chunk.extend(&exif);
    let crc = crc32fast::hash(&chunk);
    let mut out = png[..33].to_vec();
    out.extend((exif.len() as u32).to_be_bytes());
    out.extend(chunk);
    out.extend(crc.to_be_bytes());
    out.extend(&png[33..]);
    out
}

fn all_oriented(files: &mut FileMap, orientation: u8, image: impl Fn(usize) -> Vec<u8>) {
    for frame in 0..FRAMES {
        files.insert(format!("color/1/{frame}.png"), oriented(&image(frame), orientation));
    }
}

#[test]
fn orientations_that_the_size_does_not_settle_are_refused_until_one_is_chosen() {
    for orientation in [2, 3, 4] {
        let mut files = case();
        all_oriented(&mut files, orientation, |frame| color_png(1, frame));
        let text = message(&files);
        assert_eq!(reason(describe(&files)), "IMAGE_TURNED");
        let number = format!("orientation {orientation}");
        assert!(
            text.contains(&number)
                && text.contains("color/1/0.png")
                && text.contains("`image_orientation`"),
            "{text}"
        );
    }
    let mut files = case();
    all_oriented(&mut files, 3, |frame| color_png(1, frame));
    metadata(&mut files, "\"fps\"", "\"image_orientation\": \"stored\", \"fps\"");
    let (_guard, recording) = opened(&files);
    expect_whole(&recording);
    let note = recording.notes.iter().find(|n| n.code == "IMAGE_TURNED").unwrap();
    assert!(note.message.contains("180 degrees") && note.cameras == [1], "{}", note.message);
    metadata(&mut files, "\"stored\"", "\"shown\"");
    let (_guard, recording) = opened(&files);
    let color = recording.source.frames(1).unwrap().color(2).unwrap().unwrap();
    assert_eq!(color.get(0, 0), Some(color_at(1, 2, WIDTH - 1, HEIGHT - 1)));
    metadata(&mut files, "\"shown\"", "\"upright\"");
    assert_eq!(reason(describe(&files)), "INVALID_DOCUMENT");
}

#[test]
fn orientations_that_the_size_settles_are_reported() {
    // Stored upright: the camera's size is that of the file.
    let mut files = case();
    all_oriented(&mut files, 6, |frame| color_png(1, frame));
    let (_guard, recording) = opened(&files);
    expect_whole(&recording);
    let note = recording.notes.iter().find(|n| n.code == "IMAGE_TURNED").unwrap();
    assert!(
        note.message.contains("orientation 6") && note.message.contains("as stored"),
        "{}",
        note.message
    );
    // Stored on its side, to be turned clockwise: pixel (c, r) is shown at (bottom - r, c).
    let mut files = case();
    all_oriented(&mut files, 6, |frame| {
        let rows = (0..WIDTH).flat_map(|row| (0..HEIGHT).map(move |column| (column, row)));
        let shown = rows.flat_map(|(column, row)| color_at(1, frame, WIDTH - 1 - row, column));
        png_file(HEIGHT, WIDTH, ::png::ColorType::Rgb, false, &shown.collect::<Vec<u8>>())
    });
    let (_guard, recording) = opened(&files);
    expect_whole(&recording);
    let note = recording.notes.iter().find(|n| n.code == "IMAGE_TURNED").unwrap();
    assert!(note.message.contains("as shown"), "{}", note.message);
}

#[test]
fn an_orientation_in_the_middle_of_a_recording_is_refused() {
    let mut files = case();
    files.insert("color/0/2.png".into(), oriented(&color_png(0, 2), 3));
    let (_guard, recording) = opened(&files);
    let mut frames = recording.source.frames(0).unwrap();
    assert_eq!(reason(frames.color(2)), "IMAGE_TURNED");
    assert!(frames.color(1).unwrap().is_some());
}

/// Tracks of camera 0 in another form.
fn tracked(arrays: &[(&str, Vec<u8>)]) -> (tempfile::TempDir, Recording) {
    let mut files = case();
    let inner: FileMap = arrays.iter().map(|(n, b)| (format!("{n}.npy"), b.clone())).collect();
    files.insert("cotracker/0.npz".into(), pack(&inner));
    // The object is in the columns 5 to 7: a place that rows do not have.
    for frame in 0..FRAMES {
        files.insert(format!("mask/0/0/{frame}.png"), mask_png(5..8));
        for part in 1..4 {
            files.insert(format!("mask/0/{part}/{frame}.png"), mask_png(0..0));
        }
    }
    opened(&files)
}

#[test]
fn tracks_of_other_trackers_are_read() {
    // Two tracks at (6, 1 + t) and (7, 2), as x, y.
    let at = |track: usize, frame: usize| {
        if track == 0 { [6.0, 1.0 + frame as f32] } else { [7.0, 2.0] }
    };
    let by_frame = |of: &dyn Fn([f32; 2]) -> [f32; 2]| -> Vec<f32> {
        (0..FRAMES).flat_map(|t| [at(0, t), at(1, t)]).flat_map(of).collect()
    };
    let by_track = |of: &dyn Fn([f32; 2]) -> [f32; 2]| -> Vec<f32> {
        (0..2).flat_map(|n| (0..FRAMES).map(move |t| at(n, t))).flat_map(of).collect()
    };
    let scaled = |[x, y]: [f32; 2]| [(x + 0.5) / WIDTH as f32, (y + 0.5) / HEIGHT as f32];
    let flags = |shape: &[usize], value: u8| npy::write("|b1", shape, &[value; FRAMES * 2]);
    let cases: [(_, Vec<u8>, _, Vec<u8>, _); 6] = [
        (
            "tracks",
            floats_npy(&[FRAMES, 2, 2], by_frame(&|p| p)),
            "visibility",
            flags(&[FRAMES, 2], 1),
            "as x, y",
        ),
        (
            "pred_tracks",
            floats_npy(&[1, FRAMES, 2, 2], by_frame(&|p| p)),
            "pred_visibility",
            flags(&[1, FRAMES, 2], 1),
            "as x, y",
        ),
        (
            "tracks",
            floats_npy(&[2, FRAMES, 2], by_track(&|p| p)),
            "visibles",
            flags(&[2, FRAMES], 1),
            "[N, T, 2] as x, y",
        ),
        (
            "points",
            floats_npy(&[2, FRAMES, 2], by_track(&scaled)),
            "occluded",
            flags(&[2, FRAMES], 0),
            "shares of the image's size",
        ),
        (
            "tracks",
            floats_npy(&[FRAMES, 2, 2], by_frame(&|[x, y]| [y, x])),
            "visibility",
            flags(&[FRAMES, 2], 1),
            "as row, column",
        ),
        (
            "tracks",
            floats_npy(&[FRAMES, 2, 2], by_frame(&|p| p)),
            "visibility",
            floats_npy(&[FRAMES, 2, 1], vec![0.9; FRAMES * 2]),
            "as x, y",
        ),
    ];
    for (points, positions, visible, flags, form) in cases {
        let (_guard, recording) = tracked(&[(points, positions), (visible, flags)]);
        let tracks = recording.source.frames(0).unwrap().tracks().unwrap().unwrap();
        assert_eq!(tracks.count, 2, "{form}");
        for frame in 0..FRAMES {
            for track in 0..2 {
                let (found, expected) = (tracks.points[2 * frame + track], at(track, frame));
                let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
                assert!(
                    off < 1e-4 && tracks.visible[2 * frame + track],
                    "{form}: {found:?} {expected:?}"
                );
            }
        }
        let lines = listed(&recording);
        assert!(
            lines.contains("tracks of left: cotracker/0.npz") && lines.contains(form),
            "{lines}\nlacks {form}"
        );
    }
    let (_guard, recording) = tracked(&[("tracks", floats_npy(&[FRAMES, 2, 2], by_frame(&|p| p)))]);
    assert_eq!(reason(recording.source.frames(0).unwrap().tracks()), "MISSING_ARRAY");
}
