//! Patterns of names: `*` stands for any letters, `?` for one; several stand between commas.

/// Patterns of which a name matches one.
#[derive(Debug, Clone)]
pub struct Patterns(Vec<Vec<char>>);

impl Patterns {
    /// Reads patterns.
    pub fn new(text: &str) -> Self {
        let each = text.split(',').map(str::trim).filter(|p| !p.is_empty());
        Patterns(each.map(|p| p.chars().collect()).collect())
    }

    /// Whether a name matches one of them, all of it.
    pub fn matches(&self, name: &str) -> bool {
        let name: Vec<char> = name.chars().collect();
        self.0.iter().any(|pattern| matches(pattern, &name))
    }
}

/// Whether a name matches a pattern. After the last star, whatever it has taken, the rest must match; so that going back to that
/// one star is enough, and the time is at most that of the product of the lengths.
fn matches(pattern: &[char], name: &[char]) -> bool {
    let (mut p, mut n) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == '?' || c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => match &mut star {
                Some((at, taken)) => {
                    *taken += 1;
                    (p, n) = (*at + 1, *taken);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By trying everything.
    fn slowly(pattern: &[char], name: &[char]) -> bool {
        match (pattern, name) {
            ([], name) => name.is_empty(),
            (['*', rest @ ..], name) => (0..=name.len()).any(|k| slowly(rest, &name[k..])),
            (['?', rest @ ..], [_, name @ ..]) => slowly(rest, name),
            ([c, rest @ ..], [d, name @ ..]) => c == d && slowly(rest, name),
            (_, []) => false,
        }
    }

    /// All words of up to `length` letters.
    fn words(letters: &str, length: usize) -> Vec<Vec<char>> {
        let mut words = vec![Vec::new()];
        let mut last = words.clone();
        for _ in 0..length {
            let longer = last.iter().flat_map(|word| {
                letters
                    .chars()
                    .map(move |c| [word.as_slice(), &[c]].concat())
            });
            last = longer.collect();
            words.extend(last.clone());
        }
        words
    }

    #[test]
    fn patterns_match_what_trying_everything_matches() {
        let names = words("ab", 5);
        let mut matched = 0;
        for pattern in words("ab*?", 5) {
            for name in &names {
                let expected = slowly(&pattern, name);
                assert_eq!(matches(&pattern, name), expected, "{pattern:?} {name:?}");
                matched += u32::from(expected);
            }
        }
        assert!(matched > 1000);
        let several = Patterns::new("Tree_*, Ökö?");
        assert!(
            ["Tree_017", "Tree_", "Ököl"]
                .iter()
                .all(|n| several.matches(n))
        );
        assert!(
            !["Tree", "a Tree_1", "Ökö", ""]
                .iter()
                .any(|n| several.matches(n))
        );
    }
}
