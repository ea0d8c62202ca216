use super::*;
use crate::fit::Scheme;

fn plan(scenes: &[(SceneName, bool)]) -> Plan {
    Plan {
        scenes: scenes.to_vec(),
        batches: vec![1, 2],
        windows: vec![1],
        horizon: 1,
        measurement: Duration::ZERO,
        patience: Duration::from_secs(60),
        fits: Vec::new(),
    }
}

fn run_on_cpu(plan: &Plan) -> Report {
    let cancel = CancelToken::default();
    let setup = Setup { backend: bendtwin_engine::cpu(), memory: &(), cancel: &cancel };
    let mut report = Report::new(plan, &*setup.backend);
    run(plan, &setup, &mut report, &mut |_| ()).unwrap();
    report
}

/// Every scene runs a frame on the reference backend and stays finite: a divergence is an error.
#[test]
fn every_scene_is_stable_for_a_frame() {
    let scenes = SceneName::ALL.map(|name| (name, true));
    let report = run_on_cpu(&Plan { batches: vec![1], windows: Vec::new(), ..plan(&scenes) });
    assert_eq!(report.scenes.len(), 5);
    assert!(report.scenes.iter().all(|s| s.forward[0].run.is_some()));
}

#[test]
fn frames_and_substeps_agree() {
    let report = run_on_cpu(&plan(&[(SceneName::Rope, false), (SceneName::Rope, true)]));
    for scene in &report.scenes {
        assert_eq!((scene.forward.len(), scene.gradient.len()), (2, 1));
        let two = SceneReport::run_of(&scene.forward, 2).unwrap();
        assert!(two.frames_per_s > 0.0 && two.repeats == 1, "{two:?}");
        let substeps_per_s = 1e6 / two.us_per_substep;
        let frames_per_s = 2.0 * substeps_per_s / f64::from(scene.substeps);
        assert!((two.frames_per_s / frames_per_s - 1.0).abs() < 1e-9, "{two:?}");
    }
}

#[test]
fn what_would_take_too_long_is_left_out() {
    let plan = Plan { patience: Duration::ZERO, ..plan(&[(SceneName::Rope, false)]) };
    let report = run_on_cpu(&plan);
    let [one, two] = &report.scenes[0].forward[..] else { panic!("{report:?}") };
    assert!(one.run.is_some() && two.run.is_none());
    assert!(two.left_out.as_ref().is_some_and(|why| why.contains(" s")));
}

#[test]
fn the_report_is_json_with_these_fields() {
    let fit =
        FitPlan { scheme: Scheme::Frame, frames: 2, generations: 1, candidates: 2, passes: 1 };
    let plan = Plan { fits: vec![fit], ..plan(&[(SceneName::Rope, false)]) };
    let json = serde_json::to_value(run_on_cpu(&plan)).unwrap();
    let paths = [
        "/build",
        "/device/kind",
        "/method",
        "/scenes/0/name",
        "/scenes/0/bending",
        "/scenes/0/nodes",
        "/scenes/0/springs",
        "/scenes/0/substeps",
        "/scenes/0/load_s",
        "/scenes/0/forward/0/batch",
        "/scenes/0/forward/0/run/frames_per_s",
        "/scenes/0/forward/1/run/us_per_substep",
        "/scenes/0/gradient/0/run/frame_ms",
        "/scenes/0/fits/0/plan/scheme",
        "/scenes/0/fits/0/search/forward_s",
        "/scenes/0/fits/0/refine/gradient_s",
        "/scenes/0/fits/0/refine/host_s",
        "/scenes/0/fits/0/evaluate_s",
        "/scenes/0/fits/0/total_s",
        "/scenes/0/fits/0/final_loss",
    ];
    for path in paths {
        assert!(json.pointer(path).is_some_and(|v| !v.is_null()), "{path}: {json}");
    }
    assert!(json.pointer("/scenes/0/memory_bytes").is_some_and(serde_json::Value::is_null));
}
