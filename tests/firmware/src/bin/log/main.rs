//! Covers all log messages: models accepted and refused, samples with faults, a late sensor, an image in flash.
//!
//! Runs on the target, with the feature `defmt`; the messages are sent by semihosting. `.ci/device defmt` builds it,
//! runs it in the emulator and compares the output of `defmt-print` with log.out.
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
