//! Names: how species (and other things with names) are looked up, and what is suggested for a name
//! that is not there.

use super::Species;

/// Other names under which species are asked for: (alias, name in the table).
///
/// Older and variant scientific names, and the two names of the first row of Yang's table, which is
/// printed "Juniperus viginiana L." there and *Juniperus rigida* elsewhere in the paper. *Juniperus
/// virginiana* therefore means that row; eastern redcedar of the Wood Handbook is found by its
/// common name.
pub(super) const ALIASES: &[(&str, &str)] = &[
    ("Juniperus virginiana", "Juniper, temple"),
    ("Juniperus viginiana", "Juniper, temple"),
    ("needle juniper", "Juniper, temple"),
    ("Sabina chinensis", "Juniper, Chinese"),
    ("ailanthus", "Tree-of-heaven"),
    ("Quercus prinus", "Oak, chestnut"),
    ("Cupressus nootkatensis", "Cedar, yellow"),
    ("Chamaecyparis nootkatensis", "Cedar, yellow"),
    ("Xanthocyparis nootkatensis", "Cedar, yellow"),
    ("Carya alba", "Hickory (true), mockernut"),
    ("Carya illinoensis", "Hickory (pecan), pecan"),
    ("Libocedrus decurrens", "Cedar, incense"),
    ("Populus balsamifera ssp. trichocarpa", "Cottonwood, black"),
    ("balsam poplar", "Cottonwood, balsam poplar"),
    ("eastern redcedar", "Cedar, eastern redcedar"),
    ("western redcedar", "Cedar, western redcedar"),
    ("pecan", "Hickory (pecan), pecan"),
    ("cucumbertree", "Magnolia, cucumbertree"),
    ("Douglas-fir", "Douglas-fir, coast"),
    ("redwood", "Redwood, old-growth"),
];

/// How far a suggestion may be from what was typed: 1 is the same, 0 has nothing in common.
const SIMILAR: f64 = 0.55;
/// How many names are suggested.
const SUGGESTIONS: usize = 3;

/// A name that is no species.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown species \"{name}\"{}", suggestion(nearest))]
pub struct UnknownSpecies {
    /// What was asked for.
    pub name: String,
    /// Up to three names that are near it, nearest first.
    pub nearest: Vec<String>,
}

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

/// Weight of a likeness to one word of a name against one to the whole.
const PART: f64 = 0.9;

/// Up to three of `candidates` that look most like `word`, nearest first (Damerau-Levenshtein, case
/// ignored). Equals keep the candidates' order.
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
    scored
        .into_iter()
        .take(SUGGESTIONS)
        .map(|(_, c)| c.to_owned())
        .collect()
}

/// Lower case, with every run of spaces, hyphens and underscores as one space.
pub(super) fn normalise(name: &str) -> String {
    let lower = name.to_lowercase();
    lower
        .split(|c: char| c.is_whitespace() || c == '-' || c == '_')
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The ways to say a common name: "Alder, red" and "red alder"; "Hickory (true), pignut", "pignut
/// hickory".
fn common_names(name: &str) -> Vec<String> {
    let mut all = vec![normalise(name)];
    if let Some((kind, which)) = name.split_once(',') {
        let kind = kind.split('(').next().unwrap_or(kind).trim();
        all.push(normalise(&format!("{which} {kind}")));
        all.push(normalise(&format!("{kind}, {which}")));
    }
    all
}

pub(super) fn find(name: &str) -> Result<&'static Species, UnknownSpecies> {
    let wanted = normalise(name);
    let by_common = |s: &&Species| common_names(&s.name).contains(&wanted);
    let alias = ALIASES.iter().find(|(alias, _)| normalise(alias) == wanted);
    // The species without its variety: coast Douglas-fir answers to Pseudotsuga menziesii, being
    // first in the table.
    let by_science = |s: &&Species| {
        let science = normalise(&s.scientific_name);
        science == wanted || science.split(" var.").next() == Some(wanted.as_str())
    };
    let all = Species::all();
    let found = match alias {
        Some((_, target)) => all.iter().find(|s| s.name == *target),
        None => all
            .iter()
            .find(by_common)
            .or_else(|| all.iter().find(by_science)),
    };
    found.ok_or_else(|| unknown(name))
}

fn unknown(name: &str) -> UnknownSpecies {
    // Every way to say a name is compared, but the table's name is suggested, once.
    let mut names: Vec<(String, &str)> = Vec::new();
    for s in Species::all() {
        names.extend(
            common_names(&s.name)
                .into_iter()
                .map(|n| (n, s.name.as_str())),
        );
        names.push((s.scientific_name.clone(), s.name.as_str()));
    }
    names.extend(
        ALIASES
            .iter()
            .map(|&(alias, target)| (alias.to_owned(), target)),
    );
    let wanted = normalise(name);
    let mut scored: Vec<(f64, &str)> = names
        .iter()
        .map(|(n, s)| {
            (
                strsim::normalized_damerau_levenshtein(&wanted, &normalise(n)),
                *s,
            )
        })
        .filter(|&(score, _)| score >= SIMILAR)
        .collect();
    // "oak" alone is far from every oak's full name, but all of them are what was meant.
    let kind = |s: &&Species| normalise(&s.name).split([',', ' ']).any(|w| w == wanted);
    scored.extend(
        Species::all()
            .iter()
            .filter(kind)
            .map(|s| (1.0, s.name.as_str())),
    );
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut nearest: Vec<String> = Vec::new();
    for (_, s) in scored {
        if nearest.len() < SUGGESTIONS && !nearest.iter().any(|n| n == s) {
            nearest.push(s.to_owned());
        }
    }
    UnknownSpecies {
        name: name.to_owned(),
        nearest,
    }
}
