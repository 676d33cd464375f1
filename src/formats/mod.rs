//! Formats that know no robot: YAML as a tree with lines, edits of YAML that keep every other byte,
//! tables as text, bounded reading of files. The only place that names saphyr_parser and
//! serde_yaml.

pub(crate) mod table;
pub(crate) mod text;
pub(crate) mod yaml;
