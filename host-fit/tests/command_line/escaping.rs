//! Text of foreign origin stays text: in a terminal, in C, in Rust, in a page, in Markdown, in a picture.
//!
//! Every control character and every special character of these formats is sent through every text: the strings of a
//! study, of an image, of an effect, of a case, the names of files and columns, cells, labels of segments. The output
//! is compared with that of a harmless text; and each check must detect the unescaped text.

pub(crate) mod checks;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use checks::{c_differs, markdown_differs, page_differs, reaches_a_terminal, rust_differs};
use fos_diagnose::study::Study;
use fos_testkit::is_thorough;
use serde_json::{Value, json};

/// Special characters of each target, and every character without a shape.
fn hostile() -> String {
    let hidden: String = ('\u{1}'..='\u{1f}').chain('\u{7f}'..='\u{9f}').collect();
    [
        "h",
        &hidden,
        "\u{2028}\u{2029}\u{202a}\u{202e}\u{2066}\u{2069}\u{200b}\u{200f}\u{61c}\u{feff}\u{ffff}\u{e0041}",
        "\u{1b}]0;title\u{7}\u{1b}[31mred\u{1b}[2J\u{9b}2J",
        "\rint injected_1(void){return 7;}\r#pragma injected\r",
        "\nint injected_2; fn injected_3() {}\n#error injected\n",
        "*/ int injected_4; /* \" ' \\\" \\' ??/\nint injected_5;\n",
        "<script>injected()</script><img src=x onerror=injected()>&amp;\"'`]]>--><!-- ",
        "\n\n# injected\n\n| a | b |\n|---|---|\n| injected | b |\n\n- injected\n1. injected\n> injected\n```\ninjected\n```\n[x](http://injected) ![x](y) **b** ",
        "ends in \\",
    ]
    .concat()
}

/// The same for the name of a file: no `/`, and within the maximum length.
fn hostile_name() -> String {
    let hidden: String =
        ('\u{1}'..='\u{1f}').chain(['\u{7f}', '\u{85}', '\u{9b}', '\u{2028}', '\u{202e}']).collect();
    format!(
        "q{hidden}\rint injected_1(void){{return 7;}}\r#pragma x\r\nint injected_2;\n<img src=x>|`*_&\"'??\\"
    )
}

fn host_fit(folder: &Path, colours: bool, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fos"));
    command.current_dir(folder).args(arguments);
    match colours {
        true => command.env("CLICOLOR_FORCE", "1"),
        false => command.env_remove("CLICOLOR_FORCE"),
    };
    command.output().expect("it starts")
}

/// Number of runs, and amount of their output.
#[derive(Default)]
struct Runs {
    runs: u32,
    printed: usize,
    subcommands: BTreeSet<String>,
}

impl Runs {
    /// Runs a command line whose output a terminal must be able to show, with colours and without. Returns true if it
    /// succeeded.
    fn run(&mut self, folder: &Path, arguments: &[&str]) -> bool {
        self.run_with(&[true, false], folder, arguments)
    }

    fn run_with(&mut self, colours: &[bool], folder: &Path, arguments: &[&str]) -> bool {
        let mut succeeded = false;
        for &colours in colours {
            let output = host_fit(folder, colours, arguments);
            for stream in [&output.stdout, &output.stderr] {
                assert_eq!(
                    reaches_a_terminal(stream, colours),
                    None,
                    "{arguments:?}: {}",
                    String::from_utf8_lossy(stream)
                );
                self.printed += stream.len();
            }
            succeeded = output.status.success();
            assert!(matches!(output.status.code(), Some(0..=2)), "{arguments:?}: {output:?}");
        }
        self.runs += 1;
        self.subcommands.insert(arguments[0].to_owned());
        succeeded
    }

    fn done(&mut self, folder: &Path, arguments: &[&str]) {
        assert!(self.run(folder, arguments), "{arguments:?}: {:?}", host_fit(folder, false, arguments));
    }

    /// The same with --json; returns the parsed JSON.
    fn json(&mut self, folder: &Path, arguments: &[&str]) -> Value {
        let arguments = [arguments, &["--json"]].concat();
        self.done(folder, &arguments);
        serde_json::from_slice(&host_fit(folder, false, &arguments).stdout).expect("JSON")
    }
}

/// Paths of all strings of a value, as JSON pointers; of each list the first two elements.
fn strings(value: &Value, at: &str, found: &mut Vec<String>) {
    let escaped = |key: &str| key.replace('~', "~0").replace('/', "~1");
    match value {
        Value::String(_) => found.push(at.to_owned()),
        Value::Array(items) => {
            items
                .iter()
                .take(2)
                .enumerate()
                .for_each(|(index, item)| strings(item, &format!("{at}/{index}"), found));
        }
        Value::Object(fields) => {
            fields.iter().for_each(|(key, item)| strings(item, &format!("{at}/{}", escaped(key)), found));
        }
        _ => {}
    }
}

/// Replaces every string equal to `old` by `text`.
fn replace(value: &mut Value, old: &str, text: &str) {
    match value {
        Value::String(found) if found == old => text.clone_into(found),
        Value::Array(items) => items.iter_mut().for_each(|item| replace(item, old, text)),
        Value::Object(fields) => fields.values_mut().for_each(|item| replace(item, old, text)),
        _ => {}
    }
}

/// Sources exported from a study.
struct Exported {
    c: String,
    rust: String,
}

fn exported(runs: &mut Runs, folder: &Path, study: &Value, sensor: &str) -> Option<Exported> {
    fs::write(folder.join("study.json"), study.to_string()).expect("written");
    let files =
        ["study.json", "--c", "model.h", "--rust", "model.rs", "--image", "unit.fosm", "--sensor", sensor];
    runs.run_with(&[false], folder, &[&["export"][..], &files].concat()).then(|| {
        let read = |name: &str| fs::read_to_string(folder.join(name)).expect("UTF-8");
        runs.run_with(&[false], folder, &["inspect", "unit.fosm"]);
        Exported { c: read("model.h"), rust: read("model.rs") }
    })
}

/// Sends every string of a study, one by one and together, into the sources and to the terminal. Returns the number of
/// strings, and of those that a study accepts.
fn strings_of_a_study(runs: &mut Runs, folder: &Path, good: &Value) -> (usize, usize) {
    let hostile = hostile();
    let benign = exported(runs, folder, good, "x").expect("sound");
    let (mut places, mut taken) = (Vec::new(), 0);
    strings(good, "", &mut places);
    // one place, and all places with the same text: names that must agree
    let mut studies = Vec::new();
    let mut together = good.clone();
    for place in &places {
        let old = good.pointer(place).and_then(Value::as_str).expect("it is there").to_owned();
        let mut one = good.clone();
        *one.pointer_mut(place).expect("it is there") = json!(hostile);
        let mut all = good.clone();
        replace(&mut all, &old, &hostile);
        for changed in [one, all] {
            if !studies.contains(&changed) {
                studies.push(changed);
            }
        }
        let before = together.clone();
        *together.pointer_mut(place).expect("it is there") = json!(hostile);
        if serde_json::from_value::<Study>(together.clone()).is_err() || !is_read(folder, &together) {
            together = before;
        }
    }
    if !is_thorough() {
        studies = studies.into_iter().step_by(12).collect();
    }
    studies.push(together);
    for study in &studies {
        fs::write(folder.join("study.json"), study.to_string()).expect("written");
        runs.run_with(&[false], folder, &["history", "study.json"]);
        let Some(found) = exported(runs, folder, study, &hostile) else { continue };
        taken += 1;
        assert_eq!(c_differs(&found.c, &benign.c), None, "{}", found.c);
        assert_eq!(rust_differs(&found.rust, &benign.rust), None, "{}", found.rust);
    }
    assert!(taken > studies.len() / 8, "{taken} of {}", studies.len());
    (studies.len(), taken)
}

fn is_read(folder: &Path, study: &Value) -> bool {
    let path = folder.join("probe.json");
    fs::write(&path, study.to_string()).expect("written");
    Study::read(&path).is_ok()
}

/// Writes a log with this text in the name of a column, in labels and in cells.
fn log_with(text: &str, folder: &Path, from: &str, to: &str) {
    let log = fs::read_to_string(folder.join(from)).expect("written");
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\"").replace('\n', " "));
    let (header, rows) = log.split_once('\n').expect("a header");
    let header = header.replace("temp_c", &quoted(&format!("{text}temp")));
    let mut changed = format!("{header},segment,note\n");
    for (number, row) in rows.lines().enumerate() {
        let label = if number < 100 { text } else { "one" };
        let note = if number % 97 == 5 { text } else { "x" };
        let with_cell = || row.replacen(',', &format!(",{}", quoted(text)), 1);
        let row = if number % 997 == 3 { with_cell() } else { row.to_owned() };
        changed.push_str(&format!("{row},{},{}\n", quoted(label), quoted(note)));
    }
    fs::write(folder.join(to), changed).expect("written");
}

#[test]
#[cfg(unix)]
fn escapes_foreign_text_in_every_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let mut runs = Runs::default();
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/study_v1.json");
    let good: Value = serde_json::from_slice(&fs::read(fixture).expect("there")).expect("JSON");
    let (studies, taken) = strings_of_a_study(&mut runs, folder, &good);

    // names of files and columns, cells, labels
    let name = hostile_name();
    let (log, study) = (format!("{name}.csv"), format!("{name}.json"));
    assert!(log.len() <= 255);
    runs.done(folder, &["simulate", "plain.csv", "--minutes", "1.5", "--seed", "3"]);
    log_with(&hostile(), folder, "plain.csv", &log);
    log_with("x", folder, "plain.csv", "harmless.csv");
    runs.run(folder, &["fit", &log, "--axis", "gx", "--strict", "-o", "strict.json"]);
    runs.done(folder, &["fit", "harmless.csv", "--axis", "gx", "--max-terms", "2", "-o", "harmless.json"]);
    runs.done(folder, &["fit", &log, "--axis", "gx", "--max-terms", "2", "-o", &study]);
    let fitted = runs.json(folder, &["fit", &log, "--axis", "gx", "--max-terms", "2", "-o", &study]);
    assert_eq!(fitted["data"]["sources"][0]["path"], json!(log), "the true text is in the JSON");

    // a user-defined effect
    let text = hostile();
    let effect = format!(
        "id = \"mine\"\nname = {0}\nband = \"slow\"\nmechanism = {0}\nequation = {0}\ntypical_size = {0}\nsource = {0}\nexperiment = {0}\ngives_away = {0}\ndevice = {0}\n\
         [[terms]]\nregressor = \"clock:time\"\n[[confused_with]]\neffect = \"temp_linear\"\nseparate = {0}\n",
        toml_string(&text)
    );
    let no_rival = effect.replace("\"temp_linear\"", &toml_string(&text));
    fs::write(folder.join("rival.toml"), no_rival).expect("written");
    fs::write(folder.join("mine.toml"), effect).expect("written");
    fs::write(folder.join("wrong.toml"), format!("id = {}\n", toml_string(&text))).expect("written");
    runs.done(folder, &["effects", "mine", "--effect", "mine.toml"]);
    runs.run(folder, &["effects", &text.replace('\0', ""), "--effect", "mine.toml"]);
    runs.run(folder, &["effects", "--effect", "wrong.toml"]);
    runs.run(folder, &["effects", "--effect", "rival.toml"]);
    runs.json(folder, &["effects", "--effect", "mine.toml"]);

    // commands that read the log and the study
    let reading = ["--effect", "mine.toml"];
    runs.run_with(&[false], folder, &["compare", &study, &log, "--figures", "figures"]);
    runs.json(folder, &["compare", &study, &log]);
    runs.run_with(&[false], folder, &[&["diagnose", &log, "--axis", "gx"][..], &reading].concat());
    runs.run_with(&[false], folder, &[&["add", &study, "mine", "--from", &log][..], &reading].concat());
    runs.run(folder, &["history", &study]);
    runs.run_with(
        &[false],
        folder,
        &[
            "table",
            &log,
            "--axis",
            "gx",
            "--train",
            "30",
            "--evaluate",
            "20",
            "--degree",
            "1",
            "--max-order",
            "1",
        ],
    );
    runs.run(folder, &["undo", &study]);
    runs.run(folder, &["replay", "unit.fosm", &log, "-o", &format!("{name}.out.csv")]);
    runs.run(folder, &["record", &log, "-o", "recorded.csv"]);
    // errors that repeat their arguments
    for arguments in [
        &["fit", &text][..],
        &["fit", &log, "--axis", &text],
        &["fit", &log, "--map", &text],
        &["fit", &log, "--train", &text],
        &["fit", &log, "--max-lag", &text],
        &["fit", "plain.csv", &format!("--{text}")],
        &[&text],
        &["simulate", "--case", "case", "--effect", &text],
        &["simulate", "--case", "case", "--part", &text],
        &["inspect", &log],
        &["report", &log],
        &["batch", &text],
        &["serve", &text],
    ] {
        assert!(!runs.run(folder, arguments), "{arguments:?}");
    }
    // a case
    let case = folder.join(format!("cases/{name}"));
    fs::create_dir_all(&case).expect("made");
    fs::copy(folder.join("plain.csv"), case.join("field.csv")).expect("copied");
    for (file, target) in [("field", "gx_rads"), (&*text, "gx_rads"), ("field", &*text)] {
        let meta = json!({ "case": text, "target": target, "device": text, "setup": text, "nominal_rate_hz": 200.0,
                           "files": { "field": file }, "note": text });
        fs::write(case.join("meta.json"), meta.to_string()).expect("written");
        runs.run(folder, &["batch", "cases", "-o", "answers"]);
    }
    fs::write(case.join("meta.json"), json!({ "schema": text }).to_string()).expect("written");
    runs.run(folder, &["batch", "cases", "-o", "answers"]);

    // reports of a harmless log, and of this one
    let mut written = Vec::new();
    for (log, study) in [("harmless.csv", "harmless.json"), (&*log, &*study)] {
        for form in ["report.html", "report.md"] {
            let command =
                [&["report", study, "--from", log, "--axis", "gx", "-o", form][..], &reading].concat();
            assert!(runs.run_with(&[false], folder, &command), "{command:?}");
            written.push(fs::read_to_string(folder.join(form)).expect("UTF-8"));
        }
    }
    let [plain_page, plain_markdown, page, markdown] = &written[..] else { panic!("four were written") };
    assert_eq!(page_differs(page, plain_page), None);
    assert_eq!(markdown_differs(markdown, plain_markdown), None, "{markdown}");
    assert!(page.contains("injected_1") && markdown.contains("injected_1"), "the name is there, as text");
    let mut pictures = 0;
    for file in fs::read_dir(folder.join("figures")).expect("drawn") {
        let path = file.expect("listed").path();
        if path.extension().is_some_and(|extension| extension == "svg") {
            let picture = fs::read_to_string(&path).expect("UTF-8");
            assert_eq!(page_differs(&picture, plain_page), None, "{}", path.display());
            pictures += 1;
        }
    }
    assert!(pictures > 4, "{pictures}");
    let foreign = fs::read_dir(folder).expect("listed").filter(|file| {
        file.as_ref().is_ok_and(|file| file.file_name().to_string_lossy().starts_with("injected"))
    });
    assert_eq!(foreign.count(), 0);

    let noticed = raw_text_is_noticed(&text, plain_page, plain_markdown);
    println!(
        "attack: escaping | {} characters, among them all control characters, Unicode characters that reorder, hide or end lines, and special characters of C, Rust, HTML, SVG, Markdown, JSON and shells, in {studies} studies (every string alone and in every position; {taken} are valid and were exported to C and Rust) and in file names, column names, cells, labels, effects, cases and arguments: {} command lines of {} subcommands, with and without colors, {} kB of output, 2 reports, {pictures} figures; {}; no text is executed or interpreted | negative control: unescaped text, detected in {noticed}",
        text.chars().count(),
        runs.runs,
        runs.subcommands.len(),
        runs.printed / 1000,
        if checks::compiler() {
            "C preprocessed and compared token by token"
        } else {
            "C not compared: no C compiler found"
        }
    );
}

fn toml_string(text: &str) -> String {
    // escaped as in JSON, except for DEL, which TOML requires to be escaped
    serde_json::to_string(text).expect("a string").replace('\u{7f}', "\\u007f")
}

/// Checks that each check detects the unescaped text.
fn raw_text_is_noticed(text: &str, page: &str, markdown: &str) -> &'static str {
    let benign = "// provenance\nstatic const int x = 1;\n";
    for (what, piece) in [
        ("CR", "a\rint injected(void){return 7;}"),
        ("LF", "a\nint injected;"),
        ("trigraph", "a ??/"),
        ("backslash", "a \\"),
    ] {
        if checks::compiler() || what == "LF" {
            assert!(c_differs(&format!("// {piece}\nstatic const int x = 1;\n"), benign).is_some(), "{what}");
        }
    }
    let benign = "// provenance\npub static X: u8 = 1;\n";
    for piece in ["a\nfn injected() {}", "a\u{202e}", "a\r"] {
        assert!(rust_differs(&format!("// {piece}\npub static X: u8 = 1;\n"), benign).is_some(), "{piece:?}");
    }
    assert!(
        reaches_a_terminal(text.as_bytes(), false).is_some()
            && reaches_a_terminal(text.as_bytes(), true).is_some()
    );
    assert!(
        reaches_a_terminal(serde_json::to_string("\u{9b}").expect("a string").as_bytes(), false).is_some()
    );
    for piece in [text, "<img src=x>", "<b>", "</p>", "\u{1}", "\" onload=\"x"] {
        let place =
            page.replacen("role=\"img\" aria-label=\"", &format!("role=\"img\" aria-label=\"{piece}"), 1);
        let place = place.replacen("<h1>", &format!("<h1>{piece}"), 1);
        assert!(page_differs(&place, page).is_some(), "{piece:?}");
    }
    for piece in [text, "\n# injected", "\n| a |", "<img src=x>", "\n- a", "\n```", "\u{9b}"] {
        let place =
            markdown.replacen("# Sensor error report\n", &format!("# Sensor error report\n\nx {piece}\n"), 1);
        assert!(markdown_differs(&place, markdown).is_some(), "{piece:?}");
    }
    "C (a lone CR, a line's end, a trigraph, a backslash), Rust, terminal, JSON on a terminal, page, picture and Markdown"
}
