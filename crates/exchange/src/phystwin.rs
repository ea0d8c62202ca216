//! PhysTwin's results as twins whose rollouts are those of PhysTwin's model.
//!
//! A result names no springs; they follow from the points of the case and the radii of the search
//! ([`springs`]). The model is the engine's own without bending: a twin says by its environment,
//! timing and control velocity how PhysTwin's differs from a default fit. Gravity is 9.8 m/s², a
//! substep 5e-5 s, of which a frame takes a whole number, so that its frames are not quite those of
//! the recording; control points have no velocity.

mod springs;

use bendtwin_capture::phystwin::results::{SearchResult, TrainResult};
use bendtwin_core::{
    BUILD, Capture, Contact, Environment, Graph, NodeKind, Params, Plane, Point, Timing, Twin,
    environment::ControlVelocity, params::MAX_SPRING_STIFFNESS, twin::Provenance,
};

use self::springs::Springs;
use crate::Error;

/// Gravity of PhysTwin's world [m/s²].
const GRAVITY: f32 = 9.8;
/// Length of PhysTwin's substeps [s].
const DT_S: f64 = 5e-5;

/// The twin of a case's results: of its search alone, or with the springs that its training left.
///
/// # Errors
/// If there are several cases, the case has points that are not finite, or the training is that of other springs.
pub fn of_phystwin(
    capture: &Capture,
    search: &SearchResult,
    train: Option<&TrainResult>,
) -> Result<Twin, Error> {
    if !capture.others.is_empty() {
        return Err(Error::SeveralCases(1 + capture.others.len()));
    }
    let sequence = capture.sequences.first();
    let observed = sequence.map_or(&[][..], |s| s.points_at(0));
    let control_rest = sequence.map_or(&[][..], |s| s.controls_at(0)).to_vec();
    let kinds = [
        (observed, NodeKind::Observed),
        (&capture.object.completed_surface, NodeKind::Completed),
        (&capture.object.interior, NodeKind::Interior),
    ];
    let rest_positions: Vec<Point> =
        kinds.iter().flat_map(|(points, _)| *points).copied().collect();
    let all = rest_positions.iter().chain(&control_rest);
    if let Some(point) = all.clone().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(Error::PointMissing { point });
    }
    let n = rest_positions.len();
    let Springs { ends, lengths, object_count } =
        Springs::of(&rest_positions, &control_rest, search);
    if let Some(train) = train {
        let found = [train.stiffness.len(), train.object_spring_count.unwrap_or(object_count)];
        if found != [ends.len(), object_count] {
            let needed = [ends.len(), object_count];
            return Err(Error::OtherSprings { found, needed });
        }
    }
    let graph = Graph {
        kinds: kinds.iter().flat_map(|(p, kind)| std::iter::repeat_n(*kind, p.len())).collect(),
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n)
            .map(|i| if i < observed.len() { i as u32 } else { Graph::NOT_OBSERVED })
            .collect(),
        rest_positions,
        control_rest,
        springs: ends,
        ..Graph::default()
    };
    let substeps = (1.0 / (capture.fps * DT_S)).round().clamp(1.0, 1e5);
    let twin = Twin {
        environment: Environment {
            gravity: [0.0, 0.0, -GRAVITY],
            ground: Some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 }),
        },
        control_velocity: ControlVelocity::Ignored,
        provenance: Provenance {
            capture_digest: bendtwin_capture::digest(capture),
            capture_name: capture.name.clone(),
            build: BUILD.to_owned(),
            backend: "phystwin".to_owned(),
            source_to_world: capture.source_to_world,
            ..Provenance::default()
        },
        ..Twin::new(
            graph,
            params(search, train, lengths),
            Timing { fps: 1.0 / (substeps * DT_S), substeps: substeps as u32 },
        )
    };
    twin.check()?;
    Ok(twin)
}

fn params(search: &SearchResult, train: Option<&TrainResult>, rest_lengths_m: Vec<f32>) -> Params {
    let count = rest_lengths_m.len();
    let stiffness =
        train.map_or_else(|| vec![search.stiffness as f32; count], |t| t.stiffness.clone());
    // Its training reads the search's result into a configuration, which holds these two as
    // integers and cuts off what they have behind the point; the search itself does not.
    let cut = |x: f64| if train.is_some() { x.trunc() as f32 } else { x as f32 };
    let contact = train.map_or(search.contact, |t| t.contact);
    let [ground_restitution, object_restitution] =
        [contact.ground, contact.object].map(|c| c[0].clamp(0.0, 1.0) as f32);
    let [ground_friction, object_friction] =
        [contact.ground, contact.object].map(|c| c[1].clamp(0.0, 2.0) as f32);
    Params {
        spring_stiffness: stiffness.iter().map(|k| k.clamp(0.0, MAX_SPRING_STIFFNESS)).collect(),
        spring_dashpot: vec![cut(search.dashpot); count],
        rest_lengths_m,
        drag: cut(search.drag),
        contact: Contact {
            ground_restitution,
            ground_friction,
            object_restitution,
            object_friction,
            collision_distance_m: search.collision_distance_m as f32,
            ..Contact::default()
        },
        ..Params::default()
    }
}

#[cfg(test)]
mod tests;
