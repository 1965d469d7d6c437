//! ASCII text for comments in files of other stacks, whose parsers accept nothing else.

pub fn in_ascii(text: &str) -> String {
    text.chars().map(|letter| if letter.is_ascii_graphic() || letter == ' ' { letter } else { '?' }).collect()
}
