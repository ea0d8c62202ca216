//! Encodings of images: those of raw pixels, and the `format` of compressed ones.

use super::{
    index::Topic,
    messages::Kind,
    names::{self, Says},
};

/// Use of a topic's images.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Colour, or gray.
    Color {
        gray: bool,
    },
    /// Depth; the larger the rank, the surer its name is that it is aligned to colour.
    Depth {
        rank: u8,
    },
    Object,
    Manipulator,
    /// Another encoding, with the reason for which it is not read.
    Other(String),
}

/// Order of samples of 8 or 16 bits in a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pixels {
    /// Samples of each pixel, and the places of red, green and blue among them.
    Samples { count: usize, order: [usize; 3], deep: bool },
    /// Two pixels share four bytes; places of the two lumas, and of blue's and red's difference.
    Yuv422([usize; 4]),
    /// All lumas, then pairs of differences for 2 x 2 pixels, blue's first or second.
    Nv { blue: usize },
    /// A single colour for each pixel, as indices of red, green and blue in 2 x 2 pixels.
    Bayer { pattern: [usize; 4], deep: bool },
}

/// The pixels of an encoding; `None` if it is not read as colour.
pub(super) fn pixels(encoding: &str) -> Option<Pixels> {
    let samples = |count, order, deep| Some(Pixels::Samples { count, order, deep });
    match encoding {
        "rgb8" => samples(3, [0, 1, 2], false),
        "bgr8" | "8UC3" => samples(3, [2, 1, 0], false),
        "rgba8" => samples(4, [0, 1, 2], false),
        "bgra8" | "8UC4" => samples(4, [2, 1, 0], false),
        "rgb16" => samples(3, [0, 1, 2], true),
        "bgr16" | "16UC3" => samples(3, [2, 1, 0], true),
        "rgba16" => samples(4, [0, 1, 2], true),
        "bgra16" | "16UC4" => samples(4, [2, 1, 0], true),
        "mono8" | "8UC1" => samples(1, [0; 3], false),
        "mono16" => samples(1, [0; 3], true),
        "yuv422" | "uyvy" => Some(Pixels::Yuv422([1, 3, 0, 2])),
        "yuv422_yuy2" | "yuyv" | "yuy2" => Some(Pixels::Yuv422([0, 2, 1, 3])),
        "nv12" => Some(Pixels::Nv { blue: 0 }),
        "nv21" => Some(Pixels::Nv { blue: 1 }),
        _ => {
            let (order, depth) = encoding.strip_prefix("bayer_")?.split_at_checked(4)?;
            let deep = match depth {
                "8" => false,
                "16" => true,
                _ => return None,
            };
            let pattern = match order {
                "rggb" => [0, 1, 1, 2],
                "bggr" => [2, 1, 1, 0],
                "gbrg" => [1, 2, 0, 1],
                "grbg" => [1, 0, 2, 1],
                _ => return None,
            };
            Some(Pixels::Bayer { pattern, deep })
        }
    }
}

/// Words of a `format`: `bayer_rggb8; jpeg compressed bgr8`.
pub(super) fn words(format: &str) -> impl Iterator<Item = &str> {
    format.split([';', ' ']).filter(|word| !word.is_empty())
}

/// The pattern of a compressed image that was not converted to colour before.
pub(super) fn compressed_bayer(format: &str) -> Option<Pixels> {
    let after = words(format).skip_while(|word| *word != "compressed").nth(1);
    after.and_then(pixels).filter(|pixels| matches!(pixels, Pixels::Bayer { .. }))
}

/// `true` for what `compressed_depth_image_transport` makes.
pub(super) fn is_compressed_depth(format: &str) -> bool {
    words(format).any(|word| word.starts_with("compressedDepth"))
}

/// What an encoding holds.
enum Content {
    Color,
    Gray,
    DeepGray,
    Depth,
    /// A PNG file, which may hold anything.
    File,
    Unknown,
}

fn content(kind: Kind, encoding: &str) -> Content {
    let first = words(encoding).next().unwrap_or_default();
    if kind == Kind::CompressedImage {
        let has = |names: &[&str]| words(encoding).any(|word| names.contains(&word));
        if is_compressed_depth(encoding) || (has(&["png"]) && matches!(first, "16UC1" | "32FC1")) {
            return Content::Depth;
        }
        if has(&["jpeg", "jpg"]) {
            return if matches!(first, "mono8" | "8UC1") { Content::Gray } else { Content::Color };
        }
        if has(&["png"]) || first.is_empty() {
            return match first {
                "mono8" | "8UC1" => Content::Gray,
                "mono16" => Content::DeepGray,
                "png" | "" => Content::File,
                _ => Content::Color,
            };
        }
    }
    match first {
        "16UC1" | "32FC1" => Content::Depth,
        "mono16" => Content::DeepGray,
        "mono8" | "8UC1" => Content::Gray,
        other if pixels(other).is_some() => Content::Color,
        _ => Content::Unknown,
    }
}

/// Use of a topic's images, by its name and their encoding.
pub(super) fn meaning(topic: &Topic) -> Meaning {
    let name = names::base(&topic.name);
    let name = ["/image_raw", "/image"].iter().find_map(|e| name.strip_suffix(e)).unwrap_or(name);
    if name.ends_with("/mask/object") {
        return Meaning::Object;
    }
    if name.ends_with("/mask/manipulator") {
        return Meaning::Manipulator;
    }
    let says = names::says(&topic.name);
    let content = content(topic.kind, &topic.head.encoding);
    let depth = || Meaning::Depth { rank: names::depth_rank(&topic.name) };
    let other = |because: &str| Meaning::Other(because.to_owned());
    match (content, says) {
        (_, Says::Neither(what)) => other(&format!("by its name it is {what}")),
        (Content::Depth, Says::Color) => {
            other("it holds numbers as depth does, but its name says colour")
        }
        (Content::Depth, _) | (Content::DeepGray | Content::File, Says::Depth) => depth(),
        (Content::DeepGray, Says::Color) | (Content::Gray, Says::Color | Says::Nothing) => {
            Meaning::Color { gray: true }
        }
        (Content::DeepGray, _) => {
            other("it is gray (mono16), and its name says neither depth nor colour")
        }
        (Content::Gray | Content::Color, Says::Depth) => {
            other("it is a picture of depth, which holds no distances")
        }
        (Content::Color | Content::File, _) => Meaning::Color { gray: false },
        (Content::Unknown, _) => Meaning::Other(unknown(topic)),
    }
}

/// What to do about an encoding that is not read.
fn unknown(topic: &Topic) -> String {
    let encoding: String = topic.head.encoding.chars().take(40).collect();
    let advice = if topic.kind == Kind::CompressedImage {
        "republish it as JPEG or PNG (`ros2 run image_transport republish`)"
    } else {
        "have the driver send rgb8 (`image_proc` converts)"
    };
    format!("its encoding `{encoding}` is not read: {advice}")
}

#[cfg(test)]
mod tests {
    use super::{
        super::messages::{ImageHead, Wire},
        *,
    };

    fn of(name: &str, kind: Kind, encoding: &str) -> Meaning {
        let head = ImageHead { encoding: encoding.to_owned(), ..ImageHead::default() };
        meaning(&Topic { name: name.to_owned(), kind, wire: Wire::Ros2, head, images: Vec::new() })
    }

    #[test]
    fn a_topic_means_what_name_and_encoding_say_together() {
        let raw = |name, encoding| of(name, Kind::Image, encoding);
        let file = |name, format| of(name, Kind::CompressedImage, format);
        let color = Meaning::Color { gray: false };
        for encoding in
            ["rgb8", "bgra8", "yuv422", "yuv422_yuy2", "bayer_rggb8", "bayer_gbrg16", "nv12"]
        {
            assert_eq!(raw("/c/color/image_raw", encoding), color, "{encoding}");
        }
        for format in [
            "jpeg",
            "png",
            "",
            "rgb8; jpeg compressed bgr8",
            "bayer_rggb8; jpeg compressed bgr8",
            "yuv422_yuy2; jpeg compressed ",
            "bgra8; png compressed bgr8",
        ] {
            assert_eq!(file("/c/color/image_raw/compressed", format), color, "{format}");
        }
        assert_eq!(raw("/c/image_raw", "mono8"), Meaning::Color { gray: true });
        for (name, encoding) in [
            ("/z/confidence/confidence_map", "32FC1"),
            ("/z/disparity/image", "32FC1"),
            ("/k/ir/image_raw", "mono16"),
            ("/k/something", "mono16"),
            ("/c/infra1/image_rect_raw", "mono8"),
            ("/c/depth/image_colored", "rgb8"),
            ("/c/image_raw", "yuv444"),
            ("/c/color/image", "32FC1"),
        ] {
            assert!(matches!(raw(name, encoding), Meaning::Other(_)), "{name} {encoding}");
        }
        assert!(matches!(file("/c/image/compressed", "webp"), Meaning::Other(_)));
        for (name, encoding) in [("/c/depth/image_raw", "mono16"), ("/c/depth/image_raw", "16UC1")]
        {
            assert_eq!(raw(name, encoding), Meaning::Depth { rank: 1 }, "{encoding}");
        }
        for format in ["16UC1; compressedDepth RVL", "32FC1; compressedDepth png", "16UC1; png"] {
            let name = "/c/aligned_depth_to_color/image_raw/compressedDepth";
            assert_eq!(file(name, format), Meaning::Depth { rank: 2 }, "{format}");
        }
        assert_eq!(file("/c/depth/image", "png"), Meaning::Depth { rank: 1 });
        assert_eq!(raw("/c/mask/object", "mono8"), Meaning::Object);
        assert_eq!(file("/c/mask/manipulator/compressed", "png"), Meaning::Manipulator);
    }
}
