//! Percent-encoding of references to files (RFC 3986 §2.1).

/// The value of a hexadecimal digit.
fn hex(c: Option<&u8>) -> Option<u8> {
    char::from(*c?).to_digit(16).map(|d| d as u8)
}

/// Decodes percent-encoding (`%20`).
pub(crate) fn unescape(uri: &str) -> Vec<u8> {
    let raw = uri.as_bytes();
    let mut bytes = Vec::with_capacity(raw.len());
    let mut at = 0;
    while let Some(&c) = raw.get(at) {
        match (c, hex(raw.get(at + 1)), hex(raw.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                bytes.push(high << 4 | low);
                at += 3;
            }
            _ => {
                bytes.push(c);
                at += 1;
            }
        }
    }
    bytes
}

/// Percent-encodes a path as a URI. What is encoded already stays.
pub(crate) fn escape(path: &str) -> String {
    let mut uri = String::with_capacity(path.len());
    let raw = path.as_bytes();
    for (at, &c) in raw.iter().enumerate() {
        let escaped = c == b'%' && hex(raw.get(at + 1)).is_some() && hex(raw.get(at + 2)).is_some();
        match c {
            b'\\' => uri.push('/'),
            _ if escaped || c.is_ascii_alphanumeric() || b"-._~/:?#@!$&'()*+,;=".contains(&c) => {
                uri.push(char::from(c));
            }
            _ => uri += &format!("%{c:02X}"),
        }
    }
    uri
}

/// Decodes a percent-encoded reference: `bark%201.png` is `bark 1.png`. One that is no text then stays as it is.
pub fn percent_decoded(uri: &str) -> String {
    String::from_utf8(unescape(uri)).unwrap_or_else(|_| uri.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_escaped_and_back() {
        assert_eq!(escape("a b\\ü.png"), "a%20b/%C3%BC.png");
        assert_eq!(escape("a%20b.png"), "a%20b.png");
        assert_eq!(unescape(&escape("a b/ü%.png")), "a b/ü%.png".as_bytes());
        assert_eq!(percent_decoded("a%20b%2"), "a b%2");
    }
}
