//! The cameras of a recording: topics that belong together, with a lens, poses and common frames.

mod clocks;
mod lens;
mod robot;
mod settings;
mod topics;

use std::sync::Arc;

use bendtwin_core::{Environment, Finding, Plane};

use self::{robot::Robot, settings::Settings, topics::CameraTopics};
use super::{
    chunk::MAX_CHUNK,
    frames::{McapFrames, Stream, Streams},
    images,
    index::{Index, Stamped, Topic},
    messages::{self, Calibration},
    names,
    place::Store,
    transforms::{Choice, plain},
};
use crate::{
    Error, Limits, Sources,
    files::Files,
    frame::Frame,
    raw::{
        Camera, MeshFile, Recording,
        clock::{self, samples::around},
        decode::Size,
        gripper, validity,
    },
};

/// Makes a recording of what files hold; `beside` are the files in their folder or archive, and
/// `sources` has what was left out before.
pub(super) fn recording(
    name: &str,
    mut store: Store,
    mut index: Index,
    mut beside: Option<&mut Files<'_>>,
    mut sources: Sources,
    limits: &Limits,
) -> Result<Recording, Error> {
    let at = store.name().to_owned();
    let wrong = |fault: String| Error::Document { at: at.clone(), fault };
    let settings = Settings::parse(&index.settings).map_err(wrong)?;
    if let Some(topic) = settings.topics().find(|t| !index.topics.iter().any(|o| o.name == *t)) {
        return Err(wrong(format!(
            "its metadata record `bendtwin` gives a unit for `{topic}`, which is no topic of images"
        )));
    }
    let mut notes = Vec::new();
    {
        let chosen = topics::choose(&index, &mut Sources::default())?;
        validity::count(chosen.len(), 1, limits)?;
        let frame_ids: Vec<String> = chosen.iter().map(|c| c.frame_id().to_owned()).collect();
        let names: Vec<String> =
            chosen.iter().flat_map(CameraTopics::topics).map(|t| t.name.clone()).collect();
        drop(chosen);
        notes.extend(settle_parents(&mut index, &frame_ids, &settings, &mut sources)?);
        let taken = index.topics.iter_mut().filter(|t| names.contains(&t.name));
        notes.extend(clocks::join(&mut taken.collect::<Vec<_>>()));
    }
    let chosen = topics::choose(&index, &mut sources)?;
    let world = world(&index, &chosen, &settings, &wrong)?;
    let up = settings.up_axis.as_deref().unwrap_or("+z");
    let frame = Frame::of_up_axis(up)?;
    // Seconds since the first image: small numbers keep their digits.
    let first = |c: &CameraTopics<'_>| c.color.images.first().map(|i| i.ns);
    let start = chosen.iter().filter_map(first).min().unwrap_or(0);
    let seconds = |ns: i64| ns.saturating_sub(start) as f64 * 1e-9;
    let clocks: Vec<Vec<f64>> =
        chosen.iter().map(|c| c.color.images.iter().map(|i| seconds(i.ns)).collect()).collect();
    let aligned = clock::align(&clocks, limits.recording_frames)?;
    let reach_ns = (0.5e9 / aligned.fps) as i64;

    let mut cameras = Vec::with_capacity(chosen.len());
    let mut streams = Vec::with_capacity(chosen.len());
    for (topics, images) in chosen.iter().zip(&aligned.images) {
        let (name, frame_id) = (&topics.name, topics.frame_id());
        let images: Vec<Option<&Stamped>> =
            images.iter().map(|image| image.and_then(|i| topics.color.images.get(i))).collect();
        let size = image_size(&mut store, &index, topics.color)?;
        let (info, calibration) = calibration(&index, topics.color, size, name)?;
        let rectified = names::is_rectified(&topics.color.name);
        let lens_size = [calibration.width, calibration.height];
        if size.is_some_and(|size| size != lens_size) {
            let images = size.unwrap_or_default();
            return Err(Error::LensSize {
                camera: name.clone(),
                images,
                info: info.to_owned(),
                lens: lens_size,
            });
        }
        validity::check_size(name, lens_size, limits)?;
        let pose = |ns: i64| index.tree.pose(frame_id, &world, ns).turned(&frame);
        let poses = if index.tree.moves(frame_id, &world) {
            let mut last = start;
            let at = |image: &Option<&Stamped>| {
                last = image.map_or(last, |i| i.ns);
                pose(last)
            };
            images.iter().map(at).collect()
        } else {
            vec![pose(start)]
        };
        let (intrinsics, distortion) = lens::lens(calibration, rectified, name)?;
        let unit_m = settings.unit_m(&topics.depth.name);
        let nearest = |topic: &Topic| stream(topic, &images, reach_ns);
        streams.push(Streams {
            size: lens_size,
            color: Stream {
                places: images.iter().map(|image| image.map(|i| i.place)).collect(),
                ..stream(topics.color, &[], 0)
            },
            depth: Stream { unit_m, ..nearest(topics.depth) },
            object: topics.object.map(nearest),
            manipulator: topics.manipulator.map(nearest),
        });
        note_taken(&mut sources, topics, unit_m);
        sources.take("lens", Some(name), info, lens::form(calibration, rectified));
        let path = index.tree.path(frame_id);
        let end = path.iter().position(|f| *f == world).unwrap_or(path.len());
        let mut path: Vec<&str> = path.into_iter().take(end.saturating_add(1)).collect();
        path.reverse();
        let form = if poses.len() > 1 { "moving" } else { "fixed" };
        sources.take("pose", Some(name), path.join(" > "), form);
        cameras.push(Camera {
            name: name.clone(),
            width: lens_size[0],
            height: lens_size[1],
            intrinsics,
            distortion,
            poses,
            times_s: images.iter().map(|i| i.map_or(f64::NAN, |i| seconds(i.ns))).collect(),
            fps: None,
        });
    }
    if let Some((mesh, _)) = &index.mesh {
        sources.take("mesh", None, mesh, "");
    }
    drop(chosen);
    let frame_count = aligned.times_s.len();
    let attached = index.grippers.take();
    let document = match &mut beside {
        Some(files) => files.find_document(gripper::DOCUMENT)?,
        None => None,
    };
    if document.is_some() && attached.is_some() {
        let from = format!("the attachment {}", gripper::DOCUMENT);
        sources.leave_out(from, "a file of this name lies beside the recording");
    }
    let grippers = match document.or(attached) {
        None => Vec::new(),
        Some(document) => {
            let ns = |seconds: &f64| start.saturating_add((seconds * 1e9).round() as i64);
            let times_ns: Vec<i64> = aligned.times_s.iter().map(ns).collect();
            let robot = Robot { index: &index, world: &world, times_ns: &times_ns };
            let setting =
                gripper::Setting { times_s: &aligned.times_s, frame: &frame, motion: Some(&robot) };
            gripper::read(&document, beside, &setting, &mut sources)?
        }
    };
    let train = (frame_count as f64 * 0.7).round() as usize;
    let ground = settings.ground_height_m;
    let source = McapFrames { store, chunks: index.chunks, cameras: streams };
    limits.check_pixels(source.pixels(), frame_count, Some(source.store.len()))?;
    Ok(Recording {
        name: name.to_owned(),
        fps: aligned.fps,
        frame_count,
        train_frame_count: settings.train_frame_count.unwrap_or(train),
        environment: Environment {
            ground: ground.map(|offset_m| Plane { normal: [0.0, 0.0, 1.0], offset_m }),
            ..Environment::Z_UP
        },
        source_to_world: frame.rotation,
        cameras,
        mesh: index.mesh.map(|(name, bytes)| MeshFile { name, bytes, to_world: None }),
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers,
        notes,
        sources,
        source: Arc::new(source),
    })
}

/// Decides which parents of the cameras' frames count, and says so.
fn settle_parents(
    index: &mut Index,
    frame_ids: &[String],
    settings: &Settings,
    sources: &mut Sources,
) -> Result<Vec<Finding>, Error> {
    let cameras: Vec<&str> = frame_ids.iter().map(String::as_str).collect();
    let world = settings.world_frame.as_deref().map(plain);
    let choices = index.tree.settle_parents(&cameras, world).map_err(|unclear| {
        Error::Transforms(format!(
            "the frame `{}` has several parents ({}), and nothing says which one places the cameras: name the world in the \
             metadata record `bendtwin` (`world_frame`), or record without one of the two; docs/use/cameras.md#calibration",
            unclear.child,
            unclear.parents.join(", ")
        ))
    })?;
    let note = |Choice { child, parent, others, because }: Choice| {
        for other in &others {
            let what = format!("transform {other} > {child}");
            sources.leave_out(what, format!("{parent} > {child} was taken: {because}"));
        }
        let message = format!(
            "the frame `{child}` has the parents `{parent}` and `{}`: that in `{parent}` was taken, as {because}",
            others.join("`, `")
        );
        let advice = "nothing, if that is the calibration; else name the world in the metadata record `bendtwin` \
                      (`world_frame`); docs/use/cameras.md#calibration";
        Finding { advice: advice.into(), ..Finding::info("PARENT_TAKEN", message) }
    };
    Ok(choices.into_iter().map(note).collect())
}

/// The frame that counts as the world: what the settings name, else `world`, else the root that all
/// cameras share.
fn world(
    index: &Index,
    cameras: &[CameraTopics<'_>],
    settings: &Settings,
    wrong: &dyn Fn(String) -> Error,
) -> Result<String, Error> {
    let paths: Vec<Vec<&str>> = cameras.iter().map(|c| index.tree.path(c.frame_id())).collect();
    for (camera, path) in cameras.iter().zip(&paths) {
        if path.len() < 2 {
            return Err(Error::Camera {
                camera: camera.color.name.clone(),
                fault: format!(
                    "no transform leads from its frame `{}` to another (or they go in a circle): record /tf_static with the \
                     cameras' extrinsics",
                    camera.color.head.frame_id
                ),
            });
        }
    }
    let shared = |frame: &str| paths.iter().all(|path| path.contains(&frame));
    if let Some(named) = &settings.world_frame {
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
            Err(Error::Transforms(format!(
                "the cameras' frames hang from different roots ({}): record /tf_static with the extrinsics that join them; \
                 docs/use/cameras.md#calibration",
                roots.join(", ")
            )))
        }
    }
}

/// The images of a topic nearest in time to each frame's colour.
fn stream(topic: &Topic, taken: &[Option<&Stamped>], reach_ns: i64) -> Stream {
    let nearest = |image: &Option<&Stamped>| {
        let found = around(&topic.images, |i| i.ns, (*image)?.ns)?;
        (found.off_ns <= reach_ns).then(|| topic.images[found.nearest()].place)
    };
    Stream {
        topic: topic.name.clone(),
        kind: topic.kind,
        wire: topic.wire,
        places: taken.iter().map(nearest).collect(),
        unit_m: None,
    }
}

/// Columns and rows of a topic's first image; none if it is damaged, which is found when it is read.
fn image_size(store: &mut Store, index: &Index, topic: &Topic) -> Result<Option<Size>, Error> {
    if topic.head.size.is_some() {
        return Ok(topic.head.size);
    }
    let Some(first) = topic.images.first() else { return Ok(None) };
    let bytes = store.content(&first.place, &index.chunks, MAX_CHUNK, topic.wire)?;
    let image = messages::image(topic.kind, topic.wire, &bytes);
    Ok(image.and_then(|image| images::size_of(&image)))
}

/// The calibration of a colour topic's frame, with its topic: of those of the images' size, or of all
/// without one, the one with the most similar name.
fn calibration<'a>(
    index: &'a Index,
    color: &Topic,
    size: Option<Size>,
    camera: &str,
) -> Result<(&'a str, &'a Calibration), Error> {
    let frame = plain(&color.head.frame_id);
    let alike =
        |topic: &str| topic.bytes().zip(color.name.bytes()).take_while(|(a, b)| a == b).count();
    let fitting = index.calibrations.iter().filter(|(_, c)| plain(&c.frame_id) == frame);
    let nearest =
        fitting.max_by_key(|(topic, c)| (size == Some([c.width, c.height]), alike(topic)));
    nearest.map(|(topic, calibration)| (topic.as_str(), calibration)).ok_or_else(|| Error::Camera {
        camera: camera.to_owned(),
        fault: format!("no CameraInfo has its frame_id `{frame}`: record camera_info, too"),
    })
}

fn note_taken(sources: &mut Sources, topics: &CameraTopics<'_>, unit_m: Option<f64>) {
    let camera = Some(topics.name.as_str());
    let form = |topic: &Topic| topic.head.encoding.chars().take(60).collect::<String>();
    sources.take("colour", camera, &topics.color.name, form(topics.color));
    let encoding = form(topics.depth);
    let unit = match unit_m {
        Some(unit_m) => format!("1 is {unit_m} m, as declared"),
        None if encoding.starts_with("32FC1") => "metres".to_owned(),
        None => "1 is 0.001 m".to_owned(),
    };
    sources.take("depth", camera, &topics.depth.name, format!("{encoding}, {unit}"));
    for (part, topic) in [("object masks", topics.object), ("hand masks", topics.manipulator)] {
        if let Some(topic) = topic {
            sources.take(part, camera, &topic.name, form(topic));
        }
    }
}
