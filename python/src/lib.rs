//! The Python module of detune: thin over the library's studies. What they return goes out as JSON,
//! which `detune/results.py` makes objects of; arrays of numbers go in and out as numpy's.

mod fault;
mod robot;
mod studies;

use pyo3::prelude::*;

#[pymodule]
fn _detune(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<robot::Robot>()?;
    module.add_function(wrap_pyfunction!(studies::job_files, module)?)?;
    module.add_function(wrap_pyfunction!(studies::check, module)?)?;
    module.add_function(wrap_pyfunction!(studies::advise, module)?)?;
    module.add_function(wrap_pyfunction!(studies::identify, module)?)?;
    module.add_function(wrap_pyfunction!(studies::diagnose, module)?)?;
    module.add_function(wrap_pyfunction!(studies::map, module)?)?;
    module.add_function(wrap_pyfunction!(studies::run, module)?)?;
    Ok(())
}
