//! Writers that are killed.

use std::error::Error;
use std::os::unix::process::ExitStatusExt;
use std::time::{Duration, Instant};

use fastrand::Rng;

use super::bench::Bench;
use super::careless;
use super::writer::Writer;

const SEED: u64 = 1;
/// Of ten kills so many come while something is being written, the others anywhere in the run.
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
    /// Files under another name, at most.
    left: usize,
}

/// Kills `writer` so often, and, if it must be, until it was writing; looks at what is there after every one. Whether
/// one that is not killed leaves anything beside afterwards.
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
            // it was done before; that must have gone well
            if !status.success() || !writer.targets.iter().all(is_new) {
                return Err(format!("{}: {status}, and not all files are new", writer.name).into());
            }
            continue;
        }
        tally.kills += 1;
        // what was there at the start is swept by the next writer, so that it is not counted twice
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
    // one that is not killed clears up after those that were
    writer.begin(folder)?;
    writer.start(folder)?.wait()?;
    Ok(!writer.beside(folder).is_empty())
}

/// Every writer, and one that writes in place.
pub(crate) fn look(bench: &Bench, writers: &[Writer]) -> Result<bool, Box<dyn Error>> {
    println!(
        "| command | kills | while a file was being written | old file | new file | torn | left beside, at most |\n|---|---|---|---|---|---|---|"
    );
    let (mut all, mut good, mut chance) = (Tally::default(), true, Rng::with_seed(SEED));
    for writer in writers.iter().filter(|writer| writer.kills(bench.form) > 0) {
        eprintln!("killing {}", writer.name);
        let mut tally = Tally::default();
        // kills that hit nothing show nothing
        let stale = kill_it(bench, writer, writer.kills(bench.form), true, &mut chance, &mut tally)?;
        let Tally { kills, hits, old, new, torn, left } = tally;
        println!("| `{}` | {kills} | {hits} | {old} | {new} | {torn} | {left} |", writer.name);
        // a killed writer leaves one; the next one removes it
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
    // most of its time may go into starting: until one is torn
    while torn.torn == 0 && torn.kills < 400 {
        let kills = torn.kills + 20;
        kill_it(bench, &in_place, kills, false, &mut chance, &mut torn)?;
    }
    println!(
        "\nOf a command that writes several files each is old or new. What a killed writer leaves beside (`.fos-….tmp`) is \
         removed by the next one. Negative control: a writer of the same bytes in place, killed {} times, left {} torn files.",
        torn.kills, torn.torn
    );
    let both = all.old > 0 && (all.new > 0 || bench.form == crate::form::Form::Short);
    Ok(good && both && torn.torn > 0)
}
