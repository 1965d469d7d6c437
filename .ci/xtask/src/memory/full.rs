//! Measures logs of up to eight hours, with all axes.

use std::error::Error;
use std::process::{Command, Stdio};

use super::limited::Limited;
use super::line::{BASE, BYTES_A_ROW, holds, mega};
use super::runs::{Log, four_times, starved};

const AXES: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

/// Least squares over (rows, bytes): bytes, and bytes per row.
fn line(points: &[(u64, u64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |of: fn(&(u64, u64)) -> u64| points.iter().map(|point| of(point) as f64).sum::<f64>() / n;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let products = points.iter().map(|point| (point.0 as f64 - x) * (point.1 as f64 - y)).sum::<f64>();
    let slope = products / points.iter().map(|point| (point.0 as f64 - x).powi(2)).sum::<f64>();
    (y - slope * x, slope)
}

/// Runs of one length: peak memory of each command.
fn peaks(limited: &Limited, axes: &[&str]) -> Result<([u64; 3], bool), Box<dyn Error>> {
    let (mut peaks, mut good) = ([0; 3], true);
    let mut run = |at: usize, arguments: &[&str]| -> Result<(), Box<dyn Error>> {
        let ended = limited.run(arguments)?;
        good &= ended.is_success();
        peaks[at] = peaks[at].max(ended.peak);
        Ok(())
    };
    run(0, &["fit", "log.parquet", "--axis", "all", "-o", "unit.json"])?;
    for axis in axes {
        run(1, &["diagnose", "unit.json", "--from", "log.parquet", "--axis", axis])?;
    }
    for axis in axes {
        run(
            2,
            &["report", "unit.json", "--from", "log.parquet", "--axis", axis, "-o", &format!("{axis}.html")],
        )?;
    }
    Ok((peaks, good))
}

pub(crate) fn run(limited: &Limited) -> Result<bool, Box<dyn Error>> {
    let (mut good, mut found_out, mut control) = (true, false, String::new());
    let mut points: [Vec<(u64, u64)>; 3] = Default::default();
    println!(
        "| hours | rows | data as f64, MB | simulate, MB | fit of six axes, MB (× data) | diagnose, MB (× data) | report, MB (× data) |"
    );
    println!("|---|---|---|---|---|---|---|");
    for hours in [1, 2, 4, 8] {
        eprintln!("{hours} h");
        let log = Log::new(limited, "log.parquet", 60 * hours)?;
        // All axes of the longest log, one axis of the others: axes are processed in turn, so more axes need no
        // more memory.
        let (peaks, succeeded) = peaks(limited, if hours == 8 { &AXES } else { &AXES[3..4] })?;
        good &= succeeded;
        let mut row = format!("| {hours} | {} | {} | {} |", log.rows, mega(log.raw), mega(log.peak));
        for (at, (command, _)) in BYTES_A_ROW.into_iter().enumerate() {
            good &= holds(command, peaks[at], log.rows);
            points[at].push((log.rows, peaks[at]));
            row += &format!(" {} ({:.1}) |", mega(peaks[at]), peaks[at] as f64 / log.raw as f64);
        }
        println!("{row}");
        if hours == 1 {
            (found_out, control) = four_times(limited, &log)?;
        }
    }
    let all_axes_took = points[0].last().map_or(0, |point| point.1);
    let lines = BYTES_A_ROW.iter().zip(&points).map(|((command, _), points)| {
        let (base, slope) = line(points);
        format!("{command} {:.0} MB + {slope:.0} bytes per row", base / 1e6)
    });
    let bounds = BYTES_A_ROW.map(|(command, bytes)| format!("{command} {bytes}")).join(", ");
    println!(
        "\nLinear fit of the peaks: {}. The limit in `short` and `full` is {} MB plus, in bytes per row, {bounds}. \
         At 8 h diagnose and report processed every axis, one after the other.",
        lines.collect::<Vec<_>>().join("; "),
        mega(BASE)
    );
    let text = Log::new(limited, "log.csv.gz", 480)?;
    let ended = limited.run(&["fit", text.name, "--axis", "gx", "-o", "text.json"])?;
    good &= ended.is_success();
    println!(
        "\nThe same 8 h as gzip-compressed CSV: writing takes {} MB, fitting one axis {} MB.",
        mega(text.peak),
        mega(ended.peak)
    );
    let (summary, succeeded) = flat()?;
    println!("\n`cargo test --release -p host-fit --test flat_memory`: {summary}.\n{control}");
    let starved =
        starved(limited, &["fit", "log.parquet", "--axis", "all", "-o", "unit.json"], all_axes_took)?;
    Ok(starved && found_out && good && succeeded)
}

/// Memory of many fits in one process, as reported by their test.
fn flat() -> Result<(String, bool), Box<dyn Error>> {
    let arguments = ["test", "--release", "-p", "host-fit", "--test", "flat_memory", "--", "--nocapture"];
    let ended = Command::new("cargo").args(arguments).stderr(Stdio::inherit()).output()?;
    let printed = String::from_utf8(ended.stdout)?;
    let summary: Vec<&str> = printed
        .lines()
        .filter(|line| line.contains("in one process") || line.starts_with("skipped"))
        .collect();
    Ok((summary.concat(), ended.status.success() && summary.len() == 1))
}

#[cfg(test)]
mod tests {
    #[test]
    fn line_fits_collinear_points() {
        let (base, slope) = super::line(&[(1, 13), (2, 23), (4, 43)]);
        assert!((base - 3.0).abs() < 1e-9 && (slope - 10.0).abs() < 1e-9);
    }
}
