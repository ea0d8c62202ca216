//! End-to-end tests: real processes, one module a user story.
