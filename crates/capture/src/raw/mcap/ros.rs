//! ROS messages: CDR as ROS 2 writes them, and the plain serialisation of ROS 1.

/// A message read field by field, in the order of its definition.
pub(super) struct Ros<'a> {
    bytes: &'a [u8],
    position: usize,
    /// CDR aligns numbers to their size and ends texts with a zero.
    cdr: bool,
    big_endian: bool,
}

/// Time and frame of a message.
pub(super) struct Header {
    /// Nanoseconds.
    pub(super) stamp_ns: i64,
    pub(super) frame_id: String,
}

impl<'a> Ros<'a> {
    /// A ROS 1 message.
    pub(super) fn one(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0, cdr: false, big_endian: false }
    }

    /// A ROS 2 message: four bytes say how it is encoded.
    pub(super) fn two(bytes: &'a [u8]) -> Option<Self> {
        let (head, bytes) = bytes.split_first_chunk::<4>()?;
        // Plain CDR; ROS 2 uses no other form.
        match head[1] {
            0 | 1 => Some(Self { bytes, position: 0, cdr: true, big_endian: head[1] == 0 }),
            _ => None,
        }
    }

    fn number(&mut self, size: usize) -> Option<u64> {
        if self.cdr {
            self.position = self.position.checked_next_multiple_of(size)?;
        }
        let end = self.position.checked_add(size)?;
        let bytes = self.bytes.get(self.position..end)?;
        self.position = end;
        let join = |n: u64, b: &u8| (n << 8) | u64::from(*b);
        Some(if self.big_endian {
            bytes.iter().fold(0, join)
        } else {
            bytes.iter().rev().fold(0, join)
        })
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.number(1).map(|n| n as u8)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.number(4).map(|n| n as u32)
    }

    pub(super) fn f64(&mut self) -> Option<f64> {
        self.number(8).map(f64::from_bits)
    }

    pub(super) fn f64s<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Some(values)
    }

    /// A sequence of at most `most` numbers.
    pub(super) fn doubles(&mut self, most: usize) -> Option<Vec<f64>> {
        let count = self.u32()? as usize;
        if count > most {
            return None;
        }
        (0..count).map(|_| self.f64()).collect()
    }

    pub(super) fn text(&mut self) -> Option<String> {
        let bytes = self.data()?;
        let bytes = if self.cdr { bytes.strip_suffix(&[0]).unwrap_or(bytes) } else { bytes };
        Some(String::from_utf8_lossy(bytes).into_owned())
    }

    /// A sequence of bytes.
    pub(super) fn data(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()? as usize;
        let end = self.position.checked_add(length)?;
        let bytes = self.bytes.get(self.position..end)?;
        self.position = end;
        Some(bytes)
    }

    /// `std_msgs/Header`.
    pub(super) fn header(&mut self) -> Option<Header> {
        if !self.cdr {
            // ROS 1 counts messages.
            self.u32()?;
        }
        let seconds = self.u32()?;
        let seconds = if self.cdr { i64::from(seconds.cast_signed()) } else { i64::from(seconds) };
        let nanos = i64::from(self.u32()?);
        Some(Header { stamp_ns: seconds * 1_000_000_000 + nanos, frame_id: self.text()? })
    }
}
