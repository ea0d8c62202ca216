//! The binary form of a model, little-endian. Counts are checked against the bytes that follow before
//! anything is allocated.

use super::model::{ModelCamera, ModelImage, ModelPoint, parameter_count};

/// Longest file name of an image.
const MAX_NAME: usize = 1024;

struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (head, rest) = self.0.split_first_chunk::<N>().ok_or("it ends early")?;
        self.0 = rest;
        Ok(*head)
    }

    fn skip(&mut self, count: usize) -> Result<(), String> {
        self.0 = self.0.get(count..).ok_or("it ends early")?;
        Ok(())
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.take().map(u64::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.take().map(u32::from_le_bytes)
    }

    fn number(&mut self) -> Result<f64, String> {
        let number = f64::from_le_bytes(self.take()?);
        if number.is_finite() { Ok(number) } else { Err(format!("a number is {number}")) }
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Ok(numbers)
    }

    /// A count of entries of at least `each` bytes.
    fn count(&mut self, each: usize) -> Result<usize, String> {
        let count = self.u64()?;
        let room = (self.0.len() / each) as u64;
        if count > room {
            return Err(format!(
                "it says that {count} entries follow, and there is room for {room}"
            ));
        }
        Ok(count as usize)
    }

    fn name(&mut self) -> Result<String, String> {
        let end = self.0.iter().take(MAX_NAME).position(|byte| *byte == 0);
        let end = end.ok_or("a file name does not end")?;
        let name: &'a [u8] = &self.0[..end];
        self.0 = &self.0[end + 1..];
        Ok(String::from_utf8_lossy(name).into_owned())
    }
}

pub(super) fn cameras(bytes: &[u8]) -> Result<Vec<ModelCamera>, String> {
    let mut bytes = Bytes(bytes);
    let count = bytes.count(48)?;
    let mut cameras = Vec::with_capacity(count);
    for _ in 0..count {
        let id = bytes.u32()?;
        let kind = bytes.u32()? as i32;
        let size = [bytes.u64()?, bytes.u64()?];
        let mut parameters = Vec::new();
        for _ in 0..parameter_count(kind)? {
            parameters.push(bytes.number()?);
        }
        cameras.push(ModelCamera { id, kind, size, parameters });
    }
    Ok(cameras)
}

pub(super) fn images(bytes: &[u8]) -> Result<Vec<ModelImage>, String> {
    let mut bytes = Bytes(bytes);
    let count = bytes.count(73)?;
    let mut images = Vec::with_capacity(count);
    for _ in 0..count {
        bytes.u32()?;
        let (rotation, translation) = (bytes.numbers()?, bytes.numbers()?);
        let camera = bytes.u32()?;
        let name = bytes.name()?;
        let seen = bytes.count(24)?;
        let mut points = Vec::new();
        for _ in 0..seen {
            bytes.skip(16)?;
            let point = bytes.u64()?;
            // All bits are set where no point was found.
            if point != u64::MAX {
                points.push(point);
            }
        }
        images.push(ModelImage { rotation, translation, camera, name, points });
    }
    Ok(images)
}

pub(super) fn points(bytes: &[u8]) -> Result<Vec<ModelPoint>, String> {
    let mut bytes = Bytes(bytes);
    let count = bytes.count(51)?;
    let mut points = Vec::with_capacity(count);
    for _ in 0..count {
        let id = bytes.u64()?;
        let at = bytes.numbers()?;
        bytes.skip(11)?;
        let track = bytes.count(8)?;
        bytes.skip(8 * track)?;
        points.push(ModelPoint { id, at });
    }
    points.sort_by_key(|point| point.id);
    Ok(points)
}
