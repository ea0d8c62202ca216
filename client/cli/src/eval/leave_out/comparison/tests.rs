use bendtwin_core::settings::Substeps;
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;

/// A recording of a small toy.
fn take(take: u32) -> Capture {
    let options = MakeOptions { take, ..MakeOptions::tiny(5) };
    Capture { name: format!("take {take}"), ..make(Scene::Toy, &options).unwrap() }
}

fn study(captures: Vec<Capture>) -> Result<LeaveOneOut, Fault> {
    let mut settings = FitSettings { seed: 5, ..FitSettings::default() };
    settings.graph.max_nodes = Some(40);
    settings.substeps = Substeps::Auto { safety: 1.2, max: Some(80) };
    settings.search.starts = Some(1);
    settings.search.generations = Some(1);
    settings.search.population = Some(4);
    settings.refine.passes = Some(1);
    LeaveOneOut::new(captures, settings, bendtwin_engine::cpu())
}

fn run(study: &LeaveOneOut) -> (Vec<LeftOut>, Vec<usize>) {
    let mut reported = Vec::new();
    let mut tell = |fit, _| reported.push(fit);
    let results = study.run(&mut tell, &CancelToken::default()).unwrap();
    reported.dedup();
    (results, reported)
}

#[test]
fn each_recording_is_predicted_from_each_other_one_and_from_all_others() {
    // The last one is held out: predicted, never fitted.
    let mut held_out = take(2);
    held_out.sequences.iter_mut().for_each(|s| s.train_frame_count = 0);
    let several = Capture { others: vec![take(1)], ..take(0) };
    let study = study(vec![several, held_out]).unwrap();
    assert_eq!(study.fits(), 3);
    let (results, reported) = run(&study);
    assert_eq!(reported, [0, 1, 2]);
    let fitted_to = |p: &Prediction| p.fitted_to.join("+");
    let rows: Vec<String> = results
        .iter()
        .map(|left| {
            let one: Vec<String> = left.from_one.iter().map(fitted_to).collect();
            let all = left.from_all.as_ref().map(fitted_to);
            format!("{}: {}; {}", left.recording, one.join(", "), all.unwrap_or_default())
        })
        .collect();
    assert_eq!(
        rows,
        ["take 0: take 1; ", "take 1: take 0; ", "take 2: take 0, take 1; take 0+take 1"]
    );
    for prediction in results.iter().flat_map(LeftOut::all) {
        let scores = prediction.scores.unwrap();
        assert_eq!(prediction.refused, None);
        // Every frame counts as one that no fit saw, and the start is near.
        let first = scores.first_frame.track_m.unwrap();
        assert!(first < 0.02 && first < scores.twin.track_m.unwrap(), "{scores:?}");
        assert!(scores.standing_still.track_m.unwrap() > 0.02, "{scores:?}");
        assert!(scores.registered.explained > 0.5, "{scores:?}");
    }
    let last = &results[2];
    let of_one = last.from_one.iter().map(|p| p.scores.unwrap().twin.track_m.unwrap());
    let mean = of_one.sum::<f64>() / 2.0;
    assert!((last.one_m().unwrap() - mean).abs() < 1e-9);
    let table = left_out_table(&results);
    assert_eq!(table.lines().count(), 5, "{table}");
    assert!(table.contains(&format!("| {:.1} |", 1e3 * last.all_m().unwrap())), "{table}");
}

#[test]
fn a_recording_of_something_else_is_refused_with_its_reason() {
    // A toy of thrice the size.
    let mut large = Capture { name: "large".into(), ..take(1) };
    let object = &mut large.object;
    let sequence = &mut large.sequences[0];
    let parts = [&mut object.completed_surface, &mut object.interior, &mut sequence.points];
    for points in parts.into_iter().chain([&mut sequence.controls, &mut sequence.truth_tracks]) {
        points.iter_mut().flatten().for_each(|x| *x *= 3.0);
    }
    let study = study(vec![take(0), large]).unwrap();
    let (results, _) = run(&study);
    let refused = results[1].from_one[0].refused.as_ref().unwrap();
    assert_eq!((results[1].one_m(), &*refused.reason), (None, "OBSERVATION_NOT_EXPLAINED"));
    assert!(left_out_table(&results).contains("large from take 0: "));
}

#[test]
fn one_recording_cannot_be_left_out() {
    for captures in [vec![], vec![take(0)], {
        let mut held_out = take(1);
        held_out.sequences.iter_mut().for_each(|s| s.train_frame_count = 0);
        vec![take(0), held_out]
    }] {
        let refused = study(captures).err().unwrap();
        assert_eq!(refused.reason, "CAPTURE_CANNOT_BE_FITTED");
    }
}
