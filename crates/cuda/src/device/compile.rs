//! CUDA C++ to machine code of one architecture, through NVRTC.

use std::ffi::{CStr, CString, c_char};

use bendtwin_engine::Error;
use cudarc::nvrtc::sys;

/// True if NVRTC can be loaded on this machine.
pub(crate) fn is_present() -> bool {
    // SAFETY: loads a library by its well-known name and unloads it again.
    unsafe { sys::is_culib_present() }
}

/// Version of NVRTC, part of what identifies a compiled kernel.
pub(crate) fn version() -> Result<(i32, i32), Error> {
    let (mut major, mut minor) = (0, 0);
    // SAFETY: both point to integers.
    check(unsafe { sys::nvrtcVersion(&raw mut major, &raw mut minor) }, "nvrtcVersion")?;
    Ok((major, minor))
}

/// Compiles a source with these options, `--gpu-architecture=sm_..` among them, to a cubin.
pub(crate) fn compile(source: &str, options: &[String]) -> Result<Vec<u8>, Error> {
    let program = Program::new(source)?;
    let options: Vec<CString> = options.iter().map(|o| text(o)).collect::<Result<_, _>>()?;
    let pointers: Vec<*const c_char> = options.iter().map(|o| o.as_ptr()).collect();
    // SAFETY: the program is alive, and the count matches the options, which outlive the call.
    let compiled =
        unsafe { sys::nvrtcCompileProgram(program.0, pointers.len() as i32, pointers.as_ptr()) };
    if compiled != sys::nvrtcResult::NVRTC_SUCCESS {
        return Err(Error::Device(format!("NVRTC refuses a kernel:\n{}", program.log()?)));
    }
    program.cubin()
}

struct Program(sys::nvrtcProgram);

impl Program {
    fn new(source: &str) -> Result<Self, Error> {
        let source = text(source)?;
        let mut program = std::ptr::null_mut();
        // SAFETY: the source ends with a zero and is copied; the program has no name and no
        // headers.
        let created = unsafe {
            let none = std::ptr::null();
            sys::nvrtcCreateProgram(
                &raw mut program,
                source.as_ptr(),
                none,
                0,
                none.cast(),
                none.cast(),
            )
        };
        check(created, "nvrtcCreateProgram")?;
        Ok(Self(program))
    }

    fn log(&self) -> Result<String, Error> {
        let mut size = 0;
        // SAFETY: the program is alive; the buffer has the size that NVRTC asks for.
        unsafe {
            check(sys::nvrtcGetProgramLogSize(self.0, &raw mut size), "nvrtcGetProgramLogSize")?;
            let mut log = vec![0_u8; size.max(1)];
            check(sys::nvrtcGetProgramLog(self.0, log.as_mut_ptr().cast()), "nvrtcGetProgramLog")?;
            let log = CStr::from_bytes_until_nul(&log).map(CStr::to_string_lossy);
            Ok(log.map(String::from).unwrap_or_default())
        }
    }

    fn cubin(&self) -> Result<Vec<u8>, Error> {
        let mut size = 0;
        // SAFETY: as in `log`.
        unsafe {
            check(sys::nvrtcGetCUBINSize(self.0, &raw mut size), "nvrtcGetCUBINSize")?;
            let mut cubin = vec![0_u8; size];
            check(sys::nvrtcGetCUBIN(self.0, cubin.as_mut_ptr().cast()), "nvrtcGetCUBIN")?;
            Ok(cubin)
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // SAFETY: destroyed once; nothing refers to it any more.
        unsafe { sys::nvrtcDestroyProgram(&raw mut self.0) };
    }
}

fn text(s: &str) -> Result<CString, Error> {
    CString::new(s).map_err(|e| Error::Device(format!("a kernel's text has a zero byte: {e}")))
}

fn check(result: sys::nvrtcResult, what: &str) -> Result<(), Error> {
    match result {
        sys::nvrtcResult::NVRTC_SUCCESS => Ok(()),
        other => Err(Error::Device(format!("{what}: {other:?}"))),
    }
}
