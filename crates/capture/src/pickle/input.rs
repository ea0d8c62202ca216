//! Remainder of a pickle's bytes. Every length is checked against it.

use super::machine::Fault;

const CUT: Fault = Fault::Damaged("it ends before its end");

pub(super) struct Input<'a>(pub(super) &'a [u8]);

impl<'a> Input<'a> {
    /// The next `n` bytes.
    pub(super) fn take(&mut self, n: u64) -> Result<&'a [u8], Fault> {
        let n = usize::try_from(n).map_err(|_| CUT)?;
        let (taken, rest) = self.0.split_at_checked(n).ok_or(CUT)?;
        self.0 = rest;
        Ok(taken)
    }

    /// The next byte.
    pub(super) fn byte(&mut self) -> Result<u8, Fault> {
        let (first, rest) = self.0.split_first().ok_or(CUT)?;
        self.0 = rest;
        Ok(*first)
    }

    /// A little-endian number of `n` bytes.
    pub(super) fn unsigned(&mut self, n: u64) -> Result<u64, Fault> {
        Ok(self.take(n)?.iter().rev().fold(0, |x, b| (x << 8) | u64::from(*b)))
    }

    /// Bytes behind their own length of `n` bytes.
    pub(super) fn prefixed(&mut self, n: u64) -> Result<&'a [u8], Fault> {
        let len = self.unsigned(n)?;
        self.take(len)
    }

    /// Text up to a line's end, as protocols below 4 name globals.
    pub(super) fn line(&mut self) -> Result<&'a str, Fault> {
        let line = self.line_bytes()?;
        std::str::from_utf8(line).map_err(|_| Fault::Damaged("a name in it is no text"))
    }

    /// Bytes up to a line's end.
    pub(super) fn line_bytes(&mut self) -> Result<&'a [u8], Fault> {
        let end = self.0.iter().position(|b| *b == b'\n').ok_or(CUT)?;
        let line = self.take(end as u64)?;
        self.byte()?;
        Ok(line)
    }
}
