use bendtwin_core::{
    Contact, Graph, NodeKind, Params, PlannerQuality, PlannersTwin, Quality, Skin, Timing, Twin,
};
use bendtwin_core_kit::twin_of;

/// A twin of some nodes on a line, without springs.
fn twin(places: &[f32]) -> Twin {
    let graph = Graph {
        rest_positions: places.iter().map(|x| [*x, 0.0, 0.0]).collect(),
        kinds: vec![NodeKind::Observed; places.len()],
        masses: vec![1.0; places.len()],
        object_ids: vec![0; places.len()],
        observed_points: vec![Graph::NOT_OBSERVED; places.len()],
        ..Graph::default()
    };
    let params = Params { contact: Contact::default(), ..Params::default() };
    Twin { timing: Timing { fps: 30.0, substeps: 9 }, ..twin_of(graph, params) }
}

const FIGURES: PlannerQuality = PlannerQuality {
    nodes: 2,
    springs: 0,
    triplets: 0,
    substeps: 9,
    mean_deviation_m: 0.002,
    max_deviation_m: 0.01,
    mean_travel_m: 0.1,
    frames: 30,
    actions: 4,
};

/// Four nodes, of which the first and the last are the planner's; the others lie between them.
fn pair() -> Twin {
    let mut large = twin(&[0.0, 0.1, 0.2, 0.4]);
    let mut small = twin(&[0.0, 0.4]);
    small.skin = Skin::default();
    let none = [Skin::NO_FRAME; 3];
    for x in [0.0, 0.25, 0.5, 1.0, 0.0, 0.25, 0.5, 1.0_f32] {
        let weights = [(0, 1.0 - x), (1, x)];
        small.skin.push(Graph::NOT_OBSERVED, &weights, none, [0.0; 3]);
    }
    large.planner = Some(PlannersTwin { nodes: vec![0, 3], twin: Box::new(small) });
    large.quality.planner = Some(FIGURES);
    large
}

#[test]
fn a_planners_twin_survives_its_file() {
    let twin = pair();
    let file = twin.encode().unwrap();
    assert_eq!(Twin::decode(&file).unwrap(), twin);
    assert_eq!(file, twin.encode().unwrap());
    let without = Twin { planner: None, quality: Quality::default(), ..twin };
    let file = String::from_utf8_lossy(&without.encode().unwrap()).into_owned();
    assert!(file.contains("version\\\":1"), "older programs read it");
}

#[test]
fn a_twin_and_its_planners_twin_belong_together() {
    let fault = |change: fn(&mut Twin)| {
        let mut twin = pair();
        change(&mut twin);
        twin.encode().unwrap_err().to_string()
    };
    assert!(fault(|t| t.quality.planner = None).contains("no figures"));
    assert!(fault(|t| t.planner = None).contains("no such twin"));
    for change in [
        (|figures: &mut PlannerQuality| figures.substeps = 8) as fn(&mut PlannerQuality),
        |figures| figures.nodes = 1,
        |figures| figures.springs = 1,
    ] {
        let mut twin = pair();
        change(twin.quality.planner.as_mut().unwrap());
        assert!(twin.encode().unwrap_err().to_string().contains("not those of its file"));
    }
    for nodes in [vec![0], vec![3, 0], vec![0, 4]] {
        let mut twin = pair();
        twin.planner.as_mut().unwrap().nodes = nodes.clone();
        assert!(twin.encode().unwrap_err().to_string().contains("planner's"), "{nodes:?}");
    }
    let mut twin = pair();
    twin.planner.as_mut().unwrap().twin.timing.fps = 25.0;
    assert!(twin.encode().unwrap_err().to_string().contains("frames per second"));
    let mut twin = pair();
    let nested = PlannersTwin { nodes: vec![0, 1], twin: twin.planner.clone().unwrap().twin };
    twin.planner.as_mut().unwrap().twin.planner = Some(nested);
    assert!(twin.encode().is_err());
}

#[test]
fn states_are_taken_over_by_leaving_out_and_given_back_by_carrying() {
    let twin = pair();
    let planner = twin.planner.as_ref().unwrap();
    let rest = &twin.graph.rest_positions;
    assert_eq!(planner.select(rest), [[0.0; 3], [0.4, 0.0, 0.0]]);
    let moved = [[0.0, 1.0, 0.0], [0.4, 3.0, 0.0]];
    let carried = planner.positions(4, &moved);
    assert_eq!(carried.iter().map(|p| p[1]).collect::<Vec<_>>(), [1.0, 1.5, 2.0, 3.0]);
    assert_eq!(planner.select(&carried), moved, "nothing is lost on the way back");
    let speeds = planner.velocities(4, &moved, &[[0.0; 3], [0.0, 0.0, 4.0]]);
    assert_eq!(speeds.iter().map(|v| v[2]).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 4.0]);
    assert_eq!(planner.nearest(rest), [0, 0, 0, 1]);
    assert_eq!(planner.own_skin(4).len(), 4);
}
