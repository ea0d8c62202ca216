//! Suites of fits.
