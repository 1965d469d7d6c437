//! Escaping of arbitrary text for Markdown.

use fos_data::visible::{visible, visible_lines};

/// Characters that begin emphasis, code, a link, a tag or a cell.
const ACTIVE: [char; 8] = ['\\', '`', '*', '~', '[', '<', '|', '&'];

/// Escapes a line of text.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    let mut before = ' ';
    let text = on_one_line(text);
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let next = letters.peek().copied().unwrap_or(' ');
        // an underscore inside a word begins no emphasis, and names contain many
        let emphasis = letter == '_' && !(before.is_alphanumeric() && next.is_alphanumeric());
        let address = letter == ':' && next == '/' || letter == '.' && before == 'w';
        if ACTIVE.contains(&letter) || emphasis || address {
            escaped.push('\\');
        }
        escaped.push(letter);
        before = letter;
    }
    escaped
}

/// Formats text as code within a line.
pub(super) fn code(text: &str) -> String {
    let fence = fence(text, 1);
    // Markdown strips one space at both ends; next to a backtick the space is needed
    let text = on_one_line(text);
    let beside = if text.starts_with(['`', ' ']) || text.ends_with(['`', ' ']) { " " } else { "" };
    format!("{fence}{beside}{text}{beside}{fence}")
}

/// Formats lines as a block of shell code.
pub(super) fn shell(lines: &[String]) -> String {
    let text = lines.join("\n");
    let text = visible_lines(&text);
    let fence = fence(&text, 3);
    format!("{fence}sh\n{text}\n{fence}")
}

/// Replaces line breaks and tabs by spaces, as Markdown does, and makes all other hidden characters visible.
fn on_one_line(text: &str) -> String {
    visible(&text.replace(['\n', '\t'], " ")).into_owned()
}

/// Returns at least `least` backticks, and more than any run of them in the text.
fn fence(text: &str, least: usize) -> String {
    let longest = text.split(|letter| letter != '`').map(str::len).max().unwrap_or(0);
    "`".repeat(least.max(longest + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_markdown_syntax() {
        assert_eq!(
            escaped("a|b\n<img src=x> [link](http://x) *"),
            "a\\|b \\<img src=x> \\[link](http\\://x) \\*"
        );
        assert_eq!(escaped("_imu_t_c_ ~~x~~ www.x.org"), "\\_imu_t_c\\_ \\~\\~x\\~\\~ www\\.x.org");
        assert_eq!(escaped("thermal lag, 60 s × 0.5"), "thermal lag, 60 s × 0.5");
        assert_eq!([code("gx_rads"), code("a`b"), code("`a")], ["`gx_rads`", "``a`b``", "`` `a ``"]);
        assert_eq!(shell(&["fit '```'".into(), "add".into()]), "````sh\nfit '```'\nadd\n````");
    }
}
