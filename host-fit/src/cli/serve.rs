//! `serve`: the workbench, in the browser.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

use clap::Args;

use super::arguments::{OutputFolder, Reading, library};
use super::output::{Failure, print_line, print_note, print_warning};
use fos_data::recording::LoadOptions;
use fos_workbench::{Folders, Server};

/// Open the workbench in the browser, offline
///
/// The page is on this machine only and needs no network. Logs may be read below the current folder, below the folders
/// that are given, and beside the log that is given.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos serve log.parquet --reference reference.parquet\nExample: fos serve logs"
)]
pub(super) struct Serve {
    /// A log to open, or folders with logs
    #[arg(value_name = "LOG|FOLDER")]
    of: Vec<PathBuf>,
    /// A log of the same device without the missing effect
    #[arg(long = "reference", alias = "quiet", value_name = "LOG")]
    reference: Option<PathBuf>,
    /// The evaluation log: a later log that nothing is fitted to
    #[arg(long = "evaluate-on", alias = "judge", value_name = "LOG")]
    evaluate_on: Option<PathBuf>,
    /// Port; 0 for any that is free
    #[arg(long, default_value_t = 4180)]
    port: u16,
    /// Address to listen at. With another address than the default, everyone who can reach it can read every log that can be opened here
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,
    /// Folder for dropped files and the example; created if missing
    #[arg(long, default_value = "fos-workbench")]
    folder: OutputFolder,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

impl Serve {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        if self.listen.is_unspecified() {
            return Err(format!(
                "--listen {}: requests are answered under the address that was named, and this is none\nhelp: name the one that others use, as --listen 192.168.1.5",
                self.listen
            )
            .into());
        }
        let (folders, logs): (Vec<PathBuf>, Vec<PathBuf>) =
            self.of.iter().cloned().partition(|path| path.is_dir());
        let read = self.reading.options()?;
        let field = match &logs[..] {
            [] if self.reference.is_some()
                || self.evaluate_on.is_some()
                || read != LoadOptions::default() =>
            {
                return Err("there is no log that --reference, --evaluate-on, --map, --map-file, --rate or --strict would go with\nhelp: name the log as well; how a log of a folder is read, the page asks".into());
            }
            [] => None,
            [field] => Some(field),
            _ => {
                return Err(
                    "several logs\nhelp: one log with --reference and --evaluate-on, or their folder".into(),
                );
            }
        };
        let mut readable = vec![PathBuf::from(".")];
        readable.extend(folders);
        let beside = [field, self.reference.as_ref(), self.evaluate_on.as_ref()].into_iter().flatten();
        readable.extend(beside.map(|log| match log.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        }));
        let folders = Folders::new(&readable, &self.folder)?;
        let text = |path: &PathBuf| path.display().to_string();
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
        runtime.block_on(async {
            let server = Server::bind(self.listen, self.port, folders, library).await?;
            if let Some(field) = field {
                let (reference, evaluation) =
                    (self.reference.as_ref().map(text), self.evaluate_on.as_ref().map(text));
                if let Err(reason) = server.open(text(field), reference, evaluation, read) {
                    print_warning(&reason);
                }
            }
            print_line!("workbench at http://{}/", server.address());
            if !self.listen.is_loopback() {
                print_warning(&format!(
                    "listening at {}: whoever reaches it can read the logs here",
                    self.listen
                ));
            }
            print_note!(
                "Ctrl-C stops the server; `fos serve` in the same folder opens its studies again ({})",
                self.folder.join("studies").display()
            );
            let end = async {
                if tokio::signal::ctrl_c().await.is_err() {
                    // An ordinary process end: there is nothing to wait for.
                    std::future::pending::<()>().await;
                }
            };
            Ok::<(), Failure>(server.run(end).await?)
        })?;
        // Running computations are abandoned.
        runtime.shutdown_background();
        Ok(())
    }
}
