//! Motions → poses in time.
