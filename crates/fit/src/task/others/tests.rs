use bendtwin_core::{
    Environment, FitSettings, Plane,
    quality::Predictor,
    settings::{DeviceKind, Substeps},
};
use bendtwin_engine::{
    Term,
    backend::{Instance, Outputs},
    cpu_with_threads,
};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;
use crate::{
    FitJob,
    built_graph::{BuiltGraph, build_model},
};

/// A recording of a small toy.
fn take(take: u32) -> Capture {
    let options = MakeOptions { take, ..MakeOptions::tiny(5) };
    Capture { name: format!("take {take}"), ..make(Scene::Toy, &options).unwrap() }
}

fn several(takes: &[u32]) -> Capture {
    let mut all = takes.iter().map(|&n| take(n));
    let reference = all.next().unwrap();
    Capture { others: all.collect(), ..reference }
}

fn settings() -> FitSettings {
    let mut s = FitSettings { seed: 5, ..FitSettings::default() };
    s.graph.max_nodes = Some(40);
    s.substeps = Substeps::Auto { safety: 1.2, max: Some(80) };
    s.search.starts = Some(1);
    s.search.generations = Some(2);
    s.search.population = Some(4);
    s.refine.passes = Some(2);
    s
}

fn task<'a>(capture: &'a Capture, settings: &FitSettings) -> Task<'a> {
    Task::new(capture, settings, DeviceKind::Cpu, &CancelToken::default()).unwrap()
}

#[test]
fn a_graph_has_the_control_points_of_all_recordings() {
    let capture = several(&[0, 1, 2]);
    let settings = settings();
    let (one, three) = (task(&several(&[0]), &settings).sample, task(&capture, &settings));
    // The nodes are those of the reference.
    assert_eq!(three.sample, one);
    assert_eq!(three.training.len(), 3);
    let connectivity = Connectivity::from_settings(&three.settings.graph, true);
    let built = BuiltGraph::new(&three, &connectivity);
    let graph = &built.graph;
    assert_eq!(graph.check(), Ok(()));
    assert_eq!(graph.springs.len(), built.rest_lengths_m.len());
    assert_eq!(graph.control_count(), 3 * one.control_rest.len());
    let n = graph.node_count();
    for t in &three.training {
        let own = t.source.own_controls.clone();
        let holds =
            |s: &&[u32; 2]| (s[1] as usize).checked_sub(n).is_some_and(|c| own.contains(&c));
        assert!(graph.springs.iter().filter(holds).count() >= 4);
        // Targets and nodes are in one frame.
        let Some(Term::Track { points, targets, .. }) =
            t.objective.terms.iter().map(|t| &t.term).find(|t| matches!(t, Term::Track { .. }))
        else {
            panic!("nothing is tracked")
        };
        let at = three.skin.positions(&t.source.initial.positions);
        let off = |(m, y): (&u32, &Point)| point_distance(at[*m as usize], *y);
        let mean = points.iter().zip(targets).map(off).sum::<f64>() / targets.len() as f64;
        assert!(mean < 0.02, "tracks begin {mean} m away");
    }
}

#[test]
fn control_points_of_others_exert_no_force() {
    let capture = several(&[0, 1]);
    let settings = settings();
    let (alone_capture, both) = (take(0), task(&capture, &settings));
    let alone = task(&alone_capture, &settings);
    let backend = cpu_with_threads(1);
    let loaded = |task: &Task<'_>| {
        let connectivity = Connectivity::from_settings(&task.settings.graph, true);
        let built = BuiltGraph::new(task, &connectivity);
        let params = Params {
            spring_stiffness: vec![500.0; built.graph.springs.len()],
            spring_dashpot: vec![5.0; built.graph.springs.len()],
            rest_lengths_m: built.rest_lengths_m.clone(),
            bend_stiffness: vec![1e-3; built.graph.triplets.len()],
            bend_damping: vec![1e-5; built.graph.triplets.len()],
            rest_angles_rad: built.rest_angles_rad.clone(),
            drag: 1.0,
            ..Params::default()
        };
        let mut model = build_model(task, &built.graph, params, task.capture.environment).unwrap();
        model.timing.substeps = 60;
        backend.load(Arc::new(model)).unwrap()
    };
    let run = |instance: Instance| {
        let outputs = Outputs { every: 1, ..Outputs::default() };
        backend
            .roll_out(&[instance], &outputs, &CancelToken::default())
            .unwrap()
            .remove(0)
            .positions
    };
    let own = run(alone.training[0].instance(&loaded(&alone)));
    let shared = run(both.training[0].instance(&loaded(&both)));
    let farthest = own.iter().zip(&shared).map(|(a, b)| point_distance(*a, *b)).fold(0.0, f64::max);
    assert!(farthest < 1e-4, "{farthest} m apart");
}

#[test]
fn several_recordings_make_one_twin_of_the_reference() {
    let mut capture = several(&[0, 1, 2]);
    // The last one is held out, and scored all the same.
    capture.others[1].sequences[0].train_frame_count = 0;
    let run = |checkpoint: Option<&[u8]>, kept: &mut Vec<Vec<u8>>| {
        let backend = cpu_with_threads(2);
        let settings = settings();
        let job = FitJob {
            capture: &capture,
            capture_digest: "digest".into(),
            settings,
            backend,
            look: None,
        };
        job.run(checkpoint, &mut Keeper(kept), &CancelToken::default()).unwrap().twin
    };
    let mut checkpoints = Vec::new();
    let twin = run(None, &mut checkpoints);
    let reference = &capture.sequences[0];
    assert_eq!(twin.graph.control_rest, reference.controls_at(0));
    assert_eq!(twin.graph.check(), Ok(()));
    assert_eq!(twin.params.check(&twin.graph), Ok(()));
    assert_eq!(twin.skin.check(twin.graph.node_count()), Ok(()));
    assert!(bendtwin_eval::is_own_capture(&twin, &capture));
    let quality = &twin.quality;
    let names: Vec<&str> = quality.recordings.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["take 0", "take 1", "take 2"]);
    assert!(quality.recordings[0].registered.is_none());
    assert!(quality.recordings[1..].iter().all(|r| r.registered.is_some()));
    assert_eq!(quality.recordings[2].train, Default::default());
    assert!(quality.recordings.iter().all(|r| r.future.track_m.is_some()));
    assert!(quality.score(Predictor::Bending).is_some());
    for checkpoint in &checkpoints {
        assert_eq!(run(Some(checkpoint), &mut Vec::new()), twin);
    }
    // It is read as it was written.
    let again = bendtwin_core::Twin::decode(&twin.encode().unwrap()).unwrap();
    assert_eq!(again.quality, twin.quality);
}

struct Keeper<'a>(&'a mut Vec<Vec<u8>>);

impl bendtwin_core::Observer<bendtwin_core::Progress> for Keeper<'_> {
    fn progress(&mut self, _: bendtwin_core::Progress) {}

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), bendtwin_core::ObserverError> {
        self.0.push(checkpoint);
        Ok(())
    }
}

#[test]
fn recordings_that_cannot_be_joined_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Capture)| {
        let mut capture = several(&[0, 1]);
        change(&mut capture.others[0]);
        let task = Task::new(&capture, &settings(), DeviceKind::Cpu, &CancelToken::default());
        task.err().unwrap().to_string()
    };
    let fps = refused(&|c| c.fps = 60.0);
    assert!(fps.contains("`take 1` has 60 frames a second"), "{fps}");
    let ground = refused(&|c| c.environment.ground = None);
    assert!(ground.contains("do not both have a ground"), "{ground}");
    let object = refused(&|c| {
        c.sequences[0].points.iter_mut().for_each(|p| p[0] *= 9.0);
        c.object.completed_surface.clear();
    });
    assert!(object.contains("recording `take 1`"), "{object}");
    let cable = refused(&|c| c.object.edges = vec![[0, 1]]);
    assert!(cable.contains("cable"), "{cable}");
}

#[test]
fn a_recording_is_laid_on_the_ground_of_the_reference() {
    let z_up = Environment::Z_UP;
    let ground = Some(Plane { normal: [0.0, 1.0, 0.0], offset_m: 0.3 });
    let y_up = Environment { gravity: [0.0, -9.81, 0.0], ground };
    let motion = level(&z_up, &y_up).unwrap();
    // A point on the one ground is on the other.
    let p = motion.apply([0.4, 0.3, -0.2]);
    assert!(p[2].abs() < 1e-6, "{p:?}");
    let up = motion.apply([0.4, 1.3, -0.2]);
    assert!((up[2] - 1.0).abs() < 1e-6, "{up:?}");
    let over = Environment { gravity: [0.0, 0.0, 9.81], ground: None };
    let under = Environment { ground: None, ..z_up };
    let motion = level(&under, &over).unwrap();
    assert!((motion.apply([0.0, 0.0, 1.0])[2] + 1.0).abs() < 1e-6);
    assert!((motion.rotation.determinant() - 1.0).abs() < 1e-9);
    let slope = Some(Plane { normal: [0.6, 0.0, 0.8], offset_m: 0.0 });
    assert!(level(&z_up, &Environment { ground: slope, ..z_up }).is_err());
    assert!(level(&z_up, &Environment { gravity: [0.0; 3], ..z_up }).is_err());
}

#[test]
fn sequences_of_a_cable_are_joined_unchanged() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(3)).unwrap();
    let other = make(Scene::Cable, &MakeOptions::tiny(4)).unwrap();
    let alone = task(&capture, &FitSettings::default()).training.len();
    let both = Capture { others: vec![other.clone()], ..capture.clone() };
    let joined = task(&both, &FitSettings::default());
    assert!(joined.training.len() > alone);
    assert!(joined.others.is_empty());
    let mut longer = other;
    longer.object.edges.pop();
    let both = Capture { others: vec![longer], ..capture };
    let refused =
        Task::new(&both, &FitSettings::default(), DeviceKind::Cpu, &CancelToken::default());
    assert!(refused.err().unwrap().to_string().contains("other edges or clamps"));
}

/// The loss over its training frames that a fit began with, and the one that it ended with.
#[derive(Default)]
struct Losses(Vec<f64>);

impl bendtwin_core::Observer<bendtwin_core::Progress> for Losses {
    fn progress(&mut self, progress: bendtwin_core::Progress) {
        self.0.extend(progress.best_loss);
    }

    fn checkpoint(&mut self, _: Vec<u8>) -> Result<(), bendtwin_core::ObserverError> {
        Ok(())
    }
}

#[test]
fn a_twin_is_refined_in_another_recording() {
    let (first, second) = (take(0), several(&[1, 2]));
    let mut settings = settings();
    settings.search.generations = Some(4);
    settings.refine.passes = Some(6);
    let job = |capture, settings: &FitSettings| FitJob {
        capture,
        capture_digest: "digest".into(),
        settings: settings.clone(),
        backend: cpu_with_threads(2),
        look: None,
    };
    let cancel = CancelToken::default();
    let twin = job(&first, &settings).run(None, &mut (), &cancel).unwrap().twin;
    assert_eq!(twin.provenance.refined_from, None);

    let mut losses = Losses::default();
    let refined = job(&second, &settings).refine(&twin, None, &mut losses, &cancel).unwrap().twin;
    // It is a twin of the second recording, with the nodes and what joins them of the first.
    assert!(bendtwin_eval::is_own_capture(&refined, &second));
    assert_eq!(refined.graph.control_rest, second.sequences[0].controls_at(0));
    assert_eq!(refined.graph.node_count(), twin.graph.node_count());
    assert_eq!(refined.graph.triplets, twin.graph.triplets);
    assert!(refined.provenance.refined_from.is_some());
    let made = refined.provenance.settings.as_ref().unwrap();
    assert_eq!(made.search.generations, Some(0));
    assert!(losses.0.last() < losses.0.first(), "{:?}", losses.0);
    assert_eq!(refined.quality.recordings.len(), 2);
    // And in its own capture it resumes where it stopped.
    let mut again = Losses::default();
    let own = job(&first, &settings).refine(&twin, None, &mut again, &cancel).unwrap().twin;
    assert_eq!(own.graph, twin.graph);
    assert!(again.0[0] <= losses.0[0]);
    // A checkpoint of one fit is refused by another.
    let mut kept = Vec::new();
    job(&second, &settings).refine(&twin, None, &mut Keeper(&mut kept), &cancel).unwrap();
    let resumed = job(&second, &settings).refine(&twin, Some(&kept[1]), &mut (), &cancel).unwrap();
    assert_eq!(resumed.twin, refined);
    let refused = job(&second, &settings).run(Some(&kept[1]), &mut (), &cancel);
    assert!(matches!(refused, Err(Error::OtherCheckpoint)));
}

#[test]
fn a_cable_is_refined_point_by_point() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(3)).unwrap();
    let mut settings = settings();
    settings.substeps = Substeps::Auto { safety: 1.2, max: None };
    let job = FitJob {
        capture: &capture,
        capture_digest: "digest".into(),
        settings,
        backend: cpu_with_threads(2),
        look: None,
    };
    let cancel = CancelToken::default();
    let twin = job.run(None, &mut (), &cancel).unwrap().twin;
    let refined = job.refine(&twin, None, &mut (), &cancel).unwrap().twin;
    assert_eq!(refined.graph, twin.graph);
    let toy = take(0);
    let job = FitJob { capture: &toy, ..job };
    assert!(matches!(job.refine(&twin, None, &mut (), &cancel), Err(Error::Evaluation(_))));
}
