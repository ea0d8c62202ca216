//! End-to-end tests: real processes, one module a user story. The rules that
//! hold for the source tree as a whole are tested here too.

#[cfg(test)]
mod architecture;
#[cfg(test)]
mod documents;
#[cfg(test)]
mod tidy;
#[cfg(test)]
mod workspace;
