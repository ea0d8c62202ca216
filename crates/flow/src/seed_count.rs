//! Number of spots of an object that the tracker could follow, before it is run.

use bendtwin_capture::raw::{ColorImage, DepthImage, Mask, Region};

use crate::{FlowSettings, seed::seeds, view::View};

/// Number of spots of the object in an image from which [`crate::track`] would start with its default
/// settings; 0 also if the images differ in size.
pub fn seed_count(
    color: &ColorImage,
    depth: &DepthImage,
    object: &Mask,
    manipulator: Option<&Mask>,
) -> usize {
    let size = (color.width, color.height);
    let fits = |width, height, pixels| (width, height) == size && pixels == width * height;
    let alike = fits(color.width, color.height, color.pixels.len())
        && fits(depth.width, depth.height, depth.pixels.len())
        && [Some(object), manipulator]
            .into_iter()
            .flatten()
            .all(|m| fits(m.width, m.height, m.pixels.len()));
    if !alike {
        return 0;
    }
    let settings = FlowSettings::default();
    let view = View::new(color, depth, object, manipulator, &settings);
    seeds(&view, Region::Object, &settings).seeds.len()
}
