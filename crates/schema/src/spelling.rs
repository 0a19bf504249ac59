//! Suggestions for misspelt names.

/// Least similarity of a suggestion to what was typed: 1 is the same, 0 has nothing in common.
pub const MIN_SIMILARITY: f64 = 0.55;
/// Most names that are suggested.
pub const MAX_SUGGESTIONS: usize = 3;
/// Weight of the similarity to one word of a name, relative to that to the whole name.
const WORD_WEIGHT: f64 = 0.9;

/// Returns up to three of `candidates` that look most like `word`, the closest first (Damerau-Levenshtein, case
/// ignored). Equally close names keep the candidates' order.
///
/// ```
/// use greenstick_schema::{closest_names, did_you_mean};
///
/// let names = closest_names("brsh", ["brash", "shear", "twist"]);
/// assert_eq!(did_you_mean(&names), "; did you mean \"brash\"?");
/// ```
pub fn closest_names<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let word = normalise(word);
    let mut scored: Vec<(f64, &str)> = candidates
        .into_iter()
        .map(|c| {
            let name = normalise(c);
            let whole = strsim::normalized_damerau_levenshtein(&word, &name);
            // One misspelt word of several is enough, though the whole name counts for more.
            let one_word = (name.split(' '))
                .map(|w| WORD_WEIGHT * strsim::normalized_damerau_levenshtein(&word, w))
                .fold(0.0, f64::max);
            (whole.max(one_word), c)
        })
        .filter(|&(score, _)| score >= MIN_SIMILARITY)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored
        .into_iter()
        .take(MAX_SUGGESTIONS)
        .map(|(_, c)| c.to_owned())
        .collect()
}

/// The end of a message that suggests names: `; did you mean "a", "b" or "c"?`, or nothing where there are none.
pub fn did_you_mean(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => format!("; did you mean \"{one}\"?"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(|n| format!("\"{n}\"")).collect();
            format!("; did you mean {} or \"{last}\"?", first.join(", "))
        }
    }
}

/// Lower case, with every run of spaces, hyphens and underscores as one space.
pub fn normalise(name: &str) -> String {
    let lower = name.to_lowercase();
    lower
        .split(|c: char| c.is_whitespace() || c == '-' || c == '_')
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}
