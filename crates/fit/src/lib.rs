//! Search (CMA-ES) and refinement (Adam on the adjoint gradient) over any backend, with exact checkpoints.
