use serde_json::{Value, json};

use super::*;
use crate::v1::{
    Cost, Fidelity, InitialState, Interpolation, Prop, RollOutRequest, RollOutResponse, Tensor,
    cost::{Kind, When},
    initial_state::State,
    roll_out_request::Actions,
    roll_out_response::Timing,
};

fn read(json: &Value) -> Result<RollOutRequest, String> {
    let text = json.to_string();
    let request = serde_json::from_str::<Read<RollOutRequest>>(&text).map_err(|e| e.to_string())?;
    Ok(request.0)
}

fn written<T: Fields>(message: &T, tensors: TensorFormat) -> Value {
    serde_json::to_value(Write { message, tensors }).unwrap()
}

/// The positions of a request whose positions are given as this.
fn positions(json: Value) -> Result<Tensor, String> {
    match read(&json!({"trajectories": {"positions": json}}))?.actions {
        Some(Actions::Trajectories(t)) => t.positions.ok_or_else(|| "no tensor".to_owned()),
        other => Err(format!("{other:?}")),
    }
}

#[test]
fn a_request_has_the_fields_of_its_message() {
    let request = read(&json!({
        "trajectories": {"positions": [[[[0, 0, 0.5]], [[0, -1, 1e-3]]]], "interpolation": "CUBIC"},
        "initial": {"capture_frame": {"frame": 12}},
        "frames": 30,
        "costs": [
            {"keypoints": {"nodes": [4], "targets": [[0, 0, 1]], "squared": true}},
            {"name": "s", "weight": 0, "when": "EVERY_FRAME", "smoothness": {}},
        ],
        "returns": {"every_frames": 10, "encoding": "INT16", "nodes": null},
        "fidelity": "FAST",
    }))
    .unwrap();
    let Some(Actions::Trajectories(t)) = &request.actions else { panic!("{request:?}") };
    let expected = Tensor::pack(&[1, 2, 1, 3], &[0.0f32, 0.0, 0.5, 0.0, -1.0, 1e-3]);
    assert_eq!((t.positions.as_ref(), t.interpolation()), (Some(&expected), Interpolation::Cubic));
    let Some(InitialState { state: Some(State::CaptureFrame(at)) }) = &request.initial else {
        panic!("{request:?}")
    };
    assert_eq!((at.frame, request.frames, request.fidelity()), (12, 30, Fidelity::Fast));
    let [first, second] = &request.costs[..] else { panic!("{request:?}") };
    let Some(Kind::Keypoints(k)) = &first.kind else { panic!("{first:?}") };
    assert_eq!((k.nodes.as_ref(), k.squared), (Some(&Tensor::pack(&[1], &[4u32])), true));
    assert_eq!((first.weight, second.weight), (None, Some(0.0)));
    assert_eq!((first.when(), second.when()), (When::Unspecified, When::EveryFrame));
    assert_eq!(request.returns.as_ref().unwrap().nodes, None);
    // Written and read again it is the same.
    for format in [TensorFormat::Lists, TensorFormat::Base64] {
        assert_eq!(read(&written(&request, format)), Ok(request.clone()), "{format:?}");
    }
}

#[test]
fn faults_name_the_field_and_what_may_be_there() {
    for (json, fault) in [
        (
            json!({"frame": 3}),
            "has the unknown field \"frame\": RollOutRequest has twin, trajectories",
        ),
        (json!({"frames": -1}), "`frames` invalid"),
        (
            json!({"fidelity": "SLOW"}),
            "`fidelity` has the unknown value \"SLOW\": use EXACT or FAST",
        ),
        (json!({"fidelity": 2}), "`fidelity` invalid type"),
        (
            json!({"costs": [{}, {"wight": 1}]}),
            "`costs[1]` has the unknown field \"wight\": Cost has",
        ),
        (json!({"costs": [{"weight": "x"}]}), "`costs[0].weight` invalid type"),
        (
            json!({"costs": [{"keypoints": {"nodes": [0.5]}}]}),
            "`costs[0].keypoints.nodes` has an entry",
        ),
        (
            json!({"costs": [{"smoothness": {}, "keypoints": {}}]}),
            "`costs[0].smoothness` is given beside",
        ),
        (json!({"trajectories": {}, "poses": {}}), "is given beside a field that excludes it"),
        (json!({"trajectories": []}), "`trajectories` invalid type"),
        (json!({"initial": {"nowhere": {}}}), "`initial` has the unknown field"),
        (json!([]), "RollOutRequest"),
    ] {
        let error = read(&json).unwrap_err();
        assert!(error.contains(fault), "{json}: {error}");
        assert!(error.contains("at line 1 column"), "{error}");
    }
    let twice = serde_json::from_str::<Read<RollOutRequest>>(r#"{"frames": 1, "frames": 2}"#);
    assert!(twice.unwrap_err().to_string().contains("`frames` is given twice"));
}

#[test]
fn lists_and_bytes_are_the_same_tensor() {
    let tensor = Tensor::pack(&[2, 1, 3], &[0.0f32, 1.0, 2.0, 3.0, 4.0, 5.5]);
    let reply = RollOutResponse { positions: Some(tensor.clone()), ..RollOutResponse::default() };
    for format in [TensorFormat::Lists, TensorFormat::Base64] {
        let json = written(&reply, format)["positions"].clone();
        assert_eq!(positions(json), Ok(tensor.clone()), "{format:?}");
    }
    let lists = &written(&reply, TensorFormat::Lists)["positions"];
    assert_eq!(lists, &json!([[[0.0, 1.0, 2.0]], [[3.0, 4.0, 5.5]]]));
}

#[test]
fn lists_of_colours_are_bytes() {
    let color = |json: Value| {
        let text = json!({"color": json}).to_string();
        let prop = serde_json::from_str::<Read<Prop>>(&text).map_err(|e| e.to_string());
        prop.map(|prop| prop.0.color.unwrap())
    };
    assert_eq!(color(json!([[0, 128, 255]])), Ok(Tensor::pack(&[1, 3], &[0u8, 128, 255])));
    for wrong in [json!([256, 0, 0]), json!([-1, 0, 0]), json!([0.5, 0, 0])] {
        let error = color(wrong.clone()).unwrap_err();
        assert!(error.contains("no byte"), "{wrong}: {error}");
    }
}

#[test]
fn infinite_costs_are_null_and_what_is_not_there_is_left_out() {
    let reply = RollOutResponse {
        costs: Some(Tensor::pack(&[2], &[f64::INFINITY, 1.0])),
        cost_terms: Some(Tensor::pack::<f64>(&[2, 0], &[])),
        timing: Some(Timing { queue_s: 0.5, compute_s: 0.0 }),
        fidelity: Fidelity::Exact.into(),
        ..RollOutResponse::default()
    };
    let expected = json!({
        "first_instance": 0, "implausible": [],
        "costs": [null, 1.0],
        "cost_names": [],
        "cost_terms": [[], []],
        "diagnostics": [],
        "diverged": [],
        "implausible": [],
        "timing": {"queue_s": 0.5, "compute_s": 0.0},
        "worker": "",
        "fidelity": "EXACT",
        "substeps": 0,
    });
    assert_eq!(written(&reply, TensorFormat::Lists), expected);
}

#[test]
fn every_type_is_written_by_its_values() {
    let of = |tensor: Tensor| {
        let reply = RollOutResponse { positions: Some(tensor), ..RollOutResponse::default() };
        written(&reply, TensorFormat::Lists)["positions"].clone()
    };
    assert_eq!(of(Tensor::pack(&[2], &[1u32, u32::MAX])), json!([1, u32::MAX]));
    assert_eq!(of(Tensor::pack(&[1], &[-3i32])), json!([-3]));
    assert_eq!(of(Tensor::pack(&[1], &[7u8])), json!([7]));
    let coarse = of(Tensor::pack_points_i16(&[1], &[[0.0, 0.5, 1.0]]));
    assert!((coarse[0][1].as_f64().unwrap() - 0.5).abs() < 1e-4, "{coarse}");
    // The shortest digits that give the same single.
    let text = serde_json::to_string(&Write {
        message: &RollOutResponse {
            final_twists: Some(Tensor::pack(&[1], &[0.1f32])),
            ..RollOutResponse::default()
        },
        tensors: TensorFormat::Lists,
    });
    assert!(text.unwrap().contains("[0.1]"));
}

#[test]
fn lists_of_messages_and_shapes_are_bounded() {
    let costs = |count: usize| format!("{{\"costs\": [{}{{}}]}}", "{},".repeat(count - 1));
    let read = |text: &str| serde_json::from_str::<Read<RollOutRequest>>(text);
    assert_eq!(read(&costs(fields::MOST_MESSAGES)).unwrap().0.costs.len(), fields::MOST_MESSAGES);
    let error = read(&costs(fields::MOST_MESSAGES + 1)).unwrap_err().to_string();
    assert!(error.contains("`costs` has more than 65536 entries"), "{error}");
    let shape = json!({"dtype": "FLOAT32", "shape": vec![0; 9], "data": ""});
    let error = positions(shape).unwrap_err();
    assert!(error.contains("a shape of more than 8 lengths"), "{error}");
}

#[test]
fn broken_tensors_are_refused() {
    let broken = [
        json!(3),
        json!("x"),
        json!([[1.0], [1.0, 2.0]]),
        json!([1.0, [2.0]]),
        json!([[2.0], 1.0]),
        json!([[], 1.0]),
        json!([[], [1.0]]),
        json!(["a"]),
        json!([null]),
        json!([1e300]),
        json!([[[[[[[[[1.0]]]]]]]]]),
        json!({"dtype": "FLOAT99", "shape": [1], "data": "AAAAAA=="}),
        json!({"dtype": "FLOAT32", "shape": [1], "data": "?"}),
        json!({"dtype": "FLOAT32", "shape": [-1], "data": "AAAAAA=="}),
        json!({"dtype": "FLOAT32", "shape": [1], "data": "AAAAAA==", "more": 1}),
    ];
    for value in broken {
        let error = positions(value.clone()).unwrap_err();
        assert!(error.contains("`trajectories.positions`"), "{value}: {error}");
    }
    assert_eq!(positions(json!(null)), Err("no tensor".to_owned()));
    assert_eq!(positions(json!([[], []])).unwrap().shape, [2, 0]);
    let deep = format!("{{\"costs\": {}{}}}", "[".repeat(5000), "]".repeat(5000));
    assert!(serde_json::from_str::<Read<RollOutRequest>>(&deep).is_err());
    assert_eq!(Cost::FIELDS[..3], ["name", "weight", "when"]);
}
