//! `cargo xtask memory short|full`: logs of a working day with six axes fit into a small machine.
//!
//! `short`: half an hour, whose peak must be below the line measured by the full run. `full`: 1, 2, 4 and 8 hours on a
//! machine of 2 GiB; CSV; 200 fits in one process. Prints peaks of resident memory as Markdown. As a control, fos must
//! fail quickly with a quarter of the memory.

mod full;
mod limited;
mod line;
mod runs;

use std::error::Error;
use std::path::Path;

use crate::form::{Form, host_fit};
use limited::Limited;
use line::{at_most, holds, mega};
use runs::{Log, four_times, starved};

/// Prints the measurements; an error if they exceed the stated ones.
pub(crate) fn run(form: Form, root: &Path) -> Result<(), Box<dyn Error>> {
    if !cfg!(target_os = "linux") {
        println!("skipped: memory can be limited and measured only on Linux");
        return Ok(());
    }
    let limited = Limited::new(host_fit(root)?)?;
    println!(
        "`cargo xtask memory {}`: peak resident memory for logs of six axes at 200 Hz, limited to {} MiB of {}.\n",
        form.name(),
        limited::LIMIT >> 20,
        limited.how()
    );
    let good = if form == Form::Full { full::run(&limited)? } else { short(&limited)? };
    if good { Ok(()) } else { Err("memory exceeds a stated limit, or a negative control passed".into()) }
}

fn short(limited: &Limited) -> Result<bool, Box<dyn Error>> {
    let log = Log::new(limited, "log.parquet", 30)?;
    let fit = ["fit", "log.parquet", "--axis", "gx", "-o", "unit.json"];
    let diagnose = ["diagnose", "unit.json", "--from", "log.parquet"];
    let mut good = true;
    let mut fit_took = 0;
    println!("| half an hour, one axis | rows | peak, MB | at most, MB |\n|---|---|---|---|");
    for arguments in [&fit[..], &diagnose] {
        let ended = limited.run(arguments)?;
        println!(
            "| {} | {} | {} | {} |",
            arguments[0],
            log.rows,
            mega(ended.peak),
            mega(at_most(arguments[0], log.rows))
        );
        good &= ended.is_success() && holds(arguments[0], ended.peak, log.rows);
        fit_took = fit_took.max(if arguments == fit { ended.peak } else { 0 });
    }
    let (found_out, description) = four_times(limited, &log)?;
    println!("{description}");
    Ok(starved(limited, &fit, fit_took)? && found_out && good)
}
