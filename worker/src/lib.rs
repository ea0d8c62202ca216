//! Data plane: leases fit jobs, owns the compute device, answers rollouts. Knows no database.
