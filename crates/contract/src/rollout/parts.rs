//! Parts that a reply comes in.

use bendtwin_proto::v1::RollOutRequest;

use super::Batch;

/// Instances of one part of a streamed reply.
pub const STREAMED_PART: u32 = 16;

/// Instances of one part of the reply to a request; 0 means that it comes in one part. `best` ranks
/// the whole batch, so such a reply is never divided.
pub fn part_instances(request: &RollOutRequest, streamed: bool) -> u32 {
    let ranked = request.returns.as_ref().is_some_and(|r| r.best > 0);
    if streamed && !ranked { STREAMED_PART } else { 0 }
}

/// Frames of one part of the reply to a checked request: all of them unless it is divided in time.
pub fn part_frames(request: &RollOutRequest, batch: &Batch) -> u64 {
    match request.returns.as_ref().map_or(0, |returns| returns.part_frames) {
        0 => batch.frames,
        frames => u64::from(frames).min(batch.frames),
    }
}
