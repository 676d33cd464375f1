//! Files → valid types, all faults with file and line. The only place that names urdf_rs and serde_yaml.
