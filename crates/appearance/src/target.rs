//! The part of a view's image in a rectangle, over black, which a rendering is compared with.

use bendtwin_core::{View, views::Label};

/// Part of an image: column and row in which it begins, columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rectangle {
    pub(crate) corner: [u32; 2],
    pub(crate) size: [u32; 2],
}

impl Rectangle {
    pub(crate) fn of(view: &View) -> Self {
        Self { corner: view.corner, size: view.size }
    }

    /// The smallest one that covers both.
    pub(crate) fn union(self, other: Self) -> Self {
        let corner = [0, 1].map(|a| self.corner[a].min(other.corner[a]));
        let end = |r: Self, a: usize| r.corner[a] + r.size[a];
        let size = [0, 1].map(|a| end(self, a).max(end(other, a)) - corner[a]);
        Self { corner, size }
    }

    /// Indices of its pixels in a view, row by row; none where the view does not reach.
    pub(crate) fn in_view(self, view: &View) -> impl Iterator<Item = Option<usize>> {
        let [[left, top], [width, height]] = [self.corner, self.size];
        let places =
            (top..top + height).flat_map(move |row| (left..left + width).map(move |c| (c, row)));
        places.map(|(column, row)| view.index(column, row))
    }

    pub(crate) fn pixel_count(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

/// The recorded object over black. P is the number of pixels.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    pub(crate) area: Rectangle,
    /// Colours of the object, black elsewhere, shape [P, 3].
    pub(crate) colors: Vec<[f32; 3]>,
    /// True where the object is seen, shape [P].
    pub(crate) object: Vec<bool>,
    /// True where no hand may hide it, shape [P].
    pub(crate) valid: Vec<bool>,
    /// Depth [m], shape [P]; 0 where it is not known or not the object's.
    pub(crate) depth_m: Vec<f32>,
}

impl Target {
    /// A view in a rectangle; beyond the view is background.
    pub(crate) fn new(view: &View, area: Rectangle) -> Self {
        let count = area.pixel_count();
        let mut target = Self {
            area,
            colors: vec![[0.0; 3]; count],
            object: vec![false; count],
            valid: vec![true; count],
            depth_m: vec![0.0; count],
        };
        for (pixel, index) in area.in_view(view).enumerate() {
            let Some(index) = index else { continue };
            target.valid[pixel] = view.labels[index] != Label::Hand;
            if view.labels[index] == Label::Object {
                target.object[pixel] = true;
                target.colors[pixel] = view.colors[index].map(|c| f32::from(c) / 255.0);
                target.depth_m[pixel] = 1e-3 * f32::from(view.depths_mm[index]);
            }
        }
        target
    }
}
