//! Files that cannot be read, and must not hurt.

use std::{io::Write, path::Path};

use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use super::{
    super::testing::{FileMap, bundle, pack},
    *,
};
use crate::npy;

/// A PhysTwin case that Python wrote.
fn case() -> FileMap {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/case");
    ["final_data.pkl", "metadata.json", "split.json", "gt_track_3d.pkl"]
        .map(|name| (name.to_owned(), std::fs::read(folder.join(name)).unwrap()))
        .into()
}

fn check_bytes(bytes: &[u8], limits: &Limits) -> CheckReport {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("capture.zip");
    std::fs::write(&path, bytes).unwrap();
    check_path(&path, limits)
}

fn text(files: &mut FileMap, name: &str, from: &str, to: &str) {
    let text = String::from_utf8(files[name].clone()).unwrap();
    assert!(text.contains(from), "{name} has no {from}");
    files.insert(name.to_owned(), text.replace(from, to).into_bytes());
}

type Break = fn(&mut FileMap);

const BROKEN_BUNDLES: &[(&str, &str, Break)] = &[
    ("UNKNOWN_CAPTURE_KIND", "capture.json", |f| {
        f.remove("capture.json");
    }),
    ("MISSING_FILE", "object_points.npy", |f| {
        f.remove("object_points.npy");
    }),
    ("INVALID_DOCUMENT", "capture.json", |f| {
        f.insert("capture.json".into(), b"{\"format\": ".to_vec());
    }),
    ("INVALID_DOCUMENT", "`format`", |f| text(f, "capture.json", "bendtwin-capture", "other")),
    ("INVALID_DOCUMENT", "fsp", |f| text(f, "capture.json", "\"fps\"", "\"fsp\"")),
    ("UNSUPPORTED_VERSION", "version 7", |f| {
        text(f, "capture.json", "\"version\": 1", "\"version\": 7");
    }),
    ("UNKNOWN_UNITS", "furlong", |f| text(f, "capture.json", "\"m\"", "\"furlong\"")),
    ("INVALID_AXES", "does not declare `units`", |f| {
        text(f, "capture.json", "\"units\": \"m\",", "");
    }),
    ("INVALID_AXES", "does not declare `up_axis`", |f| {
        text(f, "capture.json", "\"up_axis\": \"+z\",", "");
    }),
    ("INVALID_AXES", "left-handed", |f| text(f, "capture.json", "\"right\"", "\"left\"")),
    ("INVALID_AXES", "`up_axis` is `z+`", |f| text(f, "capture.json", "\"+z\"", "\"z+\"")),
    ("INVALID_AXES", "has no direction", |f| {
        let text = String::from_utf8(f["capture.json"].clone()).unwrap();
        let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
        json["ground"]["normal"] = serde_json::json!([0, 0, 0]);
        f.insert("capture.json".into(), json.to_string().into_bytes());
    }),
    ("INVALID_AXES", "it mirrors", |f| {
        let mut json: serde_json::Value = serde_json::from_slice(&f["capture.json"]).unwrap();
        json["source_to_world"] = serde_json::json!([[-1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        f.insert("capture.json".into(), json.to_string().into_bytes());
    }),
    ("INVALID_DOCUMENT", "plain path", |f| {
        let mut json: serde_json::Value = serde_json::from_slice(&f["capture.json"]).unwrap();
        json["sequences"][0]["folder"] = serde_json::json!("../../etc");
        f.insert("capture.json".into(), json.to_string().into_bytes());
    }),
    ("SPLIT_OUT_OF_RANGE", "frame -3", |f| {
        text(f, "capture.json", "\"train_frame_count\": 17", "\"train_frame_count\": -3");
    }),
    ("WRONG_SHAPE", "object_points.npy", |f| {
        f.insert("object_points.npy".into(), npy::write("<f4", &[2, 3], &[0; 24]));
    }),
    ("WRONG_SHAPE", "control_points.npy", |f| {
        f.insert("control_points.npy".into(), npy::write("<f4", &[2, 1, 3], &[0; 24]));
    }),
    ("WRONG_DTYPE", "int32", |f| {
        f.insert("object_points.npy".into(), npy::write("<i4", &[1, 2, 3], &[0; 24]));
    }),
    ("WRONG_DTYPE", "big-endian", |f| {
        f.insert("object_points.npy".into(), npy::write(">f4", &[1, 2, 3], &[0; 24]));
    }),
    ("FILE_DAMAGED", "object_points.npy", |f| {
        f.get_mut("object_points.npy").unwrap().truncate(20);
    }),
    ("HEADER_CLAIMS_TOO_MUCH", "object_points.npy", |f| {
        let len = f["object_points.npy"].len();
        f.get_mut("object_points.npy").unwrap().truncate(len - 5);
    }),
    ("HEADER_CLAIMS_TOO_MUCH", "truth_tracks.npy", |f| {
        f.insert("truth_tracks.npy".into(), npy::write("<f8", &[1_000_000_000_000], &[]));
    }),
    ("EDGE_OUT_OF_RANGE", "-1", |f| {
        let bytes: Vec<u8> = [0_i32, -1].iter().flat_map(|i| i.to_le_bytes()).collect();
        f.insert("edges.npy".into(), npy::write("<i4", &[1, 2], &bytes));
    }),
    ("PIN_OUT_OF_RANGE", "99", |f| {
        let bytes: Vec<u8> = [0_i32, 99].iter().flat_map(|i| i.to_le_bytes()).collect();
        f.insert("pins.npy".into(), npy::write("<i4", &[1, 2], &bytes));
    }),
    ("SEVERAL_CAPTURES", "a, b", |f| {
        let manifest = f.remove("capture.json").unwrap();
        f.insert("a/capture.json".into(), manifest.clone());
        f.insert("b/capture.json".into(), manifest);
    }),
];

const BROKEN_CASES: &[(&str, &str, Break)] = &[
    ("MISSING_FILE", "metadata.json", |f| {
        f.remove("metadata.json");
    }),
    ("INVALID_DOCUMENT", "fps", |f| text(f, "metadata.json", "\"fps\"", "\"rate\"")),
    ("SPLIT_OUT_OF_RANGE", "frame 700", |f| text(f, "split.json", "[0, 4]", "[0, 700]")),
    ("SPLIT_OUT_OF_RANGE", "frame 9", |f| text(f, "split.json", "[4, 6]", "[4, 9]")),
    ("INVALID_DOCUMENT", "start at 0", |f| text(f, "split.json", "[0, 4]", "[1, 4]")),
    ("FILE_DAMAGED", "final_data.pkl", |f| {
        f.get_mut("final_data.pkl").unwrap().truncate(3000);
    }),
    ("PICKLE_GLOBAL_REFUSED", "os.system", |f| {
        let evil = b"\x80\x02cos\nsystem\nX\x02\x00\x00\x00ls\x85R.".to_vec();
        f.insert("final_data.pkl".into(), evil);
    }),
    ("PICKLE_REFUSED", "nests deeper", |f| {
        let mut deep = b"\x80\x02".to_vec();
        deep.extend(b"]".repeat(5000));
        deep.extend(b"a".repeat(4999));
        deep.push(b'.');
        f.insert("final_data.pkl".into(), deep);
    }),
    ("MISSING_ARRAY", "object_points", |f| {
        f.insert("final_data.pkl".into(), b"\x80\x02}.".to_vec());
    }),
    ("WRONG_DTYPE", "an array", |f| {
        let tracks = f["gt_track_3d.pkl"].clone();
        f.insert("final_data.pkl".into(), tracks);
    }),
    ("WRONG_DTYPE", "a dict", |f| {
        f.insert("gt_track_3d.pkl".into(), b"\x80\x02}.".to_vec());
    }),
    ("RAW_CAPTURE", "Ingest", |f| {
        f.remove("final_data.pkl");
        f.insert("color/0/0.png".into(), Vec::new());
    }),
];

#[test]
fn broken_files_get_their_message() {
    let bundles = BROKEN_BUNDLES.iter().map(|b| (bundle(&rope()), b));
    let cases = BROKEN_CASES.iter().map(|b| (case(), b));
    let mut wrong = Vec::new();
    for (mut files, (code, names, break_it)) in bundles.chain(cases) {
        break_it(&mut files);
        let report = check_bytes(&pack(&files), &Limits::default());
        wrong.extend(lacks(&report, Severity::Error, code, names));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn whole_files_are_fine() {
    for files in [bundle(&rope()), bundle(&cable()), case()] {
        let report = check_bytes(&pack(&files), &Limits::default());
        assert!(
            report.findings.iter().all(|f| f.severity == Severity::Info),
            "{:?}",
            report.findings
        );
    }
}

#[test]
fn missing_optional_files_are_noted() {
    let mut files = case();
    files.remove("split.json");
    files.remove("gt_track_3d.pkl");
    let report = check_bytes(&pack(&files), &Limits::default());
    assert!(report.is_usable());
    expect(&report, Severity::Info, "OPTIONAL_MISSING", "gt_track_3d.pkl");
    assert!(report.findings.iter().any(|f| f.sentence().contains("split.json")));
}

#[test]
fn nothing_there() {
    let report = check_path(Path::new("no/such/capture"), &Limits::default());
    expect(&report, Severity::Error, "CAPTURE_NOT_FOUND", "no/such/capture");
    let report = check_bytes(b"hello", &Limits::default());
    expect(&report, Severity::Error, "UNKNOWN_CAPTURE_KIND", "capture");
}

#[test]
fn every_truncation_of_an_archive_is_an_error() {
    let bytes = pack(&case());
    for len in (0..bytes.len()).step_by(97) {
        assert!(!check_bytes(&bytes[..len], &Limits::default()).is_usable(), "{len} bytes");
    }
    expect(
        &check_bytes(&bytes[..bytes.len() / 2], &Limits::default()),
        Severity::Error,
        "ARCHIVE_DAMAGED",
        "copy it again",
    );
}

fn zip_with(name: &str, options: SimpleFileOptions, bytes: &[u8]) -> Vec<u8> {
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file(name, options).unwrap();
    zip.write_all(bytes).unwrap();
    zip.finish().unwrap().into_inner()
}

fn replace(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for at in 0..bytes.len().saturating_sub(from.len()) {
        if bytes[at..].starts_with(from) {
            bytes[at..at + to.len()].copy_from_slice(to);
        }
    }
    bytes
}

#[test]
fn directories_are_not_read_without_end() {
    let many: FileMap = (0..4000).map(|i| (format!("{i:060}"), Vec::new())).collect();
    let limits = Limits { archive_entries: 10, name_bytes: 60, ..Limits::default() };
    expect(&check_bytes(&pack(&many), &limits), Severity::Error, "ARCHIVE_DAMAGED", "directory");
}

#[test]
fn hostile_archives_are_refused() {
    let plain = SimpleFileOptions::default();
    let deflated = plain.compression_method(CompressionMethod::Deflated);
    let small = Limits { archive_entries: 2, ..Limits::default() };

    let bomb = zip_with("capture.json", deflated, &vec![b' '; 40 << 20]);
    assert!(bomb.len() < 100_000);
    expect(
        &check_bytes(&bomb, &Limits::default()),
        Severity::Error,
        "ARCHIVE_BOMB",
        "capture.json",
    );

    for name in ["../capture.json", "a/../../capture.json", "/etc/capture.json", "C:/capture.json"]
    {
        // The writer corrects absolute names, so the bytes are changed afterwards.
        let innocent = name.replace(['/', ':'], "_");
        let bytes =
            replace(&zip_with(&innocent, plain, b"{}"), innocent.as_bytes(), name.as_bytes());
        expect(
            &check_bytes(&bytes, &Limits::default()),
            Severity::Error,
            "ARCHIVE_UNSAFE_NAME",
            name,
        );
    }
    let long = zip_with(&"a".repeat(600), plain, b"");
    expect(&check_bytes(&long, &Limits::default()), Severity::Error, "ARCHIVE_UNSAFE_NAME", "aaa");

    let many: FileMap = (0..5).map(|i| (format!("{i}"), Vec::new())).collect();
    expect(
        &check_bytes(&pack(&many), &small),
        Severity::Error,
        "ARCHIVE_TOO_MANY_ENTRIES",
        "5 entries",
    );

    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.add_symlink("capture.json", "/etc/passwd", plain).unwrap();
    let link = zip.finish().unwrap().into_inner();
    expect(
        &check_bytes(&link, &Limits::default()),
        Severity::Error,
        "ARCHIVE_NOT_A_FILE",
        "a link",
    );
}

#[test]
fn entries_that_share_bytes_are_refused() {
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file("capture.json", SimpleFileOptions::default()).unwrap();
    zip.write_all(&[b' '; 4096]).unwrap();
    zip.shallow_copy_file("capture.json", "color/0/0.png").unwrap();
    let bytes = zip.finish().unwrap().into_inner();
    expect(&check_bytes(&bytes, &Limits::default()), Severity::Error, "ARCHIVE_OVERLAP", "share");
}

#[test]
fn archives_do_not_unpack_without_end() {
    let bytes = pack(&bundle(&rope()));
    let tight = Limits { unpacked_bytes: 100, unpacked_per_byte: 0, ..Limits::default() };
    expect(&check_bytes(&bytes, &tight), Severity::Error, "CAPTURE_TOO_LARGE", "limit of 100");
    let enough = Limits { unpacked_bytes: 0, unpacked_per_byte: 2, ..Limits::default() };
    assert!(check_bytes(&bytes, &enough).is_usable());
}

#[test]
fn memory_is_counted_before_it_is_taken() {
    let bytes = pack(&bundle(&rope()));
    let tight = Limits { total_bytes: 20_000, ..Limits::default() };
    expect(&check_bytes(&bytes, &tight), Severity::Error, "CAPTURE_TOO_LARGE", "limit of 20000");
    let tight = Limits { file_bytes: 1000, ..Limits::default() };
    expect(&check_bytes(&bytes, &tight), Severity::Error, "CAPTURE_TOO_LARGE", "npy");
    for (limits, names) in [
        (Limits { frames: 10, ..Limits::default() }, "frames: 24"),
        (Limits { points: 10, ..Limits::default() }, "tracked points: 40"),
        (Limits { controls: 2, ..Limits::default() }, "control points: 8"),
        (Limits { sequences: 0, ..Limits::default() }, "sequences: 1"),
    ] {
        expect(&check_bytes(&bytes, &limits), Severity::Error, "CAPTURE_TOO_MANY", names);
    }
}

#[test]
fn folders_nested_folders_and_the_document_itself_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("take 1");
    std::fs::create_dir(&inner).unwrap();
    for (name, bytes) in bundle(&rope()) {
        std::fs::write(inner.join(name), bytes).unwrap();
    }
    for path in [folder.path(), &inner, &inner.join("capture.json")] {
        assert_eq!(crate::read(path, &Limits::default()).unwrap(), rope());
    }
    let nested: FileMap = case().into_iter().map(|(n, b)| (format!("my_case/{n}"), b)).collect();
    let capture = crate::read_bytes("upload", &pack(&nested), &Limits::default()).unwrap();
    assert_eq!(capture.name, "my_case");
}
