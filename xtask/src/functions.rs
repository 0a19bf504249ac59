//! Lengths of functions, those of tests, benches and macros included.

use crate::lexer::{Kind, Token, tokens};
use crate::workspace::{Fault, Package, read, relative, rust_files};
use std::path::Path;

/// Most lines of a function. The lines from the one with `fn` to the one with the closing brace count, blank lines and
/// comments among them; documentation and attributes before the function do not. A function within a function counts
/// towards both.
const MAX_LINES: usize = 80;

/// Finds every function that is too long.
pub fn faults(packages: &[Package], root: &Path) -> Result<Vec<Fault>, String> {
    let mut faults = Vec::new();
    for package in packages {
        for file in rust_files(&package.folder)? {
            let path = relative(&file, root);
            for function in functions(&read(&file)?) {
                let Function { name, line, lines } = function;
                if lines > MAX_LINES {
                    faults.push(Fault {
                        message: format!(
                            "{path}:{line}: function {name} has {lines} lines; split what exceeds {MAX_LINES}"
                        ),
                        exception: Some(format!("function {path} {name}")),
                    });
                }
            }
        }
    }
    Ok(faults)
}

/// A function with a body.
#[derive(Debug, PartialEq)]
struct Function {
    name: String,
    /// Line of its `fn`.
    line: usize,
    /// Lines from there to its closing brace.
    lines: usize,
}

/// All functions with a body in some source text, in the order in which they start.
fn functions(source: &str) -> Vec<Function> {
    let tokens = tokens(source);
    let mut found = Vec::new();
    for (i, pair) in tokens.windows(2).enumerate() {
        // `fn(` is the type of a function, `fn $name` stands for many functions in a macro.
        if pair[0].is("fn")
            && pair[1].kind == Kind::Word
            && let Some(end) = end_of_body(&tokens[i..])
        {
            found.push(Function {
                name: pair[1].text.to_owned(),
                line: pair[0].line,
                lines: end + 1 - pair[0].line,
            });
        }
    }
    found
}

/// The line with the closing brace of the function that starts with the first token; none where it has no body.
fn end_of_body(tokens: &[Token]) -> Option<usize> {
    let mut brackets = 0;
    let mut braces = 0;
    for token in tokens.iter().filter(|t| t.kind == Kind::Punctuation) {
        match token.text {
            "(" | "[" => brackets += 1,
            ")" | "]" => brackets -= 1,
            ";" if brackets == 0 && braces == 0 => return None,
            "{" => braces += 1,
            "}" => {
                braces -= 1;
                if braces == 0 {
                    return Some(token.line);
                }
            }
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::TestFolder;

    #[test]
    fn functions_are_measured_from_signature_to_brace() {
        let source = concat!(
            "/// Doc.\n#[inline]\npub fn one(a: [u8; 3],\n    b: fn(u8) -> u8)\nwhere\n{\n    \"}\"\n}\n",
            "trait T {\n    fn none(&self) -> [u8; 2];\n",
            "    fn outer() {\n        fn inner() {}\n        let _ = || {};\n    }\n}\n"
        );
        let found: Vec<(String, usize, usize)> = functions(source)
            .into_iter()
            .map(|f| (f.name, f.line, f.lines))
            .collect();
        let expected = [("one", 3, 6), ("outer", 11, 4), ("inner", 12, 1)];
        assert_eq!(found, expected.map(|(n, at, l)| (n.to_owned(), at, l)));
    }

    #[test]
    fn a_function_over_the_limit_is_reported() {
        let body = |lines: usize| format!("fn f() {{\n{}}}\n", "    g();\n".repeat(lines - 2));
        let folder = TestFolder::new(
            "functions",
            &[
                ("src/lib.rs", &body(MAX_LINES)),
                ("benches/b.rs", &body(MAX_LINES + 1)),
            ],
        );
        let package = folder.package("src/lib.rs");
        let found = faults(&[package], &folder.0).unwrap();
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(
            found[0].message,
            "benches/b.rs:1: function f has 81 lines; split what exceeds 80"
        );
        assert_eq!(
            found[0].exception.as_deref(),
            Some("function benches/b.rs f")
        );
    }
}
