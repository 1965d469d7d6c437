//! Makes text of foreign origin visible: nothing in it moves a cursor, ends a line, reverses the order of letters or is
//! hidden.

use std::borrow::Cow;
use std::fmt::Write;

/// Returns true for a character without a shape that has an effect: moves the cursor, ends a line, reverses the order of
/// letters (bidi), hides.
///
/// Unicode 16: Cc, Zl, Zp, the characters of Cf that belong to no script, and the noncharacters that XML does not allow.
pub fn is_hidden(letter: char) -> bool {
    letter.is_control()
        || matches!(letter,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
            | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{fffe}' | '\u{ffff}' | '\u{e0000}'..='\u{e007f}')
}

/// Text on one line without hidden characters: each is replaced by its code point, such as `<U+001B>`.
pub fn visible(text: &str) -> Cow<'_, str> {
    shown(text, is_hidden)
}

/// The same with the line breaks (`\n`) of the text preserved.
pub fn visible_lines(text: &str) -> Cow<'_, str> {
    shown(text, |letter| letter != '\n' && is_hidden(letter))
}

fn shown(text: &str, is_named: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_named) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for letter in text.chars() {
        if is_named(letter) {
            let _ = write!(shown, "<U+{:04X}>", u32::from(letter));
        } else {
            shown.push(letter);
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_hidden_characters_by_code_points() {
        assert_eq!(
            visible("gx\r\n\u{1b}[31m\u{202e}\u{9b}\0"),
            "gx<U+000D><U+000A><U+001B>[31m<U+202E><U+009B><U+0000>"
        );
        assert_eq!(visible_lines("a\nb\tc"), "a\nb<U+0009>c");
        assert!(matches!(visible("r̂ – é 漢字 😀 ماء"), Cow::Borrowed(_)), "what is text stays as it is");
    }
}
