//! The compiled side of the Python package `stiction`: kernels in a table of sizes, arrays checked and copied, batches
//! on all cores, and the gathering of a MuJoCo step.

use pyo3::prelude::*;
use stiction_kernels::sizes;

mod arrays;
mod batch;
mod derivative;
mod kernel;
mod loads;
mod mujoco;
mod solve;
mod time_stepping;

#[pymodule]
fn _stiction(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let sizes: Vec<_> = sizes::DOUBLE.iter().map(|(size, _)| size.tuple()).collect();
    module.add("SIZES", sizes)?;
    module.add_class::<kernel::Kernel>()?;
    module.add_class::<mujoco::Stepper>()?;
    module.add_function(wrap_pyfunction!(mujoco::check_version, module)?)?;
    module.add_function(wrap_pyfunction!(mujoco::rollout::rollout, module)?)?;
    module.add_function(wrap_pyfunction!(solve::solve, module)?)?;
    module.add_function(wrap_pyfunction!(batch::solve_batch, module)?)?;
    module.add_function(wrap_pyfunction!(batch::batch_shape, module)?)?;
    module.add_function(wrap_pyfunction!(derivative::derivative, module)?)?;
    module.add_function(wrap_pyfunction!(derivative::fingerprint, module)?)?;
    module.add_function(wrap_pyfunction!(loads::bear, module)?)?;
    time_stepping::add(module)
}
