//! Matching of images by their colours: layers of an image, patches cut out of them, alignment of a
//! patch with an image, and points followed from one frame to the next.

pub(crate) mod align;
pub(crate) mod follow;
pub(crate) mod layer;
pub(crate) mod patch;
