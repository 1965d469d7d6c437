//! Runs commands with limited memory: in a control group if possible, otherwise by address space, which is stricter.

use std::error::Error;
use std::fs::{self, File};
use std::io::Read;
use std::path::PathBuf;
use std::process::{Command, ExitStatus};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use wait4::Wait4;

use super::line::mega;

/// Memory limit, bytes.
pub(crate) const LIMIT: u64 = 2 << 30;
/// Time limit of a command, generous for a busy machine.
const LONGEST: Duration = Duration::from_secs(1800);
const GROUPS: &str = "/sys/fs/cgroup";

/// Environment of the limited runs.
pub(crate) struct Limited {
    program: PathBuf,
    folder: TempDir,
    group: Option<Group>,
}

/// A control group, removed when dropped.
struct Group(PathBuf);

impl Drop for Group {
    fn drop(&mut self) {
        let _ = fs::remove_dir(&self.0);
    }
}

/// Result of a run.
pub(crate) struct Ended {
    status: Option<ExitStatus>,
    /// Description.
    pub(crate) how: String,
    /// The time limit was exceeded.
    pub(crate) is_late: bool,
    /// Peak resident memory, bytes.
    pub(crate) peak: u64,
    pub(crate) printed: String,
}

impl Ended {
    pub(crate) fn is_success(&self) -> bool {
        self.status.is_some_and(|status| status.success())
    }
}

impl Limited {
    pub(crate) fn new(program: PathBuf) -> Result<Self, Box<dyn Error>> {
        let given = fs::read_to_string(format!("{GROUPS}/cgroup.subtree_control")).unwrap_or_default();
        let place = PathBuf::from(format!("{GROUPS}/fos-trust-{}", std::process::id()));
        let made = given.split_whitespace().any(|word| word == "memory") && fs::create_dir(&place).is_ok();
        let group = made
            .then_some(Group(place))
            .filter(|group| fs::write(group.0.join("memory.max"), LIMIT.to_string()).is_ok());
        Ok(Self { program, folder: tempfile::tempdir()?, group })
    }

    pub(crate) fn how(&self) -> &'static str {
        match self.group {
            Some(_) => "memory (control group v2, no swap)",
            None => "address space (prlimit), a stricter limit",
        }
    }

    /// Runs a command with [`LIMIT`].
    pub(crate) fn run(&self, arguments: &[&str]) -> Result<Ended, Box<dyn Error>> {
        self.run_with(arguments, LIMIT)
    }

    /// Address space needed to start, hardly any of which is resident memory.
    pub(crate) fn to_start(&self) -> Result<u64, Box<dyn Error>> {
        let mut beside = 0;
        while self.group.is_none() && !self.run_with(&["--version"], beside)?.is_success() {
            beside += 16 << 20;
        }
        Ok(beside)
    }

    fn command(&self, limit: u64) -> Result<Command, Box<dyn Error>> {
        let Some(Group(group)) = &self.group else {
            let mut command = Command::new("prlimit");
            command.arg(format!("--as={limit}")).arg(&self.program);
            return Ok(command);
        };
        fs::write(group.join("memory.max"), limit.to_string())?;
        if group.join("memory.swap.max").exists() {
            fs::write(group.join("memory.swap.max"), "0")?;
        }
        let mut command = Command::new("sh");
        command.args(["-c", r#"echo $$ >"$0/cgroup.procs" && exec "$@""#]).arg(group).arg(&self.program);
        Ok(command)
    }

    /// Runs a command with a limit of this many bytes.
    pub(crate) fn run_with(&self, arguments: &[&str], limit: u64) -> Result<Ended, Box<dyn Error>> {
        let folder = self.folder.path();
        let (out, error) = (folder.join("out"), folder.join("error"));
        let mut child = self
            .command(limit)?
            .args(arguments)
            .current_dir(folder)
            .stdout(File::create(&out)?)
            .stderr(File::create(&error)?)
            .spawn()?;
        let began = Instant::now();
        let (used, is_late) = loop {
            if let Some(used) = child.try_wait4()? {
                break (used, false);
            }
            if began.elapsed() > LONGEST {
                child.kill()?;
                break (child.wait4()?, true);
            }
            std::thread::sleep(Duration::from_millis(10));
        };
        let how = if is_late { "did not end".to_owned() } else { in_words(used.status) };
        let peak = used.rusage.maxrss;
        eprintln!("  {}: {how}, {} MB, {} s", arguments.join(" "), mega(peak), began.elapsed().as_secs());
        if !used.status.success() {
            let mut output = String::new();
            File::open(&error)?.take(300).read_to_string(&mut output)?;
            eprintln!("    {}", output.lines().next().unwrap_or("no error message"));
        }
        Ok(Ended {
            status: (!is_late).then_some(used.status),
            how,
            is_late,
            peak,
            printed: fs::read_to_string(out)?,
        })
    }
}

fn in_words(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("ended with exit code {code}"),
        (_, signal) => format!("was ended by signal {}", signal.unwrap_or_default()),
    }
}
