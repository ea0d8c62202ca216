//! The choice of the backend, and how it is opened; the same of the rasteriser. The only crate that
//! knows more than one of them: workers and all commands with physics in them open theirs here.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
    str::FromStr,
    sync::Arc,
};

use bendtwin_core::{Problem, error::panic_text};
use bendtwin_engine::{self as engine, Backend};
use bendtwin_splat::{self as splat, Rasteriser};

/// Choice of the backend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// CUDA if this machine has it, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// CUDA, or nothing.
    Cuda,
}

impl FromStr for Choice {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "cuda" => Ok(Self::Cuda),
            other => Err(format!("unknown backend `{other}`: use auto, cpu or cuda")),
        }
    }
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
        })
    }
}

/// Backend and the part of its device that may be used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Choice of the backend.
    pub choice: Choice,
    /// Index of the CUDA device, as CUDA counts them.
    pub device: usize,
    /// CUDA memory that may be used [bytes]; `None` for nine tenths of the free memory.
    pub device_memory: Option<u64>,
    /// Folder in which compiled kernels are kept between runs; the user's cache folder if none.
    pub kernel_dir: Option<PathBuf>,
}

/// CUDA was asked for and cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
#[error("CUDA cannot be used: {0}")]
#[problem(FailedPrecondition, "NO_CUDA")]
pub struct Error(
    /// Message of the driver or of the CUDA backend.
    pub String,
);

/// Opens the backend that was chosen. With [`Choice::Auto`] a machine without CUDA computes on
/// its CPU, and one line of the log says why.
///
/// # Errors
/// If CUDA was asked for and cannot be used.
pub fn open(options: &Options) -> Result<Arc<dyn Backend>, Error> {
    let cuda = || bendtwin_cuda::cuda(&options.cuda());
    choose(options.choice, cuda, || engine::cpu())
}

/// Opens the rasteriser on the device that was chosen, like [`open`].
///
/// # Errors
/// If CUDA was asked for and cannot be used.
pub fn rasteriser(options: &Options) -> Result<Box<dyn Rasteriser>, Error> {
    let cuda = || match bendtwin_cuda::CudaRasteriser::new(&options.cuda()) {
        Ok(rasteriser) => Ok(Box::new(rasteriser) as Box<dyn Rasteriser>),
        Err(splat::Error::Device(why)) => Err(engine::Error::Device(why)),
        Err(other) => Err(engine::Error::Device(other.to_string())),
    };
    choose(options.choice, cuda, || Box::new(splat::Cpu::default()))
}

impl Options {
    fn cuda(&self) -> bendtwin_cuda::Options {
        bendtwin_cuda::Options {
            ordinal: self.device,
            cache_dir: self.kernel_dir.clone(),
            memory_limit: self.device_memory,
            ..bendtwin_cuda::Options::default()
        }
    }
}

fn choose<T>(
    choice: Choice,
    cuda: impl FnOnce() -> Result<T, engine::Error>,
    cpu: impl FnOnce() -> T,
) -> Result<T, Error> {
    let refusal = match choice {
        Choice::Cpu => return Ok(cpu()),
        // A driver without a function that is looked for ends in a panic.
        Choice::Auto | Choice::Cuda => match caught(cuda) {
            Ok(opened) => return Ok(opened),
            Err(engine::Error::Device(why)) => why,
            Err(other) => other.to_string(),
        },
    };
    match choice {
        Choice::Cuda => Err(Error(refusal)),
        _ => {
            tracing::info!("computing on the CPU, for CUDA cannot be used: {refusal}");
            Ok(cpu())
        }
    }
}

fn caught<T>(opening: impl FnOnce() -> Result<T, engine::Error>) -> Result<T, engine::Error> {
    catch_unwind(AssertUnwindSafe(opening))
        .unwrap_or_else(|panic| Err(engine::Error::Device(panic_text(&*panic).to_owned())))
}

#[cfg(test)]
mod tests;
