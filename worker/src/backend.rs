//! Which backend computes, and how it is opened. The only place that knows of more than one: workers,
//! `bendtwin eval` and `bendtwin bench` all come here.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
    str::FromStr,
    sync::Arc,
};

use bendtwin_engine::{self as engine, Backend};

use crate::{Error, device::panic_text};

/// Which backend computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// CUDA if this machine has it, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// CUDA, or nothing.
    Cuda,
}

impl FromStr for BackendChoice {
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

impl std::fmt::Display for BackendChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
        })
    }
}

/// What computes, and what of it may be used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BackendOptions {
    /// Which backend.
    pub choice: BackendChoice,
    /// Which CUDA device, as CUDA counts them.
    pub device: usize,
    /// CUDA memory that may be used [bytes]; nine tenths of what is free if none.
    pub device_memory: Option<u64>,
    /// Where compiled kernels are kept between runs; the user's cache folder if none.
    pub kernel_dir: Option<PathBuf>,
}

/// Opens the backend that was chosen. With [`BackendChoice::Auto`] a machine without CUDA computes on
/// its CPU, and one line of the log says why.
///
/// # Errors
/// If CUDA was asked for and cannot be used.
pub fn open_backend(options: &BackendOptions) -> Result<Arc<dyn Backend>, Error> {
    let cuda = || {
        bendtwin_cuda::cuda(&bendtwin_cuda::Options {
            ordinal: options.device,
            cache_dir: options.kernel_dir.clone(),
            memory_limit: options.device_memory,
            ..bendtwin_cuda::Options::default()
        })
    };
    choose(options.choice, cuda, || engine::cpu())
}

fn choose(
    choice: BackendChoice,
    cuda: impl FnOnce() -> Result<Arc<dyn Backend>, engine::Error>,
    cpu: impl FnOnce() -> Arc<dyn Backend>,
) -> Result<Arc<dyn Backend>, Error> {
    let refusal = match choice {
        BackendChoice::Cpu => return Ok(cpu()),
        // A driver without a function that is looked for ends in a panic.
        BackendChoice::Auto | BackendChoice::Cuda => match caught(cuda) {
            Ok(backend) => return Ok(backend),
            Err(engine::Error::Device(why)) => why,
            Err(other) => other.to_string(),
        },
    };
    match choice {
        BackendChoice::Cuda => Err(Error::NoCuda(refusal)),
        _ => {
            tracing::info!("computing on the CPU, for CUDA cannot be used: {refusal}");
            Ok(cpu())
        }
    }
}

fn caught<T>(open: impl FnOnce() -> Result<T, engine::Error>) -> Result<T, engine::Error> {
    catch_unwind(AssertUnwindSafe(open))
        .unwrap_or_else(|panic| Err(engine::Error::Device(panic_text(&*panic))))
}

#[cfg(test)]
mod tests;
