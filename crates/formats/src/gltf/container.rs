//! GLB chunks (§4) and data URIs.

use crate::error::{FormatError, InFile};
use crate::uri::unescape;

const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// Splits a file into its JSON and, for a GLB, the binary chunk.
pub(super) fn split<'a>(
    bytes: &'a [u8],
    file: InFile,
) -> Result<(&'a [u8], Option<&'a [u8]>), FormatError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None));
    }
    let word = |at: usize| {
        bytes
            .get(at..at + 4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let short = || {
        let found = format!("{} bytes in total", bytes.len());
        file.truncated("GLB header", found, "12 bytes and a JSON chunk")
    };
    let version = word(4).ok_or_else(short)?;
    if version != 2 {
        return Err(file.unsupported(format!("GLB version {version}"), "save it as glTF 2.0"));
    }
    let total = word(8).ok_or_else(short)? as usize;
    if total > bytes.len() {
        let found = format!("{} bytes of {total}", bytes.len());
        return Err(file.truncated("GLB header", found, "the complete file"));
    }
    let mut at = 12;
    let (mut json, mut binary) = (None, None);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        at += 8;
        let end = at
            .checked_add(length as usize)
            .filter(|&end| end <= bytes.len());
        let chunk = end.map(|end| &bytes[at..end]).ok_or_else(|| {
            let found = format!("{} bytes left of {length}", bytes.len() - at);
            file.truncated(
                format!("GLB chunk at byte {}", at - 8),
                found,
                "the complete chunk",
            )
        })?;
        match kind {
            JSON if json.is_none() => json = Some(chunk),
            BIN if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += chunk.len();
    }
    Ok((json.ok_or_else(short)?, binary))
}

/// Decodes a `data:` URI into its media type and content. Returns `None` for other URIs, and a description of the fault of
/// invalid ones.
pub(super) fn data_uri(uri: &str) -> Option<Result<(String, Vec<u8>), &'static str>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((head, data)) = rest.split_once(',') else {
        return Some(Err("a data URI without a comma"));
    };
    let Some(media_type) = head.strip_suffix(";base64") else {
        return Some(Ok((head.to_owned(), unescape(data))));
    };
    Some(
        base64(data)
            .map(|bytes| (media_type.to_owned(), bytes))
            .ok_or("invalid base64"),
    )
}

/// Decodes base64 (RFC 4648 §4).
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=');
    let mut bytes = Vec::with_capacity(text.len() * 3 / 4);
    let (mut bits, mut count) = (0_u32, 0);
    for c in text.bytes() {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

/// Joins JSON and binary data into a GLB.
pub(super) fn join(
    json: Vec<u8>,
    mut binary: Vec<u8>,
    file: InFile,
) -> Result<Vec<u8>, FormatError> {
    binary.resize(binary.len().next_multiple_of(4), 0);
    let head = head(json, binary.len(), file)?;
    // The data move up where they are: a second buffer of their size costs more.
    drop(binary.splice(0..0, head));
    Ok(binary)
}

/// The part of a GLB before `binary` bytes of binary data, a multiple of 4.
pub(super) fn head(mut json: Vec<u8>, binary: usize, file: InFile) -> Result<Vec<u8>, FormatError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + binary;
    let total32 = u32::try_from(total)
        .map_err(|_| file.unwritable(format!("{total} bytes"), "less than 4 GiB in a GLB"))?;
    let mut bytes = Vec::with_capacity(total - binary);
    bytes.extend_from_slice(b"glTF");
    for word in [2, total32, json.len() as u32, JSON] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    bytes.append(&mut json);
    for word in [binary as u32, BIN] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris() {
        // Test vectors of RFC 4648 §10.
        for (text, bytes) in [
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYmFy", "foobar"),
        ] {
            let uri = format!("data:application/octet-stream;base64,{text}");
            assert_eq!(data_uri(&uri).unwrap().unwrap().1, bytes.as_bytes());
        }
        assert!(data_uri("data:;base64,Zm9$").unwrap().is_err());
        assert!(data_uri("a.bin").is_none());
    }
}
