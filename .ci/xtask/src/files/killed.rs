//! Kills writers.

use std::error::Error;
use std::os::unix::process::ExitStatusExt;
use std::time::{Duration, Instant};

use fastrand::Rng;

use super::bench::Bench;
use super::careless;
use super::writer::Writer;

const SEED: u64 = 1;
/// Number of kills, out of ten, that occur while a file is being written; the others occur at any time.
const WATCHED: u32 = 7;
const SIGKILL: i32 = 9;

#[derive(Default)]
struct Tally {
    kills: usize,
    /// Kills while a file was being written.
    hits: usize,
    old: usize,
    new: usize,
    torn: usize,
    /// Largest number of temporary files.
    left: usize,
}

/// Kills `writer` the given number of times, and further until one kill hit a write; checks the files after each.
/// Returns whether an undisturbed run leaves temporary files.
fn kill_it(
    bench: &Bench,
    writer: &Writer,
    kills: usize,
    must_hit: bool,
    chance: &mut Rng,
    tally: &mut Tally,
) -> Result<bool, Box<dyn Error>> {
    let folder = &bench.folder;
    let learnt = writer.learn(folder)?;
    while tally.kills < kills || (must_hit && tally.hits == 0 && tally.kills < 10 * kills) {
        writer.begin(folder)?;
        let known = writer.beside(folder);
        let watched = chance.u32(..10) < WATCHED && learnt.window > Duration::ZERO;
        let which = chance.usize(..writer.targets.len());
        let within = if watched { learnt.window.mul_f64(1.5) } else { learnt.takes.mul_f64(1.05) };
        let at = within.mul_f64(chance.f64());
        let mut process = writer.start(folder)?;
        let mut began = Instant::now();
        if watched {
            let mut seen = known.clone();
            while process.try_wait()?.is_none() && seen.len() <= known.len() + which {
                seen.extend(writer.beside(folder));
            }
            began = Instant::now();
        }
        while began.elapsed() < at && process.try_wait()?.is_none() {}
        process.kill()?;
        let status = process.wait()?;
        let left = writer.beside(folder);
        tally.left = tally.left.max(left.len());
        let found = writer.content(folder)?;
        let is_new = |target: &String| found[target] == learnt.new[target];
        if status.signal() != Some(SIGKILL) {
            // The writer had finished, which must have succeeded.
            if !status.success() || !writer.targets.iter().all(is_new) {
                return Err(format!("{}: {status}, and not all files are new", writer.name).into());
            }
            continue;
        }
        tally.kills += 1;
        // The next writer removes older temporary files, so that none is counted twice.
        tally.hits += usize::from(left.difference(&known).next().is_some());
        for target in &writer.targets {
            let count = match () {
                () if is_new(target) => &mut tally.new,
                () if found[target] == writer.old[target] => &mut tally.old,
                () => &mut tally.torn,
            };
            *count += 1;
        }
    }
    // An undisturbed writer removes the files of killed ones.
    writer.begin(folder)?;
    writer.start(folder)?.wait()?;
    Ok(!writer.beside(folder).is_empty())
}

/// Every writer, and a control that writes in place.
pub(crate) fn look(bench: &Bench, writers: &[Writer]) -> Result<bool, Box<dyn Error>> {
    println!(
        "| command | kills | of which during a write | old file | new file | torn | temporary files left, at most |\n|---|---|---|---|---|---|---|"
    );
    let (mut all, mut good, mut chance) = (Tally::default(), true, Rng::with_seed(SEED));
    for writer in writers.iter().filter(|writer| writer.kills(bench.form) > 0) {
        eprintln!("killing {}", writer.name);
        let mut tally = Tally::default();
        // Kills that hit no write prove nothing.
        let stale = kill_it(bench, writer, writer.kills(bench.form), true, &mut chance, &mut tally)?;
        let Tally { kills, hits, old, new, torn, left } = tally;
        println!("| `{}` | {kills} | {hits} | {old} | {new} | {torn} | {left} |", writer.name);
        // A killed writer leaves one temporary file, which the next one removes.
        if torn > 0 || left > 1 || stale || hits == 0 {
            eprintln!("{}: torn {torn}, left {left}, stale {stale}, hits {hits}", writer.name);
            good = false;
        }
        let sum = |a, b| a + b;
        all = Tally {
            kills: sum(all.kills, kills),
            hits: sum(all.hits, hits),
            old: sum(all.old, old),
            new: sum(all.new, new),
            torn: sum(all.torn, torn),
            left: 0,
        };
    }
    println!("| all | {} | {} | {} | {} | {} | |", all.kills, all.hits, all.old, all.new, all.torn);
    let in_place = careless::in_place(&bench.folder.join("log.parquet"))?;
    let mut torn = Tally::default();
    // Most of the time may be spent on starting, so it is repeated until a file is damaged.
    while torn.torn == 0 && torn.kills < 400 {
        let kills = torn.kills + 20;
        kill_it(bench, &in_place, kills, false, &mut chance, &mut torn)?;
    }
    println!(
        "\nEach file of a command that writes several is either old or new. The next writer removes the temporary file \
         (`.fos-….tmp`) of a killed one. Negative control: a writer that overwrites in place, killed {} times, left {} torn files.",
        torn.kills, torn.torn
    );
    let both = all.old > 0 && (all.new > 0 || bench.form == crate::form::Form::Short);
    Ok(good && both && torn.torn > 0)
}
