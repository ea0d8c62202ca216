//! Evaluations: the predictions of a twin beside a recording, as a fit scores its own.

use bendtwin_core::{CancelToken, Capture, Point, Quality, Twin};
use bendtwin_engine::Backend;
use bendtwin_eval::{
    EvaluateOptions, Motion, Scale, assess, evaluate, evaluate_with_motion, is_own_capture,
};
use bendtwin_proto::v1::{PredictedMotion, Tensor};

use crate::{error::Error, twin::warm::Warm};

/// Most bytes of the positions of a motion.
const MOTION_BYTES: usize = 16 << 20;

/// Takes over how the renderings of a twin looked beside its own recording when it was fitted: images
/// are not at hand.
fn keep_rendered(quality: &mut Quality, twin: &Twin, recording: &Capture) {
    if is_own_capture(twin, recording) {
        for row in &mut quality.scores {
            let own = twin.quality.score(row.predictor);
            row.rendered = own.and_then(|score| score.rendered.clone());
        }
    }
}

/// The quality table of a twin on a recording, as JSON, and the predicted motion of the sequence that
/// is asked for by its number.
///
/// # Errors
/// If there is no such sequence, the twin cannot be evaluated on the recording, or the backend fails.
pub fn evaluate_twin(
    warm: &Warm,
    recording: &Capture,
    sequence: Option<u32>,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<(String, Option<PredictedMotion>), Error> {
    let there: usize = recording.recordings().map(|r| r.sequences.len()).sum();
    if let Some(index) = sequence.filter(|index| *index as usize >= there) {
        let fault = format!("is {index}, but the capture has {there}, counted from 0");
        return Err(Error::field("motion.sequence", fault));
    }
    let (twin, options) = (&warm.twin, EvaluateOptions::default());
    let (mut quality, motion) = match sequence {
        None => (evaluate(backend, twin, recording, &options, cancel)?, None),
        Some(index) => {
            let at = index as usize;
            let (quality, motion) =
                evaluate_with_motion(backend, twin, recording, &options, at, cancel)?;
            (quality, motion.map(|motion| packed(index, &motion)))
        }
    };
    keep_rendered(&mut quality, twin, recording);
    let scale = Scale::of_nodes(&twin.graph.rest_positions, &twin.graph.rods);
    quality.assessment = Some(assess(&quality, scale));
    let quality =
        serde_json::to_string(&quality).map_err(|e| Error::field("quality", e.to_string()))?;
    Ok((quality, motion))
}

/// A motion as a message, with as many frames as fit.
fn packed(index: u32, motion: &Motion) -> PredictedMotion {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let prediction = &motion.prediction;
    let nodes = prediction.node_count;
    let every = (size_of_val(prediction.positions.as_slice()).div_ceil(MOTION_BYTES)).max(1);
    let kept: Vec<Point> =
        prediction.positions.chunks(nodes.max(1)).step_by(every).flatten().copied().collect();
    let rows = kept.len().checked_div(nodes).unwrap_or(0);
    let errors = |of: fn(&bendtwin_core::quality::ErrorSummary) -> Option<f64>| {
        let metres = motion.errors.iter().map(|e| of(e).map_or(f32::NAN, |m| m as f32));
        Some(Tensor::pack(&[motion.errors.len()], &metres.collect::<Vec<f32>>()))
    };
    PredictedMotion {
        sequence: index,
        recording: motion.recording.clone(),
        name: motion.sequence.clone(),
        fps: motion.fps,
        frame_count: count(motion.frame_count),
        start_frame: count(prediction.start_frame),
        train_frame_count: count(motion.train_frame_count),
        every_frames: count(every),
        positions: Some(Tensor::pack_points(&[rows, nodes], &kept)),
        track_m: errors(|e| e.track_m),
        chamfer_l1_m: errors(|e| e.chamfer_l1_m),
    }
}

#[cfg(test)]
mod tests {
    use bendtwin_core::quality::ErrorSummary;
    use bendtwin_eval::Trajectory;

    use super::*;

    #[test]
    fn long_motions_have_rows_of_some_frames() {
        let nodes = 2_000;
        let motion = |frames: usize| Motion {
            recording: "r".to_owned(),
            sequence: "s".to_owned(),
            fps: 30.0,
            frame_count: frames,
            train_frame_count: 3,
            prediction: Trajectory {
                start_frame: 0,
                node_count: nodes,
                positions: (0..frames).flat_map(|f| vec![[f as f32; 3]; nodes]).collect(),
                diverged: None,
            },
            errors: vec![ErrorSummary { track_m: Some(0.5), ..Default::default() }; frames],
        };
        let short = packed(1, &motion(10));
        assert_eq!((short.every_frames, short.sequence), (1, 1));
        assert_eq!(short.positions.unwrap().shape, [10, 2_000, 3]);
        let long = packed(0, &motion(1_001));
        let (shape, points) = long.positions.unwrap().unpack_points("p").unwrap();
        assert_eq!((long.every_frames, &shape[..2]), (2, &[501, nodes][..]));
        assert_eq!(points[nodes], [2.0; 3]);
        assert_eq!(long.track_m.unwrap().shape, [1_001]);
        let chamfer: Vec<f32> = long.chamfer_l1_m.unwrap().unpack("c").unwrap().1;
        assert!(chamfer.iter().all(|m| m.is_nan()));
    }
}
