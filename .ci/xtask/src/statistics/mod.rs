//! `cargo xtask statistics short|full`: accuracy of the diagnosis. The figures of README and of the summary in
//! docs/calibration.md follow from the tables there, which one command writes.
//!
//! `short` compares README, the summary and the tables, and checks the intervals against the counts; it takes no time.
//! `full` calibrates and writes all of them, about ten minutes of two cores, and checks that a diagnosis that finds
//! nothing fails. The gate itself runs a part of the calibration on another seed, and fails if a figure certainly
//! misses its goal.

mod anew;
mod interval;
mod page;

use std::error::Error;
use std::fs;
use std::ops::Range;
use std::path::Path;

use crate::form::Form;
use interval::upper_end;
use page::{CALIBRATION, CASES, README, SEEDS, figures, headline, holds, section, summary};

const FALSE_ALARM: &str = "false alarm with nothing missing";

/// Prints the stated rates as Markdown.
pub(crate) fn run(form: Form, root: &Path) -> Result<(), Box<dyn Error>> {
    let missed = if form == Form::Full { Some(anew::calibrate(root)?) } else { None };
    let (readme, page) = (fs::read_to_string(README)?, fs::read_to_string(CALIBRATION)?);
    check(&readme, &page)?;
    let (alarms, cases, most) = promised(&page)?;
    let gate = fs::read_to_string(".ci/run")?;
    let (in_gate, seed) = gate
        .split_once("calibrate --cases ")
        .and_then(|(_, rest)| rest.split_once(" --check")?.0.split_once(" --seed "))
        .ok_or(".ci/run runs no part of the calibration")?;
    let altered = control(&readme, &page)?;
    println!("`cargo xtask statistics {}`\n\n{}", form.name(), summary(&page)?);
    println!(
        "From `fos calibrate --cases {CASES} --seed {}`; [calibration](calibration.md) has the complete tables, README the first and the third \
         row. The intervals are those of Clopper and Pearson, and match the counts. With both seeds every figure except times meets \
         its requirement, and of {cases} cases without a missing effect {alarms} gave a false alarm: at most {:.1} %. The gate runs \
         {in_gate} cases of seed {seed}.",
        SEEDS[0],
        100.0 * most
    );
    println!(
        "\nNegative control: {altered} digits of README and of docs/calibration.md were changed, one at a time; each change was refused."
    );
    if let Some(missed) = missed {
        println!(
            "\nNegative control: with the findings of {} of the cases removed, as from a diagnosis that finds nothing, `--check` \
             fails ({missed}).",
            anew::CONTROL_CASES
        );
    }
    Ok(())
}

/// Checks that the sentence of README and the summary of the page follow from the table of the first seed.
fn check(readme: &str, page: &str) -> Result<(), Box<dyn Error>> {
    for (text, path, wanted) in [(readme, README, headline(page)?), (page, CALIBRATION, summary(page)?)] {
        let current = &text[section(text, "calibration", path)?];
        if current != wanted {
            return Err(format!("{path} says\n{current}but {CALIBRATION} gives\n{wanted}").into());
        }
    }
    Ok(())
}

/// Checks every figure of every seed except times, which depend on the machine. Returns false alarms of all seeds,
/// cases, and the upper end of the 95 % interval, which must not exceed the stated rate.
fn promised(page: &str) -> Result<(usize, usize, f64), Box<dyn Error>> {
    let (mut alarms, mut cases, mut most) = (0, 0, 0.0);
    for seed in SEEDS {
        for figure in figures(page, seed)? {
            let is_time = figure.name.starts_with("time for one case") || figure.name == "· longest";
            if !is_time && !holds(figure.value, &figure.must)? {
                return Err(format!(
                    "{CALIBRATION}: seed {seed}: {}: {}, must be {}",
                    figure.name, figure.value, figure.must
                )
                .into());
            }
            if figure.name == FALSE_ALARM {
                alarms += figure.hits();
                cases += figure.cases;
                most = figure.must.trim_start_matches(['≤', ' ']).parse()?;
            }
        }
    }
    let high = upper_end(alarms, cases);
    if high > most {
        return Err(format!(
            "{CALIBRATION}: {alarms} false alarms in {cases} cases: up to {high:.4}, promised {most}"
        )
        .into());
    }
    Ok((alarms, cases, high))
}

/// Alters every digit of the sentence and the tables, one at a time; each change must be refused. Returns their number.
fn control(readme: &str, page: &str) -> Result<usize, Box<dyn Error>> {
    let mut altered = 0;
    let mut alter = |text: &str, path: &str, numbers: Range<usize>| {
        for place in numbers.filter(|&place| text.as_bytes()[place].is_ascii_digit()) {
            let other = if text.as_bytes()[place] == b'1' { "2" } else { "1" };
            let changed = [&text[..place], other, &text[place + 1..]].concat();
            let passes = if path == README { check(&changed, page) } else { check(readme, &changed) }.is_ok();
            if passes {
                let start = text[..place].rfind('\n').map_or(0, |at| at + 1);
                return Err(format!(
                    "{path}: a changed digit {} characters into {:?} is not detected",
                    place - start,
                    &text[start..place + 1]
                ));
            }
            altered += 1;
        }
        Ok(())
    };
    alter(readme, README, section(readme, "calibration", README)?)?;
    alter(page, CALIBRATION, section(page, "calibration", CALIBRATION)?)?;
    // The summary has some rows of the table, with value, interval and cases.
    for line in page::rows(page, section(page, &format!("calibration {}", SEEDS[0]), CALIBRATION)?) {
        let cells: Vec<&str> = page[line.clone()].split('|').collect();
        if page::ROWS.iter().any(|(_, name)| cells[1].trim() == *name) {
            let before = line.start + cells[0].len() + cells[1].len() + 2;
            alter(page, CALIBRATION, before..before + cells[2].len() + cells[3].len() + cells[4].len() + 2)?;
        }
    }
    Ok(altered)
}
