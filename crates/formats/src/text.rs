//! Lines, tokens and numbers in text.

use std::str::FromStr;

/// Parses one token as a number.
pub(crate) fn number<T: FromStr>(token: &[u8]) -> Option<T> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// A token as quoted in messages, shortened if it is long.
pub(crate) fn quote(token: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(&token[..token.len().min(60)])
        .chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    if token.len() > 60 {
        format!("`{text}…`")
    } else {
        format!("`{text}`")
    }
}

/// The tokens of a line, separated by white space.
pub(crate) fn tokens(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|t| !t.is_empty())
}

/// Lines with their numbers, counted from 1, for any line ending.
pub(crate) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    bytes
        .split(|&b| b == b'\n')
        .enumerate()
        .map(|(i, line)| (i + 1, line.strip_suffix(b"\r").unwrap_or(line)))
}

/// Appends the shortest decimal number that reads back as the same `f32`.
pub(crate) fn push_number(out: &mut Vec<u8>, buffer: &mut zmij::Buffer, value: f32) {
    let text = buffer.format(value);
    out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
}

/// Appends an integer.
pub(crate) fn push_integer(out: &mut Vec<u8>, value: u64) {
    let mut digits = [0; 20];
    let mut start = digits.len();
    let mut rest = value;
    loop {
        start -= 1;
        digits[start] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[start..]);
}
