//! `cargo xtask files short|full`: files written by fos are complete, old or new, under all conditions.
//!
//! `short`: some dozen kills of the quickest subcommands; `full`: more than a thousand kills of a dozen. Kills fos at
//! random moments, mostly while it writes; fills its disk; makes it read-only; removes the permission to write into its
//! folder; lets several processes change one study; checks the order of its syncs. Prints the figures as Markdown.
//! Writers without these precautions ([`careless`]) must fail.

mod bench;
pub(crate) mod careless;
mod killed;
mod order;
mod refused;
mod together;
mod writer;

use std::error::Error;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use crate::form::{Form, host_fit};
use bench::Bench;
use writer::Writer;

/// Prints the figures; an error if a file is not as promised.
pub(crate) fn run(form: Form, root: &Path) -> Result<(), Box<dyn Error>> {
    own_mounts();
    let world = tempfile::tempdir()?;
    let bench =
        Bench { host_fit: host_fit(root)?, folder: fs::canonicalize(world.path())?.join("work"), form };
    fs::create_dir(&bench.folder)?;
    let writers = bench.writers()?;
    println!(
        "`cargo xtask files {}`: state of the written files after the writer is killed (SIGKILL) at random moments.\n",
        form.name()
    );
    let of_this_form: Vec<&Writer> = writers.iter().filter(|writer| writer.is_of(form)).collect();
    let results = [
        killed::look(&bench, &writers)?,
        order::look(&bench)?,
        together::look(&bench)?,
        refused::full_and_read_only(&bench, &of_this_form, world.path())?,
        refused::forbidden(&bench, &of_this_form, world.path())?,
    ];
    if results.contains(&false) { Err("a file is not as promised".into()) } else { Ok(()) }
}

/// Moves this process into its own mount namespace, if permitted, so that mounted disks disappear with it.
fn own_mounts() {
    let inside = "FOS_OWN_MOUNTS";
    let may =
        || Command::new("unshare").args(["--mount", "true"]).output().is_ok_and(|done| done.status.success());
    if std::env::var_os(inside).is_none()
        && may()
        && let Ok(program) = std::env::current_exe()
    {
        let error = Command::new("unshare")
            .arg("--mount")
            .arg(program)
            .args(std::env::args().skip(1))
            .env(inside, "1")
            .exec();
        eprintln!("{error}: a mounted disk would remain after a kill");
    }
}
