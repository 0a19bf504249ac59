//! Faults that `exceptions.txt` lets pass for now. The list may only shrink: a line that no fault needs any longer is a
//! fault itself.

use crate::workspace::Fault;
use std::collections::BTreeSet;

/// The file that lists them, relative to the root of the workspace.
pub const FILE: &str = "xtask/exceptions.txt";

/// What remains of some faults when those of the list have passed.
pub struct Remaining {
    /// Faults that are not on the list, and lines of the list that no fault needs.
    pub faults: Vec<Fault>,
    /// How many lines of the list were needed.
    pub passed: usize,
}

/// Takes away the faults that the list names. Blank lines of the list and lines that start with `#` are comments. A line
/// that names a circle of files also lets pass what is left of that circle.
pub fn pass(faults: Vec<Fault>, list: &str) -> Remaining {
    let lines = || {
        list.lines()
            .map(str::trim)
            .filter(|l| !(l.is_empty() || l.starts_with('#')))
    };
    let covers = |line: &str, exception: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut needed = exception.split_whitespace();
        needed.next() == words.first().copied() && needed.all(|w| words.contains(&w))
    };
    let mut needed = BTreeSet::new();
    let mut remaining = Vec::new();
    for fault in faults {
        let exception = fault.exception.as_deref();
        match exception.and_then(|e| lines().find(|line| covers(line, e))) {
            Some(line) => drop(needed.insert(line)),
            None => remaining.push(fault),
        }
    }
    for line in lines().filter(|l| !needed.contains(l)) {
        remaining.push(Fault::from(format!(
            "{FILE}: nothing needs `{line}` any longer; remove the line"
        )));
    }
    Remaining {
        faults: remaining,
        passed: needed.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_lets_its_faults_pass_and_may_only_shrink() {
        let fault = |message: &str, exception: Option<&str>| Fault {
            message: message.to_owned(),
            exception: exception.map(str::to_owned),
        };
        let faults = vec![
            fault("long", Some("function a.rs f")),
            fault("longer", Some("function a.rs g")),
            fault("crossing", None),
            fault("circle", Some("circle a.rs b.rs")),
            fault("other circle", Some("circle a.rs d.rs")),
        ];
        let list = "# comment\n\nfunction a.rs f\nfunction a.rs h\ncircle a.rs b.rs c.rs\n";
        let left = pass(faults, list);
        let messages: Vec<&str> = left.faults.iter().map(|f| f.message.as_str()).collect();
        assert_eq!(left.passed, 2);
        assert_eq!(messages[..3], ["longer", "crossing", "other circle"]);
        assert!(messages[3].contains("`function a.rs h`"), "{messages:?}");
        assert_eq!(messages.len(), 4);
    }
}
