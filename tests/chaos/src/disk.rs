//! A small disk for the data folder, which can be filled: a file system in memory.

use std::{
    fs::File,
    io::Write as _,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context as _, ensure};

/// Size of the disk [MiB].
const SIZE_MIB: u64 = 768;

/// A file system of limited size.
#[derive(Clone, Debug)]
pub(crate) struct Disk {
    folder: PathBuf,
}

impl Disk {
    /// Mounts it over a folder. In a mount namespace it goes with the process.
    pub(crate) fn mount(folder: &Path) -> anyhow::Result<Self> {
        let size = format!("size={SIZE_MIB}m");
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", &size, "chaos"]).arg(folder);
        let output = mount.output().context("mount")?;
        ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr).trim());
        Ok(Self { folder: folder.to_owned() })
    }

    fn ballast(&self) -> PathBuf {
        self.folder.join("ballast")
    }

    /// Fills it to the last byte; again, if something has become free.
    pub(crate) fn fill(&self) -> std::io::Result<()> {
        let mut ballast = File::options().create(true).append(true).open(self.ballast())?;
        for size in [1 << 20, 4 << 10, 1] {
            let piece = vec![0x5a; size];
            // The error is the end: there is no room left for a piece of this size.
            while ballast.write_all(&piece).is_ok() {}
        }
        Ok(())
    }

    /// Frees it.
    pub(crate) fn free(&self) -> std::io::Result<()> {
        match std::fs::remove_file(self.ballast()) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
            result => result,
        }
    }
}
