//! Links by the script of cortex-m-rt, which includes memory.x.

fn main() {
    for script in ["--nmagic", "-Tlink.x"] {
        println!("cargo::rustc-link-arg-bins={script}");
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
}
