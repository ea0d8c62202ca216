//! Synthetic captures, for tests and the demo. A body is simulated much more finely
//! than any twin, on another topology and with other damping, and then observed
//! as cameras and a tracker do, so that fitting it is no inverse crime.
//!
//! [`analytic`] draws shapes in closed form instead, for tests that need to know where each point
//! of an image lies.

pub mod analytic;
mod body;
mod cable;
mod camera;
mod error;
mod film;
mod hand;
mod observe;
mod pose;
mod raster;
mod scene;
mod sheet;
mod simulate;
mod skin;
mod take;
mod texture;

use bendtwin_capture::validate;
use bendtwin_core::Capture;
use bendtwin_engine::Backend;

pub use self::{
    error::Error,
    film::{Dyes, FilmOptions, Hands, Shape, film, film_with},
    sheet::{Sheet, SheetFilm, film_sheet},
};

/// Scene that is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scene {
    /// A foam rope that one hand lifts at its end, waves and shakes: bending above all.
    Rope,
    /// A bar of foam, twice as wide as thick, that one hand holds at its end and waves.
    Bar,
    /// The same bar cut twice as thick: at least as stiff under any fitted model.
    ThickBar,
    /// A toy-like body with four limbs, lifted by its head and shaken.
    Toy,
    /// A ring of foam, which one hand lifts at one side and waves: an object with a hole.
    Ring,
    /// A cable clamped at both ends by two grippers: motion capture, several sequences.
    Cable,
}

impl Scene {
    /// All scenes.
    pub const ALL: [Self; 6] =
        [Self::Rope, Self::Bar, Self::ThickBar, Self::Toy, Self::Ring, Self::Cable];

    /// Name, for example `rope`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rope => "rope",
            Self::Bar => "bar",
            Self::ThickBar => "thick_bar",
            Self::Toy => "toy",
            Self::Ring => "ring",
            Self::Cable => "cable",
        }
    }

    /// The scene of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }
}

/// Material of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Substance {
    /// Foam, as stiff as suits the scene.
    #[default]
    Foam,
    /// Stuffed cloth: softer, and sooner at rest.
    Plush,
    /// Rubber: stiffer, springy, and it holds to the ground.
    Rubber,
    /// Twisted fibres: stiffer, with friction between them, and smooth on the ground.
    Cord,
}

impl Substance {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Foam, Self::Plush, Self::Rubber, Self::Cord];

    /// Name, such as `foam`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Foam => "foam",
            Self::Plush => "plush",
            Self::Rubber => "rubber",
            Self::Cord => "cord",
        }
    }

    /// The material of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }
}

/// Options of making a capture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MakeOptions {
    /// Seed of noise, lost tracks and a cable's motions; the same seed gives the same capture.
    pub seed: u64,
    /// Frames of a sequence, 4 to 1000; 0 takes the scene's own length.
    pub frames: usize,
    /// A coarse simulation with few points and frames, made in a fraction of a second.
    pub tiny: bool,
    /// Recording of the object: 0 is the scene's own; others hold the same body elsewhere, move it
    /// in other ways and lay it down turned. A cable has only the first.
    pub take: u32,
    /// Material of the body; a cable has its own.
    pub material: Substance,
}

impl MakeOptions {
    /// The scene at its full size.
    pub fn full(seed: u64) -> Self {
        Self { seed, ..Self::default() }
    }

    /// A small variant for fast tests.
    pub fn tiny(seed: u64) -> Self {
        Self { seed, tiny: true, ..Self::default() }
    }

    fn frames_or(&self, full: usize, tiny: usize) -> usize {
        match self.frames {
            0 if self.tiny => tiny,
            0 => full,
            frames => frames.clamp(4, 1000),
        }
    }
}

/// Simulates and observes a scene on the CPU.
///
/// # Errors
/// If the simulation fails.
pub fn make(scene: Scene, options: &MakeOptions) -> Result<Capture, Error> {
    make_with(scene, options, bendtwin_engine::cpu().as_ref())
}

/// Simulates a scene on a given backend and observes it.
///
/// # Errors
/// If the simulation fails.
pub fn make_with(
    scene: Scene,
    options: &MakeOptions,
    backend: &dyn Backend,
) -> Result<Capture, Error> {
    let capture = match scene::setup(scene, options) {
        Some(mut setup) => {
            take::vary(&mut setup, scene, options.take);
            let mut capture = observe::record(&setup, options, backend)?;
            take::lay_down(&mut capture, options.take);
            capture
        }
        None => cable::record(options, backend)?,
    };
    validate(&capture)?;
    Ok(capture)
}

#[cfg(test)]
mod tests;
