//! Protocol buffers, as far as Foxglove's messages need them: fields by number, unknown ones passed
//! over.

/// A field's content.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

/// The fields of a message, in the order in which they were written. Ends at damage.
pub(super) struct Message<'a>(pub(super) &'a [u8]);

impl<'a> Iterator for Message<'a> {
    type Item = (u64, Value<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        let tag = self.varint()?;
        let value = match tag & 7 {
            0 => Value::Number(self.varint()?),
            1 => Value::Number(u64::from_le_bytes(*self.fixed()?)),
            2 => {
                let length = usize::try_from(self.varint()?).ok()?;
                let (bytes, rest) = self.0.split_at_checked(length)?;
                self.0 = rest;
                Value::Bytes(bytes)
            }
            5 => Value::Number(u64::from(u32::from_le_bytes(*self.fixed()?))),
            _ => return None,
        };
        Some((tag >> 3, value))
    }
}

impl<'a> Message<'a> {
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let (&byte, rest) = self.0.split_first()?;
            self.0 = rest;
            value |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    fn fixed<const N: usize>(&mut self) -> Option<&'a [u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(bytes)
    }
}

impl<'a> Value<'a> {
    pub(super) fn number(self) -> Option<u64> {
        match self {
            Self::Number(n) => Some(n),
            Self::Bytes(_) => None,
        }
    }

    pub(super) fn bytes(self) -> Option<&'a [u8]> {
        match self {
            Self::Bytes(bytes) => Some(bytes),
            Self::Number(_) => None,
        }
    }

    pub(super) fn text(self) -> Option<String> {
        self.bytes().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }

    /// A `google.protobuf.Timestamp` in nanoseconds.
    pub(super) fn stamp_ns(self) -> Option<i64> {
        let mut ns = 0_i64;
        for (field, value) in Message(self.bytes()?) {
            let part = value.number()?.cast_signed();
            match field {
                1 => ns = ns.checked_add(part.checked_mul(1_000_000_000)?)?,
                2 => ns = ns.checked_add(part)?,
                _ => {}
            }
        }
        Some(ns)
    }

    /// Appends doubles: one, or many packed together.
    pub(super) fn doubles(self, into: &mut Vec<f64>) {
        match self {
            Self::Number(bits) => into.push(f64::from_bits(bits)),
            Self::Bytes(bytes) => {
                into.extend(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)));
            }
        }
    }

    /// The numbered double fields of a vector or quaternion, absent ones 0.
    pub(super) fn vector<const N: usize>(self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for (field, value) in Message(self.bytes()?) {
            let place = usize::try_from(field).ok().and_then(|n| values.get_mut(n.checked_sub(1)?));
            if let Some(place) = place {
                *place = f64::from_bits(value.number()?);
            }
        }
        Some(values)
    }
}
