//! Names in the comments of files for others, whose readers take ASCII alone.

pub fn in_ascii(text: &str) -> String {
    text.chars().map(|letter| if letter.is_ascii_graphic() || letter == ' ' { letter } else { '?' }).collect()
}
