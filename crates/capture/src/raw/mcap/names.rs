//! What the name of a topic says about its images.

/// Content of images by the name of their topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Says {
    Color,
    Depth,
    /// Neither: what it is instead.
    Neither(&'static str),
    Nothing,
}

/// Words of images that are neither colour nor depth, and what they are.
const NEITHER: [(&str, &str); 34] = [
    ("confidence", "a confidence map"),
    ("conf", "a confidence map"),
    ("certainty", "a confidence map"),
    ("uncertainty", "a map of uncertainty"),
    ("variance", "a map of uncertainty"),
    ("noise", "a map of noise"),
    ("cost", "a map of costs"),
    ("disparity", "a disparity map, which is no depth"),
    ("disparities", "a disparity map, which is no depth"),
    ("infra", "infrared"),
    ("infrared", "infrared"),
    ("ir", "infrared"),
    ("nir", "infrared"),
    ("amplitude", "an amplitude image"),
    ("amplitudes", "an amplitude image"),
    ("intensity", "an intensity image"),
    ("reflectivity", "a reflectivity image"),
    ("reflectance", "a reflectivity image"),
    ("ambient", "an image of ambient light"),
    ("thermal", "a thermal image"),
    ("lwir", "a thermal image"),
    ("normal", "a map of normals"),
    ("normals", "a map of normals"),
    ("flow", "optical flow"),
    ("segmentation", "a segmentation"),
    ("semantic", "a segmentation"),
    ("label", "a segmentation"),
    ("labels", "a segmentation"),
    ("mask", "a mask: those of BendTwin end in `/mask/object` and `/mask/manipulator`"),
    ("masks", "a mask: those of BendTwin end in `/mask/object` and `/mask/manipulator`"),
    ("overlay", "a picture for people"),
    ("annotated", "a picture for people"),
    ("detections", "a picture for people"),
    ("heatmap", "a picture for people"),
];

/// Words of colour images.
const COLOR: [&str; 8] = ["color", "colour", "rgb", "bgr", "gray", "grey", "mono", "yuv"];
/// Words of devices: `depth_camera` has colour, too.
const DEVICES: [&str; 6] = ["camera", "cam", "sensor", "device", "driver", "node"];
/// Words of the part of a name that says how images are sent, and not what they are.
const SENT: [&str; 8] =
    ["image", "compressed", "compresseddepth", "raw", "rect", "hd", "qhd", "sd"];

/// The words of a part of a name, in lower case, without numbers at their ends.
fn words(part: &str) -> impl Iterator<Item = String> + '_ {
    let all = part.split(|c: char| !c.is_alphanumeric());
    let all = all.map(|w| w.trim_end_matches(|c: char| c.is_ascii_digit()).to_lowercase());
    all.filter(|word| !word.is_empty())
}

/// What a topic's name says: the last part that says something counts, and of `depth_to_rgb` what
/// comes before `to`. That an image is a `color` one says least: depth may be drawn in colours.
pub(super) fn says(topic: &str) -> Says {
    if topic.contains("/stereo/image") || topic.contains("/stereo_raw/image") {
        return Says::Neither("a pair of images side by side");
    }
    let mut is_color_image = false;
    for part in topic.rsplit('/') {
        let words: Vec<String> = words(part).take_while(|w| w != "to" && w != "from").collect();
        let has = |known: &[&str]| words.iter().any(|w| known.contains(&w.as_str()));
        let neither = NEITHER.iter().find(|(word, _)| words.iter().any(|w| w == word));
        if let Some((_, what)) = neither {
            return Says::Neither(what);
        }
        if has(&DEVICES) {
            continue;
        }
        if words.iter().any(|w| w.starts_with("depth")) {
            return Says::Depth;
        }
        if has(&COLOR) && has(&["image"]) {
            is_color_image = true;
        } else if has(&COLOR) {
            return Says::Color;
        }
    }
    if is_color_image { Says::Color } else { Says::Nothing }
}

/// How sure a topic's name is that its depth is aligned to colour: 2 if it says so, 1 if it says
/// depth, else 0.
pub(super) fn depth_rank(topic: &str) -> u8 {
    let aligned = |w: &str| w == "aligned" || w == "registered";
    let all: Vec<String> = topic.split('/').flat_map(words).collect();
    let to_color = all.windows(2).any(|w| w[0] == "to" && COLOR.contains(&w[1].as_str()));
    if to_color || all.iter().any(|w| aligned(w)) {
        2
    } else {
        u8::from(says(topic) == Says::Depth)
    }
}

/// `true` for images that were mapped onto another camera's: `rgb_to_depth`.
pub(super) fn is_mapped(topic: &str) -> bool {
    topic.split('/').any(|part| words(part).any(|w| w == "to"))
}

/// `true` for images without distortion.
pub(super) fn is_rectified(topic: &str) -> bool {
    topic.split('/').flat_map(words).any(|w| w == "rect" || w == "rectified")
}

/// `true` for images as the sensor gives them.
pub(super) fn is_raw(topic: &str) -> bool {
    topic.split('/').flat_map(words).any(|w| w == "raw")
}

/// A topic without the parts that say how its images are sent: a topic and its compressed
/// counterpart have one name.
pub(super) fn base(topic: &str) -> &str {
    let mut name = topic;
    for ending in ["/compressed", "/compressedDepth"] {
        name = name.strip_suffix(ending).unwrap_or(name);
    }
    name
}

/// The device that a topic belongs to: its name without the parts at its end that name the images
/// and the view. Of a stereo camera both views have one device.
pub(super) fn device(topic: &str) -> &str {
    let mut name = topic;
    while let Some((before, part)) = name.rsplit_once('/') {
        let of_image = words(part).all(|w| {
            let w = w.as_str();
            SENT.contains(&w)
                || COLOR.contains(&w)
                || is_view(w)
                || w == "to"
                || w == "registered"
                || w == "aligned"
                || w.starts_with("depth")
        });
        let says_device = words(part).any(|w| DEVICES.contains(&w.as_str()));
        if !of_image || says_device {
            break;
        }
        name = before;
    }
    name
}

/// The view of a stereo camera that a topic shows, if it names one.
pub(super) fn view(topic: &str) -> Option<String> {
    topic.rsplit('/').flat_map(words).find(|w| is_view(w))
}

fn is_view(word: &str) -> bool {
    word == "left" || word == "right"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_images_show() {
        for (topic, expected) in [
            ("/camera/aligned_depth_to_color/image_raw", Says::Depth),
            ("/camera/depth/image_rect_raw", Says::Depth),
            ("/zed/zed_node/depth/depth_registered", Says::Depth),
            ("/k4a/depth_to_rgb/image_raw", Says::Depth),
            ("/k4a/rgb_to_depth/image_raw", Says::Color),
            ("/camera/color/image_raw/compressed", Says::Color),
            ("/depth_camera/rgb/image_raw", Says::Color),
            ("/depth_camera/image_raw", Says::Nothing),
            ("/ir_camera/depth/image_raw", Says::Depth),
            ("/cam/image_raw", Says::Nothing),
            ("/cam/image_color", Says::Color),
            ("/stereo/left/image_raw", Says::Nothing),
            ("/cam/depth/image_color", Says::Depth),
        ] {
            assert_eq!(says(topic), expected, "{topic}");
        }
        for topic in [
            "/zed/zed_node/confidence/confidence_map",
            "/depth/confidence",
            "/camera/depth_confidence/image",
            "/zed/disparity/disparity_image",
            "/camera/infra1/image_rect_raw",
            "/k4a/ir/image_raw",
            "/tof/amplitude",
            "/cam/color/overlay",
            "/cam/mask/hand",
            "/zed/zed_node/stereo/image_rect_color",
        ] {
            assert!(matches!(says(topic), Says::Neither(_)), "{topic}");
        }
    }

    #[test]
    fn aligned_depth_ranks_before_depth_before_others() {
        for (topic, rank) in [
            ("/camera/aligned_depth_to_color/image_raw", 2),
            ("/camera/depth_registered/image", 2),
            ("/k4a/depth_to_rgb/image_raw", 2),
            ("/camera/depth/image_raw", 1),
            ("/camera/z/image", 0),
        ] {
            assert_eq!(depth_rank(topic), rank, "{topic}");
        }
    }

    #[test]
    fn topics_of_a_device_share_its_name() {
        for (topic, expected) in [
            ("/zed0/zed_node/left/image_rect_color", "/zed0/zed_node"),
            ("/zed0/zed_node/rgb/image_rect_color/compressed", "/zed0/zed_node"),
            ("/zed/zed_node/left/color/rect/image", "/zed/zed_node"),
            ("/zed/zed_node/depth/depth_registered", "/zed/zed_node"),
            ("/a/camera/color/image_raw", "/a/camera"),
            ("/k4a/rgb_to_depth/image_raw", "/k4a"),
            ("/left/image_raw", ""),
            ("/kinect2/qhd/image_color_rect", "/kinect2"),
        ] {
            assert_eq!(device(topic), expected, "{topic}");
        }
        assert_eq!(view("/zed/left/image_rect_color").as_deref(), Some("left"));
        assert!(is_rectified("/zed/left/image_rect_color") && !is_rectified("/a/image_raw"));
        assert_eq!(base("/a/image_raw/compressedDepth"), "/a/image_raw");
    }
}
