use bendtwin_core::{FitSettings, Twin, settings::Substeps};
use bendtwin_engine::{Model, enough_substeps};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;

/// A fit of a second or so with some 60 nodes, and its capture.
fn fitted() -> (Twin, Capture) {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let mut settings = FitSettings { seed: 5, ..FitSettings::default() };
    settings.graph.max_nodes = Some(60);
    settings.substeps = Substeps::Auto { safety: 1.2, max: Some(100) };
    settings.search.starts = Some(1);
    settings.search.generations = Some(2);
    settings.search.population = Some(4);
    settings.refine.passes = Some(3);
    let backend = bendtwin_engine::cpu_with_threads(2);
    let job = FitJob {
        capture: &capture,
        capture_digest: "digest".into(),
        settings,
        backend,
        look: None,
    };
    let twin = job.run(None, &mut (), &CancelToken::default()).unwrap().twin;
    (twin, capture)
}

const WANTED: Distillation = Distillation { nodes: 20, substeps: 30, seed: 3 };

#[test]
fn a_planners_twin_is_small_close_and_the_same_every_time() {
    let (twin, capture) = fitted();
    let backend = bendtwin_engine::cpu_with_threads(2);
    let cancel = CancelToken::default();
    let with = WANTED.of(&twin, Some(&capture), &backend, &cancel).unwrap();
    let (planner, figures) = (with.planner.as_ref().unwrap(), with.quality.planner.unwrap());
    assert_eq!((figures.nodes, planner.nodes.len()), (20, 20));
    assert!(figures.substeps <= 30, "{figures:?}");
    assert!(enough_substeps(&Model::from(&*planner.twin), figures.substeps).is_ok());
    assert_eq!(planner.twin.skin.len(), twin.skin.len() + twin.graph.node_count());
    let mass = |twin: &Twin| twin.graph.masses.iter().sum::<f32>();
    assert!((mass(&planner.twin) / mass(&twin) - 1.0).abs() < 1e-4);
    assert!(figures.mean_travel_m > 0.01, "the actions move it: {figures:?}");
    // Thin and softened alone it is much farther away.
    let hands = Hands::new(&twin, Some(&capture));
    let windows = |count, stream| {
        follow(&*backend, &twin, &hands.actions(count, WANTED.seed, stream), &cancel).unwrap()
    };
    let thin = WANTED.softened(&twin, &windows(TRAINING, 0), &*backend, &cancel).unwrap();
    let [before, ..] = deviation(&*backend, &thin, &twin, &windows(HELD_OUT, 1), &cancel).unwrap();
    let after = figures.mean_deviation_m;
    assert!(after < 0.8 * before, "{after} is not much less than {before}");
    assert!(figures.share_of_travel() < 0.5, "{figures:?}");
    let file = with.encode().unwrap();
    assert_eq!(Twin::decode(&file).unwrap(), with);
    let again = WANTED.of(&twin, Some(&capture), &backend, &cancel).unwrap();
    assert_eq!(again.encode().unwrap(), file);
    // One in the place of another.
    let other = Distillation { seed: 4, ..WANTED }.of(&with, None, &backend, &cancel).unwrap();
    assert_ne!(other.planner, with.planner);
}

#[test]
fn what_cannot_be_planned_with_says_why() {
    let (mut twin, _) = fitted();
    let backend = bendtwin_engine::cpu_with_threads(1);
    let cancel = CancelToken::default();
    cancel.cancel();
    assert!(matches!(WANTED.of(&twin, None, &backend, &cancel), Err(Error::Backend(_))));
    let n = twin.graph.node_count() as u32;
    twin.graph.pins.clear();
    twin.graph.springs.retain(|spring| spring[1] < n);
    twin.graph.control_rest.clear();
    let error = WANTED.of(&twin, None, &backend, &CancelToken::default()).unwrap_err();
    assert!(error.to_string().contains("control points"), "{error}");
}

#[test]
fn a_budget_is_read_and_selects_a_size() {
    let budget: Budget = "48x15@10".parse().unwrap();
    assert_eq!(budget, Budget { samples: 48, frames: 15, per_second: 10.0 });
    assert_eq!("8 x 5 @ 2.5 Hz".parse::<Budget>().unwrap().per_second, 2.5);
    for text in ["", "48x15", "48@10", "0x15@10", "48x15@0", "48x15@nan", "48x15@-1"] {
        assert!(text.parse::<Budget>().is_err(), "{text}");
    }
    let (twin, _) = fitted();
    let backend = bendtwin_engine::cpu_with_threads(1);
    let choose = |per_second| {
        let budget = Budget { samples: 1, frames: 1, per_second };
        budget.choose(&twin, &*backend, &CancelToken::default()).unwrap()
    };
    // A frame of one rollout takes less than a minute, and more than a tenth of a microsecond.
    let (slow, fast) = (choose(0.01), choose(1e7));
    assert!(slow.fits && slow.nodes == 120, "{slow:?}");
    assert!(!fast.fits && fast.nodes == 60, "{fast:?}");
}
