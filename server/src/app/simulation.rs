//! The use cases that simulate twins: rollouts, plans, sessions and plays, all with the scope
//! `rollouts:run`.

mod plans;
mod plays;
mod rollouts;
mod sessions;
