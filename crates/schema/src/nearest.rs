//! Names that look like a misspelt one.

/// How far a suggestion may be from what was typed: 1 is the same, 0 has nothing in common.
const SIMILAR: f64 = 0.55;
/// How many names are suggested.
const SUGGESTIONS: usize = 3;
/// Weight of a likeness to one word of a name against one to the whole.
const PART: f64 = 0.9;

/// "; did you mean a, b or c?", or nothing when there is nothing near.
pub fn suggestion(nearest: &[String]) -> String {
    match nearest {
        [] => String::new(),
        [one] => format!("; did you mean \"{one}\"?"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(|n| format!("\"{n}\"")).collect();
            format!("; did you mean {} or \"{last}\"?", first.join(", "))
        }
    }
}

/// Up to three of `candidates` that look most like `word`, nearest first (Damerau-Levenshtein, case ignored). Equals keep
/// the candidates' order.
///
/// ```
/// let near = greenstick_schema::nearest("slab_hieght", ["slab_height", "slab_count", "seed"]);
/// assert_eq!(near[0], "slab_height");
/// ```
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let word = normalise(word);
    let mut scored: Vec<(f64, &str)> = candidates
        .into_iter()
        .map(|c| {
            let name = normalise(c);
            let whole = strsim::normalized_damerau_levenshtein(&word, &name);
            // One misspelt word of several is enough, though the whole name counts for more.
            let part = (name.split(' '))
                .map(|p| PART * strsim::normalized_damerau_levenshtein(&word, p))
                .fold(0.0, f64::max);
            (whole.max(part), c)
        })
        .filter(|&(score, _)| score >= SIMILAR)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = scored.into_iter().take(SUGGESTIONS);
    best.map(|(_, c)| c.to_owned()).collect()
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
