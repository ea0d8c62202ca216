//! Operation of a server and of a fleet by an administrator: databases, buckets, certificates, access,
//! upgrades, traces, the trash, backup and repair.

mod backups;
mod doctor;
mod fleet;
mod healthcheck;
mod local_access;
mod logs;
mod on_postgres;
mod on_s3;
mod replicas;
mod revocation;
mod stores;
mod team;
mod tls_terminator;
mod traces;
mod trash;
mod turns;
mod upgrades;
