use super::*;
use crate::scene::SceneName;

#[test]
fn phystwins_count_is_220_candidates_and_200_passes() {
    let plan = FitPlan::phystwin(Scheme::Frame);
    assert_eq!(plan.generations as usize * plan.candidates, 220);
    let scene = Scene::new(SceneName::Rope, false).unwrap();
    for scheme in [Scheme::Frame, Scheme::Pass, Scheme::Cut] {
        let settings = settings(&scene, &FitPlan::phystwin(scheme));
        assert_eq!(settings.validate(), Ok(()));
        assert_eq!((settings.refine.passes, settings.search.population), (Some(200), Some(11)));
    }
}

#[test]
fn a_short_fit_improves_and_its_stages_add_up() {
    let scene = Scene::new(SceneName::Rope, false).unwrap();
    let plan =
        FitPlan { scheme: Scheme::Pass, frames: 3, generations: 1, candidates: 2, passes: 2 };
    let backend = bendtwin_engine::cpu();
    let run = whole_fit(&scene, &backend, &plan, &(), &CancelToken::default()).unwrap();
    let sum = run.search.total_s + run.refine.total_s + run.evaluate_s;
    assert!((sum / run.total_s - 1.0).abs() < 1e-9, "{run:?}");
    let parts = run.refine;
    assert!(parts.gradient_s > 0.0 && parts.forward_s > 0.0 && parts.host_s > 0.0, "{run:?}");
    let (search, last) = (run.search_loss.unwrap(), run.final_loss.unwrap());
    assert!(last <= search && search <= run.initial_loss.unwrap(), "{run:?}");
}

#[test]
fn the_hidden_body_is_the_scenes_body() {
    let scene = Scene::new(SceneName::Rope, false).unwrap();
    let backend = bendtwin_engine::cpu();
    let capture = target::capture(&scene, 2, &*backend, &CancelToken::default()).unwrap();
    let graph = &scene.model.graph;
    assert_eq!(capture.object.point_count, graph.surface_count());
    assert_eq!(capture.object.interior.len(), graph.node_count() - graph.surface_count());
    assert_eq!(capture.sequences[0].points_at(0), &graph.rest_positions[..graph.surface_count()]);
    assert_ne!(capture.sequences[0].points_at(1), capture.sequences[0].points_at(0));
}
