//! Masks as tools write them: read, or refused with the document to write.

use std::collections::BTreeMap;

use bendtwin_capture::raw::{ColorImage, Mask};
use jpeg_encoder::{ColorType, Encoder};

use crate::{
    Broken,
    Expected::{Found, Refused, Sound},
    Make, broken,
    files::{FileMap, npy},
};

/// Columns and rows.
const SIZE: [usize; 2] = [160, 120];
const NAMES: &[u8] = br#"{"1": "toy", "2": "hand"}"#;

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    let case = |name, expected, change| broken(name, expected, Make::Case(change));
    vec![
        case("images of labels", Sound("MASK_LABELS"), |f| {
            labelled(f);
            f.insert("mask/labels.json".to_owned(), NAMES.to_vec());
        }),
        case("images of labels without names", Refused("MASK_LABELS_UNCLEAR"), labelled),
        case("masks as arrays", Sound("MASK_LABELS"), |f| {
            replace(f, |camera, label, frame, mask| {
                let pixels: Vec<u8> = mask.pixels.iter().map(|shown| u8::from(*shown)).collect();
                let header = "{'descr': '|b1', 'fortran_order': False, 'shape': (120, 160), }";
                let name = ["toy", "hand"][label];
                (format!("mask/{camera}/{name}/{frame:05}.npy"), npy(header, &pixels))
            });
        }),
        case("masks as JPEG", Sound("MASK_LABELS"), |f| {
            replace(f, |camera, label, frame, mask| {
                let gray: Vec<u8> =
                    mask.pixels.iter().map(|shown| 255 * u8::from(*shown)).collect();
                let mut bytes = Vec::new();
                let (encoder, [width, height]) =
                    (Encoder::new(&mut bytes, 95), SIZE.map(|n| n as u16));
                encoder.encode(&gray, width, height, ColorType::Luma).expect("it has pixels");
                (format!("mask/{camera}/{}/{frame:05}.jpg", ["toy", "hand"][label]), bytes)
            });
        }),
        case("numbers of things without names", Refused("MASK_LABELS_UNCLEAR"), |f| {
            replace(f, |camera, label, frame, mask| {
                let bytes = mask.encode().expect("it has pixels");
                (format!("mask/{camera}/{:03}/{frame:05}.png", label + 1), bytes)
            });
        }),
        case("masks of the first images alone", Found("MASKS_NOT_FOLLOWED"), |f| {
            f.retain(|name, _| {
                !name.starts_with("mask/") || name.ends_with("/0.png") || name.ends_with("json")
            });
        }),
        case("masks in run lengths that are cut off", Refused("INVALID_DOCUMENT"), |f| {
            f.retain(|name, _| !name.starts_with("mask/"));
            f.insert("mask/0.json".to_owned(), br#"{"1": [{"size": [120, 160], "#.to_vec());
        }),
    ]
}

/// Takes the masks away: those of object (0) and hand (1) with their camera, thing and frame.
fn taken(files: &mut FileMap) -> Vec<([usize; 3], Mask)> {
    let mut masks = Vec::new();
    files.retain(|name, bytes| {
        let parts: Vec<&str> = name.split('/').collect();
        if let ["mask", camera, label, image] = parts.as_slice() {
            let place = [*camera, *label, image.trim_end_matches(".png")];
            let place = place.map(|number| number.parse().expect("it is a number"));
            masks.push((place, Mask::decode(name, bytes, SIZE).expect("it is whole")));
        }
        !name.starts_with("mask/")
    });
    masks
}

/// Other files for the masks of object (0) and hand (1), by camera, thing and frame.
fn replace(files: &mut FileMap, file: impl Fn(usize, usize, usize, &Mask) -> (String, Vec<u8>)) {
    for ([camera, label, frame], mask) in taken(files) {
        files.extend([file(camera, label, frame, &mask)]);
    }
}

/// Replaces both masks by one image of labels: 1 where the object is, 2 where the hand is.
fn labelled(files: &mut FileMap) {
    let mut images: BTreeMap<[usize; 2], ColorImage> = BTreeMap::new();
    for ([camera, label, frame], mask) in taken(files) {
        let blank = || ColorImage::filled(SIZE[0], SIZE[1], [0; 3]);
        let labels = images.entry([camera, frame]).or_insert_with(blank);
        let value = if label == 0 { 1 } else { 2 };
        let shown = labels.pixels.iter_mut().zip(&mask.pixels).filter(|(_, shown)| **shown);
        shown.for_each(|(pixel, _)| *pixel = [value; 3]);
    }
    files.extend(images.iter().map(|([camera, frame], image)| {
        (format!("mask/{camera}/{frame}.png"), image.encode().expect("it has pixels"))
    }));
}
