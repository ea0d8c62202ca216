//! The results of PhysTwin's own fits: `optimal_params.pkl` of its search and `best_*.pth` of its
//! training.
//!
//! The search leaves 12 numbers; the training leaves a stiffness for each spring and contact
//! parameters. Neither says which springs there are: these follow from the case's points and the
//! radii of the search.

use crate::{
    Error, Limits,
    files::at_most,
    limits::Budget,
    pickle::{self, Pickle},
    torch,
};

/// Most neighbours of a point that a result may ask for; PhysTwin's search goes up to 80.
const MAX_NEIGHBOURS: f64 = 1024.0;
/// Largest radius [m]; PhysTwin's search goes up to 0.08.
const MAX_RADIUS_M: f64 = 10.0;

/// Numbers of `optimal_params.pkl`.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchResult {
    /// Stiffness of all springs [N per unit strain] (`global_spring_Y`).
    pub stiffness: f64,
    /// Springs between object points are at most so long [m].
    pub object_radius_m: f64,
    /// Neighbours of an object point, itself among them.
    pub object_max_neighbours: usize,
    /// Springs of control points are at most so long [m].
    pub control_radius_m: f64,
    /// Object points of a control point.
    pub control_max_neighbours: usize,
    /// Restitution and friction.
    pub contact: ContactResult,
    /// Distance within which objects collide [m].
    pub collision_distance_m: f64,
    /// Decay rate of velocity [1/s].
    pub drag: f64,
    /// Dashpot of all springs [N s/m].
    pub dashpot: f64,
}

/// Restitution and friction in a result, not yet clamped to their ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactResult {
    /// Against the ground (`collide_elas`, `collide_fric`).
    pub ground: [f64; 2],
    /// Between objects (`collide_object_elas`, `collide_object_fric`).
    pub object: [f64; 2],
}

/// Content of `best_*.pth`.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainResult {
    /// Stiffness of each spring [N per unit strain], shape [E]; those between object points first.
    pub stiffness: Vec<f32>,
    /// Number of springs between object points, if the file says it.
    pub object_spring_count: Option<usize>,
    /// Restitution and friction.
    pub contact: ContactResult,
}

impl SearchResult {
    /// Reads `optimal_params.pkl`; `at` is its name in messages.
    ///
    /// # Errors
    /// If it is damaged, asks for anything but numbers, or lacks one or holds an impossible one.
    pub fn decode(at: &str, bytes: &[u8], limits: &Limits) -> Result<Self, Error> {
        let pickle = pickle::read(at, bytes, limits, &mut Budget::new(limits))?;
        let number = |key: &str, high: f64| number(at, &pickle, key, high);
        let pair = |elas: &str, fric: &str| Ok([number(elas, 1e6)?, number(fric, 1e6)?]);
        Ok(Self {
            stiffness: number("global_spring_Y", 1e9)?,
            object_radius_m: number("object_radius", MAX_RADIUS_M)?,
            object_max_neighbours: number("object_max_neighbours", MAX_NEIGHBOURS)? as usize,
            control_radius_m: number("controller_radius", MAX_RADIUS_M)?,
            control_max_neighbours: number("controller_max_neighbours", MAX_NEIGHBOURS)? as usize,
            contact: ContactResult {
                ground: pair("collide_elas", "collide_fric")?,
                object: pair("collide_object_elas", "collide_object_fric")?,
            },
            collision_distance_m: number("collision_dist", MAX_RADIUS_M)?,
            drag: number("drag_damping", 1e6)?,
            dashpot: number("dashpot_damping", 1e6)?,
        })
    }
}

/// A number of a dictionary, in 0..=high.
fn number(at: &str, pickle: &Pickle<'_>, key: &str, high: f64) -> Result<f64, Error> {
    let missing = || Error::MissingArray { at: at.to_owned(), array: key.to_owned() };
    let number = pickle.number(key)?.ok_or_else(missing)?;
    if !(0.0..=high).contains(&number) {
        return Err(out_of_range(at, key, number, high));
    }
    Ok(number)
}

fn out_of_range(at: &str, key: &str, number: f64, high: f64) -> Error {
    let fault = format!("`{key}` is {number}: it must lie in 0..={high}");
    Error::Document { at: at.to_owned(), fault }
}

impl TrainResult {
    /// Reads `best_*.pth`; `at` is its name in messages.
    ///
    /// # Errors
    /// If it is no archive of torch, damaged, asks for anything but tensors, containers and
    /// numbers, or lacks a tensor or holds an impossible number.
    pub fn decode(at: &str, bytes: &[u8], limits: &Limits) -> Result<Self, Error> {
        let (mut files, program) = torch::open(at, bytes, limits)?;
        let pickle = torch::read(at, &program, &mut files)?;
        let mut tensor = |key: &str| {
            let missing = || Error::MissingArray { at: at.to_owned(), array: key.to_owned() };
            let tensor = pickle.tensor(key)?.ok_or_else(missing)?;
            torch::floats(&format!("{at}: {key}"), &tensor, &mut files)
        };
        let stiffness = tensor("spring_Y")?;
        at_most("springs", stiffness.len(), 50 * limits.points)?;
        if let Some(bad) = stiffness.iter().find(|k| !(k.is_finite() && **k >= 0.0)) {
            return Err(out_of_range(at, "spring_Y", f64::from(*bad), f64::from(f32::MAX)));
        }
        let mut one = |key: &str| match tensor(key)?[..] {
            [number] if number.is_finite() => Ok(f64::from(number)),
            [number] => Err(out_of_range(at, key, f64::from(number), 1.0)),
            ref several => Err(Error::Shape {
                at: format!("{at}: {key}"),
                found: vec![several.len()],
                needed: "[1]".to_owned(),
            }),
        };
        let contact = ContactResult {
            ground: [one("collide_elas")?, one("collide_fric")?],
            object: [one("collide_object_elas")?, one("collide_object_fric")?],
        };
        let count = pickle.number("num_object_springs")?;
        let object_spring_count = match count {
            Some(count) if (0.0..=stiffness.len() as f64).contains(&count) => Some(count as usize),
            Some(count) => {
                let high = stiffness.len() as f64;
                return Err(out_of_range(at, "num_object_springs", count, high));
            }
            None => None,
        };
        Ok(Self { stiffness, object_spring_count, contact })
    }
}

#[cfg(test)]
mod tests;
