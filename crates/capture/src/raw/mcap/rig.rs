//! The topics of each camera: a colour topic, and depth, masks and a calibration of the same
//! `frame_id`.

use std::{collections::BTreeMap, sync::Arc};

use bendtwin_core::{Environment, Plane};

use super::{
    frames::{McapFrames, Stream, Streams},
    images::{Shows, shows},
    index::{Index, Stamped, Topic},
    messages::Calibration,
    place::Store,
    transforms::plain,
};
use crate::{
    Error, Limits, Sources,
    frame::Frame,
    raw::{Camera, Distortion, Intrinsics, MeshFile, Recording, clock, validity},
};

/// Role of a topic by its last words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Color,
    Depth,
    Object,
    Manipulator,
    Other,
}

fn role(topic: &Topic) -> Role {
    let name = topic.name.trim_end_matches("/compressed").trim_end_matches("/image_raw");
    if name.ends_with("/mask/object") {
        return Role::Object;
    }
    if name.ends_with("/mask/manipulator") {
        return Role::Manipulator;
    }
    match shows(&topic.head.encoding, &topic.name) {
        Shows::Color => Role::Color,
        Shows::Depth => Role::Depth,
        Shows::Other => Role::Other,
    }
}

/// Makes a recording of what a file holds.
pub(super) fn recording(
    name: &str,
    store: Store,
    index: Index,
    limits: &Limits,
) -> Result<Recording, Error> {
    let wrong = |fault: String| Error::Document { at: store.name().to_owned(), fault };
    let colors = color_topics(&index, &store)?;
    validity::count(colors.len(), 1, limits)?;
    let world = world(&index, &colors, &wrong)?;
    let up = index.settings.get("up_axis").map_or("+z", String::as_str);
    let frame = Frame::from_up(up).ok_or_else(|| {
        Error::Axes(format!("`up_axis` is `{up}`: it must be one of +x, -x, +y, -y, +z, -z"))
    })?;
    // Seconds since the first image: small numbers keep their digits.
    let start = colors.iter().filter_map(|t| t.images.first()).map(|i| i.ns).min().unwrap_or(0);
    let seconds = |ns: i64| ns.saturating_sub(start) as f64 * 1e-9;
    let clocks: Vec<Vec<f64>> =
        colors.iter().map(|t| t.images.iter().map(|i| seconds(i.ns)).collect()).collect();
    let aligned = clock::align(&clocks, limits.recording_frames)?;
    let reach_ns = (0.5e9 / aligned.fps) as i64;

    let mut cameras = Vec::with_capacity(colors.len());
    let mut streams = Vec::with_capacity(colors.len());
    for (topic, images) in colors.iter().zip(&aligned.images) {
        let frame_id = plain(&topic.head.frame_id);
        let name = camera_name(&topic.name, frame_id);
        let taken: Vec<Option<&Stamped>> =
            images.iter().map(|image| image.and_then(|i| topic.images.get(i))).collect();
        let (calibration, rectified) = calibration(&index, topic, &name)?;
        let size = [calibration.width, calibration.height];
        validity::check_size(&name, size, limits)?;
        let pose = |ns: i64| index.tree.pose(frame_id, &world, ns).turned(&frame);
        let poses = if index.tree.moves(frame_id, &world) {
            let mut last = start;
            let at = |image: &Option<&Stamped>| {
                last = image.map_or(last, |i| i.ns);
                pose(last)
            };
            taken.iter().map(at).collect()
        } else {
            vec![pose(start)]
        };
        let (intrinsics, distortion) = lens(calibration, rectified, &name)?;
        let near = |wanted: Role| best(&index, topic, wanted).map(|t| stream(t, &taken, reach_ns));
        let depth = near(Role::Depth).ok_or_else(|| unaligned(&index, &name, frame_id))?;
        streams.push(Streams {
            size,
            color: Stream {
                places: taken.iter().map(|image| image.map(|i| i.place)).collect(),
                ..stream(topic, &[], 0)
            },
            depth,
            object: near(Role::Object),
            manipulator: near(Role::Manipulator),
        });
        cameras.push(Camera {
            name,
            width: size[0],
            height: size[1],
            intrinsics,
            distortion,
            poses,
            times_s: taken.iter().map(|i| i.map_or(f64::NAN, |i| seconds(i.ns))).collect(),
        });
    }
    let frame_count = aligned.frame_count;
    let train = match index.settings.get("train_frame_count") {
        None => (frame_count as f64 * 0.7).round() as usize,
        Some(n) => n.parse().map_err(|_| wrong(format!("`train_frame_count` is `{n}`")))?,
    };
    let ground = match index.settings.get("ground_height_m") {
        None => None,
        Some(height) => {
            let parsed = height.parse::<f32>().ok().filter(|h| h.is_finite());
            let offset_m =
                parsed.ok_or_else(|| wrong(format!("`ground_height_m` is `{height}`")))?;
            Some(Plane { normal: [0.0, 0.0, 1.0], offset_m })
        }
    };
    let source = McapFrames { store, chunks: index.chunks, cameras: streams };
    limits.check_pixels(source.pixels(), frame_count, Some(source.store.len()))?;
    Ok(Recording {
        name: name.to_owned(),
        fps: aligned.fps,
        frame_count,
        train_frame_count: train,
        environment: Environment { ground, ..Environment::Z_UP },
        source_to_world: frame.rotation,
        cameras,
        mesh: index.mesh.map(|(name, bytes)| MeshFile { name, bytes, to_world: None }),
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers: Vec::new(),
        notes: Vec::new(),
        sources: Sources::default(),
        source: Arc::new(source),
    })
}

/// The colour topic of each camera, by the cameras' names.
fn color_topics<'a>(index: &'a Index, store: &Store) -> Result<Vec<&'a Topic>, Error> {
    let wrong = |fault: String| Error::Document { at: store.name().to_owned(), fault };
    let mut by_frame: BTreeMap<&str, Vec<&Topic>> = BTreeMap::new();
    for topic in index.topics.iter().filter(|topic| role(topic) == Role::Color) {
        by_frame.entry(plain(&topic.head.frame_id)).or_default().push(topic);
    }
    let mut colors: Vec<&Topic> = Vec::with_capacity(by_frame.len());
    for (frame_id, mut topics) in by_frame {
        // The same images may have been recorded plain and compressed: the more complete ones
        // count.
        topics.sort_by(|a, b| b.images.len().cmp(&a.images.len()).then(a.name.cmp(&b.name)));
        let base = |t: &Topic| t.name.trim_end_matches("/compressed").to_owned();
        if let Some(other) = topics.iter().find(|t| base(t) != base(topics[0])) {
            return Err(wrong(format!(
                "colour topics `{}` and `{}` have the same frame_id `{frame_id}`: give every camera its own, and record \
                 one colour topic of each",
                topics[0].name, other.name
            )));
        }
        colors.extend(topics.first().copied());
    }
    if colors.is_empty() {
        return Err(wrong(
            "it has no colour images: record sensor_msgs CompressedImage or Image, or foxglove.CompressedImage or RawImage, in \
             CDR, ROS 1 or protobuf"
                .into(),
        ));
    }
    colors.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(colors)
}

/// The frame that counts as the world: what the settings name, else `world`, else the root that all
/// cameras share.
fn world(
    index: &Index,
    colors: &[&Topic],
    wrong: &dyn Fn(String) -> Error,
) -> Result<String, Error> {
    let paths: Vec<Vec<&str>> =
        colors.iter().map(|t| index.tree.path(plain(&t.head.frame_id))).collect();
    for (topic, path) in colors.iter().zip(&paths) {
        if path.len() < 2 {
            return Err(Error::Camera {
                camera: topic.name.clone(),
                fault: format!(
                    "no transform leads from its frame `{}` to another (or they go in a circle): record /tf_static with the \
                     cameras' extrinsics",
                    topic.head.frame_id
                ),
            });
        }
    }
    let shared = |frame: &str| paths.iter().all(|path| path.contains(&frame));
    if let Some(named) = index.settings.get("world_frame") {
        return if shared(plain(named)) {
            Ok(plain(named).to_owned())
        } else {
            Err(wrong(format!(
                "`world_frame` is `{named}`, which is not above every camera's frame"
            )))
        };
    }
    let root = paths.first().and_then(|path| path.last().copied()).unwrap_or_default();
    match ["world", root].into_iter().find(|frame| shared(frame)) {
        Some(frame) => Ok(frame.to_owned()),
        None => {
            let roots: Vec<&str> = paths.iter().filter_map(|path| path.last().copied()).collect();
            Err(wrong(format!(
                "the cameras' frames hang from different roots ({}): record /tf_static with the extrinsics that join them",
                roots.join(", ")
            )))
        }
    }
}

/// The topic of a role with the most images among those of a colour topic's frame.
fn best<'a>(index: &'a Index, color: &Topic, wanted: Role) -> Option<&'a Topic> {
    let frame = plain(&color.head.frame_id);
    let fitting = index.topics.iter().filter(|t| role(t) == wanted);
    let fitting = fitting.filter(|t| plain(&t.head.frame_id) == frame);
    fitting.max_by(|a, b| a.images.len().cmp(&b.images.len()).then(b.name.cmp(&a.name)))
}

/// The images of a topic nearest in time to each frame's colour.
fn stream(topic: &Topic, taken: &[Option<&Stamped>], reach_ns: i64) -> Stream {
    let nearest = |image: &Option<&Stamped>| {
        let ns = (*image)?.ns;
        let after = topic.images.partition_point(|i| i.ns < ns);
        let around = [after.checked_sub(1), Some(after)];
        let around = around.into_iter().flatten().filter_map(|i| topic.images.get(i));
        let off = |i: &Stamped| i.ns.saturating_sub(ns).saturating_abs();
        around.min_by_key(|i| off(i)).filter(|i| off(i) <= reach_ns).map(|i| i.place)
    };
    Stream {
        topic: topic.name.clone(),
        kind: topic.kind,
        wire: topic.wire,
        places: taken.iter().map(nearest).collect(),
    }
}

fn unaligned(index: &Index, camera: &str, frame_id: &str) -> Error {
    let depths = index.topics.iter().filter(|t| role(t) == Role::Depth);
    let found: Vec<String> =
        depths.map(|t| format!("{} in {}", t.name, t.head.frame_id)).take(8).collect();
    Error::DepthNotAligned {
        camera: camera.to_owned(),
        frame_id: frame_id.to_owned(),
        found: if found.is_empty() { "no depth at all".to_owned() } else { found.join(", ") },
    }
}

/// The calibration of a colour topic's frame, and whether the topic was rectified with it.
fn calibration<'a>(
    index: &'a Index,
    color: &Topic,
    camera: &str,
) -> Result<(&'a Calibration, bool), Error> {
    let frame = plain(&color.head.frame_id);
    let alike =
        |topic: &str| topic.bytes().zip(color.name.bytes()).take_while(|(a, b)| a == b).count();
    let fitting = index.calibrations.iter().filter(|(_, c)| plain(&c.frame_id) == frame);
    let nearest = fitting.max_by_key(|(topic, _)| alike(topic));
    let rectified = color.name.contains("image_rect");
    match nearest {
        Some((_, calibration)) => Ok((calibration, rectified)),
        None => Err(Error::Camera {
            camera: camera.to_owned(),
            fault: format!("no CameraInfo has its frame_id `{frame}`: record camera_info, too"),
        }),
    }
}

fn lens(c: &Calibration, rectified: bool, camera: &str) -> Result<(Intrinsics, Distortion), Error> {
    let fail = |fault: String| Err(Error::Camera { camera: camera.to_owned(), fault });
    if rectified {
        let &[fx, _, cx, _, _, fy, cy, ..] = c.p.as_slice() else {
            return fail("its images are rectified, but its CameraInfo has no P".to_owned());
        };
        return Ok((Intrinsics { fx, fy, cx, cy }, Distortion::None));
    }
    let &[fx, skew, cx, _, fy, cy, ..] = c.k.as_slice() else {
        return fail("its CameraInfo has no K".to_owned());
    };
    if skew.abs() > 1e-6 {
        return fail(format!("its K is skewed by {skew}"));
    }
    let unused = c.d.iter().all(|d| *d == 0.0);
    let distortion = match c.model.as_str() {
        _ if unused && c.model != "equidistant" => Some(Distortion::None),
        "plumb_bob" | "rational_polynomial" | "radtan" => Distortion::brown_conrady(&c.d),
        "equidistant" | "fisheye" | "kannala_brandt" => match c.d.as_slice() {
            &[k1, k2, k3, k4] => Some(Distortion::KannalaBrandt([k1, k2, k3, k4])),
            _ => None,
        },
        _ => None,
    };
    match distortion {
        Some(distortion) => Ok((Intrinsics { fx, fy, cx, cy }, distortion)),
        None => fail(format!(
            "its distortion is `{}` with {} coefficients: plumb_bob (4 or 5), rational_polynomial (8) and equidistant (4) are \
             known",
            c.model.chars().take(40).collect::<String>(),
            c.d.len()
        )),
    }
}

/// Name of a camera for people: the topic's words before those that name the image.
fn camera_name(topic: &str, frame_id: &str) -> String {
    let words = topic.split('/').filter(|word| !word.is_empty());
    let of_image =
        |word: &str| word.starts_with("image") || ["color", "rgb", "compressed"].contains(&word);
    let name: Vec<&str> = words.take_while(|word| !of_image(word)).collect();
    if name.is_empty() { frame_id.to_owned() } else { name.join("/") }
}
