//! Escapes external text for places where some characters have an effect: a terminal, source code, a page, a shell.
//!
//! Text is first made [`visible`]; each place then has its own rule for its special characters. The rules of Markdown and HTML are in
//! fos-report, beside the report.

use std::fmt::{self, Write};

use crate::visible::{is_hidden, visible};

/// JSON for a terminal: hidden characters, which occur only inside its strings, are replaced by their JSON escapes.
pub fn visible_json(json: &str) -> String {
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

/// Writes lines as `//` comments of C. A line that ends in a backslash, or in the trigraph of one (`??/`), would continue onto the next, so
/// backslashes become slashes and consecutive question marks are separated.
pub fn c_comment(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
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
pub fn rust_comment(f: &mut impl Write, mark: &str, text: &str) -> fmt::Result {
    for line in text.lines() {
        writeln!(f, "{}", format!("{mark} {}", visible(line)).trim_end())?;
    }
    Ok(())
}

/// Quotes text for a shell if it has anything but plain letters; hidden characters are written as escapes.
pub fn quoted(text: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-./=:,+@%".contains(letter);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    if !text.contains(is_hidden) {
        return format!("'{}'", text.replace('\'', r"'\''"));
    }
    // POSIX 2024: `$'…'` has escapes, and three octal digits need no terminator.
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

/// Text as part of a file name, without characters that lead to another folder or start an extension.
pub fn in_file_name(text: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    text.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn visible_json_preserves_its_value() {
        let text = "\u{7f}\u{9b}\u{2028}\u{202e}\u{e0041}\n\u{1b}\"\\";
        let json = serde_json::to_string_pretty(&[text]).unwrap();
        let shown = visible_json(&json);
        assert!(!shown.contains(|letter| letter != '\n' && is_hidden(letter)), "{shown}");
        assert_eq!(serde_json::from_str::<Vec<String>>(&shown).unwrap(), [text]);
    }

    #[test]
    fn shell_restores_quoted_text() {
        let texts = ["plain_1.csv", "", "a b", "it's", "$HOME `x` \\", "a\rb\n'c'\\1", "\u{202e}7\u{1b}[31m"];
        for text in texts {
            let line = quoted(text);
            assert!(!line.contains(is_hidden), "{line}");
            match Command::new("bash").args(["-c", &format!("printf %s {line}")]).output() {
                Ok(output) => assert_eq!(String::from_utf8_lossy(&output.stdout), text, "{line}"),
                Err(_) => println!("skipped: no bash here"),
            }
        }
    }
}
