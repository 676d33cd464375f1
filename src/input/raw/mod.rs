//! The files as they are written: every key optional, units as the keys say, nothing checked. The
//! JSON Schemas derive from these types and say what is required and in what range.

pub(super) mod job;
pub(super) mod lobes;
pub(super) mod marks;
pub(super) mod robot;
pub(super) mod session;
pub(super) mod settings;
