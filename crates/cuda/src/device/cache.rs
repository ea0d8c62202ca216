//! Compiled kernels on disk, so that only the first start of a version on a machine compiles.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

use bendtwin_engine::Error;

use super::{
    compile,
    specialization::{Specialization, options},
};

/// Store of compiled kernels; without a folder everything is compiled again.
#[derive(Debug)]
pub(crate) struct Cache {
    folder: Option<PathBuf>,
    architecture: u32,
    version: (i32, i32),
}

impl Cache {
    /// The store for an architecture; in `folder`, or in the user's cache directory.
    pub(crate) fn new(folder: Option<&Path>, architecture: u32) -> Result<Self, Error> {
        let folder = folder.map(Path::to_path_buf).or_else(user_folder);
        Ok(Self { folder, architecture, version: compile::version()? })
    }

    /// The machine code of a kernel.
    pub(crate) fn cubin(&self, specialization: &Specialization) -> Result<Vec<u8>, Error> {
        let (source, options) = (specialization.text(), options(self.architecture));
        let mut hasher = blake3::Hasher::new();
        hasher.update(source.as_bytes());
        for option in &options {
            hasher.update(option.as_bytes());
        }
        let (major, minor) = self.version;
        hasher.update(format!("NVRTC {major}.{minor}").as_bytes());
        let name = format!("{}.cubin", hasher.finalize().to_hex());
        let path = self.folder.as_ref().map(|f| f.join(name));
        if let Some(kept) = path.as_deref().and_then(read) {
            return Ok(kept);
        }
        let began = std::time::Instant::now();
        let cubin = compile::compile(&source, &options)?;
        tracing::debug!(
            ?specialization,
            seconds = began.elapsed().as_secs_f32(),
            "kernel compiled"
        );
        if let Some(path) = path
            && let Err(error) = write(&path, &cubin)
        {
            tracing::debug!(%error, path = %path.display(), "a compiled kernel could not be kept");
        }
        Ok(cubin)
    }
}

/// A file that was written to its end: the digest behind the code says so.
fn read(path: &Path) -> Option<Vec<u8>> {
    let mut bytes = fs::read(path).ok()?;
    let digest = bytes.split_off(bytes.len().checked_sub(blake3::OUT_LEN)?);
    (blake3::hash(&bytes).as_bytes() == digest.as_slice()).then_some(bytes)
}

/// Under another name first, so that workers that start together see whole files.
fn write(path: &Path, cubin: &[u8]) -> std::io::Result<()> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let partial = path.with_extension(format!("{}-{count}", std::process::id()));
    fs::write(&partial, [cubin, blake3::hash(cubin).as_bytes()].concat())?;
    fs::rename(&partial, path)
}

fn user_folder() -> Option<PathBuf> {
    let home = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let base = home("XDG_CACHE_HOME").or_else(|| Some(home("HOME")?.join(".cache")))?;
    Some(base.join("bendtwin").join("kernels"))
}

#[cfg(test)]
mod tests;
