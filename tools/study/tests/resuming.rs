//! A suite that was interrupted ends in the same table as one that was not.

use std::{path::Path, sync::Arc, time::Duration};

use bendtwin_capture::{Limits, write_bundle_file};
use bendtwin_core::{CancelToken, Capture, Fault, Problem, Views};
use bendtwin_engine::cpu_with_threads;
use bendtwin_study::{
    Devices, Event, Folder, Invocation, Outcome, Plan, PlanOptions, Suite, Summary, Table,
    draw_pictures,
};
use bendtwin_synth::{MakeOptions, Scene, make};

const SUITE: &str = r#"{
    "version": 1,
    "captures": [
        {"name": "rope", "path": "rope.zip"},
        {"name": "cable", "path": "cable.zip"},
        {"name": "broken", "path": "broken.zip"}
    ],
    "base": {
        "graph": {"max_nodes": 20},
        "search": {"generations": 3, "population": 4},
        "refine": {"passes": 3}
    },
    "configurations": [
        {"name": "axial", "settings": {"bending": false}},
        {"name": "bending"},
        {"name": "hopeless", "settings": {"substeps": {"fixed": 1}, "graph": {"max_triplets": 0}}}
    ],
    "compare": [{"of": "bending", "against": "axial"}]
}"#;

fn prepare(folder: &Path) -> Suite {
    for (scene, name) in [(Scene::Rope, "rope.zip"), (Scene::Cable, "cable.zip")] {
        let capture = make(scene, &MakeOptions::tiny(1)).unwrap();
        write_bundle_file(&capture, &folder.join(name)).unwrap();
    }
    std::fs::write(folder.join("broken.zip"), b"no archive").unwrap();
    let file = folder.join("suite.json");
    std::fs::write(&file, SUITE).unwrap();
    Suite::read(&file).unwrap()
}

fn options() -> PlanOptions {
    PlanOptions {
        data: None,
        only: Vec::new(),
        build: "this build".into(),
        any_build: false,
        checkpoint_every: Duration::ZERO,
    }
}

fn read(path: &Path) -> Result<(Capture, Option<Views>), Fault> {
    let capture = bendtwin_capture::read(path, &Limits::default()).map_err(|e| e.fault())?;
    Ok((capture, None))
}

fn devices(count: usize) -> Devices {
    Devices {
        backends: (0..count).map(|_| cpu_with_threads(1)).collect(),
        rasteriser: Arc::new(|| Ok(Box::new(bendtwin_splat::Cpu::default()))),
    }
}

/// The table, times apart.
fn timeless(plan: &Plan<'_>) -> (String, String) {
    let mut table = Table::new(plan, &Invocation::default());
    for row in table.rows.iter_mut().chain(&mut table.means) {
        row.fit_s = None;
    }
    (table.to_json().unwrap(), table.to_markdown())
}

#[test]
fn an_interrupted_suite_ends_in_the_same_table() {
    let place = tempfile::tempdir().unwrap();
    let suite = prepare(place.path());
    let whole = {
        let folder = Folder::open(&place.path().join("whole")).unwrap();
        let mut plan = Plan::new(&suite, &folder, options(), &read).unwrap();
        let summary = plan.run(&devices(2), &CancelToken::default(), &mut |_| {}).unwrap();
        // The fits of the broken capture fail, and the hopeless one of the rope at least.
        assert_eq!((summary.finished + summary.failed, summary.left), (9, 0));
        assert!(summary.failed >= 4 && summary.finished >= 4, "{summary:?}");
        let complaints =
            draw_pictures(&plan, &*devices(1).backends[0], &CancelToken::default()).unwrap();
        assert_eq!(complaints, [] as [String; 0]);
        assert!(folder.root().join("pictures/rope.bending.axial.png").is_file());
        timeless(&plan)
    };

    let place_of_parts = place.path().join("parts");
    let (mut starts, mut resumed_ever) = (0, false);
    loop {
        starts += 1;
        assert!(starts < 200, "the suite does not end");
        let folder = Folder::open(&place_of_parts).unwrap();
        let mut plan = Plan::new(&suite, &folder, options(), &read).unwrap();
        let (cancel, mut seen) = (CancelToken::default(), 0);
        let summary = plan
            .run(&devices(1), &cancel, &mut |event| match event {
                Event::Progress { .. } => {
                    seen += 1;
                    if seen == 4 {
                        cancel.cancel();
                    }
                }
                Event::Started { resumed, .. } => resumed_ever |= resumed,
                Event::Ended(_) | Event::Interrupted(_) => {}
            })
            .unwrap();
        if summary.left == 0 {
            assert_eq!(timeless(&plan), whole);
            break;
        }
    }
    assert!(starts > 1 && resumed_ever);

    // What is done stays done, and what was refused stays refused; what another build made is made
    // again.
    let folder = Folder::open(&place_of_parts).unwrap();
    let plan = Plan::new(&suite, &folder, options(), &read).unwrap();
    assert_eq!((plan.pending(), plan.done()), (0, 9));
    assert!(plan.failures().len() >= 4);
    let other = PlanOptions { build: "another".into(), ..options() };
    assert_eq!(Plan::new(&suite, &folder, other.clone(), &read).unwrap().pending(), 9);
    let kept = PlanOptions { any_build: true, ..other };
    assert_eq!(Plan::new(&suite, &folder, kept, &read).unwrap().pending(), 0);
}

#[test]
fn a_selection_runs_what_it_names() {
    let place = tempfile::tempdir().unwrap();
    let suite = prepare(place.path());
    let folder = Folder::open(&place.path().join("out")).unwrap();
    assert!(Folder::open(&place.path().join("out")).is_err(), "one process at a time");
    let only = vec!["cable/bending".parse().unwrap()];
    let mut plan = Plan::new(&suite, &folder, PlanOptions { only, ..options() }, &read).unwrap();
    let mut names = Vec::new();
    let summary = plan
        .run(&devices(3), &CancelToken::default(), &mut |event| {
            if let Event::Ended(record) = event {
                names.push(record.run.to_string());
                assert!(record.command.starts_with("bendtwin eval"), "{}", record.command);
                let Outcome::Finished(finished) = &record.outcome else { panic!("{record:?}") };
                let losses = &finished.quality.choice.as_ref().unwrap().losses;
                let lowest = losses.iter().flatten().copied().reduce(f64::min);
                assert!(losses.len() > 1 && finished.losses.refine == lowest, "{losses:?}");
            }
        })
        .unwrap();
    assert_eq!(summary, Summary { finished: 1, failed: 0, left: 0 });
    assert_eq!(names, ["cable/bending/0"]);
    let only = vec!["cable/nothing".parse().unwrap()];
    assert!(Plan::new(&suite, &folder, PlanOptions { only, ..options() }, &read).is_err());

    std::fs::remove_file(place.path().join("rope.zip")).unwrap();
    std::fs::remove_file(place.path().join("broken.zip")).unwrap();
    let error = Plan::new(&suite, &folder, options(), &read).unwrap_err().to_string();
    assert!(error.contains("`rope`") && error.contains("`broken`"), "{error}");
}
