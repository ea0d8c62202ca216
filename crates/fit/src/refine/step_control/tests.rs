use super::*;

#[test]
fn gradients_reach_less_and_less_until_a_frame_is_left() {
    let ladder = |from: u32| -> Vec<u32> {
        std::iter::successors(Some(from), |&reach| shorter_reach(reach)).skip(1).collect()
    };
    assert_eq!(ladder(0), [16, 4, 1]);
    assert_eq!(ladder(1_000_000), [16, 4, 1]);
    assert_eq!(ladder(16), [4, 1]);
    assert_eq!(ladder(7), [1]);
    assert_eq!(ladder(2), [1]);
    assert!(ladder(1).is_empty());
}

#[test]
fn the_rate_warms_up_and_falls_where_passes_have_several_steps() {
    let step_control = StepControl::new(0);
    let parts = |passes| Schedule::Parts { passes };
    let rates: Vec<f64> = (0..10).map(|steps| step_control.rate(parts(100), 0, steps)).collect();
    assert!(rates.is_sorted() && rates[0] > 0.0 && rates[0] < 0.2, "{rates:?}");
    assert_eq!(rates[9], 1.0);
    assert!((step_control.rate(parts(100), 100, 100) - FINAL_RATE).abs() < 1e-12);
    assert!(step_control.rate(parts(0), 0, 0).is_finite());
    assert_eq!(step_control.rate(Schedule::Whole, 100, 100), 1.0, "it falls by rollbacks alone");
}

#[test]
fn a_run_ends_when_passes_gain_next_to_nothing() {
    let passes_until_end = |gain: f64| -> Option<i32> {
        let mut step_control = StepControl::new(0);
        (0..200).find(|pass| step_control.has_ended((1.0 - gain).powi(*pass)))
    };
    assert_eq!(passes_until_end(1e-3), None, "four percent in forty passes");
    assert_eq!(passes_until_end(1e-4), Some(IDLE_PASSES as i32));
}

#[test]
fn a_gradient_out_of_the_usual_is_shortened() {
    let mut step_control = StepControl::new(0);
    assert!((0..20).all(|_| step_control.clip_factor(2.0) == 1.0));
    assert_eq!(step_control.clip_factor(600.0), 0.01);
    assert_eq!(step_control.clip_factor(1.0), 1.0);
    let grows: Vec<f64> = (0..20).map(|_| step_control.clip_factor(600.0)).collect();
    assert_eq!(grows[19], 1.0, "what lasts is usual");
    assert!(StepControl::new(0).clip_factor(0.0) == 1.0);
}

#[test]
fn failures_halve_the_rate_and_cut_the_reach_by_turns() {
    let mut step_control = StepControl::new(0);
    let parts = |passes| Schedule::Parts { passes };
    for _ in 0..MIN_PATIENCE - 1 {
        assert_eq!(step_control.record_no_gain(parts(40)), None);
    }
    assert_eq!(step_control.record_no_gain(parts(40)), Some(MIN_PATIENCE));
    assert_eq!(step_control.record_no_gain(parts(1200)), None, "long fits are more patient");
    let said: Vec<String> = (0..4).map(|_| step_control.back_off()).collect();
    let words = ["halved", "16", "halved", " 4"];
    assert!(said.iter().zip(words).all(|(said, word)| said.contains(word)), "{said:?}");
    assert_eq!((step_control.rate, step_control.reach), (0.25, 4));
    step_control.record_gain();
    assert!(step_control.back_off().contains("halved"), "a gain forgets failures");
    let mut frame = StepControl::new(1);
    assert!(frame.shorten_reach().contains("halved"), "there is nothing left to cut");
    (0..20).for_each(|_| drop(frame.halve_rate()));
    assert!(!frame.can_continue());
}
