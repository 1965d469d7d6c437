//! Writers that cannot write: on a full and on a read-only disk, and in a folder without permission.

use std::error::Error;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::bench::{Bench, skipped};
use super::careless::{self, TARGET};
use super::writer::Writer;
use crate::workspace::output;

/// Copies the inputs of a writer and the old versions of its outputs into `place`.
fn lay_out(bench: &Bench, writer: &Writer, place: &Path) -> Result<(), Box<dyn Error>> {
    for name in ["log.parquet", "field.parquet", "fitted.json", "fitted.fosm"] {
        fs::copy(bench.folder.join(name), place.join(name))?;
    }
    writer.begin(place)
}

/// The writer ended with an error that names a file and a remedy, and changed nothing.
fn is_refused_whole(
    writer: &Writer,
    place: &Path,
    ended: &Output,
    state: &str,
) -> Result<bool, Box<dyn Error>> {
    let message = String::from_utf8_lossy(&ended.stderr);
    let names = |target: &String| message.contains(target.rsplit('/').next().unwrap_or(target));
    let as_it_must = ended.status.code() == Some(1)
        && writer.targets.iter().any(names)
        && message.contains("help: ")
        && writer.content(place)? == writer.old
        && writer.beside(place).is_empty();
    if !as_it_must {
        eprintln!("{}, {state}: {}: {message}", writer.name, ended.status);
    }
    Ok(as_it_must)
}

/// Fills the remaining space of a disk.
fn fill(path: &Path) -> Result<(), Box<dyn Error>> {
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    for size in [1 << 16, 1 << 12, 1] {
        while file.write(&vec![0; size]).is_ok_and(|written| written > 0) {}
    }
    Ok(())
}

fn is_root() -> bool {
    cfg!(target_os = "linux") && fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0)
}

fn mount(options: &str, disk: &Path) -> Result<(), Box<dyn Error>> {
    output(Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(disk)).map(|_| ())
}

/// A mounted disk, unmounted when dropped.
struct Disk(PathBuf);

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

impl Disk {
    fn clear(&self) -> Result<(), Box<dyn Error>> {
        for entry in fs::read_dir(&self.0)? {
            let path = entry?.path();
            if path.is_dir() { fs::remove_dir_all(path)? } else { fs::remove_file(path)? }
        }
        Ok(())
    }

    /// Runs a writer on this disk in the given state and checks the result.
    fn ended(&self, bench: &Bench, writer: &Writer, state: &str) -> Result<bool, Box<dyn Error>> {
        self.clear()?;
        lay_out(bench, writer, &self.0)?;
        match state {
            "full" => fill(&self.0.join("filler"))?,
            _ => mount("remount,ro", &self.0)?,
        }
        let arguments: Vec<&str> = writer.arguments.iter().map(String::as_str).collect();
        let ended = bench.run(&self.0, &arguments)?;
        if state != "full" {
            mount("remount,rw", &self.0)?;
        }
        is_refused_whole(writer, &self.0, &ended, state)
    }
}

/// Runs every writer on a full and on a read-only disk.
pub(crate) fn full_and_read_only(
    bench: &Bench,
    writers: &[&Writer],
    world: &Path,
) -> Result<bool, Box<dyn Error>> {
    if !is_root() {
        return Ok(skipped("a full and a read-only disk (needs root on Linux)"));
    }
    let disk = Disk(world.join("disk"));
    fs::create_dir(&disk.0)?;
    if let Err(error) = mount("size=8m", &disk.0) {
        return Ok(skipped(&format!("a tmpfs cannot be mounted: {error}")));
    }
    let mut refused = [0, 0];
    for writer in writers {
        eprintln!("a disk that is full, or read-only: {}", writer.name);
        for (count, state) in refused.iter_mut().zip(["full", "read-only"]) {
            *count += usize::from(disk.ended(bench, writer, state)?);
        }
    }
    disk.clear()?;
    let (target, log) = (disk.0.join(TARGET), bench.folder.join("log.parquet"));
    fs::write(&target, "old".repeat(1000))?;
    fill(&disk.0.join("filler"))?;
    let status = careless::in_place(&log)?.start(&disk.0)?.wait()?;
    let found = fs::read(&target)?;
    let destroyed = !status.success() && found != "old".repeat(1000).into_bytes() && found != fs::read(log)?;
    println!(
        "\nOn a full disk {} of {} commands that write, and on a read-only disk {}, ended with exit code 1 and an error with the file \
         name and a remedy, changed no file and left no temporary file. Negative control: a writer that overwrites in place {} the \
         old file on the full disk.",
        refused[0],
        writers.len(),
        refused[1],
        if destroyed { "lost" } else { "KEPT" }
    );
    Ok(destroyed && refused == [writers.len(); 2])
}

/// Sets the permissions of everything below a folder and of the folder itself.
fn permit(folder: &Path, of_folders: u32, of_files: u32) -> Result<(), Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            permit(&path, of_folders, of_files)?;
        } else {
            File::open(&path)?.set_permissions(Permissions::from_mode(of_files))?;
        }
    }
    Ok(fs::set_permissions(folder, Permissions::from_mode(of_folders))?)
}

/// Runs every writer in a folder without write permission, as an unprivileged user.
pub(crate) fn forbidden(bench: &Bench, writers: &[&Writer], world: &Path) -> Result<bool, Box<dyn Error>> {
    let (closed, program) = (world.join("closed"), world.join("fos"));
    // The user must be able to enter the folder.
    fs::set_permissions(world, Permissions::from_mode(0o755))?;
    fs::copy(&bench.host_fit, &program)?;
    fs::set_permissions(&program, Permissions::from_mode(0o755))?;
    let mut as_they_must = 0;
    for writer in writers {
        eprintln!("a folder that may not be written into: {}", writer.name);
        fs::create_dir(&closed)?;
        lay_out(bench, writer, &closed)?;
        // The file itself is writable, so a writer in place would destroy it.
        permit(&closed, 0o555, 0o666)?;
        let mut command = if is_root() { Command::new("setpriv") } else { Command::new("env") };
        if is_root() {
            command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]);
        }
        let ended = command.arg(&program).args(&writer.arguments).current_dir(&closed).output()?;
        permit(&closed, 0o755, 0o666)?;
        as_they_must += usize::from(is_refused_whole(writer, &closed, &ended, "no rights")?);
        fs::remove_dir_all(&closed)?;
    }
    println!(
        "\nIn a folder without write permission, run by an unprivileged user, {as_they_must} of {} commands ended in the same way; the \
         files in it were writable in place.",
        writers.len()
    );
    Ok(as_they_must == writers.len())
}
