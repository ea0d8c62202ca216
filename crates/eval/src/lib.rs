//! How good a twin is: Chamfer distance, track error, baselines, pictures. Knows no optimiser.
