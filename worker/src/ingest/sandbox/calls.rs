//! System calls: seccomp denies those that reading a file never needs. A list of what is denied
//! and not of what is allowed, since every version of the C library has its own way to allocate,
//! to wait and to start threads.

use std::{collections::BTreeMap, io};

use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule, TargetArch, apply_filter_all_threads,
};

use super::Layer;

/// Denied with EPERM, with any arguments.
const DENIED: &[libc::c_long] = &[
    // The network, and sockets of this machine.
    libc::SYS_socket,
    libc::SYS_socketpair,
    libc::SYS_connect,
    libc::SYS_bind,
    libc::SYS_listen,
    libc::SYS_accept,
    libc::SYS_accept4,
    libc::SYS_sendto,
    libc::SYS_sendmsg,
    libc::SYS_sendmmsg,
    libc::SYS_recvfrom,
    libc::SYS_recvmsg,
    libc::SYS_recvmmsg,
    // Other programs, also from memory.
    libc::SYS_execve,
    libc::SYS_execveat,
    libc::SYS_memfd_create,
    // Other processes: their memory, descriptors, scheduling and signals.
    libc::SYS_ptrace,
    libc::SYS_process_vm_readv,
    libc::SYS_process_vm_writev,
    libc::SYS_process_madvise,
    libc::SYS_process_mrelease,
    libc::SYS_pidfd_open,
    libc::SYS_pidfd_getfd,
    libc::SYS_pidfd_send_signal,
    libc::SYS_kcmp,
    libc::SYS_tkill,
    libc::SYS_rt_sigqueueinfo,
    libc::SYS_rt_tgsigqueueinfo,
    libc::SYS_setpriority,
    libc::SYS_sched_setscheduler,
    libc::SYS_sched_setparam,
    libc::SYS_sched_setattr,
    libc::SYS_ioprio_set,
    libc::SYS_migrate_pages,
    libc::SYS_move_pages,
    // Memory and messages shared with other processes.
    libc::SYS_shmget,
    libc::SYS_shmat,
    libc::SYS_msgget,
    libc::SYS_semget,
    libc::SYS_mq_open,
    // Modes, owners and times of files, which Landlock leaves free.
    libc::SYS_fchmod,
    libc::SYS_fchmodat,
    SYS_FCHMODAT2,
    libc::SYS_fchown,
    libc::SYS_fchownat,
    libc::SYS_utimensat,
    libc::SYS_setxattr,
    libc::SYS_lsetxattr,
    libc::SYS_fsetxattr,
    libc::SYS_removexattr,
    libc::SYS_lremovexattr,
    libc::SYS_fremovexattr,
    libc::SYS_mknodat,
    // Links, which would lead the worker elsewhere when it fetches the results.
    libc::SYS_symlinkat,
    libc::SYS_linkat,
    libc::SYS_name_to_handle_at,
    libc::SYS_open_by_handle_at,
    libc::SYS_fanotify_init,
    // Mounts and namespaces.
    libc::SYS_mount,
    libc::SYS_umount2,
    libc::SYS_pivot_root,
    libc::SYS_chroot,
    libc::SYS_open_tree,
    libc::SYS_move_mount,
    libc::SYS_fsopen,
    libc::SYS_fsconfig,
    libc::SYS_fsmount,
    libc::SYS_fspick,
    libc::SYS_mount_setattr,
    libc::SYS_unshare,
    libc::SYS_setns,
    // Identity.
    libc::SYS_setuid,
    libc::SYS_setgid,
    libc::SYS_setreuid,
    libc::SYS_setregid,
    libc::SYS_setresuid,
    libc::SYS_setresgid,
    libc::SYS_setgroups,
    libc::SYS_setfsuid,
    libc::SYS_setfsgid,
    libc::SYS_capset,
    // Parts of the kernel where defects were found again and again.
    libc::SYS_bpf,
    libc::SYS_perf_event_open,
    libc::SYS_userfaultfd,
    libc::SYS_io_uring_setup,
    libc::SYS_io_uring_enter,
    libc::SYS_io_uring_register,
    libc::SYS_io_setup,
    libc::SYS_keyctl,
    libc::SYS_add_key,
    libc::SYS_request_key,
    libc::SYS_personality,
    // The machine.
    libc::SYS_init_module,
    libc::SYS_finit_module,
    libc::SYS_delete_module,
    libc::SYS_kexec_load,
    libc::SYS_kexec_file_load,
    libc::SYS_reboot,
    libc::SYS_swapon,
    libc::SYS_swapoff,
    libc::SYS_acct,
    libc::SYS_quotactl,
    libc::SYS_sethostname,
    libc::SYS_setdomainname,
    libc::SYS_settimeofday,
    libc::SYS_clock_settime,
    libc::SYS_clock_adjtime,
    libc::SYS_adjtimex,
    libc::SYS_syslog,
    libc::SYS_vhangup,
];

/// Newer than some C libraries; one number on all processors.
const SYS_FCHMODAT2: libc::c_long = 452;

/// Calls that only this processor has.
#[cfg(target_arch = "x86_64")]
const DENIED_HERE: &[libc::c_long] = &[
    libc::SYS_fork,
    libc::SYS_vfork,
    libc::SYS_chmod,
    libc::SYS_chown,
    libc::SYS_lchown,
    libc::SYS_utime,
    libc::SYS_utimes,
    libc::SYS_futimesat,
    libc::SYS_mknod,
    libc::SYS_symlink,
    libc::SYS_link,
    libc::SYS_iopl,
    libc::SYS_ioperm,
];
#[cfg(not(target_arch = "x86_64"))]
const DENIED_HERE: &[libc::c_long] = &[];

/// Denies the calls to this process irrevocably.
pub(super) fn deny() -> io::Result<Layer> {
    let Ok(arch) = TargetArch::try_from(std::env::consts::ARCH) else { return Ok(Layer::Missing) };
    if available() == Layer::Missing {
        return Ok(Layer::Missing);
    }
    // The C library takes ENOSYS for an older kernel and calls `clone`, whose flags can be read.
    let newer = BTreeMap::from([(libc::SYS_clone3, Vec::new())]);
    install(newer, libc::ENOSYS, arch)?;
    install(rules().map_err(io::Error::other)?, libc::EPERM, arch)?;
    Ok(Layer::Full)
}

/// Completeness of seccomp in this kernel.
pub(super) fn available() -> Layer {
    let known = TargetArch::try_from(std::env::consts::ARCH).is_ok();
    let has = std::fs::read_to_string("/proc/sys/kernel/seccomp/actions_avail")
        .is_ok_and(|actions| actions.split_whitespace().any(|action| action == "errno"));
    if known && has { Layer::Full } else { Layer::Missing }
}

fn install(rules: BTreeMap<i64, Vec<SeccompRule>>, errno: i32, arch: TargetArch) -> io::Result<()> {
    let answer = SeccompAction::Errno(errno.unsigned_abs());
    let filter = SeccompFilter::new(rules, SeccompAction::Allow, answer, arch);
    let program: BpfProgram = filter.and_then(BpfProgram::try_from).map_err(io::Error::other)?;
    apply_filter_all_threads(&program).map_err(io::Error::other)
}

fn rules() -> Result<BTreeMap<i64, Vec<SeccompRule>>, seccompiler::BackendError> {
    let first = |length, operator, value| -> Result<_, seccompiler::BackendError> {
        let condition = SeccompCondition::new(0, length, operator, value)?;
        Ok(vec![SeccompRule::new(vec![condition])?])
    };
    let other_than = |value| first(SeccompCmpArgLen::Dword, SeccompCmpOp::Ne, value);
    let this = u64::from(std::process::id());
    let thread = u64::from(libc::CLONE_THREAD.unsigned_abs());
    let conditional = [
        // Threads, but no processes.
        (libc::SYS_clone, first(SeccompCmpArgLen::Qword, SeccompCmpOp::MaskedEq(thread), 0)?),
        // Limits of this process, but of no other.
        (libc::SYS_prlimit64, other_than(0)?),
        // Signals to itself: an abort is one.
        (libc::SYS_kill, other_than(this)?),
        (libc::SYS_tgkill, other_than(this)?),
    ];
    let always = DENIED.iter().chain(DENIED_HERE).map(|call| (*call, Vec::new()));
    let mut rules: BTreeMap<i64, _> = always.chain(conditional).collect();
    deny_x32(&mut rules);
    Ok(rules)
}

/// Denies the calls' second numbers on x86-64, which exist for programs with short pointers; some
/// calls have another number there.
#[cfg(target_arch = "x86_64")]
fn deny_x32(rules: &mut BTreeMap<i64, Vec<SeccompRule>>) {
    const X32: i64 = 0x4000_0000;
    const OWN_NUMBERS: std::ops::RangeInclusive<i64> = 512..=547;
    let numbers: Vec<i64> = rules.keys().copied().chain(OWN_NUMBERS).collect();
    rules.extend(numbers.into_iter().map(|number| (number | X32, Vec::new())));
}

#[cfg(not(target_arch = "x86_64"))]
fn deny_x32(_: &mut BTreeMap<i64, Vec<SeccompRule>>) {}
