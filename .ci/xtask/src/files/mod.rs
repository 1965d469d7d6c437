//! `cargo xtask files short|full`: what host-fit writes is there whole, as it was or as it should be, whatever happens meanwhile.
//!
//! `short`: some dozen kills of the quickest subcommands; `full`: more than a thousand kills of a dozen. Kills host-fit at random
//! moments, most of them while it writes; fills its disk; makes it read-only; takes away the right to write into its folder; lets
//! several processes change one study; looks at the order in which it has its bytes put onto the disk. Prints the figures as
//! Markdown. A writer without these precautions ([`careless`]) must be found out.

pub(crate) mod careless;
mod killed;
mod order;
mod refused;
mod together;
mod writer;

use std::error::Error;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::form::{Form, host_fit};
use writer::Writer;

/// The folder that host-fit works in, with the logs and studies it needs.
struct Bench {
    host_fit: PathBuf,
    folder: PathBuf,
    form: Form,
}

/// Prints what was seen; an error if a file was not as it is promised.
pub(crate) fn run(form: Form, root: &Path) -> Result<(), Box<dyn Error>> {
    own_mounts();
    let world = tempfile::tempdir()?;
    let bench =
        Bench { host_fit: host_fit(root)?, folder: fs::canonicalize(world.path())?.join("work"), form };
    fs::create_dir(&bench.folder)?;
    let writers = bench.writers()?;
    println!(
        "`cargo xtask files {}`: what is written, when the writer is killed (SIGKILL) at random moments.\n",
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
    if results.contains(&false) { Err("files are not as they are promised".into()) } else { Ok(()) }
}

/// A disk that is mounted here goes with this process, however that ends: in a namespace of its own, if it may have one.
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
        eprintln!("{error}: a disk that is mounted would stay after a kill");
    }
}

fn skipped(why: &str) -> bool {
    println!("\nskipped: {why}");
    eprintln!("skipped: {why}");
    true
}

impl Bench {
    fn run(&self, folder: &Path, arguments: &[&str]) -> Result<Output, Box<dyn Error>> {
        Ok(Command::new(&self.host_fit).args(arguments).current_dir(folder).output()?)
    }

    fn done(&self, arguments: &[&str]) -> Result<(), Box<dyn Error>> {
        let ended = self.run(&self.folder, arguments)?;
        if ended.status.success() {
            return Ok(());
        }
        Err(format!("host-fit {}: {}", arguments.join(" "), String::from_utf8_lossy(&ended.stderr)).into())
    }

    fn read(&self, name: &str) -> Result<Vec<u8>, Box<dyn Error>> {
        fs::read(self.folder.join(name)).map_err(|error| format!("{name}: {error}").into())
    }

    /// The files of a folder, by their names from here.
    fn listed(&self, folder: &str) -> Result<Vec<String>, Box<dyn Error>> {
        let entries = fs::read_dir(self.folder.join(folder))?;
        let mut names: Vec<String> = entries
            .map(|entry| Ok(format!("{folder}/{}", entry?.file_name().to_string_lossy())))
            .collect::<Result<_, std::io::Error>>()?;
        names.sort();
        Ok(names)
    }

    /// A dozen subcommands, with the logs and studies that they need. The others write by the same code.
    fn writers(&self) -> Result<Vec<Writer>, Box<dyn Error>> {
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
            self.done(&["add", "grown.json", "thermal_lag", "--axis", axis, "--from", "field.parquet"])?;
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
        // with the kills of `short` and of `full`
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
            writer("add", "add unit.json thermal_lag --axis gx --from field.parquet", unit.clone(), [0, 80])
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
