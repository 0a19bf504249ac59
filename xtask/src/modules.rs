//! The modules of a crate: what each defines, what it imports, and what it names.

use crate::lexer::{Kind, Token, tokens};
use crate::workspace::read;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{self, PathBuf};

/// A path as it is written, such as `crate`, `film`, `Sink`.
pub type Path = Vec<String>;

/// Something that `use` brings into a module.
pub struct Import {
    /// Its path; of a glob import that of the module whose names it takes.
    pub path: Path,
    /// The name that it has here; none for a glob import.
    pub name: Option<String>,
    /// Whether it is handed on by `pub use` or `pub(crate) use`.
    pub is_public: bool,
}

/// A module, in a file of its own or within another.
#[derive(Default)]
pub struct Module {
    /// Index of the file that holds it.
    pub file: usize,
    /// What it imports, in functions too.
    pub imports: Vec<Import>,
    /// Paths that its code names, single words included.
    pub paths: BTreeSet<Path>,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    items: BTreeSet<String>,
}

/// Where something is defined, and under which name.
pub struct Definition {
    pub file: usize,
    pub name: String,
}

/// A crate's modules and files; the first module is the root.
#[derive(Default)]
pub struct Crate {
    pub files: Vec<PathBuf>,
    pub modules: Vec<Module>,
}

/// Words that start an item whose name follows.
const ITEM_WORDS: [&str; 8] = [
    "fn", "struct", "enum", "union", "trait", "type", "const", "static",
];

impl Crate {
    /// Reads a crate from its root file.
    pub fn read(root: &path::Path) -> Result<Crate, String> {
        let mut tree = Crate::default();
        let folder = root.parent().unwrap_or(path::Path::new(""));
        tree.read_file(root, folder, None)?;
        Ok(tree)
    }

    /// Reads a module from its file; `folder` is where the files of its children lie.
    fn read_file(
        &mut self,
        file: &path::Path,
        folder: &path::Path,
        parent: Option<usize>,
    ) -> Result<usize, String> {
        let source = read(file)?;
        self.files.push(file.to_owned());
        let number = self.add_module(self.files.len() - 1, parent);
        self.read_tokens(&tokens(&source), number, folder)?;
        Ok(number)
    }

    fn add_module(&mut self, file: usize, parent: Option<usize>) -> usize {
        self.modules.push(Module {
            file,
            parent,
            ..Module::default()
        });
        self.modules.len() - 1
    }

    /// Reads what stands in a module.
    fn read_tokens(
        &mut self,
        tokens: &[Token],
        module: usize,
        folder: &path::Path,
    ) -> Result<(), String> {
        let word = |i: usize| tokens.get(i).filter(|t| t.kind == Kind::Word);
        let is = |i: usize, text: &str| tokens.get(i).is_some_and(|t| t.is(text));
        let mut depth = 0;
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            if token.is("{") {
                depth += 1;
            } else if token.is("}") {
                depth -= 1;
            } else if token.is("mod") && word(at + 1).is_some() {
                let name = tokens[at + 1].text;
                let inner = folder.join(name);
                let child = if is(at + 2, "{") {
                    let end = closing(tokens, at + 2);
                    let child = self.add_module(self.modules[module].file, Some(module));
                    self.read_tokens(&tokens[at + 3..end], child, &inner)?;
                    at = end;
                    child
                } else {
                    at += 2;
                    let (file, folder) = match given_path(&tokens[..at - 2]) {
                        Some(given) => beside(&self.files[self.modules[module].file], given),
                        None => {
                            let alone = folder.join(format!("{name}.rs"));
                            let with_children = inner.join("mod.rs");
                            (if alone.exists() { alone } else { with_children }, inner)
                        }
                    };
                    self.read_file(&file, &folder, Some(module))?
                };
                self.modules[module].children.insert(name.to_owned(), child);
            } else if token.is("use") {
                let end = (at..tokens.len())
                    .find(|&i| tokens[i].is(";"))
                    .unwrap_or(tokens.len());
                let is_public = at > 0 && (tokens[at - 1].is("pub") || tokens[at - 1].is(")"));
                let tree = &mut tokens[at + 1..end].iter().copied().peekable();
                read_use(tree, &[], is_public, &mut self.modules[module].imports);
                at = end;
            } else if depth == 0 && token.is("macro_rules") {
                let name = word(at + 2).map(|t| t.text.to_owned());
                self.modules[module].items.extend(name);
                at += 2;
            } else if ITEM_WORDS.contains(&token.text) && word(at + 1).is_some() {
                if depth == 0 {
                    let name = tokens[at + 1].text.to_owned();
                    self.modules[module].items.insert(name);
                }
                at += usize::from(!is(at + 1, "fn"));
            } else if token.kind == Kind::Word && !(at > 0 && is(at - 1, ".")) {
                let mut path = vec![token.text.to_owned()];
                while is(at + 1, "::") && word(at + 2).is_some() {
                    path.push(tokens[at + 2].text.to_owned());
                    at += 2;
                }
                self.modules[module].paths.insert(path);
            }
            at += 1;
        }
        Ok(())
    }

    /// The file that defines what a path in a module stands for; none where that is a module or not of this crate.
    pub fn resolve(&self, module: usize, path: &Path) -> Option<Definition> {
        match self.walk(module, path, &mut BTreeSet::new())? {
            Target::Item(definition) => Some(definition),
            Target::Module(_) => None,
        }
    }

    fn walk(
        &self,
        module: usize,
        path: &[String],
        visited: &mut BTreeSet<(usize, String)>,
    ) -> Option<Target> {
        let mut module = module;
        for (i, name) in path.iter().enumerate() {
            let target = match name.as_str() {
                "crate" => Target::Module(0),
                "self" => Target::Module(module),
                "super" => Target::Module(self.modules[module].parent?),
                _ => self.look_up(module, name, visited)?,
            };
            match target {
                Target::Module(next) => module = next,
                // What follows are variants, constants and functions of a type.
                Target::Item(_) => return Some(target),
            }
            if i + 1 == path.len() {
                return Some(Target::Module(module));
            }
        }
        None
    }

    /// What a name stands for in a module.
    fn look_up(
        &self,
        module: usize,
        name: &str,
        visited: &mut BTreeSet<(usize, String)>,
    ) -> Option<Target> {
        // Imports may lead back to where they start.
        if !visited.insert((module, name.to_owned())) {
            return None;
        }
        let here = &self.modules[module];
        if let Some(&child) = here.children.get(name) {
            return Some(Target::Module(child));
        }
        if here.items.contains(name) {
            return Some(Target::Item(Definition {
                file: here.file,
                name: name.to_owned(),
            }));
        }
        let named = |i: &&Import| i.name.as_deref() == Some(name);
        if let Some(import) = here.imports.iter().find(named) {
            return self.walk(module, &import.path, visited);
        }
        let mut globs = here.imports.iter().filter(|i| i.name.is_none());
        globs.find_map(|glob| {
            let path = [&glob.path[..], &[name.to_owned()]].concat();
            self.walk(module, &path, visited)
        })
    }
}

enum Target {
    Module(usize),
    Item(Definition),
}

/// Index of the brace that closes the one at `open`.
fn closing(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        depth += i32::from(token.is("{")) - i32::from(token.is("}"));
        if depth == 0 {
            return i;
        }
    }
    tokens.len()
}

/// The file that an attribute `#[path = "…"]` names at the end of some tokens, or before a last `pub`.
fn given_path<'a>(tokens: &[Token<'a>]) -> Option<&'a str> {
    let tokens = match tokens {
        [before @ .., last] if last.is("pub") => before,
        _ => tokens,
    };
    let [.., path, equals, file, bracket] = tokens else {
        return None;
    };
    let is_path = path.is("path") && equals.is("=") && bracket.is("]");
    is_path.then(|| file.text.trim_matches('"'))
}

/// A file given relative to another, and its folder, where its children lie.
fn beside(file: &path::Path, given: &str) -> (PathBuf, PathBuf) {
    let given = file.with_file_name(given);
    let folder = given.parent().map(PathBuf::from).unwrap_or_default();
    (given, folder)
}

/// Reads one tree of a `use`, up to the comma or the brace behind it.
fn read_use<'a>(
    tokens: &mut std::iter::Peekable<impl Iterator<Item = Token<'a>>>,
    before: &[String],
    is_public: bool,
    imports: &mut Vec<Import>,
) {
    let mut path = before.to_vec();
    let mut name = None;
    while let Some(token) = tokens.next() {
        if token.is("{") {
            while tokens.peek().is_some_and(|t| !t.is("}")) {
                read_use(tokens, &path, is_public, imports);
                tokens.next_if(|t| t.is(","));
            }
            tokens.next();
            return;
        } else if token.is("*") {
            imports.push(Import {
                path,
                name: None,
                is_public,
            });
            return;
        } else if token.is("as") {
            name = tokens.next().map(|t| t.text.to_owned());
        } else if token.kind == Kind::Word && (!token.is("self") || path.is_empty()) {
            path.push(token.text.to_owned());
        }
        if tokens.peek().is_none_or(|t| t.is(",") || t.is("}")) {
            break;
        }
    }
    let name = name.or_else(|| path.last().cloned());
    imports.push(Import {
        path,
        name,
        is_public,
    });
}
