//! Files → valid types: YAML, URDF, CSV. Raw input and valid input are different types; all faults of a
//! file are reported in one go, each with file and line. The only place that names urdf_rs and serde_yaml.

mod fault;

pub use fault::Fault;
