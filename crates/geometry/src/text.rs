//! Text from files in messages: nothing in it may move a terminal's cursor, colour its lines or pass for a message of ours.
//!
//! Terminals obey control characters (ECMA-48 §5: C0 and C1 sets; OSC sets titles and links), and characters that change the
//! direction of writing or break lines (Unicode Standard §23.2, UAX #9) make text look like another.

use std::borrow::Cow;

/// Whether a character shows nothing, but changes how other text is shown.
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn escaped(text: &str, is_kept: impl Fn(char) -> bool) -> Cow<'_, str> {
    let hidden = |c: char| is_hidden(c) && !is_kept(c);
    if !text.contains(hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if hidden(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// Returns a name from a file as one line of a message: what is hidden in it is escaped, as `\u{1b}`.
///
/// ```
/// use greenstick_geometry::text::one_line;
///
/// assert_eq!(one_line("bark\nerror: \u{1b}[31m"), "bark\\nerror: \\u{1b}[31m");
/// ```
pub fn one_line(name: &str) -> Cow<'_, str> {
    escaped(name, |_| false)
}

/// Returns text of several lines, as it may go to a terminal: what is hidden in it is escaped, but for ends of lines and tabs.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |c| matches!(c, '\n' | '\t'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_are_escaped() {
        let title = "a\u{1b}]0;owned\u{7}b\u{9b}31m";
        assert_eq!(one_line(title), "a\\u{1b}]0;owned\\u{7}b\\u{9b}31m");
        assert_eq!(one_line("x\u{202e}y"), "x\\u{202e}y");
        assert_eq!(printable("a\n\tb\r"), "a\n\tb\\r");
        assert!(matches!(one_line("Fichte, größer"), Cow::Borrowed(_)));
    }
}
