use bendtwin_core::{FitSettings, settings::DeviceKind};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;

fn settings(starts: u32, held_back: f64) -> FitSettings {
    let mut settings = FitSettings::default();
    settings.search.starts = Some(starts);
    settings.search.held_back = held_back;
    settings
}

#[test]
fn a_single_start_and_too_few_frames_leave_no_choice() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    for (starts, held_back, expected) in [(1, 0.4, false), (2, 0.0, false), (2, 0.4, true)] {
        let task = Task::new(
            &capture,
            &settings(starts, held_back),
            DeviceKind::Cpu,
            &CancelToken::default(),
        )
        .unwrap();
        assert_eq!(Validation::new(&task).is_some(), expected, "{starts} starts, {held_back}");
    }
    let mut short = capture;
    short.sequences[0].train_frame_count = 2 * LEAST_FRAMES;
    let task =
        Task::new(&short, &settings(2, 0.4), DeviceKind::Cpu, &CancelToken::default()).unwrap();
    assert!(Validation::new(&task).is_none());
}

#[test]
fn starts_see_nothing_of_the_frames_held_back() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let task =
        Task::new(&capture, &settings(2, 0.4), DeviceKind::Cpu, &CancelToken::default()).unwrap();
    let validation = Validation::new(&task).unwrap();
    let (all, kept) = (&task.training[0], &validation.shorter.training[0]);
    assert_eq!(all.frames, kept.frames + validation.frames as usize);
    let last = |objective: &Objective| objective.terms.iter().map(|t| t.frame).max();
    assert_eq!(last(&kept.objective), Some(kept.frames));
    assert!(validation.shorter.search_set().iter().all(|t| t.frames == kept.frames));

    let held_back = &validation.objectives[0];
    assert!(held_back.terms.iter().all(|t| t.frame > kept.frames && t.frame <= all.frames));
    // Both losses are means over their frames.
    let last = all.objective.terms.len() - held_back.terms.len();
    let frames = (all.frames as f32, validation.frames as f32);
    for (one, of_all) in held_back.terms.iter().zip(&all.objective.terms[last..]) {
        assert_eq!((one.frame, &one.term), (of_all.frame, &of_all.term));
        assert!((one.weight * frames.1 - of_all.weight * frames.0).abs() < 1e-5);
    }
}
