use bendtwin_proto::v1::{Tensor, tensor::Dtype};
use serde_json::json;

use super::{JsonTensor, TensorFormat};

fn read(value: serde_json::Value) -> Option<Tensor> {
    let tensor: JsonTensor = serde_json::from_value(value).ok()?;
    tensor.read("t", Dtype::Float32).ok()
}

#[test]
fn lists_and_bytes_are_the_same_tensor() {
    let tensor = Tensor::pack(&[2, 1, 3], &[0.0f32, 1.0, 2.0, 3.0, 4.0, 5.5]);
    for format in [TensorFormat::Lists, TensorFormat::Base64] {
        let json = serde_json::to_value(JsonTensor::write(&tensor, format)).unwrap();
        assert_eq!(read(json), Some(tensor.clone()), "{format:?}");
    }
    let lists = serde_json::to_value(JsonTensor::write(&tensor, TensorFormat::Lists)).unwrap();
    assert_eq!(lists, json!([[[0.0, 1.0, 2.0]], [[3.0, 4.0, 5.5]]]));
}

#[test]
fn infinite_costs_are_null() {
    let costs = Tensor::pack(&[2], &[f64::INFINITY, 1.0]);
    let lists = serde_json::to_value(JsonTensor::write(&costs, TensorFormat::Lists)).unwrap();
    assert_eq!(lists, json!([null, 1.0]));
}

#[test]
fn broken_tensors_are_refused() {
    let broken = [
        json!(3),
        json!("x"),
        json!(null),
        json!([[1.0], [1.0, 2.0]]),
        json!([1.0, [2.0]]),
        json!(["a"]),
        json!([1e300]),
        json!([[[[[[[[[1.0]]]]]]]]]),
        json!({"dtype": "FLOAT99", "shape": [1], "data": "AAAAAA=="}),
        json!({"dtype": "FLOAT32", "shape": [1], "data": "?"}),
        json!({"dtype": "FLOAT32", "shape": [-1], "data": "AAAAAA=="}),
    ];
    for value in broken {
        assert_eq!(read(value.clone()), None, "{value}");
    }
}
