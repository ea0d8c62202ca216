use super::*;

#[test]
fn points_survive_both_encodings() {
    let points = [[0.0, -1.0, 1.0], [0.25, 0.5, -0.75]];
    let exact = Tensor::pack_points(&[2, 1], &points);
    assert_eq!(exact.unpack_points("p").unwrap(), (vec![2, 1], points.to_vec()));
    let (shape, coarse) = Tensor::pack_points_i16(&[2], &points).unpack_points("p").unwrap();
    assert_eq!(shape, [2]);
    for (a, b) in points.iter().flatten().zip(coarse.iter().flatten()) {
        assert!((a - b).abs() < 2.0 / 65534.0);
    }
}

#[test]
fn claims_beyond_the_bytes_are_refused() {
    for shape in [vec![u64::MAX, u64::MAX], vec![1 << 40], vec![3], vec![]] {
        let tensor = Tensor { dtype: Dtype::Float32.into(), shape, ..Tensor::default() };
        assert!(tensor.unpack::<f32>("x").is_err());
    }
    let unknown = Tensor { dtype: 99, shape: vec![0], ..Tensor::default() };
    assert!(unknown.unpack::<f32>("x").is_err());
    assert!(Tensor::pack(&[1], &[1u32]).unpack::<f32>("x").is_err());
    assert!(Tensor::pack(&[2], &[1f32, 2.0]).unpack_points("x").is_err());
}
