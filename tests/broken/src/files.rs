//! Damaged, absurd and contradictory files.

use std::{
    collections::BTreeMap,
    io::{Cursor, Read},
    path::Path,
    sync::LazyLock,
};

use bendtwin_capture::raw::{BundleOptions, Recording, export_case, write_bundle_to};
use zip::ZipArchive;

use crate::{
    Broken,
    Expected::{Damaged, Found, Refused},
    Make, Sample, broken,
    footage::{CameraFrames, Footage, healthy},
};

/// Contents of files by their names in the recording.
pub type FileMap = BTreeMap<String, Vec<u8>>;

static CASE: LazyLock<FileMap> = LazyLock::new(|| exported(&healthy().recording()));

static BUNDLE: LazyLock<FileMap> = LazyLock::new(|| {
    let options = BundleOptions::default();
    let bytes = write_bundle_to(&healthy().recording(), Cursor::new(Vec::new()), &options);
    let mut zip = ZipArchive::new(bytes.expect("it is written")).expect("it is an archive");
    let mut files = FileMap::new();
    for index in 0..zip.len() {
        let mut entry = zip.by_index(index).expect("it has as many entries as it says");
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).expect("it is whole");
        files.insert(entry.name().expect("names are text").into_owned(), bytes);
    }
    files
});

/// The healthy recording as a PhysTwin case.
pub fn case() -> &'static FileMap {
    &CASE
}

/// The healthy recording as a raw bundle.
pub fn bundle() -> &'static FileMap {
    &BUNDLE
}

fn exported(recording: &Recording) -> FileMap {
    let mut files = FileMap::new();
    let put = |name: &str, bytes| {
        files.insert(name.to_owned(), bytes);
        Ok(())
    };
    export_case(recording, put).expect("it is written");
    files
}

/// Writes the changed description of a case; frames are unchanged.
pub(crate) fn redescribe(files: &mut FileMap, change: impl Fn(&mut Recording)) {
    let mut about = healthy().about;
    change(&mut about);
    let blank = Footage { reels: vec![CameraFrames::default(); about.cameras.len()], about };
    files.extend(exported(&blank.recording()));
}

/// Changed files in a folder.
pub(crate) fn stored(files: &FileMap, change: fn(&mut FileMap)) -> Sample {
    let mut files = files.clone();
    change(&mut files);
    let folder = tempfile::tempdir().expect("there is room for it");
    write(&files, folder.path());
    let path = folder.path().to_owned();
    Sample::Stored(folder, path)
}

/// A changed folder with a case.
pub(crate) fn changed_folder(change: fn(&Path)) -> Sample {
    let folder = tempfile::tempdir().expect("there is room for it");
    write(case(), folder.path());
    change(folder.path());
    let path = folder.path().to_owned();
    Sample::Stored(folder, path)
}

fn write(files: &FileMap, folder: &Path) {
    for (name, bytes) in files {
        let path = folder.join(name);
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).expect("folders can be made");
        std::fs::write(&path, bytes).expect("there is room for it");
    }
}

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    let mut all = [descriptions(), manifests(), frames()].concat();
    #[cfg(unix)]
    all.push(broken(
        "a link out of the folder",
        Found("FRAMES_DROPPED"),
        Make::Folder(|folder| {
            let image = folder.join("color/0/3.png");
            std::fs::remove_file(&image).expect("it was there");
            std::os::unix::fs::symlink("/dev/zero", &image).expect("links can be made");
        }),
    ));
    all
}

/// What Git leaves of a file that was not fetched.
const POINTER: &[u8] = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";

fn descriptions() -> Vec<Broken> {
    let case = |name, reason, change| broken(name, Refused(reason), Make::Case(change));
    vec![
        case("no files", "UNKNOWN_CAPTURE_KIND", FileMap::clear),
        case("a description that was cut off", "INVALID_DOCUMENT", |f| cut(f, "metadata.json")),
        case("no frame rate", "INVALID_DOCUMENT", |f| reword(f, "\"fps\":30.0,", "")),
        case("a frame rate of zero", "LENGTH_MISMATCH", |f| reword(f, "\"fps\":30.0", "\"fps\":0")),
        case("NaN in JSON", "INVALID_DOCUMENT", |f| reword(f, "\"fps\":30.0", "\"fps\":NaN")),
        case("brackets without end", "INVALID_DOCUMENT", |f| {
            f.insert("metadata.json".to_owned(), vec![b'['; 200_000]);
        }),
        case("no frame count", "LENGTH_MISMATCH", |f| {
            reword(f, "\"frame_num\":36", "\"frame_num\":0");
        }),
        case("a split behind the last frame", "SPLIT_OUT_OF_RANGE", |f| {
            f.insert("split.json".to_owned(), br#"{"train": [0, 200]}"#.to_vec());
        }),
        case("a split that begins in the middle", "INVALID_DOCUMENT", |f| {
            f.insert("split.json".to_owned(), br#"{"train": [10, 20]}"#.to_vec());
        }),
        case("a billion frames", "CAPTURE_TOO_MANY", |f| {
            reword(f, "\"frame_num\":36", "\"frame_num\":1000000000");
        }),
        case("images of 100,000 x 100,000", "CAPTURE_TOO_MANY", |f| {
            reword(f, "[160,120]", "[100000,100000]");
        }),
        case("images without columns", "INVALID_CAMERA", |f| reword(f, "[160,120]", "[0,120]")),
        case("a thousand cameras", "CAPTURE_TOO_MANY", |f| {
            redescribe(f, |about| about.cameras = vec![about.cameras[0].clone(); 1000]);
        }),
        case("a calibration that was cut off", "FILE_DAMAGED", |f| cut(f, "calibrate.pkl")),
        case("a calibration that calls a function", "PICKLE_GLOBAL_REFUSED", |f| {
            let call = b"\x80\x03cos\nsystem\nX\x04\x00\x00\x00true\x85R.".to_vec();
            f.insert("calibrate.pkl".to_owned(), call);
        }),
        case("pointers of Git LFS for images", "FORMAT_NOT_READ", |f| {
            for (_, bytes) in f.iter_mut().filter(|(name, _)| name.ends_with(".png")) {
                *bytes = POINTER.to_vec();
            }
        }),
        case("a pointer of Git LFS for a calibration", "FORMAT_NOT_READ", |f| {
            f.insert("calibrate.pkl".to_owned(), POINTER.to_vec());
        }),
        case("a web page for a description", "FORMAT_NOT_READ", |f| {
            f.insert("metadata.json".to_owned(), b"<!doctype html><p>Sign in".to_vec());
        }),
        case("a calibration of nested lists", "PICKLE_REFUSED", |f| {
            let nested = [vec![b']'; 5000], vec![b'a'; 4999], vec![b'.']].concat();
            f.insert("calibrate.pkl".to_owned(), nested);
        }),
    ]
}

fn manifests() -> Vec<Broken> {
    let bundle = |name, reason, change| broken(name, Refused(reason), Make::Bundle(change));
    vec![
        bundle("a bundle of a version to come", "UNSUPPORTED_VERSION", |f| {
            reword(f, "\"version\": 1", "\"version\": 99");
        }),
        bundle("a bundle in feet", "UNKNOWN_UNITS", |f| {
            reword(f, "\"units\": \"m\"", "\"units\": \"ft\"");
        }),
        bundle("a left-handed bundle", "INVALID_AXES", |f| reword(f, "\"right\"", "\"left\"")),
        bundle("a misspelt key", "INVALID_DOCUMENT", |f| {
            reword(f, "\"frame_count\"", "\"frames_count\"");
        }),
        bundle("an image pattern that leaves the bundle", "INVALID_DOCUMENT", |f| {
            reword(f, "cameras/0/color", "../../color");
        }),
        broken(
            "times of other frames",
            Refused("WRONG_SHAPE"),
            Make::Bundle(|f| {
                let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }";
                f.insert("cameras/0/times_s.npy".to_owned(), npy(header, &[0; 16]));
            }),
        ),
        broken(
            "no depth images",
            Refused("IMAGES_NOT_FOUND"),
            Make::Bundle(|f| {
                f.retain(|name, _| !name.contains("/depth/"));
            }),
        ),
    ]
}

fn frames() -> Vec<Broken> {
    let case = |name, reason, change| broken(name, Damaged(reason), Make::Case(change));
    vec![
        case("an image that was cut off", "FILE_DAMAGED", |f| cut(f, "color/1/5.png")),
        case("an image whose data is noise", "FILE_DAMAGED", |f| {
            let image = f.get_mut("color/1/5.png").expect("it is there");
            image[60..].iter_mut().enumerate().for_each(|(i, b)| *b = (i * 97 % 251) as u8);
        }),
        case("text for an image", "FILE_DAMAGED", |f| {
            f.insert("color/1/5.png".to_owned(), b"404 Not Found".to_vec());
        }),
        case("an image of another size", "WRONG_IMAGE_SIZE", |f| {
            let image = f.get_mut("color/1/5.png").expect("it is there");
            resize(image, 80, 60);
        }),
        case("an image that claims 100,000 x 100,000", "WRONG_IMAGE_SIZE", |f| {
            let image = f.get_mut("color/1/5.png").expect("it is there");
            resize(image, 100_000, 100_000);
        }),
        case("a mask of another size", "WRONG_IMAGE_SIZE", |f| {
            let image = f.get_mut("mask/0/0/7.png").expect("it is there");
            resize(image, 320, 240);
        }),
        case("depth of another shape than colour", "WRONG_IMAGE_SIZE", |f| {
            let header = "{'descr': '<u2', 'fortran_order': False, 'shape': (160, 120), }";
            f.insert("depth/2/0.npy".to_owned(), npy(header, &vec![0; 160 * 120 * 2]));
        }),
        case("depth that claims a trillion numbers", "HEADER_CLAIMS_TOO_MUCH", |f| {
            let header = "{'descr': '<u2', 'fortran_order': False, 'shape': (1000000, 1000000), }";
            f.insert("depth/2/0.npy".to_owned(), npy(header, &[0; 16]));
        }),
        case("depth that was cut off", "HEADER_CLAIMS_TOO_MUCH", |f| cut(f, "depth/2/0.npy")),
        case("depth of complex numbers", "WRONG_DTYPE", |f| {
            let header = "{'descr': '<c16', 'fortran_order': False, 'shape': (120, 160), }";
            f.insert("depth/2/0.npy".to_owned(), npy(header, &vec![0; 160 * 120 * 16]));
        }),
        case("tracks that were cut off", "ARCHIVE_DAMAGED", |f| cut(f, "cotracker/0.npz")),
        case("tracks of another recording", "WRONG_SHAPE", |f| {
            let archive = crate::archives::pack(&FileMap::from([
                (
                    "tracks.npy".to_owned(),
                    npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 1, 2), }", &[0; 16]),
                ),
                (
                    "visibility.npy".to_owned(),
                    npy("{'descr': '|b1', 'fortran_order': False, 'shape': (2, 1), }", &[1; 2]),
                ),
            ]));
            f.insert("cotracker/0.npz".to_owned(), archive);
        }),
    ]
}

/// The first half of a file.
fn cut(files: &mut FileMap, name: &str) {
    let file = files.get_mut(name).expect("it is there");
    file.truncate(file.len() / 2);
}

/// Changes words of the description.
pub(crate) fn reword(files: &mut FileMap, from: &str, to: &str) {
    let mut changed = false;
    for name in ["metadata.json", "capture.json"] {
        if let Some(file) = files.get_mut(name) {
            let text = String::from_utf8_lossy(file).into_owned();
            changed |= text.contains(from);
            *file = text.replace(from, to).into_bytes();
        }
    }
    assert!(changed, "the description does not say {from}");
}

pub(crate) fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16 + 1).to_le_bytes());
    out.extend(header.as_bytes());
    out.push(b'\n');
    out.extend(data);
    out
}

/// Makes a PNG claim another size, with the checksum that belongs to it.
fn resize(image: &mut [u8], width: u32, height: u32) {
    image[16..20].copy_from_slice(&width.to_be_bytes());
    image[20..24].copy_from_slice(&height.to_be_bytes());
    let sum = crc32fast::hash(&image[12..29]);
    image[29..33].copy_from_slice(&sum.to_be_bytes());
}
