//! Places of the masks of each camera: below `mask` by the camera's number or name, or in the folder of
//! the camera.

use crate::{files::Files, raw::Camera};

/// Folders that hold the masks of all cameras, or of one in its own folder.
const FOLDERS: &[&str] = &["mask", "masks"];
/// Words before the number of a camera.
const CAMERA: &[&str] = &["", "c", "cam", "camera", "view", "device", "kinect", "realsense"];
/// Extensions of files with the masks of all frames, the preferred first.
const WHOLE: &[&str] = &["npz", "npy", "json"];

/// Where the masks of all cameras lie.
pub(super) struct Rig {
    /// The folder of all cameras, with `/` at its end; empty if that is the root.
    root: String,
    cameras: Vec<Places>,
    /// A folder for masks in which no camera was found.
    pub(super) strange: Option<String>,
}

/// Where those of a camera lie.
#[derive(Clone, Default)]
pub(super) struct Places {
    /// Folders with images or parts.
    pub(super) folders: Vec<String>,
    /// Files with the masks of all frames.
    pub(super) files: Vec<String>,
}

impl Rig {
    pub(super) fn find(files: &Files<'_>, cameras: &[Camera]) -> Self {
        let root = files.list("");
        let is_recording = root.has("metadata.json");
        let folder = FOLDERS.iter().find(|name| root.has_folder(name));
        if let Some(folder) = folder {
            let rig = Self::below(files, format!("{folder}/"), cameras);
            if rig.cameras.iter().any(Places::are_any) || !is_recording {
                return rig;
            }
        }
        // Each camera has a folder with all that it recorded.
        let mut rig = Self::below(files, String::new(), cameras);
        rig.strange = folder.map(|folder| (*folder).to_owned());
        for places in &mut rig.cameras {
            let inner = places.folders.iter().flat_map(|folder| {
                let has = files.list(folder).folders;
                let own = FOLDERS.iter().filter(move |name| has.iter().any(|f| f == *name));
                own.map(move |name| format!("{folder}/{name}"))
            });
            let inner: Vec<String> = inner.collect();
            // Without a recording beside them, the folders of cameras hold nothing but masks.
            if is_recording || !inner.is_empty() {
                *places = Places { folders: inner, files: Vec::new() };
            }
        }
        rig
    }

    /// What lies in a folder for each camera, by its name or by its number, whichever more of them
    /// have.
    fn below(files: &Files<'_>, root: String, cameras: &[Camera]) -> Self {
        let contents = files.list(&root);
        let places = |is_own: &dyn Fn(usize, &str) -> bool| -> Vec<Places> {
            let of = |camera: usize| {
                let folders = contents.folders.iter().filter(|name| is_own(camera, name));
                let whole = WHOLE.iter().flat_map(|extension| {
                    contents.files.iter().filter(move |name| {
                        let parts = name.rsplit_once('.');
                        parts.is_some_and(|(stem, ending)| {
                            ending.eq_ignore_ascii_case(extension) && is_own(camera, stem)
                        })
                    })
                });
                Places {
                    folders: folders.map(|name| format!("{root}{name}")).collect(),
                    files: whole.map(|name| format!("{root}{name}")).collect(),
                }
            };
            (0..cameras.len()).map(of).collect()
        };
        let by_name = places(&|camera, name| cameras[camera].name.eq_ignore_ascii_case(name));
        let by_number = places(&|camera, name| number(name) == Some(camera));
        let count = |places: &[Places]| places.iter().filter(|p| p.are_any()).count();
        let mut found = if count(&by_name) >= count(&by_number) { by_name } else { by_number };
        if let ([only], false) = (found.as_mut_slice(), root.is_empty())
            && !only.are_any()
        {
            only.folders.push(root.trim_end_matches('/').to_owned());
        }
        Self { root, cameras: found, strange: None }
    }

    pub(super) fn camera(&self, index: usize) -> Places {
        self.cameras.get(index).cloned().unwrap_or_default()
    }

    /// The folder of all cameras, with `/` at its end unless that is the root.
    pub(super) fn folder(&self) -> &str {
        &self.root
    }
}

impl Places {
    fn are_any(&self) -> bool {
        !(self.folders.is_empty() && self.files.is_empty())
    }
}

/// The number of a camera in a name such as `2`, `cam_02` or `camera2`.
fn number(name: &str) -> Option<usize> {
    let start = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let word = start.trim_end_matches(['_', '-', ' ']).to_ascii_lowercase();
    let digits = &name[start.len()..];
    CAMERA.contains(&word.as_str()).then(|| digits.parse().ok())?
}
