//! Tensors as lists, and counts as indices. An absent tensor is an empty list.

use std::ops::RangeInclusive;

use bendtwin_core::Point;
use bendtwin_proto::v1::{Tensor, roll_out_response::Window};

use super::FromWire;
use crate::Error;

macro_rules! numbers {
    ($($number:ty),+) => {$(
        impl FromWire<Option<Tensor>> for Vec<$number> {
            fn from_wire(wire: Option<Tensor>, name: &str) -> Result<Self, Error> {
                let Some(tensor) = present(wire) else { return Ok(Self::new()) };
                Ok(tensor.unpack::<$number>(name).map_err(Error::malformed)?.1)
            }
        }
    )+};
}

numbers!(f32, f64, u32);

impl FromWire<Option<Tensor>> for Vec<Point> {
    fn from_wire(wire: Option<Tensor>, name: &str) -> Result<Self, Error> {
        let Some(tensor) = present(wire) else { return Ok(Self::new()) };
        Ok(tensor.unpack_points(name).map_err(Error::malformed)?.1)
    }
}

impl FromWire<Option<Tensor>> for Vec<usize> {
    fn from_wire(wire: Option<Tensor>, name: &str) -> Result<Self, Error> {
        let numbers = Vec::<u32>::from_wire(wire, name)?;
        Ok(numbers.into_iter().map(|number| number as usize).collect())
    }
}

impl FromWire<Option<Tensor>> for Vec<bool> {
    fn from_wire(wire: Option<Tensor>, name: &str) -> Result<Self, Error> {
        let numbers = Vec::<u32>::from_wire(wire, name)?;
        Ok(numbers.into_iter().map(|number| number != 0).collect())
    }
}

/// Values by their names.
impl FromWire<(Vec<String>, Option<Tensor>)> for Vec<(String, f64)> {
    fn from_wire(wire: (Vec<String>, Option<Tensor>), name: &str) -> Result<Self, Error> {
        let (names, values) = wire;
        Ok(names.into_iter().zip(Vec::<f64>::from_wire(values, name)?).collect())
    }
}

impl FromWire<u32> for usize {
    fn from_wire(wire: u32, _: &str) -> Result<Self, Error> {
        Ok(wire as usize)
    }
}

impl FromWire<Option<u32>> for Option<usize> {
    fn from_wire(wire: Option<u32>, _: &str) -> Result<Self, Error> {
        Ok(wire.map(|number| number as usize))
    }
}

impl FromWire<Option<Window>> for Option<RangeInclusive<usize>> {
    fn from_wire(wire: Option<Window>, _: &str) -> Result<Self, Error> {
        Ok(wire.map(|window| window.first_frame as usize..=window.last_frame as usize))
    }
}

fn present(tensor: Option<Tensor>) -> Option<Tensor> {
    tensor.filter(|tensor| !tensor.is_absent())
}
