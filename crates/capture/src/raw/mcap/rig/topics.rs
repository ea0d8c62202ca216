//! The topics of each camera: a colour topic, and depth and masks in its frame.

use std::collections::BTreeMap;

use super::super::{
    encodings::{Meaning, meaning},
    index::{Index, Topic},
    names,
    transforms::plain,
};
use crate::{Error, Sources};

/// Topics that a message names.
const NAMED: usize = 8;

/// The topics of a camera.
pub(super) struct CameraTopics<'a> {
    /// A person's name for it.
    pub(super) name: String,
    pub(super) color: &'a Topic,
    pub(super) depth: &'a Topic,
    pub(super) object: Option<&'a Topic>,
    pub(super) manipulator: Option<&'a Topic>,
}

impl<'a> CameraTopics<'a> {
    pub(super) fn frame_id(&self) -> &'a str {
        frame_of(self.color)
    }

    pub(super) fn topics(&self) -> impl Iterator<Item = &'a Topic> {
        [Some(self.color), Some(self.depth), self.object, self.manipulator].into_iter().flatten()
    }
}

/// Topics by what they show, in the order of their names.
struct Sorted<'a> {
    color: Vec<(&'a Topic, bool)>,
    depth: Vec<(&'a Topic, u8)>,
    object: Vec<&'a Topic>,
    manipulator: Vec<&'a Topic>,
    /// Neither, with the reasons.
    others: Vec<(&'a str, String)>,
}

impl<'a> Sorted<'a> {
    fn of(index: &'a Index) -> Self {
        let mut topics: Vec<&Topic> = index.topics.iter().collect();
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        let mut sorted = Self {
            color: Vec::new(),
            depth: Vec::new(),
            object: Vec::new(),
            manipulator: Vec::new(),
            others: Vec::new(),
        };
        for topic in topics {
            match meaning(topic) {
                Meaning::Color { gray } => sorted.color.push((topic, gray)),
                Meaning::Depth { rank } => sorted.depth.push((topic, rank)),
                Meaning::Object => sorted.object.push(topic),
                Meaning::Manipulator => sorted.manipulator.push(topic),
                Meaning::Other(because) => sorted.others.push((&topic.name, because)),
            }
        }
        sorted.others.extend(index.unread.iter().map(|(name, what)| (&name[..], what.clone())));
        sorted
    }

    /// The depth of a colour topic: in its frame, the one whose name is surest that it is aligned,
    /// then that of the same device, then the one with the most images.
    fn depth_of(&self, color: &Topic) -> Option<&'a Topic> {
        let fitting = self.depth.iter().filter(|(t, _)| frame_of(t) == frame_of(color));
        let most = fitting.clone().map(|(t, _)| t.images.len()).max()?;
        let full = fitting.filter(|(t, _)| 2 * t.images.len() >= most);
        let key = |(t, rank): &&(&'a Topic, u8)| {
            let own = names::device(&t.name) == names::device(&color.name);
            (*rank, own, t.images.len(), std::cmp::Reverse(&t.name))
        };
        full.max_by_key(key).map(|(topic, _)| *topic)
    }
}

/// Chooses the topics of all cameras, in the order of their names, and says in `sources` what was
/// left out.
pub(super) fn choose<'a>(
    index: &'a Index,
    sources: &mut Sources,
) -> Result<Vec<CameraTopics<'a>>, Error> {
    let sorted = Sorted::of(index);
    for (topic, because) in &sorted.others {
        sources.leave_out(*topic, because.clone());
    }
    if sorted.color.is_empty() {
        return Err(Error::Topics(no_color(&sorted)));
    }
    let mut cameras = with_depth(&sorted, sources)?;
    name_all(&mut cameras);
    cameras.sort_by(|a, b| a.color.name.cmp(&b.color.name));
    let masks = [(&sorted.object, true), (&sorted.manipulator, false)];
    for (topics, is_object) in masks {
        for topic in topics {
            let camera = cameras.iter_mut().find(|c| c.frame_id() == frame_of(topic));
            let Some(camera) = camera else {
                let because = format!("no camera has its frame_id `{}`", frame_of(topic));
                sources.leave_out(&topic.name, because);
                continue;
            };
            let place = if is_object { &mut camera.object } else { &mut camera.manipulator };
            match place {
                Some(other) if other.images.len() >= topic.images.len() => {
                    sources.leave_out(&topic.name, format!("`{}` has the same masks", other.name));
                }
                Some(other) => {
                    sources.leave_out(&other.name, format!("`{}` has more masks", topic.name));
                    *place = Some(topic);
                }
                None => *place = Some(topic),
            }
        }
    }
    for (depth, _) in &sorted.depth {
        let Some(camera) = cameras.iter().find(|c| c.frame_id() == frame_of(depth)) else {
            let because =
                format!("it is in the frame `{}`, in which no colour was taken", frame_of(depth));
            sources.leave_out(&depth.name, because);
            continue;
        };
        if !std::ptr::eq(camera.depth, *depth) {
            let because =
                format!("`{}` was taken as the depth of `{}`", camera.depth.name, camera.name);
            sources.leave_out(&depth.name, because);
        }
    }
    Ok(cameras)
}

/// The cameras that have depth. A colour topic without is left out if it is another view of a camera
/// with depth, or a camera without any depth beside others that have it.
fn with_depth<'a>(
    sorted: &Sorted<'a>,
    sources: &mut Sources,
) -> Result<Vec<CameraTopics<'a>>, Error> {
    let mut by_frame: BTreeMap<&str, Vec<(&'a Topic, bool)>> = BTreeMap::new();
    for (topic, gray) in &sorted.color {
        by_frame.entry(frame_of(topic)).or_default().push((topic, *gray));
    }
    let (mut cameras, mut without): (Vec<Candidate<'a>>, Vec<(&Topic, bool)>) =
        (Vec::new(), Vec::new());
    for (frame_id, topics) in by_frame {
        let depth = sorted.depth_of(topics[0].0);
        let (color, gray) = one_view(frame_id, &topics, depth, sources)?;
        let Some(depth) = sorted.depth_of(color) else {
            without.push((color, gray));
            continue;
        };
        let (name, object, manipulator) = (String::new(), None, None);
        let camera = CameraTopics { name, color, depth, object, manipulator };
        let device = names::device(&color.name);
        cameras.push(Candidate { camera, device, gray });
    }
    for (color, gray) in without {
        let device = names::device(&color.name);
        let beside = cameras.iter().find(|c| c.device == device && (gray || !c.gray));
        let is_own = |depth: &Topic| {
            names::device(&depth.name) == device
                && names::view(&depth.name) == names::view(&color.name)
                && beside.is_none_or(|c| c.camera.frame_id() != frame_of(depth))
        };
        let own_depth = sorted.depth.iter().any(|(depth, _)| is_own(depth));
        let frame_id = frame_of(color);
        let because = match beside {
            _ if own_depth || cameras.is_empty() => return Err(unaligned(sorted, color)),
            Some(Candidate { camera, .. }) => format!(
                "no depth is in its frame `{frame_id}`, and `{}` of the same device was taken",
                camera.color.name
            ),
            None => format!("no depth is in its frame `{frame_id}`"),
        };
        sources.leave_out(&color.name, because);
    }
    // A device's images that were mapped onto its other camera, or are gray, show nothing new.
    let is_less = |c: &Candidate<'_>| c.gray || names::is_mapped(&c.camera.color.name);
    let originals: Vec<&str> = cameras.iter().filter(|c| !is_less(c)).map(|c| c.device).collect();
    cameras.retain(|candidate| {
        let twice = is_less(candidate) && originals.contains(&candidate.device);
        if twice {
            sources.leave_out(&candidate.camera.color.name, "the same device's colour was taken");
        }
        !twice
    });
    Ok(cameras.into_iter().map(|candidate| candidate.camera).collect())
}

/// A camera with depth, which may show what another one shows better.
struct Candidate<'a> {
    camera: CameraTopics<'a>,
    device: &'a str,
    gray: bool,
}

/// Chooses among the colour topics of a frame, which must be of one device and one view: colour rather than
/// gray, rectified as depth is, `rgb` or `color` rather than another name, the one with more images.
fn one_view<'a>(
    frame_id: &str,
    topics: &[(&'a Topic, bool)],
    depth: Option<&Topic>,
    sources: &mut Sources,
) -> Result<(&'a Topic, bool), Error> {
    let first = topics[0].0;
    let other = topics.iter().map(|(topic, _)| *topic).find(|topic| {
        let views = (names::view(&first.name), names::view(&topic.name));
        let other_view = matches!(&views, (Some(a), Some(b)) if a != b);
        names::device(&topic.name) != names::device(&first.name) || other_view
    });
    if let Some(other) = other {
        return Err(Error::Topics(format!(
            "colour topics `{}` and `{}` have the same frame_id `{frame_id}`, but are of different cameras: give every camera \
             its own (`camera_name` of a RealSense driver), or leave one topic out with `mcap filter --exclude-topic-regex`; \
             docs/use/cameras.md#mcap",
            first.name, other.name
        )));
    }
    // A rectified depth belongs to rectified colour; one that says raw to colour as it was taken.
    let wants_raw = depth.is_some_and(|d| names::is_raw(&d.name) && !names::is_rectified(&d.name));
    let most = topics.iter().map(|(t, _)| t.images.len()).max().unwrap_or(0);
    let key = |(t, gray): &&(&'a Topic, bool)| {
        (
            2 * t.images.len() >= most,
            !*gray,
            names::is_rectified(&t.name) != wants_raw,
            names::view(&t.name).is_none(),
            t.images.len(),
            std::cmp::Reverse(&t.name),
        )
    };
    let &(taken, gray) = topics.iter().max_by_key(key).unwrap_or(&topics[0]);
    for (topic, _) in topics.iter().filter(|(topic, _)| !std::ptr::eq(*topic, taken)) {
        let because = format!("`{}` of the same frame `{frame_id}` was taken", taken.name);
        sources.leave_out(&topic.name, because);
    }
    Ok((taken, gray))
}

fn frame_of(topic: &Topic) -> &str {
    plain(&topic.head.frame_id)
}

fn unaligned(sorted: &Sorted<'_>, color: &Topic) -> Error {
    let depths = sorted.depth.iter().map(|(t, _)| format!("{} in {}", t.name, frame_of(t)));
    let mut found: Vec<String> = depths.take(NAMED).collect();
    if found.is_empty() {
        found.push("no depth at all".to_owned());
        let others = sorted.others.iter().take(NAMED);
        found.extend(others.map(|(topic, because)| format!("{topic}: {because}")));
    }
    Error::DepthNotAligned {
        camera: camera_name(color),
        frame_id: frame_of(color).to_owned(),
        found: found.join(", "),
    }
}

fn no_color(sorted: &Sorted<'_>) -> String {
    let found: Vec<String> = sorted
        .others
        .iter()
        .take(NAMED)
        .map(|(topic, because)| format!("`{topic}`: {because}"))
        .collect();
    let found = if found.is_empty() {
        "it has no other images either".to_owned()
    } else {
        found.join("; ")
    };
    format!(
        "no topic has colour images that are read ({found}): record sensor_msgs CompressedImage or Image, or \
         foxglove.CompressedImage or RawImage, in CDR, ROS 1 or protobuf; docs/use/cameras.md#mcap"
    )
}

/// Names for people: the words of colour topics before those that name the image, with the frame
/// where two are alike.
fn name_all(cameras: &mut [CameraTopics<'_>]) {
    let names: Vec<String> = cameras.iter().map(|camera| camera_name(camera.color)).collect();
    for (camera, name) in cameras.iter_mut().zip(&names) {
        let alone = names.iter().filter(|other| *other == name).count() == 1;
        camera.name = if alone { name.clone() } else { format!("{name} ({})", camera.frame_id()) };
    }
}

fn camera_name(color: &Topic) -> String {
    let words = color.name.split('/').filter(|word| !word.is_empty());
    let of_image =
        |word: &str| word.starts_with("image") || ["color", "rgb", "compressed"].contains(&word);
    let name: Vec<&str> = words.take_while(|word| !of_image(word)).collect();
    if name.is_empty() { frame_of(color).to_owned() } else { name.join("/") }
}
