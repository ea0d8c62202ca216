//! Convolution and pooling of images.

use rayon::prelude::*;

use super::{
    Error,
    tensor::{Tensor, size},
};

/// Windows that move over an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Windows {
    /// Steps along rows and columns.
    pub(super) strides: [usize; 2],
    /// Values added above, left, below, right.
    pub(super) pads: [usize; 4],
}

impl Windows {
    /// Number of windows of a size along the axis 0 (rows) or 1.
    fn count(&self, axis: usize, image: usize, window: usize) -> Result<usize, Error> {
        let padded =
            image.checked_add(self.pads[axis]).and_then(|n| n.checked_add(self.pads[axis + 2]));
        let count = padded.and_then(|n| n.checked_sub(window)).map(|n| n / self.strides[axis] + 1);
        count.filter(|_| window > 0).ok_or_else(|| {
            Error::Network(format!(
                "an image of {image} pixels is smaller than a window of {window}"
            ))
        })
    }

    /// Index in the image of a window's value, if it is inside.
    fn inside(&self, axis: usize, at: usize, offset: usize, image: usize) -> Option<usize> {
        (at * self.strides[axis] + offset).checked_sub(self.pads[axis]).filter(|i| *i < image)
    }
}

/// Convolution with weights [out, in, rows, columns] and perhaps a bias [out]:
/// out[o, y, x] = bias[o] + sum over c, j, i of weight[o, c, j, i] in[c, s y + j - p, s x + i - p].
pub(super) fn conv(
    x: &Tensor,
    weights: &Tensor,
    bias: Option<&Tensor>,
    windows: Windows,
) -> Result<Tensor, Error> {
    let [_, channels, height, width] = x.image_shape("Conv")?;
    let [outs, ins, rows, columns] = match weights.shape[..] {
        [o, i, r, c] => [o, i, r, c],
        _ => return Err(Error::Network(format!("weights of the shape {:?}", weights.shape))),
    };
    if ins != channels || bias.is_some_and(|b| b.values.len() != outs) {
        let shape = &weights.shape;
        return Err(Error::Network(format!("weights {shape:?} do not fit {channels} channels")));
    }
    let out_height = windows.count(0, height, rows)?;
    let out_width = windows.count(1, width, columns)?;
    let shape = vec![1, outs, out_height, out_width];
    let mut values = vec![0f32; size(&shape)?];
    let plane = (out_height * out_width).max(1);
    values.par_chunks_mut(plane).enumerate().for_each(|(o, out)| {
        out.fill(bias.map_or(0.0, |b| b.values[o]));
        for tap in 0..ins * rows * columns {
            let weight = weights.values[o * ins * rows * columns + tap];
            let (c, j, i) = (tap / (rows * columns), tap / columns % rows, tap % columns);
            for (y, line) in out.chunks_exact_mut(out_width).enumerate() {
                let Some(from) = windows.inside(0, y, j, height) else { continue };
                let row = &x.values[(c * height + from) * width..][..width];
                for (at, sum) in line.iter_mut().enumerate() {
                    if let Some(column) = windows.inside(1, at, i, width) {
                        *sum += weight * row[column];
                    }
                }
            }
        }
    });
    Ok(Tensor { shape, values })
}

/// Largest value of each window.
pub(super) fn max_pool(x: &Tensor, kernel: [usize; 2], windows: Windows) -> Result<Tensor, Error> {
    let [_, channels, height, width] = x.image_shape("MaxPool")?;
    let out_height = windows.count(0, height, kernel[0])?;
    let out_width = windows.count(1, width, kernel[1])?;
    let shape = vec![1, channels, out_height, out_width];
    let count = size(&shape)?;
    let plane = (out_height * out_width).max(1);
    let value = |index: usize| {
        let (c, y, at) = (index / plane, index % plane / out_width, index % out_width);
        let rows = (0..kernel[0]).filter_map(|j| windows.inside(0, y, j, height));
        let found = rows.flat_map(|row| {
            let columns = (0..kernel[1]).filter_map(move |i| windows.inside(1, at, i, width));
            columns.map(move |column| x.values[(c * height + row) * width + column])
        });
        found.fold(f32::NEG_INFINITY, f32::max)
    };
    Ok(Tensor { values: (0..count).into_par_iter().map(value).collect(), shape })
}
