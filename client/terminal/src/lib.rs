//! What `bendtwin` and `bendtwin-lab` share: options of the server ([`global`]), of the backend
//! ([`backend`]) and of the log ([`logging`]), results ([`output`], [`table`]), errors ([`failure`]),
//! progress ([`progress`]), signals, what is measured and for how long ([`measurement`]), captures
//! that are read without a server ([`observation`]), twin files ([`twin_file`]), and the choice
//! of the model that answers ([`fidelity`]).

pub mod backend;
pub mod failure;
pub mod fidelity;
pub mod global;
pub mod logging;
pub mod measurement;
pub mod observation;
pub mod output;
pub mod progress;
pub mod signals;
pub mod table;
pub mod twin_file;
