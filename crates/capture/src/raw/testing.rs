//! Tiny recordings as maps from file name to bytes, easy to break.

use std::{fmt::Write as _, path::PathBuf};

use tempfile::TempDir;

use super::Recording;
use crate::{
    Error, Limits,
    check::testing::{FileMap, pack},
    npy,
};

pub(super) const WIDTH: usize = 8;
pub(super) const HEIGHT: usize = 6;
pub(super) const FRAMES: usize = 4;

/// A PNG image of samples of 8 bits, or 16 with the higher byte first.
pub(super) fn png_file(
    width: usize,
    height: usize,
    color: png::ColorType,
    deep: bool,
    data: &[u8],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(color);
    encoder.set_depth(if deep { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    bytes
}

/// A PNG whose header claims a size that its data does not have.
pub(super) fn png_claiming(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = png_file(1, 1, png::ColorType::Grayscale, false, &[0]);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let crc = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    bytes
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, b| {
        (0..8).fold(
            crc ^ u32::from(*b),
            |c, _| if c & 1 == 1 { (c >> 1) ^ 0xEDB8_8320 } else { c >> 1 },
        )
    })
}

/// The colour that the tiny recordings have at a pixel.
pub(super) fn color_at(camera: usize, frame: usize, column: usize, row: usize) -> [u8; 3] {
    [(camera * 100 + frame) as u8, (column * 10) as u8, (row * 10) as u8]
}

/// The depth [mm] that they have at a pixel; the first row saw nothing.
pub(super) fn depth_mm_at(camera: usize, frame: usize, column: usize, row: usize) -> u16 {
    if row == 0 { 0 } else { (500 + 100 * camera + 10 * frame + row * WIDTH + column) as u16 }
}

pub(super) fn pixels() -> impl Iterator<Item = (usize, usize)> {
    (0..HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| (column, row)))
}

pub(super) fn color_png(camera: usize, frame: usize) -> Vec<u8> {
    let data: Vec<u8> = pixels().flat_map(|(c, r)| color_at(camera, frame, c, r)).collect();
    png_file(WIDTH, HEIGHT, png::ColorType::Rgb, false, &data)
}

/// A mask of the columns in `columns`.
pub(super) fn mask_png(columns: std::ops::Range<usize>) -> Vec<u8> {
    let data: Vec<u8> = pixels().map(|(c, _)| if columns.contains(&c) { 255 } else { 0 }).collect();
    png_file(WIDTH, HEIGHT, png::ColorType::Grayscale, false, &data)
}

pub(super) fn depth_npy(camera: usize, frame: usize) -> Vec<u8> {
    let data: Vec<u8> =
        pixels().flat_map(|(c, r)| depth_mm_at(camera, frame, c, r).to_le_bytes()).collect();
    npy::write("<u2", &[HEIGHT, WIDTH], &data)
}

/// A pickled list of 4 x 4 matrices as numpy writes them in protocol 3.
pub(super) fn pickled(matrices: &[[[f64; 4]; 4]]) -> Vec<u8> {
    let mut bytes = b"\x80\x03]".to_vec();
    for m in matrices {
        bytes
            .extend(b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R");
        bytes.extend(b"(K\x01K\x04K\x04\x86cnumpy\ndtype\nX\x02\x00\x00\x00f8\x89\x88\x87R");
        bytes.extend(b"(K\x03X\x01\x00\x00\x00<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89B\x80\x00\x00\x00");
        bytes.extend(m.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend(b"tba");
    }
    bytes.push(b'.');
    bytes
}

/// A camera 0.5 m above the ground of a world with z down, looking down.
pub(super) const LOOKING_DOWN: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.1], [0.0, 1.0, 0.0, 0.2], [0.0, 0.0, 1.0, -0.5], [0.0, 0.0, 0.0, 1.0]];

pub(super) fn floats_npy(shape: &[usize], values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    let data: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
    npy::write("<f4", shape, &data)
}

/// A PhysTwin case of two cameras.
pub(crate) fn case() -> FileMap {
    let mut files = FileMap::new();
    let mut put = |name: String, bytes: Vec<u8>| {
        files.insert(name, bytes);
    };
    let k = "[[10.0, 0.0, 3.5], [0.0, 11.0, 2.5], [0.0, 0.0, 1.0]]";
    let mut metadata = String::new();
    write!(
        metadata,
        "{{\"intrinsics\": [{k}, {k}], \"WH\": [{WIDTH}, {HEIGHT}], \"fps\": 30.0, \
         \"frame_num\": {FRAMES}, \"serial_numbers\": [\"left\", \"right\"]}}"
    )
    .unwrap();
    put("metadata.json".into(), metadata.into_bytes());
    put("calibrate.pkl".into(), pickled(&[LOOKING_DOWN; 2]));
    put("split.json".into(), br#"{"frame_len": 4, "train": [0, 3], "test": [3, 4]}"#.to_vec());
    put("shape/matching/final_mesh.glb".into(), b"glTF".to_vec());
    for camera in 0..2 {
        let info = br#"{"0": "toy", "1": "left_hand", "2": "Gripper2", "3": "handkerchief"}"#;
        put(format!("mask/mask_info_{camera}.json"), info.to_vec());
        let points = (0..FRAMES).flat_map(|t| [1.0 + t as f32, 6.0, 2.0, f32::NAN]);
        let tracks = FileMap::from([
            ("tracks.npy".to_owned(), floats_npy(&[FRAMES, 2, 2], points)),
            ("visibility.npy".to_owned(), npy::write("|b1", &[FRAMES, 2], &[1; FRAMES * 2])),
        ]);
        put(format!("cotracker/{camera}.npz"), pack(&tracks));
        for frame in 0..FRAMES {
            put(format!("color/{camera}/{frame}.png"), color_png(camera, frame));
            put(format!("depth/{camera}/{frame}.npy"), depth_npy(camera, frame));
            for part in 0..4 {
                put(format!("mask/{camera}/{part}/{frame}.png"), mask_png(part..part + 1));
            }
        }
    }
    files
}

/// Files in a folder that lasts as long as the returned guard.
pub(crate) fn folder(files: &FileMap) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

/// Files in an archive that lasts as long as the returned guard.
pub(super) fn archive(files: &FileMap) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording.zip");
    std::fs::write(&path, pack(files)).unwrap();
    (folder, path)
}

/// Opens files as a recording; in-memory files are read from a folder that is removed when this
/// returns, so only descriptions can be checked.
pub(super) fn describe(files: &FileMap) -> Result<Recording, Error> {
    let folder = folder(files);
    super::open(folder.path(), &Limits::default())
}

/// The reason of an error.
pub(super) fn reason<T>(result: Result<T, Error>) -> &'static str {
    use bendtwin_core::Problem;
    match result {
        Ok(_) => "no error",
        Err(error) => error.reason(),
    }
}
