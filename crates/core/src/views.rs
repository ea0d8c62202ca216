//! Views of an object: what cameras saw of it, frame by frame, cut out around it and without the
//! distortion of lenses, as renderings are trained on and compared with.

use crate::Point;

/// Most pixels of all views of a recording.
pub const MOST_PIXELS: usize = 20 << 20;

/// Views of one recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Views {
    /// The cameras of the recording.
    pub cameras: Vec<ViewCamera>,
}

/// A camera without distortion: OpenCV's axes (x right, y down, z into the scene); the centre of the
/// first pixel is (0, 0).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewCamera {
    /// A person's name for it.
    pub name: String,
    /// Columns and rows of whole images.
    pub size: [u32; 2],
    /// Focal lengths in columns and in rows [pixels].
    pub focal: [f64; 2],
    /// Column and row of the principal point.
    pub centre: [f64; 2],
    /// World to camera, row-major, shape [1 or frames, 3, 4]; one for a camera that stands.
    pub world_to_camera: Vec<[[f64; 4]; 3]>,
    /// Views by rising frame; frames in which it did not see the object, or that were left out, have
    /// none.
    pub views: Vec<View>,
}

/// Part of an image around the object. P is the number of its pixels, row by row from the upper
/// left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Frame of the sequence.
    pub frame: u32,
    /// Column and row of the whole image in which it begins.
    pub corner: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
    /// Colours (sRGB), shape [P, 3].
    pub colors: Vec<[u8; 3]>,
    /// Label of each pixel, shape [P].
    pub labels: Vec<Label>,
    /// Depth along the optical axis [mm], shape [P]; 0 where it is not known.
    pub depths_mm: Vec<u16>,
}

/// Content of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Label {
    /// Neither object nor hand.
    #[default]
    Background = 0,
    /// The object.
    Object = 1,
    /// A hand or gripper, which may hide the object.
    Hand = 2,
}

impl Label {
    /// The label of a number.
    pub fn from_number(number: u8) -> Option<Self> {
        [Self::Background, Self::Object, Self::Hand].get(usize::from(number)).copied()
    }
}

impl ViewCamera {
    /// World to camera in a frame.
    pub fn pose(&self, frame: u32) -> [[f64; 4]; 3] {
        let poses = &self.world_to_camera;
        poses.get(frame as usize).or(poses.first()).copied().unwrap_or_default()
    }

    /// The view of a frame, if there is one.
    pub fn view(&self, frame: u32) -> Option<&View> {
        let index = self.views.binary_search_by_key(&frame, |view| view.frame).ok()?;
        self.views.get(index)
    }

    /// Column, row and depth [m] of a point of the world; none behind the camera.
    pub fn project(&self, point: Point, frame: u32) -> Option<([f64; 2], f64)> {
        let at = |row: [f64; 4]| {
            row[..3].iter().zip(point).map(|(r, x)| r * f64::from(x)).sum::<f64>() + row[3]
        };
        let [x, y, z] = self.pose(frame).map(at);
        let pixel = [x, y].map(|u| u / z);
        let along = |axis: usize| self.focal[axis] * pixel[axis] + self.centre[axis];
        (z > 1e-6).then(|| ([along(0), along(1)], z))
    }
}

impl View {
    /// Index of the pixel at a column and row of the whole image, if it lies in the view.
    pub fn index(&self, column: u32, row: u32) -> Option<usize> {
        let x = column.checked_sub(self.corner[0]).filter(|x| *x < self.size[0])?;
        let y = row.checked_sub(self.corner[1]).filter(|y| *y < self.size[1])?;
        Some(y as usize * self.size[0] as usize + x as usize)
    }
}

impl Views {
    /// Number of pixels of all views.
    pub fn pixel_count(&self) -> usize {
        let views = self.cameras.iter().flat_map(|camera| &camera.views);
        views.map(|view| view.labels.len()).sum()
    }

    /// Checks that lengths agree, views lie in their images, and numbers are finite.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self) -> Result<(), String> {
        for camera in &self.cameras {
            let name = &camera.name;
            let numbers = camera.focal.iter().chain(&camera.centre);
            let poses = camera.world_to_camera.iter().flatten().flatten();
            if !numbers.chain(poses).all(|x| x.is_finite()) {
                return Err(format!("a number of camera `{name}` is not finite"));
            }
            if !camera.views.is_sorted_by(|a, b| a.frame < b.frame) {
                return Err(format!("the views of camera `{name}` are not in the order of frames"));
            }
            for view in &camera.views {
                let inside = |axis: usize| {
                    let end = view.corner[axis].checked_add(view.size[axis]);
                    end.is_some_and(|end| end <= camera.size[axis])
                };
                if !(inside(0) && inside(1)) {
                    let frame = view.frame;
                    return Err(format!("the view of frame {frame} leaves camera `{name}`"));
                }
                let pixels = view.size[0] as usize * view.size[1] as usize;
                let lengths = [view.colors.len(), view.labels.len(), view.depths_mm.len()];
                if lengths != [pixels; 3] {
                    let frame = view.frame;
                    return Err(format!(
                        "the view of frame {frame} of camera `{name}` has {pixels} pixels but arrays of {lengths:?}"
                    ));
                }
            }
        }
        Ok(())
    }
}
