//! Capture bundles, PhysTwin cases and motion capture: read, check, make, write.
