//! An extension module leaves the symbols of Python to the interpreter that loads it; the linker of macOS must be told.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
