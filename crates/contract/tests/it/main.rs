//! The rules of the contract on requests that are right but for one thing.

mod encoded;
mod plans;
mod prices;
mod registrations;
mod rollouts;
