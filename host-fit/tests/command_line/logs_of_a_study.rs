//! A study finds its logs from any working folder, and after study and logs were moved together; logs can also be read
//! from pipes.

use std::fs;
use std::path::Path;

use crate::session::{done, fails};
use serde_json::Value;

/// Creates `work/logs/reference.parquet`, and its study `work/studies/unit.json`, from within `work`.
fn study(world: &Path) {
    let work = world.join("work");
    for folder in ["logs", "studies"] {
        fs::create_dir_all(work.join(folder)).expect("made");
    }
    for (log, seed) in [("logs/reference.parquet", "1"), ("logs/field.parquet", "2")] {
        done(&work, &["simulate", log, "--minutes", "1", "--seed", seed, "--at-rest"]);
    }
    let fit = ["fit", "logs/reference.parquet", "--axis", "gx", "--max-terms", "2", "--memory", "none"];
    done(&work, &[&fit[..], &["-o", "studies/unit.json"]].concat());
}

#[test]
fn study_finds_its_logs_from_any_folder_and_after_a_move() {
    let world = tempfile::tempdir().expect("a folder");
    let world = world.path();
    study(world);
    let work = world.join("work");
    let compared = done(&work, &["compare", "studies/unit.json"]);
    let but_paths = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    for (from, study) in
        [("work/studies", "unit.json"), ("", "work/studies/unit.json"), ("work/logs", "../studies/unit.json")]
    {
        let again = done(&world.join(from), &["compare", study]);
        assert_eq!(but_paths(&again), but_paths(&compared), "from {from:?}");
    }
    // including the log of its refinement
    let added = ["add", "studies/unit.json", "temp_linear", "--from", "logs/field.parquet"];
    done(&work, &added);
    done(&work.join("studies"), &["diagnose", "unit.json"]);

    // moved together
    fs::rename(&work, world.join("moved")).expect("moved");
    let again = done(world, &["compare", "moved/studies/unit.json", "moved/logs/reference.parquet"]);
    assert_eq!(again.lines().count(), done(world, &["compare", "moved/studies/unit.json"]).lines().count());
    done(world, &["diagnose", "moved/studies/unit.json"]);

    // into one folder, with a study that does not state the location of its logs
    let flat = world.join("flat");
    fs::create_dir(&flat).expect("made");
    for log in ["reference", "field"] {
        fs::rename(world.join(format!("moved/logs/{log}.parquet")), flat.join(format!("{log}.parquet")))
            .expect("moved");
    }
    let text = fs::read_to_string(world.join("moved/studies/unit.json")).expect("there");
    let mut old: Value = serde_json::from_str(&text).expect("JSON");
    for source in ["/data/sources/0", "/refinements/0/logs/log", "/refinements/0/logs/reference"] {
        let source = old.pointer_mut(source).and_then(Value::as_object_mut).expect(source);
        let seen = source.remove("from_study").expect("noted");
        assert!(seen.as_str().is_some_and(|path| path.starts_with("../logs/")), "{seen}");
    }
    fs::write(flat.join("unit.json"), old.to_string()).expect("written");
    done(world, &["compare", "flat/unit.json"]);
    done(world, &["diagnose", "flat/unit.json"]);
}

#[test]
fn rejects_another_log_of_the_same_name() {
    let world = tempfile::tempdir().expect("a folder");
    let world = world.path();
    study(world);
    let other = world.join("other");
    fs::create_dir_all(other.join("logs")).expect("made");
    done(&other, &["simulate", "logs/reference.parquet", "--minutes", "1", "--seed", "9", "--at-rest"]);
    // another log has the stored name here
    let compared = done(&other, &["compare", "../work/studies/unit.json"]);
    assert!(compared.contains("studies/../logs/reference.parquet"), "{compared}");
    fs::remove_file(world.join("work/logs/reference.parquet")).expect("it was there");
    let message = fails(&other, 1, &["compare", "../work/studies/unit.json"]);
    assert!(
        message.contains("logs/reference.parquet: not the log that ../work/studies/unit.json was made with"),
        "{message}"
    );
    let message = fails(&world.join("work"), 1, &["compare", "studies/unit.json"]);
    for words in [
        "logs/reference.parquet: the log that studies/unit.json names is not there",
        "looked for as logs/reference.parquet, ",
        "studies/../logs/reference.parquet, ",
        "studies/reference.parquet\nhelp: put it back, or beside the study",
    ] {
        assert!(message.contains(words), "{words:?}: {message}");
    }
}

/// Used to fail with "Illegal seek".
#[cfg(unix)]
#[test]
fn reads_a_log_through_a_pipe() {
    use std::process::{Command, Stdio};

    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for log in ["log.csv", "log.csv.gz", "log.parquet"] {
        done(folder, &["simulate", log, "--minutes", "1", "--at-rest"]);
        let fit = ["fit", log, "--axis", "gx", "--max-terms", "2", "--memory", "none"];
        done(folder, &[&fit[..], &["-o", "file.json"]].concat());
        let script = format!(
            "cat {log} | {0} fit /dev/stdin --axis gx --max-terms 2 --memory none -o piped.json",
            env!("CARGO_BIN_EXE_fos")
        );
        let piped =
            Command::new("sh").args(["-c", &script]).current_dir(folder).stdin(Stdio::null()).output();
        let piped = piped.expect("a shell");
        assert!(piped.status.success(), "{log}: {}", String::from_utf8_lossy(&piped.stderr));
        let read = |name: &str| -> Value {
            serde_json::from_slice(&fs::read(folder.join(name)).expect("written")).expect("JSON")
        };
        let (file, piped) = (read("file.json"), read("piped.json"));
        assert_eq!(file["model"], piped["model"], "{log}");
        assert_eq!(file["data"]["sources"][0]["sha256"], piped["data"]["sources"][0]["sha256"], "{log}");
        assert_eq!(piped["data"]["sources"][0]["path"], "/dev/stdin");
        // a pipe cannot be read again, and the error states it
        let message = fails(folder, 1, &["compare", "piped.json"]);
        assert!(message.contains("help: "), "{message}");
    }
}
