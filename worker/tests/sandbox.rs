//! The confinement of the process that reads captures, from inside: this program starts itself as
//! that process would be, and tries what a hijacked reader would.

use std::{
    fs, io,
    net::{TcpStream, UdpSocket},
    os::{fd::AsRawFd as _, unix::net::UnixStream},
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use bendtwin_worker::{Layer, Resources, available, confine};

/// Variable with the folder of the child. Its presence distinguishes the two processes.
const FOLDER: &str = "BENDTWIN_TEST_FOLDER";
/// Variable with the descriptor that the child inherits.
const DESCRIPTOR: &str = "BENDTWIN_TEST_DESCRIPTOR";
/// Variable that only the parent has.
const SECRET: &str = "BENDTWIN_WORKER_TOKEN";

const RESOURCES: Resources =
    Resources { memory_bytes: 512 << 20, processor_s: 60, file_bytes: 1 << 20 };

fn main() -> ExitCode {
    if let Some(folder) = std::env::var_os(FOLDER) {
        return try_everything(&PathBuf::from(folder));
    }
    let enforced = available();
    if !cfg!(target_os = "linux") || enforced.files != Layer::Full || enforced.calls != Layer::Full
    {
        eprintln!("SKIPPED: this system lacks {}", enforced.lacking().unwrap_or_default());
        return ExitCode::SUCCESS;
    }
    match start_confined() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("the probe cannot be started: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Starts this program again with a secret beside it and a descriptor too many.
fn start_confined() -> io::Result<bool> {
    let folder = tempfile::tempdir()?;
    let own = folder.path().join("own");
    fs::create_dir(&own)?;
    fs::write(own.join("capture.zip"), "a stranger's")?;
    let secret = folder.path().join("secret");
    fs::write(&secret, "somebody else's")?;
    let inherited = fs::File::open(&secret)?;
    let flags = nix::fcntl::FcntlArg::F_SETFD(nix::fcntl::FdFlag::empty());
    nix::fcntl::fcntl(&inherited, flags)?;
    let status = Command::new(std::env::current_exe()?)
        .env(FOLDER, &own)
        .env(DESCRIPTOR, inherited.as_raw_fd().to_string())
        .env(SECRET, "a token")
        .status()?;
    Ok(status.success() && own.join("result").exists())
}

/// Confines this process, then counts what it should not be able to do, and what it should.
fn try_everything(folder: &Path) -> ExitCode {
    let secret = folder.with_file_name("secret");
    let descriptor = std::env::var(DESCRIPTOR).unwrap_or_default();
    let inherited = format!("/proc/self/fd/{descriptor}");
    let parent = std::os::unix::process::parent_id();
    let mut faults = Vec::new();
    let mut expect = |what: &str, wanted: bool, outcome: io::Result<()>| {
        if outcome.is_ok() != wanted {
            faults.push(format!("{what}: {outcome:?}"));
        }
    };
    // Before: all of it works, so what is denied afterwards is denied by the confinement.
    expect("reading a file, unconfined", true, fs::read(&secret).map(drop));
    expect("the inherited descriptor, unconfined", true, fs::read_link(&inherited).map(drop));
    expect("a socket, unconfined", true, UdpSocket::bind("127.0.0.1:0").map(drop));
    expect("a program, unconfined", true, run_program());
    expect("the parent's environment, unconfined", true, read_environment(parent));

    match confine(folder, &RESOURCES) {
        Ok(enforced) if enforced.lacking().is_none() => {}
        other => expect("confining", true, Err(io::Error::other(format!("{other:?}")))),
    }

    expect("reading a file", false, fs::read(&secret).map(drop));
    expect("reading /etc/passwd", false, fs::read("/etc/passwd").map(drop));
    expect("listing a folder", false, fs::read_dir("/").map(drop));
    expect("writing a file", false, fs::write(folder.with_file_name("made"), "x"));
    expect("changing the modes of a file", false, make_readable(&secret));
    expect("removing a file", false, fs::remove_file(&secret));
    let link = folder.join("report.json");
    expect("a link", false, std::os::unix::fs::symlink(&secret, &link));
    expect("a second name of a file", false, fs::hard_link(&secret, &link));
    expect(
        "a pipe",
        false,
        nix::unistd::mkfifo(&link, nix::sys::stat::Mode::S_IRWXU).map_err(Into::into),
    );
    expect("the parent's environment", false, read_environment(parent));
    expect("the inherited descriptor", false, fs::read_link(&inherited).map(drop));
    expect("a datagram socket", false, UdpSocket::bind("127.0.0.1:0").map(drop));
    expect("a connection", false, TcpStream::connect("127.0.0.1:9").map(drop));
    expect("a pair of sockets", false, UnixStream::pair().map(drop));
    expect("a program", false, run_program());
    expect("the limits of the parent", false, lower_limits_of(parent));

    expect("its own archive", true, fs::read(folder.join("capture.zip")).map(drop));
    expect("its own result", true, fs::write(folder.join("new"), "done"));
    expect("renaming it", true, fs::rename(folder.join("new"), folder.join("result")));
    expect("a thread, confined, too", true, in_a_thread(|| fs::read("/etc/passwd").is_err()));
    expect("memory", true, in_a_thread(|| vec![1_u8; 16 << 20].len() == 16 << 20));
    for fault in &faults {
        eprintln!("{fault}");
    }
    if faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn run_program() -> io::Result<()> {
    Command::new("/bin/true").status().map(drop)
}

fn read_environment(process: u32) -> io::Result<()> {
    fs::read(format!("/proc/{process}/environ")).map(drop)
}

fn make_readable(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(path, fs::Permissions::from_mode(0o666))
}

fn lower_limits_of(process: u32) -> io::Result<()> {
    let process = i32::try_from(process).map_err(io::Error::other)?;
    rlimit::prlimit(process, rlimit::Resource::CORE, Some((0, 0)), None)
}

fn in_a_thread(work: impl FnOnce() -> bool + Send + 'static) -> io::Result<()> {
    match std::thread::spawn(work).join() {
        Ok(true) => Ok(()),
        other => Err(io::Error::other(format!("{other:?}"))),
    }
}
