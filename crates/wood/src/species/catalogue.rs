//! The catalogue of all species, and how one is found by its name.

use super::names::{ALIASES, UnknownSpecies, common_names};
use super::record::Species;
use super::table;
use greenstick_schema::{Format, MAX_SUGGESTIONS, MIN_SIMILARITY, normalise};
use std::sync::LazyLock;

/// A common or scientific name of a species.
pub const SPECIES_NAME: Format = Format {
    name: "NAME",
    check: |name| Species::find(name).map(|_| ()).map_err(|e| e.to_string()),
};

static ALL: LazyLock<Vec<Species>> = LazyLock::new(table::read);

impl Species {
    /// All species: the 112 of the Wood Handbook in its order, then nine of Europe, then the four of Yang's Table 1.
    pub fn all() -> &'static [Species] {
        &ALL
    }

    /// Finds a species by name: "alder, red", "red alder" or "Alnus rubra"; case, hyphens and spaces
    /// do not matter. Where several rows share a scientific name, it is the first in the table.
    ///
    /// # Errors
    /// [`UnknownSpecies`] with up to three similar names.
    pub fn find(name: &str) -> Result<&'static Species, UnknownSpecies> {
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
}

/// How similar two normalised names are, from 0 to 1; names of the same words in another order count as equal.
fn similarity(a: &str, b: &str) -> f64 {
    let words = |name: &str| {
        let mut words: Vec<String> = (name.split(|c: char| !c.is_alphanumeric()))
            .map(str::to_owned)
            .collect();
        words.retain(|word| !word.is_empty());
        words.sort_unstable();
        words
    };
    if words(a) == words(b) {
        return 1.0;
    }
    strsim::normalized_damerau_levenshtein(a, b)
}

fn unknown(name: &str) -> UnknownSpecies {
    // Every way to write a name is compared, but the table's name is suggested, once.
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
        .map(|(n, s)| (similarity(&wanted, &normalise(n)), *s))
        .filter(|&(score, _)| score >= MIN_SIMILARITY)
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
        if nearest.len() < MAX_SUGGESTIONS && !nearest.iter().any(|n| n == s) {
            nearest.push(s.to_owned());
        }
    }
    UnknownSpecies {
        name: name.to_owned(),
        nearest,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_have_125_species_of_which_27_are_known_green() {
        let all = Species::all();
        assert_eq!(all.len(), 125);
        assert_eq!(
            all.iter().filter(|s| s.source.contains("5-3a")).count(),
            112
        );
        assert_eq!(all.iter().filter(|s| s.green.is_some()).count(), 27);
        // 79 rows of Table 4-3 of which nine are no species of Table 5-3a, eight of Europe's nine, and Yang's four.
        assert_eq!(
            all.iter().filter(|s| s.shrinkage.radial.is_some()).count(),
            70 + 8 + 4
        );
        assert_eq!(
            all.iter()
                .filter(|s| s.green_heartwood_percent.is_some())
                .count(),
            16
        );
        // Thirteen names, one of which joins four Douglas-firs and one two redwoods.
        assert_eq!(
            all.iter()
                .filter(|s| s.intersection_percent.is_some())
                .count(),
            17
        );
        assert!(all.iter().all(|s| s.ring_character.is_some()));
        assert!(
            all.iter()
                .all(|s| s.dry.modulus_of_rupture.is_some_and(f64::is_finite))
        );
    }

    #[test]
    fn every_name_finds_its_species() {
        for s in Species::all() {
            assert_eq!(Species::find(&s.name).unwrap().name, s.name);
            assert_eq!(Species::find(&s.name.to_uppercase()).unwrap().name, s.name);
            let by_science = Species::find(&s.scientific_name).unwrap();
            let shared = s.name.starts_with("Douglas-fir") || s.name.starts_with("Redwood");
            let yang = s.name == "Cedar, eastern redcedar";
            assert!(
                by_science.name == s.name || shared || yang,
                "{}",
                s.scientific_name
            );
        }
        for (alias, target) in ALIASES {
            assert_eq!(Species::find(alias).unwrap().name, *target);
        }
        let name = |n| Species::find(n).map(|s| s.name.as_str());
        assert_eq!(name("red  Alder"), Ok("Alder, red"));
        assert_eq!(name("pignut hickory"), Ok("Hickory (true), pignut"));
        assert_eq!(name("yellow poplar"), Ok("Yellow-poplar"));
        assert_eq!(name("Pseudotsuga menziesii"), Ok("Douglas-fir, coast"));
        assert_eq!(name("Eastern redcedar"), Ok("Cedar, eastern redcedar"));
        for spruce in ["Picea abies", "Norway spruce", "Fichte", "ÉPICÉA"] {
            assert_eq!(name(spruce), Ok("Spruce, Norway"));
        }
        assert_eq!(name("weißtanne"), Ok("Fir, silver"));
    }

    #[test]
    fn a_misspelt_name_suggests_the_right_one() {
        let nearest = |n: &str| Species::find(n).unwrap_err().nearest;
        assert_eq!(nearest("sitka spurce")[0], "Spruce, Sitka");
        assert_eq!(nearest("Quercus albs")[0], "Oak, white");
        assert!(nearest("oak").iter().all(|n| n.starts_with("Oak")));
        assert!(nearest("xyzzy plugh").is_empty());
        let message = Species::find("whit ash").unwrap_err().to_string();
        assert!(message.starts_with("unknown species \"whit ash\"; did you mean \"Ash, white\""));
        let reordered = Species::find("red oak, northern").unwrap_err();
        assert_eq!(reordered.nearest[0], "Oak, northern red");
    }

    #[test]
    fn values_are_in_si_units() {
        let oak = Species::find("white oak").unwrap();
        assert_eq!(oak.dry.modulus_of_rupture, Some(105e6));
        assert_eq!(oak.dry.modulus_of_elasticity, Some(12.3e9));
        assert_eq!(oak.dry.work_to_maximum_load, Some(102e3));
        assert_eq!(oak.dry.impact_height, Some(940.0 * 1e-3));
        assert_eq!(oak.green.as_ref().unwrap().side_hardness, Some(4700.0));
        assert_eq!(oak.air_dry_density.map(f64::round), Some(762.0));
        assert_eq!(oak.shrinkage.tangential, Some(0.105));
    }
}
