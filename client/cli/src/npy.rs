//! Arrays of numbers in .npy files, as numpy writes them.

use std::path::Path;

use anyhow::Context as _;
use npyz::{NpyFile, TypeChar, WriterBuilder as _};

use crate::failure::Usage;

/// A dense array in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<f32>,
}

/// Reads floating-point numbers of either width.
pub(crate) fn read(path: &Path) -> anyhow::Result<Array> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    parse(&bytes).map_err(|fault| Usage::error(format!("{}: {fault}", path.display())))
}

fn parse(bytes: &[u8]) -> Result<Array, String> {
    let file = NpyFile::new(bytes).map_err(|e| format!("is no .npy file ({e})"))?;
    if file.order() != npyz::Order::C {
        return Err("is in Fortran order: save it with numpy.ascontiguousarray".to_owned());
    }
    let element = match file.dtype() {
        npyz::DType::Plain(t) if t.type_char() == TypeChar::Float => t.size_field(),
        _ => 0,
    };
    let shape: Vec<usize> = file.shape().iter().map(|d| *d as usize).collect();
    // The header's claim is checked against the bytes present before anything is allocated.
    let claimed = shape.iter().try_fold(element as usize, |p, d| p.checked_mul(*d));
    if claimed.is_none_or(|claimed| claimed > bytes.len()) {
        return Err(format!("claims shape {shape:?} but has {} bytes", bytes.len()));
    }
    let damaged = |e: std::io::Error| format!("is damaged ({e})");
    let values = match element {
        4 => file.into_vec::<f32>().map_err(damaged)?,
        8 => {
            let wide = file.into_vec::<f64>().map_err(damaged)?;
            wide.into_iter().map(|v| v as f32).collect()
        }
        _ => return Err("must hold 32- or 64-bit floating-point numbers".to_owned()),
    };
    Ok(Array { shape, values })
}

/// Writes 32-bit numbers.
pub(crate) fn write(path: &Path, array: &Array) -> anyhow::Result<()> {
    let write = || -> std::io::Result<()> {
        let shape: Vec<u64> = array.shape.iter().map(|d| *d as u64).collect();
        let file = std::io::BufWriter::new(std::fs::File::create(path)?);
        let mut writer =
            npyz::WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd()?;
        writer.extend(array.values.iter())?;
        writer.finish()
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_survive_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        let array = Array { shape: vec![2, 1, 3], values: vec![1.0, 2.0, 3.0, -4.0, 5.5, 6.0] };
        write(&path, &array).unwrap();
        assert_eq!(read(&path).unwrap(), array);
    }

    #[test]
    fn claims_beyond_the_bytes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        write(&path, &Array { shape: vec![4], values: vec![0.0; 4] }).unwrap();
        let text = std::fs::read(&path).unwrap();
        let huge: Vec<u8> = String::from_utf8_lossy(&text).replace("(4,)", "(9999999999,)").into();
        assert!(parse(&huge).is_err());
        assert!(parse(b"nonsense").is_err());
    }
}
