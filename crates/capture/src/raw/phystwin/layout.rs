//! Folders of a raw PhysTwin case: `color/0` as PhysTwin has them, or the spellings of other programs,
//! by kind (`rgb/SERIAL`) or by camera (`cam0/color`).

use bendtwin_core::Finding;

use super::MARKER;
use crate::{
    Error, Sources,
    files::{Contents, Files, shortened},
};

/// Names of the folder of colour images, the preferred first.
const COLOR: &[&str] = &["color", "colour", "rgb", "image", "images", "colors", "colours"];
/// The name of the folder of depth that is preferred.
const DEPTH: &str = "depth";
/// Folders of 2D tracks.
const TRACKS: &[&str] = &["cotracker", "tracks", "tapir", "cotracker3"];
/// Words before a camera's number or name.
const PREFIXES: &[&str] = &["camera", "cam", "device", "view", "kinect", "realsense", "sensor"];
/// Words for a camera's place, which may be the name of its folder.
const PLACES: &[&str] = &["left", "right", "front", "back", "top", "side", "middle", "center"];

/// Folders and files of one camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Folders {
    pub(super) color: String,
    pub(super) depth: String,
    /// File of 2D tracks, which need not exist.
    pub(super) tracks: String,
}

/// `true` if a folder with these files is a case.
pub(in crate::raw) fn is_case(contents: &Contents) -> bool {
    let folders = &contents.folders;
    contents.has(MARKER)
        && (of_color(folders).next().is_some() || folders.iter().any(|name| is_camera(name)))
}

/// Finds the folders of all cameras, whose names are given in their order.
pub(super) fn find(
    files: &Files<'_>,
    cameras: &[String],
    depth_folder: Option<&str>,
    sources: &mut Sources,
    notes: &mut Vec<Finding>,
) -> Result<Vec<Folders>, Error> {
    let root = files.list("").folders;
    let mut colors = of_color(&root);
    let Some(color) = colors.next() else {
        return by_camera(files, cameras, depth_folder, sources, notes);
    };
    for other in colors {
        sources.leave_out(other, format!("`{color}` was taken for colour"));
    }
    let depth = depth(&root, "", depth_folder, sources)?;
    let of_kind = |kind: &str, notes: &mut Vec<Finding>| -> Vec<String> {
        let inner = files.list(kind).folders;
        // One camera needs no folder inside.
        if let ([_], []) = (cameras, inner.as_slice())
            && !files.list(kind).files.is_empty()
        {
            return vec![kind.to_owned()];
        }
        let assigned = assign(&inner, cameras);
        notes.extend(assigned.note(&format!("the folders in `{kind}`"), &inner));
        let name = |index: usize| {
            assigned.0[index].map_or_else(|| index.to_string(), |i| inner[i].clone())
        };
        (0..cameras.len()).map(|index| format!("{kind}/{}", name(index))).collect()
    };
    let colors = of_kind(color, notes);
    // The folders of depth are assigned as those of colour, which is said once.
    let depths = of_kind(&depth, &mut Vec::new());
    let folders = colors.into_iter().zip(depths).enumerate();
    let folders = folders.map(|(index, (color, depth))| Folders {
        color,
        depth,
        tracks: tracks(files, index, &cameras[index]),
    });
    Ok(folders.collect())
}

/// A folder for each camera.
fn by_camera(
    files: &Files<'_>,
    cameras: &[String],
    depth_folder: Option<&str>,
    sources: &mut Sources,
    notes: &mut Vec<Finding>,
) -> Result<Vec<Folders>, Error> {
    let root = files.list("").folders;
    let has_color = |name: &String| of_color(&files.list(name).folders).next().is_some();
    let with_images: Vec<String> = root.into_iter().filter(has_color).collect();
    let assigned = assign(&with_images, cameras);
    notes.extend(assigned.note("the cameras' folders", &with_images));
    let mut all = Vec::with_capacity(cameras.len());
    for (index, place) in assigned.0.iter().enumerate() {
        let folder = place.map_or_else(|| format!("cam{index}"), |i| with_images[i].clone());
        let contents = files.list(&folder);
        let inner = &contents.folders;
        let color = of_color(inner).next().map_or(COLOR[0], String::as_str);
        let depth = depth(inner, &format!("{folder}/"), depth_folder, sources)?;
        let tracks = TRACKS.iter().map(|name| format!("{folder}/{name}.npz"));
        let tracks = tracks.into_iter().find(|name| files.has(name));
        all.push(Folders {
            color: format!("{folder}/{color}"),
            depth: format!("{folder}/{depth}"),
            tracks: tracks.unwrap_or_else(|| self::tracks(files, index, &cameras[index])),
        });
    }
    Ok(all)
}

/// Folders of colour images, the preferred first.
fn of_color(folders: &[String]) -> impl Iterator<Item = &String> {
    COLOR.iter().flat_map(|kind| folders.iter().filter(|name| name.eq_ignore_ascii_case(kind)))
}

/// The folder of depth: the chosen one, else `depth`, else the first of those that begin so.
fn depth(
    folders: &[String],
    above: &str,
    chosen: Option<&str>,
    sources: &mut Sources,
) -> Result<String, Error> {
    let is_depth = |name: &&String| {
        let lower = name.to_ascii_lowercase();
        lower
            .strip_prefix(DEPTH)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with(['_', '-', 's']))
    };
    let mut found: Vec<&String> = folders.iter().filter(is_depth).collect();
    found.sort_by_key(|name| !name.eq_ignore_ascii_case(DEPTH));
    let taken = match chosen {
        Some(chosen) if !folders.iter().any(|name| name == chosen) => {
            return Err(Error::Document {
                at: MARKER.to_owned(),
                fault: format!(
                    "`depth_folder` is `{}`, but there are the folders {}",
                    chosen.chars().take(80).collect::<String>(),
                    shortened(folders, folders.len())
                ),
            });
        }
        Some(chosen) => chosen.to_owned(),
        None => found.first().map_or_else(|| DEPTH.to_owned(), |name| (*name).clone()),
    };
    for other in found.into_iter().filter(|name| **name != taken) {
        let because =
            format!("`{above}{taken}` was taken for depth; `depth_folder` in {MARKER} chooses");
        sources.leave_out(format!("{above}{other}"), because);
    }
    Ok(taken)
}

/// File of a camera's tracks; PhysTwin's name for it if no file is found.
fn tracks(files: &Files<'_>, index: usize, name: &str) -> String {
    let named = |folder: &&str| [format!("{folder}/{index}.npz"), format!("{folder}/{name}.npz")];
    let mut all = TRACKS.iter().flat_map(named);
    all.find(|name| files.has(name)).unwrap_or_else(|| format!("{}/{index}.npz", TRACKS[0]))
}

/// Places of cameras among names, shape [camera]; and whether these were matched by order alone.
pub(super) struct Assigned(pub(super) Vec<Option<usize>>, bool);

impl Assigned {
    /// `true` if nothing but their order matched names and cameras.
    pub(super) fn is_by_order(&self) -> bool {
        self.1
    }

    fn note(&self, what: &str, names: &[String]) -> Option<Finding> {
        if !self.1 {
            return None;
        }
        let message = format!(
            "{what} ({}) were taken for the cameras by the order of their names",
            shortened(names, names.len())
        );
        let advice = format!("name the cameras in `serial_numbers` of {MARKER}, as their folders");
        Some(Finding { advice, ..Finding::info("CAMERAS_BY_ORDER", message) })
    }
}

/// Finds each camera among names: by its number, its name, either of these after a word such as `cam`,
/// or, where there are as many names as cameras, by their order. The first of these rules that
/// finds all cameras counts; otherwise the first that finds any.
pub(super) fn assign(names: &[String], cameras: &[String]) -> Assigned {
    let numbers: Vec<String> = (0..cameras.len()).map(|index| index.to_string()).collect();
    let exact = |wanted: &[String]| -> Vec<Option<usize>> {
        wanted.iter().map(|wanted| names.iter().position(|name| name == wanted)).collect()
    };
    let plain: Vec<String> = names.iter().map(|name| bare(name)).collect();
    let loose = |wanted: &[String]| -> Vec<Option<usize>> {
        wanted.iter().map(|wanted| plain.iter().position(|name| *name == bare(wanted))).collect()
    };
    let rules = [exact(&numbers), exact(cameras), loose(cameras), loose(&numbers)];
    if let Some(all) = rules.iter().find(|rule| rule.iter().all(Option::is_some)) {
        return Assigned(all.clone(), false);
    }
    if names.len() == cameras.len() {
        let mut order: Vec<usize> = (0..names.len()).collect();
        // cam10 comes after cam9.
        order.sort_by_key(|i| (plain[*i].parse::<u64>().ok(), &names[*i]));
        return Assigned(order.into_iter().map(Some).collect(), true);
    }
    let any = rules.into_iter().find(|rule| rule.iter().any(Option::is_some));
    Assigned(any.unwrap_or_else(|| vec![None; cameras.len()]), false)
}

/// A camera's number or name without the word before it, and without leading zeros.
fn bare(name: &str) -> String {
    let lower = name.to_lowercase();
    let rest = PREFIXES.iter().find_map(|prefix| lower.strip_prefix(prefix)).unwrap_or(&lower);
    let rest = rest.trim_start_matches(['_', '-', ' ', '.']);
    match rest.parse::<u64>() {
        Ok(number) => number.to_string(),
        Err(_) if rest.is_empty() => lower,
        Err(_) => rest.to_owned(),
    }
}

/// `true` if a folder's name is a camera's: `cam0`, `camera_left`, a serial number.
fn is_camera(name: &str) -> bool {
    let lower = name.to_lowercase();
    let is_serial = lower.len() >= 6 && lower.bytes().all(|b| b.is_ascii_digit());
    is_serial
        || PLACES.contains(&lower.as_str())
        || PREFIXES.iter().any(|prefix| lower.starts_with(prefix))
}

#[cfg(test)]
mod tests;
