//! `cargo xtask COMMAND`: checks of the workspace itself, as the gate and people run them.

mod corpus;
mod files;
mod form;
mod memory;
mod workspace;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use form::Form;

const USAGE: &str = "\
cargo xtask COMMAND

  corpus CONTROL FOLDER        the inputs of a merge by libFuzzer that are kept in the repository
  files short|full             what fos writes is there whole, whatever happens meanwhile
  memory short|full            how much memory a log of a working day takes";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[&str]) -> Result<(), Box<dyn Error>> {
    if let ["write", careless @ ..] = arguments {
        return files::careless::write(careless);
    }
    let root = workspace::root()?;
    std::env::set_current_dir(&root)?;
    let (command, form) = match arguments {
        ["corpus", control, folder] => return corpus::run(control, Path::new(folder)),
        [command, "short"] => (*command, Form::Short),
        [command, "full"] => (*command, Form::Full),
        _ => return Err(USAGE.into()),
    };
    match command {
        "files" => files::run(form, &root),
        "memory" => memory::run(form, &root),
        _ => Err(USAGE.into()),
    }
}
