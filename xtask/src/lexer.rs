//! Tokens of Rust source text, as far as the checks of the workspace need them: comments and white space are dropped,
//! and every token knows its line. It reads what the compiler has accepted and does not look for errors.

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A name or a keyword; of a raw name the part after `r#`.
    Word,
    /// One character of punctuation, or the pair `::`.
    Punctuation,
    /// A string, a character, a number or a lifetime.
    Literal,
}

/// A token and where it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Token<'a> {
    pub kind: Kind,
    pub text: &'a str,
    /// Line, counted from 1.
    pub line: usize,
}

impl Token<'_> {
    /// Whether the token is this word or this punctuation.
    pub fn is(&self, text: &str) -> bool {
        self.kind != Kind::Literal && self.text == text
    }
}

/// Splits source text into tokens.
pub fn tokens(source: &str) -> Vec<Token<'_>> {
    let mut lexer = Lexer {
        source,
        at: 0,
        line: 1,
    };
    let mut tokens = Vec::new();
    while let Some((kind, start, line)) = lexer.next() {
        let text = &source[start..lexer.at];
        let text = match kind {
            Kind::Word => text.strip_prefix("r#").unwrap_or(text),
            _ => text,
        };
        tokens.push(Token { kind, text, line });
    }
    tokens
}

struct Lexer<'a> {
    source: &'a str,
    at: usize,
    line: usize,
}

impl Lexer<'_> {
    fn rest(&self) -> &str {
        &self.source[self.at..]
    }

    fn skip(&mut self, bytes: usize) {
        let end = (self.at + bytes).min(self.source.len());
        self.line += self.source[self.at..end].matches('\n').count();
        self.at = end;
    }

    /// Skips characters for as long as `wanted` holds.
    fn skip_while(&mut self, wanted: impl Fn(char) -> bool) {
        let rest = self.rest();
        let length = rest.find(|c| !wanted(c)).unwrap_or(rest.len());
        self.skip(length);
    }

    /// The next token: its kind, where it starts, and its line. It ends where the lexer then stands.
    fn next(&mut self) -> Option<(Kind, usize, usize)> {
        loop {
            self.skip_while(char::is_whitespace);
            if self.rest().starts_with("//") {
                self.skip_while(|c| c != '\n');
            } else if self.rest().starts_with("/*") {
                self.skip_block_comment();
            } else {
                break;
            }
        }
        let (start, line) = (self.at, self.line);
        let first = self.rest().chars().next()?;
        let kind = if let Some(hashes) = self.string_start() {
            self.skip_string(hashes);
            Kind::Literal
        } else if first.is_alphabetic() || first == '_' {
            if self.rest().starts_with("r#") {
                self.skip(2);
            }
            self.skip_while(is_word);
            Kind::Word
        } else if first.is_ascii_digit() {
            self.skip_while(is_word);
            Kind::Literal
        } else if first == '\'' {
            self.skip_quote();
            Kind::Literal
        } else {
            let double = self.rest().starts_with("::");
            self.skip(if double { 2 } else { first.len_utf8() });
            Kind::Punctuation
        };
        Some((kind, start, line))
    }

    /// Skips a block comment, those nested in it included.
    fn skip_block_comment(&mut self) {
        let mut depth = 0;
        loop {
            let rest = self.rest();
            match (rest.find("/*"), rest.find("*/")) {
                (Some(open), Some(close)) if open < close => {
                    depth += 1;
                    self.skip(open + 2);
                }
                (_, Some(close)) => {
                    depth -= 1;
                    self.skip(close + 2);
                }
                _ => self.skip(rest.len()),
            }
            if depth == 0 || self.rest().is_empty() {
                return;
            }
        }
    }

    /// Where a string starts here: `Some(None)` for one with escapes, and the number of `#` of a raw one.
    fn string_start(&self) -> Option<Option<usize>> {
        let prefix = self.rest().trim_start_matches(['b', 'c']);
        if self.rest().len() - prefix.len() > 1 {
            return None;
        }
        if prefix.starts_with('"') {
            return Some(None);
        }
        let hashes = prefix.strip_prefix('r')?;
        let rest = hashes.trim_start_matches('#');
        rest.starts_with('"')
            .then_some(Some(hashes.len() - rest.len()))
    }

    fn skip_string(&mut self, hashes: Option<usize>) {
        let open = self.rest().find('"').unwrap_or(0);
        self.skip(open + 1);
        if let Some(hashes) = hashes {
            let end = format!("\"{}", "#".repeat(hashes));
            let length = self.rest().find(&end).unwrap_or(self.rest().len());
            self.skip(length + end.len());
            return;
        }
        loop {
            self.skip_while(|c| c != '"' && c != '\\');
            let escaped = self.rest().starts_with('\\');
            self.skip(if escaped { 2 } else { 1 });
            if !escaped {
                return;
            }
        }
    }

    /// Skips a character or a lifetime.
    fn skip_quote(&mut self) {
        self.skip(1);
        let mut next = self.rest().chars();
        match (next.next(), next.next()) {
            (Some('\\'), _) => {
                self.skip(2);
                self.skip_while(|c| c != '\'');
                self.skip(1);
            }
            (Some(c), Some('\'')) => self.skip(c.len_utf8() + 1),
            _ => self.skip_while(is_word),
        }
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braces_in_strings_characters_and_comments_are_no_tokens() {
        let source = concat!(
            "fn a<'b>(c: &'b str) { // }\n",
            "    /* { /* { */ } */ let d = ['{', '\\'', '\\u{7d}', b'}'];\n",
            "    (\"}\\\"}\", r#\"}\"}\"#, br\"{\", 1.5e3, r#type::f)\n",
            "}\n"
        );
        let found = tokens(source);
        let braces: Vec<(&str, usize)> = found
            .iter()
            .filter(|t| t.is("{") || t.is("}"))
            .map(|t| (t.text, t.line))
            .collect();
        assert_eq!(braces, [("{", 1), ("}", 4)]);
        let words: Vec<&str> = found
            .iter()
            .filter(|t| t.kind == Kind::Word)
            .map(|t| t.text)
            .collect();
        assert_eq!(words, ["fn", "a", "c", "str", "let", "d", "b", "type", "f"]);
    }
}
