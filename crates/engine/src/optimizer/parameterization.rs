//! Parameterization of a model: the parameters that an optimizer run changes, and their
//! coordinates. Logarithms suit parameters that are positive and of unknown scale.

use std::ops::Range;

use bendtwin_core::{Graph, Params};

use super::{Adam, Parameter, Position};
use crate::backend::Error;

/// Smallest positive value that a logarithm is taken of.
const TINY: f64 = 1e-9;

/// The mapping of values to coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scale {
    /// The value itself.
    Linear,
    /// The natural logarithm, for positive values.
    Logarithmic,
}

impl Scale {
    /// The coordinate of a value.
    pub fn coordinate(self, value: f32) -> f64 {
        match self {
            Self::Linear => f64::from(value),
            Self::Logarithmic => f64::from(value).max(TINY).ln(),
        }
    }

    /// The value of a coordinate.
    #[allow(clippy::cast_possible_truncation)]
    pub fn value(self, coordinate: f64) -> f32 {
        match self {
            Self::Linear => coordinate as f32,
            Self::Logarithmic => coordinate.exp() as f32,
        }
    }

    /// d value / d coordinate at a value: d/d ln p = p d/dp.
    pub fn derivative(self, value: f32) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Logarithmic => f64::from(value),
        }
    }
}

/// The coordinates of one field.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// The field.
    pub parameter: Parameter,
    /// Mapping of its values to coordinates.
    pub scale: Scale,
    /// Length of a step relative to the learning rate.
    pub rate: f64,
    /// Range of coordinates: one per value of the field, in its order.
    pub range: Range<usize>,
}

/// The coordinates of one graph's parameters. Parameters without a section keep their base values.
#[derive(Clone, Debug)]
pub struct Parameterization {
    base: Params,
    sections: Vec<Section>,
    bounds: Vec<[f64; 2]>,
}

impl Parameterization {
    /// A parameterization around these parameters, without coordinates yet.
    pub fn new(base: Params) -> Self {
        Self { base, sections: Vec::new(), bounds: Vec::new() }
    }

    /// Adds a field; a second time is ignored. `bounds` gives the bounds of a coordinate from its
    /// start, and is widened to include the start.
    #[must_use]
    pub fn with(
        mut self,
        parameter: Parameter,
        scale: Scale,
        rate: f64,
        bounds: impl Fn(f64) -> [f64; 2],
    ) -> Self {
        if self.sections.iter().any(|s| s.parameter == parameter) {
            return self;
        }
        let first = self.bounds.len();
        for &value in parameter.values(&self.base) {
            let start = scale.coordinate(value);
            let [low, high] = bounds(start);
            self.bounds.push([low.min(start), high.max(start)]);
        }
        self.sections.push(Section { parameter, scale, rate, range: first..self.bounds.len() });
        self
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.bounds.len()
    }

    /// True if there is nothing to change.
    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    /// The fields that have coordinates. Their ranges follow each other without gaps.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Least and greatest value of each coordinate, shape [len].
    pub fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    /// Each coordinate's step relative to the learning rate, shape [len].
    pub fn rates(&self) -> impl Iterator<Item = f64> + '_ {
        self.sections.iter().flat_map(|s| std::iter::repeat_n(s.rate, s.range.len()))
    }

    /// Coordinates of each field, as the kinds of [`super::Bounds`].
    pub fn kinds(&self) -> Vec<Range<usize>> {
        self.sections.iter().map(|s| s.range.clone()).collect()
    }

    /// A position at these coordinates, without momentum.
    pub fn at_rest(&self, theta: Vec<f64>) -> Position {
        Position { adam: Adam::new(theta.len(), self.sections.len()), theta }
    }

    /// The base parameters' coordinates.
    pub fn start(&self) -> Vec<f64> {
        let each = |s: &'_ Section| {
            let scale = s.scale;
            s.parameter.values(&self.base).iter().map(move |&v| scale.coordinate(v))
        };
        self.sections.iter().flat_map(each).collect()
    }

    /// The parameters at a point. `theta` has shape [len].
    pub fn params(&self, theta: &[f64]) -> Params {
        let mut params = self.base.clone();
        let mut rest = theta.iter();
        for Section { parameter, scale, .. } in &self.sections {
            let values = parameter.values_mut(&mut params);
            values.iter_mut().zip(&mut rest).for_each(|(value, &x)| *value = scale.value(x));
        }
        // Rounding to f32 must not carry an angle above pi.
        let pi = std::f32::consts::PI;
        params.rest_angles_rad.iter_mut().for_each(|a| *a = a.min(pi));
        params
    }

    /// d loss / d theta at `params`, from d loss / d params; shape [len].
    pub fn gradient(&self, params: &Params, gradient: &Params) -> Vec<f64> {
        let mut norms = Vec::with_capacity(self.len());
        for Section { parameter, scale, .. } in &self.sections {
            let pairs = parameter.values(gradient).iter().zip(parameter.values(params));
            norms.extend(pairs.map(|(&s, &value)| f64::from(s) * scale.derivative(value)));
        }
        norms
    }

    /// Checks that the base parameters fit a graph.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check(&self, graph: &Graph) -> Result<(), Error> {
        self.base.check(graph).map_err(Error::InvalidModel)
    }

    /// Checks that a position has this parameterization's length and finite numbers.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check_position(&self, position: &Position) -> Result<(), Error> {
        let arrays = [
            ("coordinates", &position.theta, self.len()),
            ("first moments", &position.adam.first, self.len()),
            ("second moments", &position.adam.second, self.sections.len()),
        ];
        for (what, values, expected) in arrays {
            if values.len() != expected {
                return Err(Error::InvalidInput(format!(
                    "a position has {} {what}, its parameterization {expected}",
                    values.len(),
                )));
            }
            if let Some(i) = values.iter().position(|x| !x.is_finite()) {
                return Err(Error::InvalidInput(format!("a position's {what}: {i} is not finite")));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
