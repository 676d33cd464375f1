//! Formats that know no robot: YAML and TOML as a tree with lines, edits of YAML that keep every
//! other byte, tables as text, NumPy's arrays, records of channels (CSV, UFF, WAV, NPY,
//! MAT), videos (YUV4MPEG, PNG, JPEG), surfaces (STL, OBJ, COLLADA), bounded reading of files.
//! The only place that names saphyr_parser, serde_yaml, toml, hound, flate2, png, zune_jpeg,
//! stl_io and tobj.

pub(crate) mod mesh;
pub(crate) mod npy;
pub(crate) mod records;
mod scalar;
pub(crate) mod table;
pub(crate) mod text;
pub(crate) mod toml;
pub(crate) mod video;
pub(crate) mod yaml;
