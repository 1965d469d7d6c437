//! A command that writes files, and their contents.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::form::Form;

/// Content of each output.
pub(crate) type Contents = BTreeMap<String, Vec<u8>>;

/// A subcommand.
pub(crate) struct Writer {
    pub(crate) name: String,
    pub(crate) program: PathBuf,
    pub(crate) arguments: Vec<String>,
    pub(crate) targets: Vec<String>,
    /// Number of kills in `short` and in `full`.
    kills: [usize; 2],
    /// Contents before the run.
    pub(crate) old: Contents,
}

/// Results of an undisturbed run.
pub(crate) struct Learnt {
    pub(crate) new: Contents,
    pub(crate) takes: Duration,
    /// Time during which a temporary file exists.
    pub(crate) window: Duration,
}

impl Writer {
    pub(crate) fn new(
        name: &str,
        program: &Path,
        arguments: &[&str],
        targets: Vec<String>,
        kills: [usize; 2],
    ) -> Self {
        let arguments = arguments.iter().map(|argument| (*argument).to_owned()).collect();
        let old =
            targets.iter().map(|target| (target.clone(), b"what was there before\n".repeat(500))).collect();
        Self { name: name.to_owned(), program: program.to_owned(), arguments, targets, kills, old }
    }

    /// Adds an output that is also an input, and so needs valid content.
    pub(crate) fn over(mut self, target: &str, content: Vec<u8>) -> Self {
        self.old.insert(target.to_owned(), content);
        self
    }

    pub(crate) fn kills(&self, form: Form) -> usize {
        self.kills[usize::from(form == Form::Full)]
    }

    /// Included in the checks without kills.
    pub(crate) fn is_of(&self, form: Form) -> bool {
        form == Form::Full || self.kills[0] > 0 || self.name == "man"
    }

    /// Restores the contents before the run.
    pub(crate) fn begin(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        for (target, content) in &self.old {
            let path = folder.join(target);
            fs::create_dir_all(path.parent().unwrap_or(folder))?;
            fs::write(path, content)?;
        }
        Ok(())
    }

    pub(crate) fn start(&self, folder: &Path) -> Result<Child, Box<dyn Error>> {
        let mut command = Command::new(&self.program);
        Ok(command
            .args(&self.arguments)
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()?)
    }

    pub(crate) fn content(&self, folder: &Path) -> Result<Contents, Box<dyn Error>> {
        let of =
            |target: &String| fs::read(folder.join(target)).map_err(|error| format!("{target}: {error}"));
        Ok(self
            .targets
            .iter()
            .map(|target| Ok::<_, String>((target.clone(), of(target)?)))
            .collect::<Result<_, _>>()?)
    }

    /// Temporary files of running and killed writers.
    pub(crate) fn beside(&self, folder: &Path) -> BTreeSet<PathBuf> {
        let places: BTreeSet<PathBuf> =
            self.targets.iter().filter_map(|target| Some(folder.join(target).parent()?.to_owned())).collect();
        let entries = places.iter().filter_map(|place| fs::read_dir(place).ok()).flatten().flatten();
        let is_one = |path: &PathBuf| {
            path.file_name()
                .and_then(|name| name.to_str())
                .is_some_and(|name| name.starts_with(".fos-") && name.ends_with(".tmp"))
        };
        entries.map(|entry| entry.path()).filter(is_one).collect()
    }

    /// Runs the writer twice; the results must be equal.
    pub(crate) fn learn(&self, folder: &Path) -> Result<Learnt, Box<dyn Error>> {
        let first = self.learn_once(folder)?;
        let learnt = self.learn_once(folder)?;
        if first.new != learnt.new {
            return Err(format!("{}: two runs wrote different files", self.name).into());
        }
        if let Some((same, _)) =
            self.old.iter().find(|(target, content)| learnt.new.get(*target) == Some(content))
        {
            return Err(format!("{}: {same} is the same before and after", self.name).into());
        }
        Ok(learnt)
    }

    fn learn_once(&self, folder: &Path) -> Result<Learnt, Box<dyn Error>> {
        self.begin(folder)?;
        let began = Instant::now();
        let (mut now, mut process) = (began, self.start(folder)?);
        let mut seen: BTreeMap<PathBuf, (Instant, Instant)> = BTreeMap::new();
        let status = loop {
            if let Some(status) = process.try_wait()? {
                break status;
            }
            // From the last look before the file appears to the first after it is gone: it may be seen only
            // once.
            let (before, there) = (now, self.beside(folder));
            now = Instant::now();
            for path in there {
                seen.entry(path).or_insert((before, now)).1 = now;
            }
        };
        if !status.success() {
            return Err(format!("{}: {status}", self.name).into());
        }
        let window = seen.values().map(|(first, last)| *last - *first).max().unwrap_or_default();
        Ok(Learnt { new: self.content(folder)?, takes: began.elapsed(), window })
    }
}
