//! Text that came from outside, on its way to where some characters do things: a terminal, source code, a page, a
//! shell.
//!
//! What is shown in every one of them is [`visible`](fos_data::visible::visible); then each has its own rule for what
//! it takes for its own. Those of the report are beside it: Markdown in `report/markdown_text.rs`, HTML in
//! `report/render.rs`; figures make theirs visible in `figures/canvas.rs`.

use std::fmt::{self, Write};

use fos_data::visible::{is_hidden, visible};

/// JSON that a terminal can show: what is hidden, which can only be inside its strings, as the escape that means it.
pub(crate) fn visible_json(json: &str) -> String {
    let mut shown = String::with_capacity(json.len());
    for letter in json.chars() {
        if letter == '\n' || !is_hidden(letter) {
            shown.push(letter);
        } else {
            for unit in letter.encode_utf16(&mut [0; 2]) {
                let _ = write!(shown, "\\u{unit:04x}");
            }
        }
    }
    shown
}

/// Lines as `//` comments of C, whatever compiler reads them: a line that ends in a backslash, or in the three
/// characters that stand for one (trigraph), would take in the next.
pub(crate) fn c_comment(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    for line in text.lines() {
        let mut comment = "// ".to_owned();
        for letter in visible(line).chars() {
            match letter {
                '\\' => comment.push('/'),
                '?' if comment.ends_with('?') => comment.push_str(" ?"),
                _ => comment.push(letter),
            }
        }
        writeln!(f, "{}", comment.trim_end())?;
    }
    Ok(())
}

/// Lines as comments of Rust, each after `mark`: `//` or `///`.
pub(crate) fn rust_comment(f: &mut impl Write, mark: &str, text: &str) -> fmt::Result {
    for line in text.lines() {
        writeln!(f, "{}", format!("{mark} {}", visible(line)).trim_end())?;
    }
    Ok(())
}

/// As a shell takes it: in quotes if it holds anything but plain letters, and nothing hidden in it.
pub(crate) fn quoted(text: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-./=:,+@%".contains(letter);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    if !text.contains(is_hidden) {
        return format!("'{}'", text.replace('\'', r"'\''"));
    }
    // POSIX 2024: quotes that know escapes. Three octal digits end by themselves.
    let mut quoted = "$'".to_owned();
    for letter in text.chars() {
        match letter {
            '\'' | '\\' => quoted.extend(['\\', letter]),
            _ if is_hidden(letter) => {
                for byte in letter.encode_utf8(&mut [0; 4]).bytes() {
                    let _ = write!(quoted, "\\{byte:03o}");
                }
            }
            _ => quoted.push(letter),
        }
    }
    quoted + "'"
}

/// As part of the name of a file: nothing in it leads to another folder, or is taken for the ending.
pub(crate) fn in_file_name(text: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    text.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn json_means_what_it_meant() {
        let text = "\u{7f}\u{9b}\u{2028}\u{202e}\u{e0041}\n\u{1b}\"\\";
        let json = serde_json::to_string_pretty(&[text]).unwrap();
        let shown = visible_json(&json);
        assert!(!shown.contains(|letter| letter != '\n' && is_hidden(letter)), "{shown}");
        assert_eq!(serde_json::from_str::<Vec<String>>(&shown).unwrap(), [text]);
    }

    #[test]
    fn a_shell_gives_back_what_was_quoted() {
        let texts = ["plain_1.csv", "", "a b", "it's", "$HOME `x` \\", "a\rb\n'c'\\1", "\u{202e}7\u{1b}[31m"];
        for text in texts {
            let line = quoted(text);
            assert!(!line.contains(is_hidden), "{line}");
            match Command::new("bash").args(["-c", &format!("printf %s {line}")]).output() {
                Ok(said) => assert_eq!(String::from_utf8_lossy(&said.stdout), text, "{line}"),
                Err(_) => println!("skipped: no bash here"),
            }
        }
    }
}
