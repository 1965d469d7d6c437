//! Checks of a text in its target format, by comparison with the output for harmless text; each returns the problem
//! found.

use std::collections::BTreeSet;
use std::io::Write;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// Returns true for a character without a shape that has an effect.
fn is_hidden(letter: char) -> bool {
    letter.is_control()
        || matches!(letter, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
            | '\u{feff}' | '\u{ffff}' | '\u{e0000}'..='\u{e007f}')
}

fn hidden_in(text: &str) -> Option<String> {
    text.chars().find(|&letter| letter != '\n' && is_hidden(letter)).map(|letter| format!("holds {letter:?}"))
}

/// Finds text that a terminal would execute. With `colours` those of the program are allowed: bold, red, green, yellow,
/// and their end.
pub(crate) fn reaches_a_terminal(bytes: &[u8], colours: bool) -> Option<String> {
    let mut text = String::from_utf8(bytes.to_vec()).map_err(|_| "not UTF-8".to_owned()).ok()?;
    if colours {
        for own in [
            "\u{1b}[1m\u{1b}[31m",
            "\u{1b}[1m\u{1b}[32m",
            "\u{1b}[1m\u{1b}[33m",
            "\u{1b}[0m",
            "\u{1b}[1m",
            "\u{1b}[4m",
        ] {
            text = text.replace(own, "");
        }
    }
    hidden_in(&text)
}

/// Returns true if a C compiler exists.
pub(crate) fn compiler() -> bool {
    static THERE: OnceLock<bool> = OnceLock::new();
    *THERE.get_or_init(|| {
        let there = Command::new("cc").arg("--version").output().is_ok_and(|output| output.status.success());
        if !there {
            println!("skipped: no cc here, C is not compiled");
        }
        there
    })
}

/// Compares the tokens with those for harmless text, except numbers: an image contains the text as numbers.
pub(crate) fn c_differs(found: &str, benign: &str) -> Option<String> {
    hidden_in(found).or_else(|| {
        if !compiler() {
            let code = |text: &str| {
                text.lines().filter(|line| !line.starts_with("//")).map(without_numbers).collect::<String>()
            };
            return (code(found) != code(benign)).then(|| "other lines".to_owned());
        }
        // trigraphs with the one, the extensions of GNU with the other
        ["-std=c99", "-std=gnu17"].into_iter().find_map(|standard| {
            let (found, benign) = (preprocessed(found, standard), preprocessed(benign, standard));
            (found != benign).then(|| format!("other tokens with {standard}:\n{found}\nthan\n{benign}"))
        })
    })
}

/// Source without comments and included headers.
fn preprocessed(source: &str, standard: &str) -> String {
    let own: String = source.lines_by_lf().filter(|line| !line.starts_with("#include")).collect();
    let mut cc = Command::new("cc")
        .args([
            "-E",
            "-P",
            standard,
            "-DFOS_MAX_INPUTS=99",
            "-DFOS_MAX_TERMS=999",
            "-DFOS_MAX_HISTORY=9999",
            "-xc",
            "-",
        ])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it is there");
    cc.stdin.take().expect("piped").write_all(own.as_bytes()).expect("it reads");
    let output = cc.wait_with_output().expect("it ends");
    let message = String::from_utf8_lossy(&output.stderr)
        .lines()
        .filter(|line| line.contains("error"))
        .collect::<String>();
    without_numbers(&String::from_utf8_lossy(&output.stdout)) + &message
}

trait LinesByLf {
    /// Lines with their ends, split at LF only.
    fn lines_by_lf(&self) -> impl Iterator<Item = &str>;
}

impl LinesByLf for str {
    fn lines_by_lf(&self) -> impl Iterator<Item = &str> {
        self.split_inclusive('\n')
    }
}

/// Words that are no numbers.
fn without_numbers(text: &str) -> String {
    let is_word =
        |word: &&str| !word.trim_start_matches(['-', '{']).starts_with(|first: char| first.is_ascii_digit());
    text.split_whitespace().filter(is_word).collect::<Vec<_>>().join(" ")
}

/// Compares the lines with those for harmless text, except comments, which must not contain a line end of rustc or a
/// character that it rejects.
pub(crate) fn rust_differs(found: &str, benign: &str) -> Option<String> {
    let code = |text: &str| {
        let lines = text.split('\n').filter(|line| !line.trim_start().starts_with("//"));
        lines.collect::<Vec<_>>().join("\n")
    };
    hidden_in(found).or_else(|| {
        (code(found) != code(benign))
            .then(|| format!("other items:\n{}\nthan\n{}", code(found), code(benign)))
    })
}

/// Tags with the names of their attributes, and whether each is an end tag.
fn tags(page: &str) -> Result<Vec<(String, bool)>, String> {
    let mut tags = Vec::new();
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let mut quote = None;
        let end = rest.char_indices().find(|&(_, letter)| match (quote, letter) {
            (None, '>') => true,
            (None, '"' | '\'') => {
                quote = Some(letter);
                false
            }
            (Some(open), _) if letter == open => {
                quote = None;
                false
            }
            _ => false,
        });
        let (end, _) = end
            .ok_or_else(|| format!("a tag without an end: {}", rest.chars().take(80).collect::<String>()))?;
        let tag = &rest[..end];
        // quoted text is not part of the structure
        let shape: String = tag.split('"').step_by(2).collect::<Vec<_>>().join("\"");
        let (shape, is_end) =
            shape.strip_prefix('/').map_or((shape.clone(), false), |shape| (shape.to_owned(), true));
        tags.push((shape.split_whitespace().collect::<Vec<_>>().join(" "), is_end));
        rest = &rest[end + 1..];
    }
    Ok(tags)
}

/// Finds a tag that the page of a harmless log does not have, an unclosed tag, or a character that XML does not allow.
pub(crate) fn page_differs(found: &str, benign: &str) -> Option<String> {
    const ALONE: [&str; 4] = ["meta", "br", "!doctype", "hr"];
    let known: BTreeSet<String> = tags(benign).expect("sound").into_iter().map(|(tag, _)| tag).collect();
    // pictures have more attributes than needed
    let name = |tag: &str| tag.split_whitespace().next().unwrap_or_default().to_ascii_lowercase();
    let names: BTreeSet<String> = known.iter().map(|tag| name(tag)).collect();
    let attributes = |tag: &str| -> BTreeSet<String> {
        tag.split_whitespace()
            .skip(1)
            .filter_map(|part| part.split_once('='))
            .map(|(name, _)| name.trim_matches('"').to_owned())
            .collect()
    };
    let all: BTreeSet<String> = known.iter().flat_map(|tag| attributes(tag)).collect();
    let mut open = Vec::new();
    if let Some(hidden) = hidden_in(found) {
        return Some(hidden);
    }
    let tags = match tags(found) {
        Ok(tags) => tags,
        Err(wrong) => return Some(wrong),
    };
    for (tag, is_end) in tags {
        let tag_name = name(tag.trim_end_matches('/'));
        if !names.contains(&name(&tag)) && !names.contains(&tag_name) {
            return Some(format!("a tag <{tag}>"));
        }
        if let Some(other) = attributes(&tag).difference(&all).next() {
            return Some(format!("an attribute {other} in <{tag}>"));
        }
        if is_end {
            if open.pop().as_ref() != Some(&tag_name) {
                return Some(format!("</{tag}> ends nothing"));
            }
        } else if !tag.ends_with('/') && !ALONE.contains(&&*tag_name) {
            open.push(tag_name);
        }
    }
    (!open.is_empty()).then(|| format!("{open:?} do not end"))
}

/// Finds more headings, rows, items, quotes or fences than for a harmless log; a tag or a link outside of code.
pub(crate) fn markdown_differs(found: &str, benign: &str) -> Option<String> {
    if let Some(hidden) = hidden_in(found) {
        return Some(hidden);
    }
    let (found, benign) = (shape(found), shape(benign));
    match (found, benign) {
        (Ok(found), Ok(benign)) if found == benign => None,
        (found, benign) => Some(format!("{found:?} where {benign:?} are")),
    }
}

/// Numbers of lines that begin as a Markdown heading, row and so on; and of cells of rows.
fn shape(text: &str) -> Result<[usize; 7], String> {
    let mut counts = [0; 7];
    let mut fence: Option<String> = None;
    for line in text.split('\n') {
        let begin = line.trim_start();
        let ticks: String = begin.chars().take_while(|&letter| letter == '`').collect();
        if let Some(open) = &fence {
            if ticks.len() >= open.len() && begin.trim_end() == ticks {
                fence = None;
            }
            continue;
        }
        if ticks.len() >= 3 {
            counts[0] += 1;
            fence = Some(ticks);
            continue;
        }
        let text = without_code(begin);
        let active =
            text.match_indices(['<', '[']).find(|(at, _)| escapes_before(&text, *at).is_multiple_of(2));
        if let Some((at, _)) = active {
            return Err(format!("a tag or a link: {}", text[at..].chars().take(60).collect::<String>()));
        }
        let kinds = [
            begin.starts_with('#'),
            begin.starts_with('|'),
            begin.starts_with("- ") || begin.starts_with("* ") || begin.starts_with("+ "),
            begin.starts_with('>'),
            begin.split_once('.').is_some_and(|(number, _)| {
                !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())
            }),
        ];
        for (count, is) in counts[1..].iter_mut().zip(kinds) {
            *count += usize::from(is);
        }
        if begin.starts_with('|') {
            counts[6] += text
                .match_indices('|')
                .filter(|(at, _)| escapes_before(&text, *at).is_multiple_of(2))
                .count();
        }
    }
    if fence.is_some() { Err("a fence that is not closed".to_owned()) } else { Ok(counts) }
}

fn escapes_before(text: &str, at: usize) -> usize {
    text[..at].bytes().rev().take_while(|&byte| byte == b'\\').count()
}

/// A line without its code spans.
fn without_code(line: &str) -> String {
    let mut rest = line;
    let mut text = String::new();
    while let Some(at) = rest.find('`') {
        let escaped = escapes_before(rest, at) % 2 == 1;
        let ticks: String = rest[at..].chars().take_while(|&letter| letter == '`').collect();
        text.push_str(&rest[..at]);
        let behind = &rest[at + ticks.len()..];
        let close = behind
            .match_indices(&ticks)
            .find(|(end, _)| !behind[..*end].ends_with('`') && !behind[end + ticks.len()..].starts_with('`'));
        rest = match close {
            Some((end, _)) if !escaped => &behind[end + ticks.len()..],
            _ => behind,
        };
    }
    text + rest
}
