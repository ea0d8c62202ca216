//! Errors of an authority.

use std::path::PathBuf;

use bendtwin_core::Problem;
use jiff::Timestamp;

use super::AUTHORITY_DAYS;
use crate::FileError;

/// An error of an authority.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// A file would be overwritten.
    #[error(
        "{} exists: name another folder for another authority, or issue with --renew to replace a \
         certificate", path.display()
    )]
    #[problem(AlreadyExists, "CA_FILE_EXISTS")]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The folder has no authority.
    #[error("there is no authority in {}: make one with `bendtwin ca init`", folder.display())]
    #[problem(NotFound, "NO_CA")]
    Missing {
        /// The folder.
        folder: PathBuf,
    },
    /// The name cannot be that of a file and of a host.
    #[error(
        "`{0}` is no name for a certificate: use up to 63 letters, digits, `-` and `.`, and neither \
         `ca` nor `crl`"
    )]
    #[problem(InvalidArgument, "INVALID_ARGUMENT")]
    Name(String),
    /// The authority issued no such certificate.
    #[error(
        "the authority in {0} issued no certificate `{what}`: give a name or a serial number of \
         `bendtwin ca list {0}`, or the file of the certificate", folder.display()
    )]
    #[problem(NotFound, "CERTIFICATE_UNKNOWN")]
    Unknown {
        /// Name, serial number or file that was asked for.
        what: String,
        /// The folder.
        folder: PathBuf,
    },
    /// A file is of another authority.
    #[error(
        "{} is of another authority, `{issuer}`: name the folder of that one", path.display()
    )]
    #[problem(InvalidArgument, "INVALID_ARGUMENT")]
    OfAnother {
        /// The file.
        path: PathBuf,
        /// Common name of that authority.
        issuer: String,
    },
    /// Not a host name or address.
    #[error("`{0}` is neither a host name nor an address: give it without scheme and port")]
    #[problem(InvalidArgument, "INVALID_ARGUMENT")]
    Host(String),
    /// The validity is out of range.
    #[error("{0} days are no validity: give 1 to {AUTHORITY_DAYS}")]
    #[problem(InvalidArgument, "INVALID_ARGUMENT")]
    Days(i64),
    /// The certificate would hold longer than that of the authority.
    #[error(
        "a certificate of {days} days would outlive the authority, which ends at {end:.0}: give \
         fewer days, or make another authority"
    )]
    #[problem(InvalidArgument, "INVALID_ARGUMENT")]
    TooLong {
        /// Days that were asked for.
        days: i64,
        /// End of the authority.
        end: Timestamp,
    },
    /// A file of the authority cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    #[problem(FailedPrecondition, "FILE_UNUSABLE")]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A certificate cannot be made.
    #[error("no certificate can be made: {0}")]
    #[problem(Internal, "CA_FAILED")]
    Generation(#[from] rcgen::Error),
    /// A certificate cannot be read, or the clock is out of range.
    #[error("the certificate cannot be read: is the clock of this machine right?")]
    #[problem(Internal, "CA_FAILED")]
    Unreadable,
}
