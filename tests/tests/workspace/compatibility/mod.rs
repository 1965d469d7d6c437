//! What was written once is read for ever: a file of every version of every format, with what it must come to.
//!
//! `tests/fixtures/README.md` says what the files are and how those of a new version are made.

mod digest;
mod flash;
mod formats;
mod kinds;
mod make;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use formats::{FORMATS, Format};
use fos_core::{AxisParameters, Image, Range};
use fos_diagnose::study::Study;
use fos_fit::export::current;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

/// `NAME_vVERSION.EXTENSION`.
fn file_of(format: &Format, version: u32) -> PathBuf {
    folder().join(format!("{}_v{version}.{}", format.name, format.extension))
}

/// Every fixture by the name of its format, with its version.
fn fixtures() -> BTreeMap<&'static str, Vec<u32>> {
    let mut found: BTreeMap<_, Vec<u32>> = BTreeMap::new();
    for format in FORMATS {
        let mut versions: Vec<u32> =
            (0..=format.version).filter(|version| file_of(format, *version).exists()).collect();
        versions.sort_unstable();
        found.insert(format.name, versions);
    }
    found
}

fn read(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What it must come to stands beside a fixture, in a file of its name with `.txt` behind it.
fn recorded(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".txt");
    name.into()
}

#[test]
fn every_fixture_still_reads_and_comes_to_what_it_came_to() {
    println!("| format | read | written | fixtures, bytes |\n|---|---|---|---|");
    for format in FORMATS {
        let versions = &fixtures()[format.name];
        assert!(!versions.is_empty(), "there is no fixture of a {}", format.name);
        let mut sizes = Vec::new();
        for version in versions {
            let path = file_of(format, *version);
            let bytes = read(&path);
            let outputs =
                (format.outputs)(&bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            let expected = String::from_utf8(read(&recorded(&path))).expect("UTF-8");
            assert!(outputs == expected, "{}: it now comes to\n{outputs}", path.display());
            sizes.push(bytes.len().to_string());
        }
        let versions: Vec<String> = versions.iter().map(u32::to_string).collect();
        println!(
            "| {} | {} | {} | {} |",
            format.title,
            versions.join(", "),
            format.version,
            sizes.join(", ")
        );
    }
}

#[test]
fn what_is_written_today_is_among_the_fixtures() {
    for format in FORMATS {
        let path = file_of(format, format.version);
        assert!(
            path.exists() && recorded(&path).exists(),
            "{} of version {} has no fixture {}; tests/fixtures/README.md says how to make it",
            format.title,
            format.version,
            path.display()
        );
    }
}

#[test]
fn what_is_written_today_is_written_as_it_was() {
    for (name, make) in [
        ("kinds", kinds::image as fn() -> Vec<u8>),
        ("hub_log", make::hub_log),
        ("replay_log", make::replay_log),
        ("telemetry", make::telemetry),
    ] {
        let format = FORMATS.iter().find(|format| format.name == name).expect("a format");
        // nothing but the writer decides: no fit is in them
        assert!(
            make() == read(&file_of(format, format.version)),
            "{}: other bytes, and no other version",
            format.title
        );
    }
    let study = folder().join("study_v1.json");
    let written = Study::read(&study).expect("it is read").to_bytes();
    assert_eq!(String::from_utf8_lossy(&written), String::from_utf8_lossy(&read(&study)));
    // of an image: the writer against the format's description, byte by byte, in fos-core/tests/image.rs
}

#[test]
fn a_file_in_the_folder_is_a_fixture_with_its_outputs() {
    // `reference`: answers computed by others, with a README of its own
    let mut known: Vec<PathBuf> =
        ["README.md", "c_api_v1.h", "c_api_v2.h", "reference"].map(|name| folder().join(name)).into();
    for format in FORMATS {
        for version in &fixtures()[format.name] {
            let path = file_of(format, *version);
            known.extend([recorded(&path), path]);
        }
    }
    for entry in fs::read_dir(folder()).expect("a folder") {
        let path = entry.expect("an entry").path();
        assert!(known.contains(&path), "{}: of no format, or newer than this program", path.display());
    }
}

#[test]
fn another_version_is_refused_by_its_number() {
    for format in FORMATS {
        let Some(as_version) = format.as_version else { continue };
        let bytes = read(&file_of(format, format.version));
        for version in [format.version + 1, 999] {
            let said = (format.outputs)(&as_version(&bytes, version)).expect_err("it is refused");
            for word in [version.to_string(), "this program reads".to_owned(), format.version.to_string()] {
                assert!(said.contains(&word), "{}: {word:?} is not in: {said}", format.title);
            }
        }
    }
}

/// What is told from what was written before there was a range of p: nothing, and p is not limited.
#[test]
fn what_is_older_than_the_range_of_p_does_not_limit_it() {
    for name in ["model", "kinds"] {
        let bytes = |version: u32| read(&folder().join(format!("{name}_v{version}.fosm")));
        let (old, new) = (bytes(1), bytes(2));
        let old = current(&old).expect("it is read");
        let (old, new) = (Image::parse(&old).expect("an image"), Image::parse(&new).expect("an image"));
        assert!(old.inputs().eq(new.inputs()) && old.quantities().eq(new.quantities()), "{name}");
        assert_eq!((old.axes().count(), old.stillness()), (new.axes().count(), new.stillness()), "{name}");
        for (old, new) in old.axes().zip(new.axes()) {
            assert_ne!(new.parameters.physical_range, Range::unlimited());
            let physical_range = Range::unlimited();
            assert_eq!(old.parameters, AxisParameters { physical_range, ..new.parameters }, "{name}");
            assert!(old.physical.eq(new.physical) && old.stochastic.eq(new.stochastic), "{name}");
        }
    }
    let study = Study::read(&folder().join("study_v1.json")).expect("it is read");
    assert!(study.model.axes.iter().all(|axis| axis.parameters.physical_range == Range::unlimited()));
}

/// The counter-check: the outputs see what changes.
#[test]
fn every_changed_byte_is_refused_or_comes_to_something_else() {
    for format in FORMATS {
        for version in &fixtures()[format.name] {
            let path = file_of(format, *version);
            let (bytes, expected) = (read(&path), (format.outputs)(&read(&path)));
            let (mut refused, mut differs) = (0, 0);
            for place in (format.payload)(&bytes) {
                let mut changed = bytes.clone();
                changed[place] ^= 1;
                match (format.outputs)(&changed) {
                    Err(_) => refused += 1,
                    outputs if outputs != expected => differs += 1,
                    _ => panic!("{}: a change of byte {place} is not noticed", path.display()),
                }
            }
            assert!(refused + differs > 10, "{}: {refused} + {differs} bytes", path.display());
            println!(
                "control: {}, {} bytes changed: {refused} refused, {differs} came to something else, 0 unnoticed",
                format.title,
                refused + differs
            );
        }
    }
}

/// Everything that `header` declares, without comments, one declaration an item.
fn declarations(header: &str) -> Vec<String> {
    let mut code = String::new();
    let mut rest = header;
    while let Some((before, after)) = rest.split_once("/*") {
        code.push_str(before);
        rest = after.split_once("*/").map_or("", |(_, after)| after);
    }
    code.push_str(rest);
    let mut declarations = vec![String::new()];
    let mut depth = 0_u32;
    for line in code.lines().map(|line| line.split("//").next().unwrap_or("").trim_end()) {
        // what C++ needs around everything is not a body
        if line != "extern \"C\" {" {
            depth += line.matches('{').count() as u32;
            depth = depth.saturating_sub(line.matches('}').count() as u32);
        }
        // an empty line outside of a body ends a declaration
        match (line.is_empty(), declarations.last_mut()) {
            (false, Some(last)) => last.push_str(&format!("{line}\n")),
            (true, _) if depth > 0 => {}
            _ => declarations.push(String::new()),
        }
    }
    declarations.retain(|declaration| !declaration.is_empty());
    // where a line breaks is the generator's to say
    declarations.iter().map(|words| words.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

const C_VERSION: &str = "#define FOS_API_VERSION ";

/// Whether what was declared then is declared today: word for word, or an enumeration with more at its end.
fn is_declared(then: &str, today: &[String]) -> bool {
    let body = |declaration: &str| -> Option<(String, String)> {
        let (body, rest) = declaration.strip_prefix("enum ")?.split_once(" };")?;
        Some((body.to_owned(), rest.to_owned()))
    };
    let has_grown = |today: &str| match (body(then), body(today)) {
        (Some((then, rest)), Some((today, same))) => today.starts_with(&then) && rest == same,
        _ => false,
    };
    today.iter().any(|today| today == then || has_grown(today))
}

#[test]
fn what_a_program_in_c_was_compiled_with_is_still_declared() {
    let header = |path: &Path| String::from_utf8(read(path)).expect("UTF-8");
    let today = header(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../fos-embedded/include/fos.h"));
    let today = declarations(&today);
    let newest = today.iter().find_map(|line| line.strip_prefix(C_VERSION));
    let newest: u32 =
        newest.and_then(|version| version.trim().parse().ok()).expect("the header says its version");
    for version in 1..=newest {
        let mut then = declarations(&header(&folder().join(format!("c_api_v{version}.h"))));
        assert!(then.contains(&format!("{C_VERSION}{version}")), "its own version");
        then.retain(|declaration| version == newest || !declaration.starts_with(C_VERSION));
        assert!(then.len() > 40, "{} declarations", then.len());
        let missing = |today: &[String]| -> Vec<String> {
            then.iter().filter(|declaration| !is_declared(declaration, today)).cloned().collect()
        };
        assert_eq!(missing(&today), [""; 0], "of version {version}: gone or changed");
        println!("| C interface | {version} | {newest} | {} declarations |", then.len());
        // the counter-check: any one of them that is changed is missed
        for place in 0..today.len() {
            let mut changed = today.clone();
            changed[place].insert(0, 'x');
            let only_one = today.iter().filter(|declaration| **declaration == today[place]).count() == 1;
            let held = |declaration: &String| is_declared(declaration, &today[place..=place]);
            let must_be_missed = only_one && then.iter().any(held);
            assert_eq!(missing(&changed).len(), usize::from(must_be_missed), "{}", today[place]);
        }
    }
}

#[test]
fn an_enumeration_may_grow_at_its_end_alone() {
    let then = "enum status { A = 0, B = 1, };";
    for (today, held) in [
        (then, true),
        ("enum status { A = 0, B = 1, C = 2, };", true),
        ("enum status { A = 0, C = 1, B = 2, };", false),
        ("enum status { A = 0, };", false),
        ("enum state { A = 0, B = 1, };", false),
        ("enum status { A = 0, B = 1, }; #endif", false),
    ] {
        assert_eq!(is_declared(then, &[today.to_owned()]), held, "{today}");
    }
}
