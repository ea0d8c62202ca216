//! Control plane: HTTP and gRPC on one port, queue, routing of rollouts. Knows no physics.
