//! Behaviour at a power loss, from the order of system calls.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::bench::{Bench, skipped};
use crate::workspace::output;

pub(crate) fn look(bench: &Bench) -> Result<bool, Box<dyn Error>> {
    if Command::new("strace").arg("--version").output().is_err() {
        return Ok(skipped("the order of syncs and renames (strace is not installed)"));
    }
    fs::write(bench.folder.join("ordered.json"), bench.read("grown.json")?)?;
    // A file that is always replaced, and one that is replaced only if unchanged since it was read.
    let export = ["export", "fitted.json", "--image", "unit.fosm"];
    let kept = is_in_order(&bench.folder, &bench.host_fit, &export, "unit.fosm")?
        && is_in_order(
            &bench.folder,
            &bench.host_fit,
            &["undo", "ordered.json", "--axis", "gx"],
            "ordered.json",
        )?;
    let found_out =
        !is_in_order(&bench.folder, &std::env::current_exe()?, &["write", "hasty", "hasty"], "hasty")?;
    println!(
        "\nThe contents of a file {} on the disk before the file gets its name (fsync, rename, fsync of the folder; strace of `export` \
         and `undo`). Negative control: a writer that only renames was {}detected.",
        if kept { "are" } else { "ARE NOT" },
        if found_out { "" } else { "NOT " }
    );
    Ok(kept && found_out)
}

/// The bytes are synced before the file is renamed to `target`, and the folder before the command ends.
fn is_in_order(
    folder: &Path,
    program: &Path,
    arguments: &[&str],
    target: &str,
) -> Result<bool, Box<dyn Error>> {
    let trace = folder.join("trace");
    let mut strace = Command::new("strace");
    strace
        .args(["-f", "-y", "-e", "trace=fsync,fdatasync,rename,renameat,renameat2", "-o"])
        .arg(&trace)
        .arg(program);
    output(strace.args(arguments).current_dir(folder))?;
    Ok(in_order(&fs::read_to_string(trace)?, &folder.to_string_lossy(), target))
}

/// Checks the order in a trace of strace.
fn in_order(trace: &str, folder: &str, target: &str) -> bool {
    let calls: Vec<&str> = trace.lines().map(str::trim_end).filter(|call| call.ends_with("= 0")).collect();
    let is_named = |call: &&str| call.contains("rename") && call.contains(&format!("{target}\""));
    let named: Vec<usize> = (0..calls.len()).filter(|&at| is_named(&calls[at])).collect();
    // sync(3</folder/.fos-1.tmp>)
    let synced = |call: &&str| {
        call.split_once("sync(")
            .and_then(|(_, rest)| rest.split_once('<')?.1.split_once(">)"))
            .map(|found| found.0.to_owned())
    };
    let is_beside = |path: String| {
        path.strip_prefix(folder)
            .and_then(|name| name.strip_prefix("/.fos-"))
            .is_some_and(|name| name.ends_with(".tmp") && !name.contains('/'))
    };
    match named[..] {
        [at] => {
            calls[..at].iter().filter_map(synced).any(is_beside)
                && calls[at..].iter().filter_map(synced).any(|path| path == folder)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::in_order;

    const BYTES: &str = "7 fsync(9</w/.fos-ab.tmp>) = 0\n";
    const NAME: &str = "7 rename(\"/w/.fos-ab.tmp\", \"/w/unit.fosm\") = 0\n";
    const FOLDER: &str = "7 fsync(9</w>)    = 0\n";

    #[test]
    fn requires_order_of_syncs_and_rename() {
        assert!(in_order(&[BYTES, NAME, FOLDER].concat(), "/w", "unit.fosm"));
        for other in [
            [BYTES, FOLDER, NAME],
            [NAME, BYTES, FOLDER],
            [BYTES, NAME, NAME],
            [NAME, FOLDER, ""],
            [BYTES, NAME, ""],
        ] {
            assert!(!in_order(&other.concat(), "/w", "unit.fosm"), "{other:?}");
        }
        let failed = [&BYTES.replace("= 0", "= -1 EIO"), NAME, FOLDER].concat();
        assert!(!in_order(&failed, "/w", "unit.fosm"));
    }
}
