//! Twins and their planner's twins.

mod planner;
mod twin;
