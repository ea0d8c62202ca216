//! Stable sorts of pairs of 32-bit numbers on the device: by eight bits at a time, the lowest
//! first, each pass by counting.

use bendtwin_engine::Error;

use crate::device::{
    args::{SplatHistogramArgs, SplatScanArgs, SplatScatterArgs},
    kernels,
    memory::Buffer,
    queue::Queue,
    specialization::THREADS,
};

/// Bits of a pass, and their values.
const DIGIT_BITS: u32 = 8;
const RADIX: usize = 1 << DIGIT_BITS;
/// Pairs of a block, as in `splat.cuh`.
const BLOCK: usize = 8 * THREADS as usize;

/// Keys and values, and as much again to sort them into.
pub(super) struct Pairs {
    pub(super) keys: [Buffer<u32>; 2],
    pub(super) values: [Buffer<u32>; 2],
}

/// Length of the histograms of a sort of `count` pairs.
pub(super) fn histogram_len(count: usize) -> usize {
    RADIX * count.div_ceil(BLOCK)
}

/// Sorts the first `count` pairs by the lowest `bits` of their keys; gives the half of the arrays
/// in which they are.
pub(super) fn sort(
    queue: &Queue,
    pairs: &Pairs,
    count: usize,
    bits: u32,
    histograms: &Buffer<u32>,
    total: &Buffer<u64>,
) -> Result<usize, Error> {
    let fits = |b: &Buffer<u32>| b.len() >= count;
    if !pairs.keys.iter().chain(&pairs.values).all(fits) || histograms.len() < histogram_len(count)
    {
        return Err(Error::Device("a sort behind the end of its arrays".into()));
    }
    let grid = queue.grid(count.div_ceil(BLOCK) as u32, 1, 1);
    let mut from = 0;
    for shift in (0..bits).step_by(DIGIT_BITS as usize) {
        let to = 1 - from;
        let histogram = SplatHistogramArgs {
            keys: pairs.keys[from].address(),
            counts: histograms.address(),
            count: count as u32,
            shift,
        };
        let scan = SplatScanArgs {
            values: histograms.address(),
            total: total.address(),
            count: histogram_len(count) as u32,
            pad: 0,
        };
        let scatter = SplatScatterArgs {
            keys: pairs.keys[from].address(),
            values: pairs.values[from].address(),
            sorted_keys: pairs.keys[to].address(),
            sorted_values: pairs.values[to].address(),
            offsets: histograms.address(),
            count: count as u32,
            shift,
        };
        // SAFETY: the lengths have been compared above; the queue has one stream.
        unsafe {
            kernels::splat_histogram(&grid, &histogram)?;
            kernels::splat_scan(&queue.grid(1, 1, 1), &scan)?;
            kernels::splat_scatter(&grid, &scatter)?;
        }
        from = to;
    }
    Ok(from)
}
