//! Bundle adjustment: poses of cameras and of a board that together put its corners nearest to where
//! they were seen, by the method of Levenberg and Marquardt with Huber's weights (Triggs et al.,
//! *Bundle adjustment: a modern synthesis*, 2000). Lenses and the board's shape do not change.

use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix2x6, Matrix3, Translation3, UnitQuaternion, Vector3,
};

use crate::lens::Lens;

/// Most steps; few are needed from a good start.
const STEPS: usize = 60;
/// Distance from which a corner pulls with constant force [px].
const HUBER_PX: f64 = 1.0;

/// A corner of the board as a camera saw it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observation {
    /// Index of the camera.
    pub(crate) camera: usize,
    /// Index of the board's pose.
    pub(crate) board: usize,
    /// Place on the board [m].
    pub(crate) point: [f64; 2],
    /// Where it was seen [px].
    pub(crate) at: [f64; 2],
    /// Number of images of which this is the mean.
    pub(crate) weight: f64,
}

/// Poses of cameras and of the board.
#[derive(Clone, Debug)]
pub(crate) struct Poses {
    /// From the world to each camera.
    pub(crate) cameras: Vec<Isometry3<f64>>,
    /// From the board to the world, each time it rests; the first stays.
    pub(crate) boards: Vec<Isometry3<f64>>,
}

impl Poses {
    /// Where a corner appears less where it was seen [px]; `None` behind the camera.
    pub(crate) fn residual(&self, lenses: &[Lens], seen: &Observation) -> Option<[f64; 2]> {
        let place = self.place(seen);
        let at = lenses[seen.camera].pixel(place)?;
        Some([at[0] - seen.at[0], at[1] - seen.at[1]])
    }

    /// The corner in the camera's axes [m].
    pub(crate) fn place(&self, seen: &Observation) -> Vector3<f64> {
        let [x, y] = seen.point;
        let world = self.boards[seen.board] * nalgebra::Point3::new(x, y, 0.0);
        (self.cameras[seen.camera] * world).coords
    }

    /// Sum of Huber's costs; infinite if a corner lies behind a camera.
    fn cost(&self, lenses: &[Lens], seen: &[Observation]) -> f64 {
        let cost = |o: &Observation| match self.residual(lenses, o) {
            Some([x, y]) => {
                let r = x.hypot(y);
                let huber = if r <= HUBER_PX { r * r } else { HUBER_PX * (2.0 * r - HUBER_PX) };
                o.weight * huber
            }
            None => f64::INFINITY,
        };
        seen.iter().map(cost).sum()
    }

    /// Column of the first of six unknowns of a board's pose; the first pose has none.
    fn board_column(&self, board: usize) -> Option<usize> {
        board.checked_sub(1).map(|before| 6 * (self.cameras.len() + before))
    }

    /// Moves all poses by the six numbers of each, rotation and translation.
    fn moved(&self, step: &DVector<f64>) -> Self {
        let motion = |column: usize| {
            let part = |k: usize| {
                Vector3::new(step[column + k], step[column + k + 1], step[column + k + 2])
            };
            Isometry3::from_parts(
                Translation3::from(part(3)),
                UnitQuaternion::from_scaled_axis(part(0)),
            )
        };
        let mut moved = self.clone();
        for (index, camera) in moved.cameras.iter_mut().enumerate() {
            *camera = motion(6 * index) * *camera;
        }
        for index in 0..self.boards.len() {
            if let Some(column) = self.board_column(index) {
                moved.boards[index] = motion(column) * moved.boards[index];
            }
        }
        moved
    }

    /// Adjusts the poses and returns the root mean square distance [px].
    pub(crate) fn adjust(&mut self, lenses: &[Lens], seen: &[Observation]) -> f64 {
        let unknowns = 6 * (self.cameras.len() + self.boards.len() - 1);
        let mut damping = 1e-4;
        let mut cost = self.cost(lenses, seen);
        for _ in 0..STEPS {
            let (matrix, right) = self.normal_equations(lenses, seen, unknowns);
            let mut improved = false;
            for _ in 0..10 {
                let mut damped = matrix.clone();
                for k in 0..unknowns {
                    // What nothing determines stays.
                    damped[(k, k)] = damped[(k, k)] * (1.0 + damping) + 1e-12;
                }
                let Some(cholesky) = damped.cholesky() else {
                    damping *= 10.0;
                    continue;
                };
                let step = cholesky.solve(&right);
                let moved = self.moved(&step);
                let new = moved.cost(lenses, seen);
                if new < cost {
                    improved = new < cost * (1.0 - 1e-10);
                    (*self, cost) = (moved, new);
                    damping = (damping / 10.0).max(1e-12);
                    break;
                }
                damping *= 10.0;
            }
            if !improved {
                break;
            }
        }
        self.rms(lenses, seen)
    }

    /// Root mean square distance of corners from where they were seen [px].
    pub(crate) fn rms(&self, lenses: &[Lens], seen: &[Observation]) -> f64 {
        let squares = seen.iter().filter_map(|o| {
            let [x, y] = self.residual(lenses, o)?;
            Some(x * x + y * y)
        });
        let (sum, count) = squares.fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
        (sum / f64::from(count.max(1))).sqrt()
    }

    fn normal_equations(
        &self,
        lenses: &[Lens],
        seen: &[Observation],
        unknowns: usize,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let mut matrix = DMatrix::zeros(unknowns, unknowns);
        let mut right = DVector::zeros(unknowns);
        for o in seen {
            let place = self.place(o);
            let (Some(residual), Some(by_place)) =
                (self.residual(lenses, o), lenses[o.camera].jacobian(place))
            else {
                continue;
            };
            let distance = residual[0].hypot(residual[1]);
            let weight = o.weight * if distance > HUBER_PX { HUBER_PX / distance } else { 1.0 };
            let residual = nalgebra::Vector2::from(residual);
            let mut blocks: [Option<(usize, Matrix2x6<f64>)>; 2] = [None, None];
            let by_motion = |by: &nalgebra::Matrix2x3<f64>, at: Vector3<f64>| {
                let mut block = Matrix2x6::zeros();
                block.fixed_columns_mut::<3>(0).copy_from(&(by * -skew(at)));
                block.fixed_columns_mut::<3>(3).copy_from(by);
                block
            };
            blocks[0] = Some((6 * o.camera, by_motion(&by_place, place)));
            if let Some(column) = self.board_column(o.board) {
                let camera = &self.cameras[o.camera];
                let by_world = by_place * camera.rotation.to_rotation_matrix().matrix();
                let world = camera.inverse() * nalgebra::Point3::from(place);
                blocks[1] = Some((column, by_motion(&by_world, world.coords)));
            }
            for (row, a) in blocks.iter().flatten() {
                let part = a.transpose() * residual * weight;
                for k in 0..6 {
                    right[row + k] -= part[k];
                }
                for (column, b) in blocks.iter().flatten() {
                    let product = a.transpose() * b * weight;
                    let mut block = matrix.fixed_view_mut::<6, 6>(*row, *column);
                    block += product;
                }
            }
        }
        (matrix, right)
    }
}

/// The matrix that takes the cross product with a vector.
fn skew(v: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}
