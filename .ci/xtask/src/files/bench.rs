//! Working folder of the tests.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::writer::Writer;
use crate::form::Form;

/// A folder with the necessary logs and studies.
pub(crate) struct Bench {
    pub(crate) host_fit: PathBuf,
    pub(crate) folder: PathBuf,
    pub(crate) form: Form,
}

impl Bench {
    pub(crate) fn run(&self, folder: &Path, arguments: &[&str]) -> Result<Output, Box<dyn Error>> {
        Ok(Command::new(&self.host_fit).args(arguments).current_dir(folder).output()?)
    }

    pub(crate) fn done(&self, arguments: &[&str]) -> Result<(), Box<dyn Error>> {
        let ended = self.run(&self.folder, arguments)?;
        if ended.status.success() {
            return Ok(());
        }
        Err(format!("fos {}: {}", arguments.join(" "), String::from_utf8_lossy(&ended.stderr)).into())
    }

    pub(crate) fn read(&self, name: &str) -> Result<Vec<u8>, Box<dyn Error>> {
        fs::read(self.folder.join(name)).map_err(|error| format!("{name}: {error}").into())
    }

    /// Names of the files in a folder, relative to the working folder.
    pub(crate) fn listed(&self, folder: &str) -> Result<Vec<String>, Box<dyn Error>> {
        let entries = fs::read_dir(self.folder.join(folder))?;
        let mut names: Vec<String> = entries
            .map(|entry| Ok(format!("{folder}/{}", entry?.file_name().to_string_lossy())))
            .collect::<Result<_, std::io::Error>>()?;
        names.sort();
        Ok(names)
    }

    /// A dozen subcommands with their inputs. The others write by the same code.
    pub(crate) fn writers(&self) -> Result<Vec<Writer>, Box<dyn Error>> {
        self.done(&["simulate", "log.parquet", "--minutes", "2", "--seed", "1", "--at-rest"])?;
        self.done(&[
            "simulate",
            "field.parquet",
            "--minutes",
            "2",
            "--seed",
            "2",
            "--temperature",
            "3",
            "--at-rest",
        ])?;
        self.done(&["fit", "log.parquet", "--axis", "gx,gy,gz", "-o", "fitted.json"])?;
        fs::copy(self.folder.join("fitted.json"), self.folder.join("grown.json"))?;
        for axis in ["gx", "gy", "gz"] {
            self.done(&["add", "grown.json", "temp_linear", "--axis", axis, "--from", "field.parquet"])?;
        }
        self.done(&["export", "fitted.json", "--image", "fitted.fosm"])?;
        self.done(&["man", "pages"])?;
        let (mut figures, mut case) = (Vec::new(), Vec::new());
        if self.form == Form::Full {
            self.done(&["compare", "fitted.json", "--figures", "figures"])?;
            figures = self.listed("figures")?;
            self.done(&["simulate", "--case", "case", "--effect", "thermal_lag"])?;
            case = self.listed("case")?;
        }
        // With the numbers of kills in `short` and `full`.
        let writer = |name: &str, line: &str, targets: Vec<String>, kills| {
            Writer::new(name, &self.host_fit, &line.split(' ').collect::<Vec<_>>(), targets, kills)
        };
        let one = |name: &str| vec![name.to_owned()];
        let log = "--minutes 2 --seed 3 --at-rest";
        let unit = one("unit.json");
        let exported = ["unit.fosm", "model.rs", "model.h"].map(str::to_owned).to_vec();
        Ok(vec![
            writer("simulate (csv)", &format!("simulate out.csv {log}"), one("out.csv"), [14, 150]),
            writer("simulate (csv.gz)", &format!("simulate out.csv.gz {log}"), one("out.csv.gz"), [0, 150]),
            writer(
                "simulate (parquet)",
                &format!("simulate out.parquet {log}"),
                one("out.parquet"),
                [14, 150],
            ),
            writer("simulate --case", "simulate --case case --effect bias_ramp", case, [0, 60]),
            writer("fit", "fit log.parquet --axis gx -o unit.json", unit.clone(), [0, 100]),
            writer("add", "add unit.json temp_linear --axis gx --from field.parquet", unit.clone(), [0, 80])
                .over("unit.json", self.read("fitted.json")?),
            writer("undo", "undo unit.json --axis gx", unit, [14, 200])
                .over("unit.json", self.read("grown.json")?),
            writer(
                "export",
                "export fitted.json --image unit.fosm --rust model.rs --c model.h",
                exported,
                [14, 100],
            ),
            writer(
                "replay",
                "replay fitted.fosm log.parquet -o corrected.csv",
                one("corrected.csv"),
                [0, 100],
            ),
            writer(
                "report",
                "report fitted.json --from field.parquet --axis gx -o report.html",
                one("report.html"),
                [0, 40],
            ),
            writer("compare --figures", "compare fitted.json --figures figures", figures, [0, 30]),
            writer("man", "man pages", self.listed("pages")?, [0, 60]),
        ])
    }
}

/// Reports a skipped check, which is not a failure.
pub(crate) fn skipped(why: &str) -> bool {
    println!("\nskipped: {why}");
    eprintln!("skipped: {why}");
    true
}
