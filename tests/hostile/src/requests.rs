//! Rollout requests as JSON: other numbers, ragged lists, tensors that lie about their bytes.

use base64::{Engine as _, prelude::BASE64_STANDARD};
use rand::RngExt as _;
use serde_json::{Value, json};

use crate::{Fault, Rng, damage, documents, samples};

/// Faults of requests.
pub const FAULTS: &[Fault] = &[
    Fault { what: "a request with damage", make: |rng| damage::any(rng, &valid()) },
    Fault { what: "a request with other numbers", make: |rng| documents::numbers(rng, &valid()) },
    Fault { what: "a request of nested brackets", make: nested },
    Fault { what: "a request with a ragged list", make: ragged },
    Fault { what: "a request with a long list", make: long },
    Fault { what: "a request with numbers that are none", make: not_finite },
    Fault { what: "a request with bytes of another shape", make: packed },
    Fault { what: "a request with fields of another type", make: wrong_type },
    Fault { what: "a request with fields that exclude each other", make: several },
    Fault { what: "a request with many costs", make: costs },
    Fault { what: "a request that asks for much", make: much },
    Fault { what: "a request that is no object", make: no_object },
];

/// The valid request.
pub fn valid() -> Vec<u8> {
    samples::rollout().to_string().into_bytes()
}

fn changed(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut request = samples::rollout();
    change(&mut request);
    request.to_string().into_bytes()
}

fn positions(value: Value) -> Vec<u8> {
    changed(|request| request["trajectories"]["positions"] = value)
}

/// The request with text for its positions.
fn positions_text(text: &str) -> Vec<u8> {
    let whole = positions(json!("POSITIONS"));
    String::from_utf8_lossy(&whole).replace("\"POSITIONS\"", text).into_bytes()
}

fn nested(rng: &mut Rng) -> Vec<u8> {
    let depth = rng.random_range(9..100_000);
    match rng.random_range(0..3) {
        0 => positions_text(&"[".repeat(depth)),
        1 => positions_text(&format!("{}0{}", "[".repeat(depth), "]".repeat(depth))),
        _ => "{\"initial\":".repeat(depth).into_bytes(),
    }
}

fn ragged(rng: &mut Rng) -> Vec<u8> {
    let any = [
        json!([[[[0, 0, 0]], [[0, 0]]]]),
        json!([[[[0, 0, 0]], []]]),
        json!([[[[0, 0, 0]], 1]]),
        json!([[], [[]], [[[]]]]),
        json!([1, [2]]),
        json!([[[[0, 0, 0]]], [[[0, 0, 0]], [[0, 0, 0]]]]),
    ];
    positions(any[rng.random_range(0..any.len())].clone())
}

fn long(rng: &mut Rng) -> Vec<u8> {
    let one = ["[[[0,0,0]],[[0,0,1]]]", "[]", "[[[]]]", "0", "null", "[[[1e-300,-0,9]]]"];
    let one = one[rng.random_range(0..one.len())];
    positions_text(&format!("[{}{one}]", format!("{one},").repeat(rng.random_range(1000..60_000))))
}

fn not_finite(rng: &mut Rng) -> Vec<u8> {
    let any = ["NaN", "Infinity", "-Infinity", "1e39", "-1e400", "null", "\"nan\"", "1e-400", "00"];
    let any = any[rng.random_range(0..any.len())];
    positions_text(&format!("[[[[{any},0,0]],[[0,{any},0]]]]"))
}

fn packed(rng: &mut Rng) -> Vec<u8> {
    let shapes = [
        json!([1, 2, 1, 3]),
        json!([u64::MAX, 2, 1, 3]),
        json!([1_u64 << 32, 1_u64 << 32, 0, 3]),
        json!([0, 2, 1, 3]),
        json!([]),
        json!(vec![1; 5000]),
        json!([1.5, 2, 1, 3]),
    ];
    let types = ["FLOAT32", "FLOAT64", "INT16_SCALED", "UINT8", "FLOAT31", ""];
    let mut data = BASE64_STANDARD.encode(vec![0; [24, 48, 23, 0][rng.random_range(0..4)]]);
    if rng.random_range(0..4) == 0 {
        data.push('*');
    }
    let scale = [0.0, 1e38, -1.0][rng.random_range(0..3)];
    positions(json!({
        "dtype": types[rng.random_range(0..types.len())],
        "shape": shapes[rng.random_range(0..shapes.len())],
        "data": data,
        "scale": scale,
    }))
}

fn wrong_type(rng: &mut Rng) -> Vec<u8> {
    let fields = ["trajectories", "frames", "costs", "returns", "initial", "fidelity", "twin", "x"];
    let values = [json!(true), json!("a"), json!([[]]), json!({"a": 1}), json!(-1), json!(1e300)];
    let field = fields[rng.random_range(0..fields.len())];
    changed(|request| request[field] = values[rng.random_range(0..values.len())].clone())
}

fn several(rng: &mut Rng) -> Vec<u8> {
    match rng.random_range(0..4) {
        0 => changed(|request| request["poses"] = json!({"poses": [[[[0, 0, 0, 0, 0, 0, 0]]]]})),
        1 => changed(|request| request["costs"][0]["smoothness"] = json!({})),
        2 => changed(|request| {
            request["initial"] = json!({"rest": {}, "capture_frame": {"frame": 4_294_967_295_u32}});
        }),
        _ => {
            let text = samples::rollout().to_string();
            text.replacen('{', "{\"frames\":1,\"frames\":2,", 1).into_bytes()
        }
    }
}

fn costs(rng: &mut Rng) -> Vec<u8> {
    let count = rng.random_range(100..5000);
    changed(|request| {
        let cost = request["costs"][0].clone();
        request["costs"] = json!(vec![cost; count]);
    })
}

fn much(rng: &mut Rng) -> Vec<u8> {
    let frames = [100_000_u64, 100_001, u64::from(u32::MAX), u64::MAX][rng.random_range(0..4)];
    let nodes = vec![2; rng.random_range(0..20_000)];
    changed(|request| {
        request["frames"] = json!(frames);
        request["returns"] = json!({"every_frames": 1, "nodes": nodes, "control_gradients": true});
    })
}

fn no_object(rng: &mut Rng) -> Vec<u8> {
    let any = ["", "null", "[]", "\"\"", "0", "{", "{}{}", "\u{feff}{}", "{\"\\ud800\":1}", "{}\0"];
    any[rng.random_range(0..any.len())].as_bytes().to_vec()
}
