//! A request as the part of an address after `#`: what differs from the defaults, or a whole recipe where that does not say it all.

use super::command::settings;
use greenstick::RequestFile;
use greenstick::formats::percent_decoded;
use std::fmt::Write;

/// The key of a whole recipe, which no parameter has.
const RECIPE: &str = "recipe";
/// The key of a preset.
const PRESET: &str = "preset";
/// The key of the name of the file that is broken.
const INPUT: &str = "input";

/// Returns the address of a request, without `#`; `input` is the name of the file that it is about.
pub fn link(file: &RequestFile, input: Option<&str>) -> String {
    let mut words = match settings(file) {
        Some(settings) => settings,
        None => vec![format!("{RECIPE}={}", file.to_toml())],
    };
    words.extend(input.map(|name| format!("{INPUT}={name}")));
    let words: Vec<String> = words.iter().map(|w| escaped(w)).collect();
    words.join("&")
}

/// Reads an address; what it is about is in its `input`.
///
/// # Errors
/// What is wrong with it.
pub fn read_link(address: &str) -> Result<RequestFile, String> {
    let words: Vec<String> = address
        .split('&')
        .filter(|w| !w.is_empty())
        .map(percent_decoded)
        .collect();
    let mut presets = Vec::new();
    let mut settings = Vec::new();
    let (mut recipe, mut input) = (None, None);
    for word in &words {
        match word.split_once('=') {
            Some((RECIPE, text)) => recipe = Some(text),
            Some((PRESET, name)) => presets.push(name),
            Some((INPUT, name)) => input = Some(name.to_owned()),
            _ => settings.push(word.as_str()),
        }
    }
    let mut file = RequestFile::resolve(&presets, recipe, &settings)
        .map_err(|e| format!("The address of this page: {e}"))?;
    file.input = input;
    Ok(file)
}

/// A word as addresses take it.
fn escaped(word: &str) -> String {
    let mut out = String::new();
    for byte in word.bytes() {
        let plain = byte.is_ascii_alphanumeric() || b"-_.~=,:+/".contains(&byte);
        if plain {
            out.push(char::from(byte));
        } else {
            let _ = write!(out, "%{byte:02X}");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_gives_the_same_request() {
        let several = "part = '3 cm'\n[[breaks]]\nat = 0.4\n[[breaks]]\nat = '60 cm'\n";
        for (text, input) in [
            ("", None),
            ("species = 'white oak'\nat = '12cm'\n", Some("täg & x.glb")),
            (several, None),
        ] {
            let mut file = RequestFile::resolve(&["green-stick"], Some(text), &["seed=9"]).unwrap();
            let address = link(&file, input);
            assert!(address.is_ascii() && !address.contains(' '), "{address}");
            file.input = input.map(str::to_owned);
            assert_eq!(read_link(&address).unwrap(), file, "{address}");
        }
        assert_eq!(link(&RequestFile::default(), None), "");
        let preset = RequestFile::resolve(&["brash"], None, &[]).unwrap();
        assert_eq!(read_link("preset=brash").unwrap(), preset);
        assert!(
            read_link("inclinatoin=3")
                .unwrap_err()
                .contains("inclinatoin")
        );
    }
}
