//! Runs the commands of the tutorials, and those of the pages for users of other tools on logs generated here.

use std::collections::BTreeMap;
use std::path::Path;

use crate::session::done;
use crate::temperature_tables::{rows, write};

/// Endings of the logs named on the page, whatever their format.
const LOGS: [&str; 5] = ["bag", "csv", "ulg", "bin", "mcap"];

/// Words of every command in shell blocks.
fn commands(page: &str) -> Vec<Vec<String>> {
    let blocks = page.split("```sh\n").skip(1).map(|block| block.split("```").next().expect("an end"));
    let lines = blocks.flat_map(str::lines).flat_map(|line| line.split(" && "));
    lines.map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
}

fn page(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name)).expect("there")
}

/// Runs the commands of a tutorial and finds every line of its sample output in what they print. A line that ends in …
/// is compared up to there.
fn runs_as_it_stands(name: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let page = page(name);
    let mut printed = Vec::new();
    for command in commands(&page) {
        let words: Vec<&str> = command.iter().map(String::as_str).take_while(|word| *word != "#").collect();
        match words[..] {
            ["fos", ref arguments @ .., ">", file] => {
                std::fs::write(folder.join(file), done(folder, arguments)).expect("written");
            }
            ["fos", ref arguments @ ..] => printed.extend(lines_of(&done(folder, arguments))),
            _ => {} // how fos is installed
        }
    }
    let blocks = page.split("\n```").skip(1).step_by(2).filter(|block| !block.starts_with("sh\n"));
    for line in blocks.flat_map(|block| lines_of(block.split_once('\n').expect("a line").1)) {
        let found = match line.strip_suffix('…') {
            Some(beginning) => printed.iter().any(|line| line.starts_with(beginning.trim_end())),
            None => printed.contains(&line),
        };
        assert!(found || line == "[...]", "{name}: {line}\n\n{}", printed.join("\n"));
    }
    if let Ok(image) = folder.join("unit.fosm").metadata() {
        assert!(
            page.contains(&format!("{} bytes", image.len())),
            "{name}: an image of {} bytes",
            image.len()
        );
    }
}

/// Lines with single spaces, so that a column may be wider.
fn lines_of(text: &str) -> Vec<String> {
    text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

#[test]
fn first_tutorial_runs_as_printed() {
    runs_as_it_stands("first-correction.md");
}

#[test]
fn walk_through_runs_as_printed() {
    runs_as_it_stands("finding-a-missing-effect.md");
}

#[test]
fn every_command_of_the_pages_succeeds() {
    let pages = ["imu-yaml.md", "coming-from.md", "px4.md", "ardupilot.md"].map(page);
    let page = pages.concat();
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let commands = commands(&page);
    assert!(commands.len() >= 12, "{commands:?}");
    // logs are written as tables here, under the same names: other tests cover the opening of other formats
    let mut logs: BTreeMap<String, String> = BTreeMap::new();
    for (at, command) in commands.iter().enumerate() {
        assert_eq!(command[0], "fos");
        let named: Vec<String> = command[1..]
            .iter()
            .enumerate()
            .map(|(place, word)| {
                let is_written = command[place].starts_with("--") && command[place] != "--evaluate-on";
                let Some((stem, ending)) = word.rsplit_once('.').filter(|_| !is_written) else {
                    return word.clone();
                };
                if !LOGS.contains(&ending) {
                    return word.clone();
                }
                let log = format!("{stem}.{ending}.csv");
                if logs.insert(word.clone(), log.clone()).is_none() {
                    let swing = if stem == "rest" { 0.0 } else { 15.0 };
                    write(&folder.join(&log), &rows(1.5, swing, at as u32));
                }
                log
            })
            .collect();
        let mut words: Vec<&str> = named.iter().map(String::as_str).collect();
        // the number of the IMU is in a log of the autopilot, but not in a table
        if words.iter().any(|word| ["--px4", "--ardupilot"].contains(word)) {
            words.extend(["--instance", "0"]);
        }
        done(folder, &words);
    }
    for file in ["allan.csv", "allan.svg", "imu.yaml", "orb.yaml", "vins.yaml", "unit.params", "unit.parm"] {
        assert!(folder.join(file).metadata().is_ok_and(|file| file.len() > 300), "{file}");
    }
}
