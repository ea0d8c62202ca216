//! Memory of a process as a budget: allocations that grow with a request are counted here before
//! they are made, and refused with the size that would fit.
//!
//! Callers take a [`Share`] and hold it for as long as the memory. Small and large shares have
//! separate pools, so that a large request that waits never blocks small ones.

mod held;
mod machine;
mod share;

use std::sync::Arc;

use tokio::sync::Semaphore;

pub use held::held;
pub use machine::machine_bytes;
pub use share::Share;

/// Unit of counting [bytes]; sizes are rounded up to it.
pub(crate) const PAGE: u64 = 4 << 10;
/// Largest share that counts as small [bytes].
pub const SMALL_BYTES: u64 = 1 << 20;
/// Divisor of the whole for the part that only small shares may take.
const SMALL_PART: u64 = 8;

/// A share that cannot be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Exhausted {
    /// Larger than the whole budget.
    #[error("{asked} bytes of memory are needed, and at most {most} are given to one request")]
    TooLarge {
        /// Bytes asked for.
        asked: u64,
        /// Largest share that is given.
        most: u64,
    },
    /// Others hold too much of it at present.
    #[error("{asked} bytes of memory are needed, and {free} of {most} are free at present")]
    InUse {
        /// Bytes asked for.
        asked: u64,
        /// Bytes that are free now.
        free: u64,
        /// Largest share that is given.
        most: u64,
    },
}

impl Exhausted {
    /// True if waiting may help.
    pub fn is_passing(&self) -> bool {
        matches!(self, Self::InUse { .. })
    }
}

/// A budget of memory. Clones share it.
#[derive(Clone, Debug)]
pub struct Budget {
    small: Arc<Semaphore>,
    large: Arc<Semaphore>,
    total: u64,
    most: u64,
}

impl Budget {
    /// A budget of `bytes`, at least 16 MiB.
    pub fn new(bytes: u64) -> Self {
        let pages = (bytes.max(16 << 20) / PAGE).min(Semaphore::MAX_PERMITS as u64);
        let small = pages / SMALL_PART;
        let large = pages - small;
        let pool = |pages: u64| Arc::new(Semaphore::new(usize::try_from(pages).unwrap_or(0)));
        Self { small: pool(small), large: pool(large), total: pages * PAGE, most: large * PAGE }
    }

    /// Bytes in all.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Largest share that is ever given [bytes].
    pub fn most(&self) -> u64 {
        self.most
    }

    /// Bytes in use.
    pub fn used(&self) -> u64 {
        let free = self.small.available_permits() + self.large.available_permits();
        self.total.saturating_sub(free as u64 * PAGE)
    }

    /// Takes a share without waiting.
    ///
    /// # Errors
    /// [`Exhausted`].
    pub fn try_take(&self, bytes: u64) -> Result<Share, Exhausted> {
        let pages = self.pages(bytes)?;
        self.take_now(bytes, pages).ok_or_else(|| self.in_use(bytes))
    }

    /// Takes a share, waiting in order of arrival behind others of its class. Bound the wait with a
    /// timeout.
    ///
    /// # Errors
    /// [`Exhausted::TooLarge`]; waiting would not help.
    pub async fn take(&self, bytes: u64) -> Result<Share, Exhausted> {
        let pages = self.pages(bytes)?;
        let pool = if bytes <= SMALL_BYTES {
            if let Some(share) = self.take_now(bytes, pages) {
                return Ok(share);
            }
            &self.small
        } else {
            &self.large
        };
        Share::wait(pool, pages).await.ok_or_else(|| self.in_use(bytes))
    }

    /// Small shares may come from either pool.
    fn take_now(&self, bytes: u64, pages: u32) -> Option<Share> {
        let small = || Share::try_new(&self.small, pages);
        let small = (bytes <= SMALL_BYTES).then(small).flatten();
        small.or_else(|| Share::try_new(&self.large, pages))
    }

    fn pages(&self, bytes: u64) -> Result<u32, Exhausted> {
        let too_large = Exhausted::TooLarge { asked: bytes, most: self.most };
        if bytes > self.most {
            return Err(too_large);
        }
        u32::try_from(bytes.div_ceil(PAGE)).map_err(|_| too_large)
    }

    fn in_use(&self, asked: u64) -> Exhausted {
        Exhausted::InUse { asked, free: self.total - self.used(), most: self.most }
    }
}

#[cfg(test)]
mod tests;
