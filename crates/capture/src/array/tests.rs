use super::*;
use crate::Limits;

fn budget() -> Budget {
    Budget::new(&Limits::default())
}

fn array(dtype: Dtype, shape: &[usize], data: &[u8]) -> Array<'static> {
    Array::new("a", dtype, shape.to_vec(), false, Cow::Owned(data.to_vec())).unwrap()
}

#[test]
fn integers_keep_their_sign_at_every_width() {
    for (dtype, bytes) in [
        (Dtype::I8, &[0xfe][..]),
        (Dtype::I16, &[0xfe, 0xff]),
        (Dtype::I32, &[0xfe, 0xff, 0xff, 0xff]),
        (Dtype::I64, &[0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]),
    ] {
        assert_eq!(array(dtype, &[1], bytes).integers(&mut budget()).unwrap(), [-2]);
    }
    assert_eq!(array(Dtype::U8, &[1], &[0xfe]).integers(&mut budget()).unwrap(), [254]);
    // Beyond i64 no index exists, so the largest number stands for it.
    assert_eq!(array(Dtype::U64, &[1], &[0xff; 8]).integers(&mut budget()).unwrap(), [i64::MAX]);
}

#[test]
fn fortran_order_of_three_dimensions() {
    let shape = vec![2, 3, 2];
    let mut data = vec![0_u8; 12];
    for (i, j, k) in (0..2).flat_map(|i| (0..3).flat_map(move |j| (0..2).map(move |k| (i, j, k)))) {
        data[i + 2 * j + 6 * k] = (i * 6 + j * 2 + k) as u8;
    }
    let array = Array::new("a", Dtype::U8, shape, true, Cow::Owned(data)).unwrap();
    assert_eq!(array.integers(&mut budget()).unwrap(), (0..12).collect::<Vec<i64>>());
}

#[test]
fn decoding_is_charged_to_the_budget() {
    let limits = Limits { total_bytes: 16, ..Limits::default() };
    let array = array(Dtype::F64, &[5], &[0; 40]);
    assert!(matches!(array.floats(&mut Budget::new(&limits)), Err(Error::TooLarge { .. })));
}

#[test]
fn types_are_not_guessed() {
    assert!(array(Dtype::I32, &[1, 3], &[0; 12]).points(&mut budget()).is_err());
    assert!(array(Dtype::F32, &[3], &[0; 12]).bools(&mut budget()).is_err());
    assert!(array(Dtype::Bool, &[3], &[0; 3]).integers(&mut budget()).is_err());
    let color = array(Dtype::U8, &[1, 3], &[255, 0, 51]).colors(&mut budget()).unwrap();
    assert_eq!(color, [[1.0, 0.0, 0.2]]);
}

#[test]
fn labels_may_be_probabilities_in_half_precision() {
    // 0, 1 and a half.
    let halves = array(Dtype::F16, &[3], &[0, 0, 0, 0x3c, 0, 0x38]);
    assert_eq!(halves.labels().range(0..3).collect::<Vec<_>>(), [0, 1, 1]);
}
