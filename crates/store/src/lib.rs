//! The durable truth: captures, fit jobs (the queue), twins and blobs, on SQLite and files.
