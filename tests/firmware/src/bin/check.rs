//! An exported model checks itself: the same bits on the board as on the machine that exported it.
//!
//! The source is the output of `fos export --rust` for the model of tests/tests/workspace/exported_model.
#![cfg_attr(target_os = "none", no_std, no_main)]

use fos_firmware::{Instructions, fail, println};

#[allow(unreachable_pub, reason = "exported to be used from anywhere in a firmware")]
mod exported {
    include!("../../../golden/model.rs");
}

fn run() {
    let mut instructions = Instructions::start();
    let mut checked = Ok(());
    let cost = instructions.of(|| checked = exported::check());
    if let Err(error) = checked {
        fail(format_args!("{error}"));
    }
    let samples = exported::TEST_VECTOR.samples.len();
    let stack = size_of::<exported::ModelHub>();
    println!("test vector: {samples} samples, every bit as exported; a hub of {stack} bytes on the stack");
    // on the host nothing is counted
    if cost.is_finite() {
        println!("{cost:.0} instructions, those that build the model among them");
    }
}

fos_firmware::firmware!(run);
