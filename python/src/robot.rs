//! A robot over arrays of poses.

use std::path::PathBuf;

use detune::model::{Placement, Robot as Model, elastic_jacobian};
use detune::modes::batch::{BatchFault, Kernel, ModesOut};
use detune::modes::{ModalSolver, tip_receptance_m_per_n};
use detune::study::Read;
use nalgebra::{Matrix6xX, Point3, Unit, Vector3};
use numpy::{
    Complex64, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1,
    PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::fault::raised;

/// A robot as its robot.yaml describes it.
#[pyclass(frozen, subclass, module = "detune._detune")]
pub(crate) struct Robot {
    model: Model,
    file: PathBuf,
    warnings: Vec<String>,
}

/// Frequencies (poses × modes), shapes (poses × modes × coordinates) and damping ratios.
type Modes<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<f64>>);

impl Robot {
    fn joints(&self) -> usize {
        self.model.joints().len()
    }

    fn modes(&self) -> usize {
        self.model.coordinates().len()
    }

    /// The poses of an array with one row each, as plain numbers.
    fn poses<'a>(&self, q: &'a PyReadonlyArray2<'_, f64>) -> PyResult<&'a [f64]> {
        let (given, joints) = (q.shape()[1], self.joints());
        if given != joints {
            let what = format!("poses have {given} columns, must have {joints}, one per joint");
            return Err(PyValueError::new_err(what));
        }
        q.as_slice().map_err(|_| PyValueError::new_err("poses must be contiguous in C order"))
    }
}

fn refused(fault: BatchFault) -> PyErr {
    PyValueError::new_err(fault.to_string())
}

#[pymethods]
impl Robot {
    #[new]
    fn new(py: Python<'_>, file: PathBuf) -> PyResult<Self> {
        let named = if file.is_dir() { file.join("robot.yaml") } else { file.clone() };
        let Read { value, warnings, .. } = py.detach(|| detune::study::map::read_robot(&named));
        let model = value.map_err(|notes| raised(py, &notes))?;
        Ok(Self { model, file, warnings: warnings.iter().map(ToString::to_string).collect() })
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> PyResult<(Py<PyAny>, (PathBuf,))> {
        Ok((slf.get_type().into_any().unbind(), (slf.get().file.clone(),)))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    /// Its robot.yaml, or the folder of it, as it was given.
    #[getter]
    fn file(&self) -> PathBuf {
        self.file.clone()
    }

    /// What its file gives rise to doubt.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// URDF names of the moving joints, base to tip: the columns of poses.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.model.joints().iter().map(|joint| joint.name.as_str()).collect()
    }

    /// Names of the elastic coordinates, base first: there are as many modes.
    #[getter]
    fn coordinate_names(&self) -> Vec<&str> {
        self.model.coordinates().iter().map(|coordinate| coordinate.name.as_str()).collect()
    }

    #[pyo3(name = "_frequencies")]
    fn frequencies<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
        parallel: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let poses = self.poses(&q)?;
        let out = PyArray2::<f64>::zeros(py, [q.shape()[0], self.modes()], false);
        {
            let mut held = out.readwrite();
            let into = held.as_slice_mut()?;
            let kernel = Kernel::new(&self.model);
            py.detach(|| match parallel {
                true => kernel.par_frequencies_hz(poses, into),
                false => kernel.frequencies_hz(poses, into),
            })
            .map_err(refused)?;
        }
        Ok(out)
    }

    #[pyo3(name = "_modes")]
    fn all_modes<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
        parallel: bool,
    ) -> PyResult<Modes<'py>> {
        let (poses, count, n) = (self.poses(&q)?, q.shape()[0], self.modes());
        let hz = PyArray2::<f64>::zeros(py, [count, n], false);
        let shapes = PyArray3::<f64>::zeros(py, [count, n, n], false);
        let damping = PyArray2::<f64>::zeros(py, [count, n], false);
        {
            let (mut f, mut phi, mut zeta) =
                (hz.readwrite(), shapes.readwrite(), damping.readwrite());
            let out = ModesOut {
                natural_frequencies_hz: f.as_slice_mut()?,
                shapes: phi.as_slice_mut()?,
                damping_ratios: zeta.as_slice_mut()?,
            };
            let kernel = Kernel::new(&self.model);
            py.detach(|| {
                if parallel { kernel.par_modes(poses, out) } else { kernel.modes(poses, out) }
            })
            .map_err(refused)?;
        }
        Ok((hz, shapes, damping))
    }

    #[pyo3(name = "_tip_response")]
    fn tip_response<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
        frequencies_hz: PyReadonlyArray1<'py, f64>,
        direction: [f64; 3],
        tcp_m: [f64; 3],
    ) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
        let poses = self.poses(&q)?;
        let (hz, count) = (frequencies_hz.to_vec()?, q.shape()[0]);
        let Some(direction) = Unit::try_new(Vector3::from(direction), 1e-12) else {
            return Err(PyValueError::new_err("direction must not be zero"));
        };
        let solved = py.detach(|| {
            let mut solver = ModalSolver::new(&self.model);
            let mut jacobian = Matrix6xX::zeros(self.modes());
            let mut all = Vec::with_capacity(count * hz.len());
            for (pose, q) in poses.chunks_exact(self.joints().max(1)).enumerate() {
                solver.solve(q).map_err(|fault| format!("pose {}: {fault}", pose + 1))?;
                let placement: &Placement = solver.placement();
                elastic_jacobian(&self.model, placement, &Point3::from(tcp_m), &mut jacobian);
                all.extend(hz.iter().map(|&hz| {
                    let g = tip_receptance_m_per_n(solver.modes(), &jacobian, &direction, hz);
                    Complex64::new(g.re, g.im)
                }));
            }
            Ok::<_, String>(all)
        });
        let all: Bound<'py, PyArray1<Complex64>> =
            solved.map_err(PyValueError::new_err)?.into_pyarray(py);
        all.reshape([count, hz.len()])
    }
}
