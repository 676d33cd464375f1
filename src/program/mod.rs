//! Robot and CAM programs → motions, each with its line.
