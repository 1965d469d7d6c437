//! What a log says: models taken and refused, samples with faults, a sensor that comes late, an image in flash.
//!
//! On the target, with the feature `defmt`; the messages go out by semihosting. `.ci/device defmt` builds it, runs it
//! in the emulator and compares what `defmt-print` makes of it with log.out.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod flash;
#[cfg(all(target_arch = "arm", target_os = "none"))]
mod run;
#[cfg(all(target_arch = "arm", target_os = "none"))]
mod sensor;

#[cfg(all(target_arch = "arm", target_os = "none"))]
fos_firmware::firmware!(run::run);

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("for the target: on a host nothing takes log messages");
}
