//! The reference page of scene files.

use super::keys::Scene;
use greenstick_schema::{Parameters, markdown_tables};
use std::fmt::Write;

impl Scene {
    /// Returns the keys of a scene as a page in Markdown.
    pub fn reference_markdown() -> String {
        let mut page = String::from(
            "# Keys of a scene\n\nLengths carry their unit, as in \"15 cm\"; one unit after the last of several numbers holds for \
             all of them. Keys with a dot stand in the table before it: `stem.length` is `length` in `[stem]`.\n",
        );
        page.push_str(&markdown_tables(&Scene::table(), "##"));
        add_lists(&mut page, &mut Scene::default(), "");
        page
    }
}

/// Adds the lists of tables in a set, and those in their entries. `path` is the name of the list that the set stands in.
fn add_lists(page: &mut String, set: &mut dyn Parameters, path: &str) {
    for list in set.lists() {
        let name = if path.is_empty() {
            list.key.to_owned()
        } else {
            format!("{path}.{}", list.key)
        };
        let Some(entry) = set.add_entry(list.key) else {
            continue;
        };
        let _ = write!(page, "\n## `[[{name}]]`\n\n{}\n", list.doc);
        page.push_str(&markdown_tables(&entry.list(), "###"));
        add_lists(page, entry, &name);
    }
}
