//! LPIPS: distance of images by the features of a network, given as a local ONNX file.
//!
//! The network's weights are not part of this project: they are trained on data with terms of
//! their own. The file is an export of the whole module `lpips.LPIPS`, so that nothing of the
//! measure but the images' range is decided here; `docs/use/looks.md` has the command.

mod arithmetic;
mod convolution;
mod error;
mod graph;
mod onnx;
mod tensor;

use std::{fs::File, io::Read, path::Path};

use self::{graph::Graph, tensor::Tensor};
pub use error::Error;

use crate::{Image, Pair};

/// Largest file [bytes]; VGG's features take 60 MB.
const MOST_BYTES: u64 = 1 << 30;

/// A network that measures distances of images.
pub struct Lpips {
    graph: Graph,
}

impl Lpips {
    /// Network of a file.
    ///
    /// # Errors
    /// A file that cannot be read, is too large, or fails in [`Lpips::decode`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let io = |source| Error::Io { at: path.display().to_string(), source };
        let mut bytes = Vec::new();
        File::open(path).map_err(io)?.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(Error::TooLarge { limit: MOST_BYTES });
        }
        Self::decode(&bytes)
    }

    /// Network of an ONNX file's content.
    ///
    /// # Errors
    /// A file that is no ONNX model, has other than two inputs and one output, weights in other
    /// files, or operators that are not read.
    pub fn decode(bytes: &[u8]) -> Result<Self, Error> {
        Graph::decode(bytes).map(|graph| Self { graph })
    }

    /// Distance of the images of a pair, 0 if they are equal. Pixels that do not count are black in
    /// both.
    ///
    /// # Errors
    /// Images too small for the network, or a network whose result is not one number.
    pub fn distance(&self, pair: &Pair<'_>) -> Result<f64, Error> {
        let result = self.graph.run([input(pair, pair.image()), input(pair, pair.reference())])?;
        match result.values.as_slice() {
            [value] if value.is_finite() => Ok(f64::from(*value)),
            [_] => Err(Error::Network("its result is not a finite number".into())),
            values => Err(Error::Network(format!("its result has {} numbers", values.len()))),
        }
    }
}

/// Image as the network takes it: shape [1, 3, height, width], -1 to 1.
fn input(pair: &Pair<'_>, image: Image<'_>) -> Tensor {
    let planes = crate::planes::channels(pair, image);
    let values = planes.iter().flat_map(|plane| plane.values.iter().map(|v| 2.0 * v - 1.0));
    Tensor { shape: vec![1, 3, image.height(), image.width()], values: values.collect() }
}

#[cfg(test)]
mod tests;
