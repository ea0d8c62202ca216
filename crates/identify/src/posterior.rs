//! The linear-Gaussian algebra of a report. All quantities are in standard deviations before a
//! recording, so that the prior covariance is the identity.

use nalgebra::{DMatrix, DVector};

/// Standard deviation of a constant offset of all tracked points of a recording [m]: of the depth and
/// the placement of cameras.
const CAMERA_OFFSET_M: f32 = 0.005;

/// Columns as a matrix: one coordinate a row. The number of rows is given for the case without columns.
fn matrix(columns: &[Vec<f32>], rows: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns.len(), |row, column| {
        columns[column].get(row).copied().map_or(0.0, f64::from)
    })
}

/// A constant offset of all points along each axis.
fn offsets(rows: usize) -> impl Iterator<Item = Vec<f32>> {
    (0..3).map(move |axis| {
        (0..rows).map(|row| if row % 3 == axis { CAMERA_OFFSET_M } else { 0.0 }).collect()
    })
}

/// Information of a recording about the shared directions: `weight` is one over the variance of an
/// observed coordinate. What the recording's own nuisances, and a constant offset of all its points,
/// could explain is left out: they are marginalised.
pub(crate) fn information(
    shared: &[Vec<f32>],
    nuisances: &[Vec<f32>],
    weight: f64,
) -> DMatrix<f64> {
    let rows = shared.first().map_or(0, Vec::len);
    let nuisances: Vec<Vec<f32>> = nuisances.iter().cloned().chain(offsets(rows)).collect();
    let (j, k) = (matrix(shared, rows), matrix(&nuisances, rows));
    let own = j.tr_mul(&j) * weight;
    let both = j.tr_mul(&k) * weight;
    let count = nuisances.len();
    let nuisance = k.tr_mul(&k) * weight + DMatrix::identity(count, count);
    let Some(factor) = nuisance.cholesky() else { return own };
    let explained = &both * factor.solve(&both.transpose());
    let left = own - explained;
    (&left + left.transpose()) * 0.5
}

/// Covariance of the directions after recordings of this information.
pub(crate) fn covariance(information: &DMatrix<f64>) -> DMatrix<f64> {
    let n = information.nrows();
    let precision = information + DMatrix::<f64>::identity(n, n);
    precision.cholesky().map_or_else(|| DMatrix::identity(n, n), |factor| factor.inverse())
}

/// The answer of points to all directions in a motion.
pub(crate) struct Query {
    /// Rows of coordinates, points in threes; all samples of a point set follow one another.
    rows: DMatrix<f64>,
    /// Sum of the outer products of the rows.
    moment: DMatrix<f64>,
}

impl Query {
    pub(crate) fn new(columns: &[Vec<f32>]) -> Self {
        let rows = matrix(columns, columns.first().map_or(0, Vec::len));
        let moment = rows.tr_mul(&rows);
        Self { rows, moment }
    }

    /// Number of points, each sample of one counted.
    fn points(&self) -> usize {
        self.rows.nrows() / 3
    }

    /// Variance of each point of each sample [m²].
    pub(crate) fn variances(&self, covariance: &DMatrix<f64>) -> Vec<f64> {
        let Some(factor) = covariance.clone().cholesky() else { return vec![0.0; self.points()] };
        let scaled = &self.rows * factor.l();
        let square = |row: usize| scaled.row(row).iter().map(|x| x * x).sum::<f64>();
        (0..self.points()).map(|p| (3 * p..3 * p + 3).map(square).sum()).collect()
    }

    /// Root mean square standard deviation of the points [m].
    pub(crate) fn rms_m(&self, covariance: &DMatrix<f64>) -> f64 {
        let total = (covariance * &self.moment).trace();
        (total.max(0.0) / self.points().max(1) as f64).sqrt()
    }

    /// Part of the variance that would go if a direction were known, of each direction.
    pub(crate) fn shares(&self, covariance: &DMatrix<f64>) -> Vec<f64> {
        let total = (covariance * &self.moment).trace();
        let share = |g: usize| {
            let column: DVector<f64> = covariance.column(g).into_owned();
            let gone = column.dot(&(&self.moment * &column)) / covariance[(g, g)];
            if total > 0.0 { (gone / total).clamp(0.0, 1.0) } else { 0.0 }
        };
        (0..covariance.nrows()).map(share).collect()
    }
}

#[cfg(test)]
mod tests;
