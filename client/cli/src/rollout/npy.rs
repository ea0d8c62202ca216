//! Arrays of numbers in .npy files, as numpy writes them.

use std::path::Path;

use anyhow::Context as _;
use bendtwin_capture::{Limits, npy::Floats};

use crate::failure;

/// Reads 32- or 64-bit floats.
pub(crate) fn read(path: &Path) -> anyhow::Result<Floats> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {name}"))?;
    Floats::decode(&name, &bytes, &Limits::default())
        .map_err(|e| failure::Usage::error(e.to_string()))
}

/// Writes 32-bit floats.
pub(crate) fn write(path: &Path, array: &Floats) -> anyhow::Result<()> {
    std::fs::write(path, array.encode()).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_survive_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        let array = Floats { shape: vec![2, 1, 3], values: vec![1.0, 2.0, 3.0, -4.0, 5.5, 6.0] };
        write(&path, &array).unwrap();
        assert_eq!(read(&path).unwrap(), array);
    }

    #[test]
    fn claims_beyond_the_bytes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        let mut file = Floats { shape: vec![4], values: vec![0.0; 4] }.encode();
        let extent = file.windows(4).position(|w| w == b"(4,)").unwrap() + 1;
        file[extent] = b'9';
        std::fs::write(&path, file).unwrap();
        assert!(read(&path).is_err());
        std::fs::write(&path, "nonsense").unwrap();
        assert!(read(&path).is_err());
    }
}
