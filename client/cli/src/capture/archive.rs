//! Packing files of a folder as a ZIP archive. The same files give the same bytes, so that an interrupted
//! upload is found again by its content.

use std::{
    fs::File,
    io::{self, BufWriter, Read, Seek, Write},
    path::{Path, PathBuf},
};

use anyhow::{Context as _, bail};
use bendtwin_capture::FilesRead;
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::{failure::Usage, progress};

/// Extensions of files that are compressed already: deflating them again costs time and saves
/// nothing.
const COMPRESSED_EXTENSIONS: [&str; 17] = [
    "png",
    "jpg",
    "jpeg",
    "webp",
    "exr",
    "npz",
    "zip",
    "gz",
    "zst",
    "zstd",
    "mcap",
    "mp4",
    "mkv",
    "avi",
    "glb",
    "pth",
    "safetensors",
];
/// Size from which an entry needs the long form of its header [bytes].
const ZIP64_BYTES: u64 = u32::MAX as u64;
const CHUNK: usize = 256 << 10;

/// The files of a folder, in the order of packing.
pub(super) struct Listing {
    root: PathBuf,
    /// Name of the folder, the prefix of entries in the archive.
    name: String,
    /// Names relative to the root, with their sizes [bytes].
    files: Vec<(String, u64)>,
    /// Number of links and other entries that are no regular files; they are left out.
    pub(super) skipped: usize,
}

impl Listing {
    /// Lists all regular files under a folder except hidden ones.
    pub(super) fn of(root: &Path) -> anyhow::Result<Self> {
        let full = root.canonicalize().with_context(|| root.display().to_string())?;
        let name = full.file_name().and_then(|n| n.to_str()).map(str::to_owned);
        let name = name.ok_or_else(|| Usage::error(format!("{} has no name", root.display())))?;
        let mut listing = Self { root: full, name, files: Vec::new(), skipped: 0 };
        listing.list_folder(&mut String::new())?;
        // By their names as bytes: no two systems list a folder in the same order.
        listing.files.sort_unstable();
        if listing.files.is_empty() {
            bail!(Usage::error(format!("there are no files in {}", root.display())));
        }
        Ok(listing)
    }

    /// Lists the files of a folder that its reader reads.
    pub(super) fn read_of(root: &Path, read: &FilesRead) -> anyhow::Result<Self> {
        let full = root.canonicalize().with_context(|| root.display().to_string())?;
        let within = full.join(&read.folder);
        let mut outside = Vec::new();
        let mut files = Vec::with_capacity(read.files.len());
        for name in &read.files {
            let path = within.join(name);
            let at = || path.display().to_string();
            // A link may lead to files that nobody means to send.
            if !path.canonicalize().with_context(at)?.starts_with(&full) {
                outside.push(name.as_str());
            }
            files.push((name.clone(), std::fs::metadata(&path).with_context(at)?.len()));
        }
        if let Some(first) = outside.first() {
            bail!(Usage::error(format!(
                "{} of its files are behind links that lead out of {} ({first}), and links are not followed: \
                 copy the folder with `cp -rL`, and push the copy",
                outside.len(),
                root.display(),
            )));
        }
        Ok(Self { root: within, name: read.name.clone(), files, skipped: 0 })
    }

    /// The files of a folder of masks: of a folder `mask` in it, if there is one, else its own, under
    /// that name.
    pub(super) fn of_masks(root: &Path) -> anyhow::Result<Self> {
        let inside = root.join("mask");
        let listing = Self::of(if inside.is_dir() { &inside } else { root })?;
        if !listing.root.starts_with(root.canonicalize()?) {
            bail!(Usage::error(format!(
                "{} is a link that leads out of {}, and links are not followed: name the folder with the masks itself",
                inside.display(),
                root.display(),
            )));
        }
        Ok(Self { name: "mask".to_owned(), ..listing })
    }

    /// Number of files.
    pub(super) fn len(&self) -> usize {
        self.files.len()
    }

    /// Sizes of the files together [bytes].
    pub(super) fn bytes(&self) -> u64 {
        self.files.iter().map(|(_, size)| size).sum()
    }

    fn list_folder(&mut self, prefix: &mut String) -> anyhow::Result<()> {
        let folder = self.root.join(prefix.as_str());
        let at = || folder.display().to_string();
        for entry in std::fs::read_dir(&folder).with_context(at)? {
            let entry = entry.with_context(at)?;
            let Ok(name) = entry.file_name().into_string() else {
                let name = entry.path().display().to_string();
                bail!(Usage::error(format!("{name}: the name is not UTF-8: rename it")));
            };
            if name.starts_with('.') || name == "__MACOSX" {
                continue;
            }
            let kind = entry.file_type().with_context(at)?;
            let length = prefix.len();
            prefix.push_str(&name);
            if kind.is_dir() {
                prefix.push('/');
                self.list_folder(prefix)?;
            } else if kind.is_file() {
                self.files.push((prefix.clone(), entry.metadata().with_context(at)?.len()));
            } else {
                self.skipped += 1;
            }
            prefix.truncate(length);
        }
        Ok(())
    }

    /// Writes the archive into a file, with a progress bar.
    pub(super) fn pack_to(&self, file: &Path, quiet: bool) -> anyhow::Result<()> {
        let bar = progress::byte_bar("packing", self.bytes(), quiet);
        let into = BufWriter::new(File::create(file)?);
        let packed = self.pack(into, |bytes| bar.set_position(bytes));
        bar.finish_and_clear();
        packed
    }

    /// Writes the archive; `packed` gets the number of bytes of files in it so far.
    pub(super) fn pack(&self, into: impl Write + Seek, packed: impl Fn(u64)) -> anyhow::Result<()> {
        let mut archive = ZipWriter::new(into);
        let (mut total, mut chunk) = (0, vec![0; CHUNK]);
        for (name, size) in &self.files {
            let path = self.root.join(name);
            let at = || path.display().to_string();
            let mut file = File::open(&path).with_context(at)?;
            let options = SimpleFileOptions::DEFAULT
                .compression_method(method(name))
                // Fast: the arrays of depth cameras shrink by a third at any level.
                .compression_level((method(name) == CompressionMethod::Deflated).then_some(1))
                .last_modified_time(zip::DateTime::default())
                .unix_permissions(0o644)
                .large_file(*size >= ZIP64_BYTES);
            archive.start_file(format!("{}/{name}", self.name), options).with_context(at)?;
            loop {
                let read = match file.read(&mut chunk) {
                    Ok(0) => break,
                    Ok(read) => read,
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                    Err(error) => return Err(error).with_context(at),
                };
                archive.write_all(&chunk[..read]).map_err(disk_error)?;
                total += read as u64;
                packed(total);
            }
        }
        archive.finish().map_err(io::Error::from).map_err(disk_error)?.flush().map_err(disk_error)
    }
}

fn method(name: &str) -> CompressionMethod {
    let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    let stored = COMPRESSED_EXTENSIONS.contains(&ending.as_str());
    if stored { CompressionMethod::Stored } else { CompressionMethod::Deflated }
}

fn disk_error(error: io::Error) -> anyhow::Error {
    anyhow::Error::from(error).context(
        "cannot write the archive to the folder of temporary files (TMPDIR names another one)",
    )
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use bendtwin_capture::{Limits, files_read, raw};
    use bendtwin_synth::{FilmOptions, Scene, film};

    use super::*;

    fn folder() -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        let case = root.path().join("rope");
        std::fs::create_dir_all(case.join("color/0")).unwrap();
        std::fs::create_dir_all(case.join(".git")).unwrap();
        for (name, content) in [
            ("metadata.json", "{}"),
            ("color/0/10.png", "png"),
            ("color/0/2.png", "png"),
            ("depth.npy", &"depth".repeat(100)),
            (".DS_Store", "x"),
            (".git/config", "x"),
        ] {
            std::fs::write(case.join(name), content).unwrap();
        }
        root
    }

    fn pack(root: &Path) -> (Listing, Vec<u8>) {
        let listing = Listing::of(&root.join("rope")).unwrap();
        let mut bytes = Cursor::new(Vec::new());
        listing.pack(&mut bytes, |_| ()).unwrap();
        (listing, bytes.into_inner())
    }

    #[test]
    fn the_same_files_are_the_same_bytes() {
        let (a, b) = (folder(), folder());
        let (listing, first) = pack(a.path());
        assert_eq!(listing.bytes(), 2 + 3 + 3 + 500);
        assert_eq!(first, pack(b.path()).1);
        let mut archive = zip::ZipArchive::new(Cursor::new(first)).unwrap();
        let names: Vec<_> = archive.file_names().map(|n| n.unwrap().into_owned()).collect();
        assert_eq!(
            names,
            ["rope/color/0/10.png", "rope/color/0/2.png", "rope/depth.npy", "rope/metadata.json"]
        );
        assert_eq!(archive.by_index(0).unwrap().compression(), CompressionMethod::Stored);
        let depth = archive.by_index(2).unwrap();
        assert_eq!(depth.compression(), CompressionMethod::Deflated);
        assert!(depth.compressed_size() < depth.size());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_left_out_and_counted() {
        let root = folder();
        std::os::unix::fs::symlink("/etc/hostname", root.path().join("rope/link")).unwrap();
        let (listing, bytes) = pack(root.path());
        assert_eq!(listing.skipped, 1);
        assert_eq!(zip::ZipArchive::new(Cursor::new(bytes)).unwrap().len(), 4);
    }

    /// What is behind a link may be no part of the recording.
    #[cfg(unix)]
    #[test]
    fn links_out_of_the_folder_are_refused_and_named() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let case = root.path().join("toy");
        let recording =
            film(Scene::Toy, &FilmOptions { frames: 3, ..FilmOptions::tiny(0) }).unwrap();
        raw::write_case(&recording, &case).unwrap();
        let push = || {
            let read = files_read(&case, &Limits::default()).unwrap();
            Listing::read_of(&case, &read).map(|listing| listing.len())
        };
        let whole = push().unwrap();
        // Inside the folder a link is another name.
        std::fs::rename(case.join("color/1"), case.join("second")).unwrap();
        symlink(case.join("second"), case.join("color/1")).unwrap();
        assert_eq!(push().unwrap(), whole);
        std::fs::rename(case.join("second"), root.path().join("elsewhere")).unwrap();
        std::fs::remove_file(case.join("color/1")).unwrap();
        symlink(root.path().join("elsewhere"), case.join("color/1")).unwrap();
        let error = push().unwrap_err();
        assert!(error.is::<Usage>());
        let text = error.to_string();
        assert!(
            text.contains("of its files are behind links") && text.contains("color/1/"),
            "{text}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn masks_behind_a_link_out_of_the_folder_are_refused() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let (case, private) = (root.path().join("toy"), root.path().join("private"));
        for folder in [&case, &private] {
            std::fs::create_dir(folder).unwrap();
        }
        std::fs::write(private.join("key"), "secret").unwrap();
        symlink(&private, case.join("mask")).unwrap();
        let error = Listing::of_masks(&case).err().unwrap();
        assert!(error.is::<Usage>() && error.to_string().contains("leads out of"), "{error}");
        // Inside the folder a link is another name, and the folder that is named may be one itself.
        std::fs::remove_file(case.join("mask")).unwrap();
        std::fs::create_dir(case.join("made")).unwrap();
        std::fs::write(case.join("made/0.png"), "png").unwrap();
        symlink(case.join("made"), case.join("mask")).unwrap();
        symlink(&case, root.path().join("other")).unwrap();
        for folder in [case, root.path().join("other")] {
            assert_eq!(Listing::of_masks(&folder).unwrap().len(), 1);
        }
    }

    /// Unread files are most of the folder of a PhysTwin case: here 8 MiB of 8.
    #[test]
    fn only_the_files_that_are_read_are_packed() {
        let root = tempfile::tempdir().unwrap();
        let case = root.path().join("different_types/toy");
        let recording =
            film(Scene::Toy, &FilmOptions { frames: 3, ..FilmOptions::tiny(0) }).unwrap();
        raw::write_case(&recording, &case).unwrap();
        std::fs::create_dir_all(case.join("pcd")).unwrap();
        for frame in 0..4 {
            std::fs::write(case.join(format!("pcd/{frame}.npz")), vec![7; 2 << 20]).unwrap();
        }
        std::fs::write(case.join("color/0.mp4"), vec![7; 1 << 20]).unwrap();
        let limits = Limits::default();
        let read = files_read(root.path(), &limits).unwrap();
        let listing = Listing::read_of(root.path(), &read).unwrap();
        let all = Listing::of(root.path()).unwrap();
        assert!(listing.bytes() * 20 < all.bytes(), "{} of {}", listing.bytes(), all.bytes());
        assert_eq!((listing.len(), all.len()), (all.len() - 5, all.len()));
        let archive = root.path().join("toy.zip");
        listing.pack(File::create(&archive).unwrap(), |_| ()).unwrap();
        assert!(archive.metadata().unwrap().len() < 1 << 20);
        // The same capture, and all of it.
        let [from_folder, from_archive] =
            [&case, &archive].map(|path| raw::open(path, &limits).unwrap());
        assert_eq!(from_archive.name, "toy");
        assert_eq!(from_archive.truth_tracks, from_folder.truth_tracks);
        for camera in 0..2 {
            let [mut a, mut b] =
                [&from_folder, &from_archive].map(|r| r.source.frames(camera).unwrap());
            assert_eq!(a.tracks().unwrap(), b.tracks().unwrap());
            for frame in 0..3 {
                assert_eq!(a.color(frame).unwrap(), b.color(frame).unwrap());
                assert_eq!(a.depth(frame).unwrap(), b.depth(frame).unwrap());
                for region in [raw::Region::Object, raw::Region::Manipulator] {
                    assert_eq!(a.mask(frame, region).unwrap(), b.mask(frame, region).unwrap());
                }
            }
        }
    }

    /// Images of a processed case are not read.
    #[test]
    fn a_processed_case_is_sent_without_its_images() {
        let root = tempfile::tempdir().unwrap();
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/capture/testdata/case");
        for file in ["final_data.pkl", "metadata.json", "split.json", "gt_track_3d.pkl"] {
            std::fs::copy(Path::new(data).join(file), root.path().join(file)).unwrap();
        }
        std::fs::create_dir_all(root.path().join("color/0")).unwrap();
        std::fs::write(root.path().join("color/0/0.png"), vec![7; 1 << 20]).unwrap();
        let read = files_read(root.path(), &Limits::default()).unwrap();
        assert_eq!(
            read.files,
            ["final_data.pkl", "gt_track_3d.pkl", "metadata.json", "split.json"]
        );
        assert_eq!(read.format, "a processed PhysTwin case (`final_data.pkl`)");
    }

    #[test]
    fn masks_are_packed_alone_and_under_their_name() {
        let root = tempfile::tempdir().unwrap();
        let case = root.path().join("rope");
        for name in ["mask/0/object/0.png", "mask/mask_info_0.json", "color/0/0.png"] {
            std::fs::create_dir_all(case.join(name).parent().unwrap()).unwrap();
            std::fs::write(case.join(name), name).unwrap();
        }
        let renamed = root.path().join("from_a_tool");
        std::fs::create_dir(&renamed).unwrap();
        std::fs::rename(case.join("mask"), renamed.join("mask")).unwrap();
        let inside = renamed.join("mask");
        for folder in [&renamed, &inside] {
            let mut bytes = Cursor::new(Vec::new());
            Listing::of_masks(folder).unwrap().pack(&mut bytes, |_| ()).unwrap();
            let archive = zip::ZipArchive::new(bytes).unwrap();
            let names: Vec<_> = archive.file_names().map(|n| n.unwrap().into_owned()).collect();
            assert_eq!(names, ["mask/0/object/0.png", "mask/mask_info_0.json"]);
        }
        let other = root.path().join("tool");
        std::fs::rename(&inside, &other).unwrap();
        let mut bytes = Cursor::new(Vec::new());
        Listing::of_masks(&other).unwrap().pack(&mut bytes, |_| ()).unwrap();
        let mut archive = zip::ZipArchive::new(bytes).unwrap();
        assert_eq!(archive.by_index(0).unwrap().name().unwrap(), "mask/0/object/0.png");
    }

    #[test]
    fn an_empty_folder_is_wrong_usage() {
        let root = tempfile::tempdir().unwrap();
        assert!(Listing::of(root.path()).is_err_and(|e| e.is::<Usage>()));
    }
}
