//! Valid files, as small as their formats allow: what everything hostile is made from.

use std::{
    collections::BTreeMap,
    io::{Cursor, Read as _},
    sync::{Arc, LazyLock},
};

use bendtwin_capture::{
    Error,
    raw::{
        BundleOptions, Camera, ColorImage, DepthImage, Distortion, Frames, Image, Intrinsics, Mask,
        MeshFile, Pose, Recording, Region, Source, Tracks, export_case, write_bundle_to,
    },
    write_bundle,
};
use bendtwin_core::{
    Capture, Environment, Graph, NodeKind, Params, Pin, Point, Sequence, Skin, Timing, Twin,
    capture::{HeldPoint, Object},
    geometry::IDENTITY,
};
use bendtwin_mesh::Mesh;
use zip::ZipArchive;

use crate::pickles;

/// Contents of files by their names.
pub type FileMap = BTreeMap<String, Vec<u8>>;

/// Columns, rows and frames of the recording.
pub const SIZE: [usize; 2] = [16, 12];
/// Frames of all samples.
pub const FRAMES: usize = 4;
const POINTS: usize = 6;

static OBSERVATION: LazyLock<FileMap> = LazyLock::new(|| {
    let bytes = write_bundle(&capture(), Cursor::new(Vec::new())).expect("it is written");
    unpack(&bytes.into_inner())
});

static CASE: LazyLock<FileMap> = LazyLock::new(case_files);

static RAW_BUNDLE: LazyLock<FileMap> = LazyLock::new(|| {
    let options = BundleOptions::default();
    let bytes = write_bundle_to(&recording(), Cursor::new(Vec::new()), &options);
    unpack(&bytes.expect("it is written").into_inner())
});

static RAW_CASE: LazyLock<FileMap> = LazyLock::new(|| {
    let mut files = FileMap::new();
    let put = |name: &str, bytes| {
        files.insert(name.to_owned(), bytes);
        Ok(())
    };
    export_case(&recording(), put).expect("it is written");
    files
});

/// A bundle of tracked points, file by file.
pub fn observation() -> FileMap {
    OBSERVATION.clone()
}

/// A PhysTwin case of tracked points, file by file.
pub fn case() -> FileMap {
    CASE.clone()
}

/// A bundle of camera images, file by file.
pub fn raw_bundle() -> FileMap {
    RAW_BUNDLE.clone()
}

/// A PhysTwin case of camera images, file by file.
pub fn raw_case() -> FileMap {
    RAW_CASE.clone()
}

/// An image of the recording, as PNG.
pub fn png() -> Vec<u8> {
    raw_bundle().remove("cameras/0/color/000001.png").expect("the recording has it")
}

/// A depth image of the recording, as PNG.
pub fn depth_png() -> Vec<u8> {
    raw_bundle().remove("cameras/0/depth/000001.png").expect("the recording has it")
}

/// An image of 16 x 8 pixels, as JPEG.
pub fn jpeg() -> Vec<u8> {
    include_bytes!("../../../crates/capture/testdata/plain.jpg").to_vec()
}

/// Recordings of ROS 2 with compressed chunks, as MCAP.
pub fn mcap() -> [Vec<u8>; 2] {
    [
        include_bytes!("../../../crates/capture/testdata/ros2-lz4.mcap").to_vec(),
        include_bytes!("../../../crates/capture/testdata/ros2-zstd.mcap").to_vec(),
    ]
}

/// A tetrahedron.
pub fn mesh() -> Mesh {
    Mesh {
        vertices: vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

/// The files of an archive.
pub fn unpack(archive: &[u8]) -> FileMap {
    let mut zip = ZipArchive::new(Cursor::new(archive)).expect("it is an archive");
    let mut files = FileMap::new();
    for index in 0..zip.len() {
        let mut entry = zip.by_index(index).expect("it has as many entries as it says");
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).expect("it is whole");
        files.insert(entry.name().expect("names are text").into_owned(), bytes);
    }
    files
}

/// A capture of a few points that one control point lifts.
pub fn capture() -> Capture {
    let row = |frame: usize| (0..POINTS).map(move |p| [0.1 * p as f32, 0.0, 0.01 * frame as f32]);
    let points: Vec<Point> = (0..FRAMES).flat_map(row).collect();
    let cells = points.len();
    Capture {
        name: "rope".to_owned(),
        fps: 30.0,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        object: Object {
            point_count: POINTS,
            edges: (1..POINTS as u32).map(|i| [i - 1, i]).collect(),
            pins: vec![HeldPoint { point: 0, control: 0 }],
            ..Object::default()
        },
        others: Vec::new(),
        sequences: vec![Sequence {
            name: "main".to_owned(),
            frame_count: FRAMES,
            train_frame_count: FRAMES - 1,
            controls: (0..FRAMES).map(|f| points[f * POINTS]).collect(),
            points,
            visible: vec![true; cells],
            motion_valid: (0..cells).map(|i| i >= POINTS).collect(),
            truth_tracks: Vec::new(),
            start_frames: 1,
        }],
    }
}

fn case_files() -> FileMap {
    let cells = FRAMES * POINTS;
    let points: Vec<f64> = (0..cells * 3).map(|i| i as f64 * 0.01).collect();
    let controls: Vec<f64> = (0..FRAMES * 3).map(|i| i as f64 * 0.01).collect();
    let flags = vec![1; cells];
    let data = pickles::dictionary(&[
        ("object_points", pickles::floats(&[FRAMES, POINTS, 3], &points)),
        ("object_visibilities", pickles::array("b1", &[FRAMES, POINTS], &flags)),
        ("object_motions_valid", pickles::array("b1", &[FRAMES, POINTS], &flags)),
        ("controller_points", pickles::floats(&[FRAMES, 1, 3], &controls)),
        ("surface_points", pickles::floats(&[2, 3], &points[..6])),
        ("interior_points", pickles::floats(&[2, 3], &points[6..12])),
    ]);
    let split = format!("{{\"frame_len\": {FRAMES}, \"train\": [0, 3], \"test\": [3, {FRAMES}]}}");
    [
        ("metadata.json", b"{\"fps\": 30}".to_vec()),
        ("split.json", split.into_bytes()),
        ("final_data.pkl", data),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .into()
}

/// A recording of two cameras that look down.
pub fn recording() -> Recording {
    let camera = |index: usize| Camera {
        name: format!("cam{index}"),
        width: SIZE[0],
        height: SIZE[1],
        intrinsics: Intrinsics { fx: 20.0, fy: 20.0, cx: 7.5, cy: 5.5 },
        distortion: Distortion::None,
        poses: vec![Pose {
            rotation: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            translation: [0.05 * index as f64, 0.0, 0.5],
        }],
        times_s: Vec::new(),
        fps: None,
    };
    Recording {
        name: "toy".to_owned(),
        fps: 30.0,
        frame_count: FRAMES,
        train_frame_count: FRAMES - 1,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        cameras: vec![camera(0), camera(1)],
        mesh: Some(MeshFile {
            name: "mesh.glb".to_owned(),
            bytes: bendtwin_mesh::write_glb(&mesh()),
            to_world: None,
        }),
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers: Vec::new(),
        notes: Vec::new(),
        sources: bendtwin_capture::Sources::default(),
        source: Arc::new(Made),
    }
}

/// Frames that are made when they are asked for.
#[derive(Debug)]
struct Made;

impl Source for Made {
    fn frames(&self, _camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(Self))
    }
}

impl Frames for Made {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        Ok(Some(image(|column, row| [(frame * 40) as u8, (column * 9) as u8, (row * 9) as u8])))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        Ok(Some(image(|column, _| 0.4 + 0.001 * (column + frame) as f32)))
    }

    fn mask(&mut self, _frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let columns = if region == Region::Object { 3..9 } else { 11..14 };
        Ok(Some(image(|column, _| columns.contains(&column))))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        let count = 3;
        let points = (0..FRAMES * count).map(|i| [3.0 + (i % count) as f32 * 2.0, 5.0]).collect();
        Ok(Some(Tracks { count, points, visible: vec![true; FRAMES * count] }))
    }
}

fn image<P>(pixel: impl Fn(usize, usize) -> P) -> Image<P> {
    let [width, height] = SIZE;
    let pixels = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
    Image { width, height, pixels }
}

/// A twin of three nodes.
pub fn twin() -> Twin {
    let graph = Graph {
        rest_positions: vec![[0.0, 0.0, 0.1], [0.1, 0.0, 0.1], [0.2, 0.0, 0.1]],
        kinds: vec![NodeKind::Observed; 3],
        masses: vec![1.0; 3],
        object_ids: vec![0; 3],
        observed_points: vec![0, 1, 2],
        control_rest: vec![[0.3, 0.0, 0.1]],
        springs: vec![[0, 1], [1, 2], [2, 3]],
        triplets: vec![[0, 1, 2]],
        pins: vec![Pin { node: 2, control: 0, offset_m: [-0.1, 0.0, 0.0] }],
        rods: Vec::new(),
    };
    Twin::new(
        graph,
        Params {
            spring_stiffness: vec![1e3; 3],
            spring_dashpot: vec![1.0; 3],
            rest_lengths_m: vec![0.1; 3],
            bend_stiffness: vec![0.5],
            bend_damping: vec![0.01],
            rest_angles_rad: vec![std::f32::consts::PI],
            drag: 1.0,
            ..Params::default()
        },
        Timing { fps: 30.0, substeps: 50 },
    )
}

/// A twin with two rods.
pub fn cable() -> Twin {
    let nodes = 9;
    let mut twin = twin();
    twin.graph = Graph {
        rest_positions: (0..nodes).map(|i| [0.1 * i as f32, 0.0, 0.1]).collect(),
        kinds: vec![NodeKind::Observed; nodes],
        masses: vec![1.0; nodes],
        object_ids: vec![0; nodes],
        observed_points: (0..nodes as u32).collect(),
        control_rest: vec![[0.0; 3]],
        pins: [0, 1, 3, 4, 7, 8].map(|node| Pin { node, control: 0, offset_m: [0.0; 3] }).to_vec(),
        rods: vec![vec![0, 1, 2, 3, 4], vec![4, 3, 5, 6, 7, 8]],
        ..Graph::default()
    };
    twin.skin = Skin::of_nodes(&twin.graph);
    twin.params = Params {
        twist_stiffness: vec![0.1, 0.2],
        twist_damping: vec![0.01, 0.02],
        rest_twists_rad: vec![-7.0, 0.5],
        ..Params::default()
    };
    twin
}

/// A rollout request for [`twin`], as JSON.
pub fn rollout() -> serde_json::Value {
    serde_json::json!({
        "trajectories": {"positions": [[[[0.3, 0.0, 0.1]], [[0.3, 0.0, 0.2]], [[0.3, 0.1, 0.2]]]]},
        "frames": 4,
        "costs": [{"name": "reach", "keypoints": {"nodes": [0], "targets": [[0.0, 0.0, 0.2]]}}],
        "returns": {"every_frames": 2, "nodes": [0, 2], "final_state": true},
    })
}
