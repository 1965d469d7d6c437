//! Text as Markdown shows it, whatever is in it.

use fos_data::visible::{visible, visible_lines};

/// What would otherwise begin something: emphasis, code, a link, a tag, a cell.
const ACTIVE: [char; 8] = ['\\', '`', '*', '~', '[', '<', '|', '&'];

/// In a line of text.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    let mut before = ' ';
    let text = on_one_line(text);
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let next = letters.peek().copied().unwrap_or(' ');
        // inside a word it begins nothing, and names are full of it
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

/// As code in a line of text.
pub(super) fn code(text: &str) -> String {
    let fence = fence(text, 1);
    // a space at both ends is taken off, and needed beside a backtick
    let text = on_one_line(text);
    let beside = if text.starts_with(['`', ' ']) || text.ends_with(['`', ' ']) { " " } else { "" };
    format!("{fence}{beside}{text}{beside}{fence}")
}

/// As lines of a shell.
pub(super) fn shell(lines: &[String]) -> String {
    let text = lines.join("\n");
    let text = visible_lines(&text);
    let fence = fence(&text, 3);
    format!("{fence}sh\n{text}\n{fence}")
}

/// Our own texts have lines, which Markdown takes for spaces; whatever else is hidden is shown.
fn on_one_line(text: &str) -> String {
    visible(&text.replace(['\n', '\t'], " ")).into_owned()
}

/// More backticks than there are anywhere in the text, `least` at least.
fn fence(text: &str, least: usize) -> String {
    let longest = text.split(|letter| letter != '`').map(str::len).max().unwrap_or(0);
    "`".repeat(least.max(longest + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_markdown_would_take_for_its_own_is_shown() {
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
