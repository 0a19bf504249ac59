//! Reference pages in Markdown.

use crate::{Kind, ParameterInfo};
use std::fmt::Write;

/// Parameters as tables in Markdown, one for each heading that they are listed under; `level` is that of the headings,
/// such as "###".
pub fn markdown_tables(list: &[ParameterInfo], level: &str) -> String {
    let mut page = String::new();
    let mut groups: Vec<&str> = Vec::new();
    for p in list {
        if !groups.contains(&p.group.as_str()) {
            groups.push(&p.group);
        }
    }
    let in_groups = groups
        .iter()
        .flat_map(|group| list.iter().filter(move |p| p.group == *group));
    let mut group = None;
    for p in in_groups {
        if group != Some(&p.group) {
            group = Some(&p.group);
            let _ = write!(
                page,
                "\n{level} {}\n\n| key | symbol | unit | range | default | what it does |\n|---|---|---|---|---|---|\n",
                p.group
            );
        }
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} | {} | {} |",
            p.key,
            p.symbol,
            p.unit(),
            range(p),
            p.default,
            p.doc.replace('|', "\\|")
        );
    }
    page
}

/// A parameter's range as a cell of a table.
fn range(p: &ParameterInfo) -> String {
    let mut cell = match p.kind {
        Kind::Number { min, max, .. } => match (min.is_finite(), max.is_finite()) {
            (false, false) => String::new(),
            _ => format!("{min} … {max}"),
        },
        Kind::Integer { min, max, .. } => format!("{min} … {max}, whole"),
        Kind::Choice { .. } | Kind::Flag | Kind::List { .. } => p.kind.range(),
        Kind::Text { format } => format.name.to_lowercase(),
    };
    let words = p.words.iter().map(|w| w.0).chain(p.auto.then_some("auto"));
    for word in words {
        cell.push_str(" or ");
        cell.push_str(word);
    }
    cell
}
