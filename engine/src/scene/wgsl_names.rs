//! The names in a WGSL text, without understanding it: which it declares for the whole module, and which it uses.

use std::collections::HashSet;

/// A name or one character of punctuation, and the byte where it begins.
type Lexeme<'a> = (usize, &'a str);

/// The names and punctuation of `text`, comments and spaces left out.
fn lexemes(text: &str) -> Vec<Lexeme<'_>> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut lexemes = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else {
            let length = rest.find(|c| !is_name(c)).unwrap_or(rest.len()).max(c.len_utf8());
            if !c.is_whitespace() {
                lexemes.push((at, &rest[..length]));
            }
            length
        };
        at += length;
    }
    lexemes
}

/// The length of the comment that `text` begins with; such comments nest.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let rest = &text.as_bytes()[at..];
        let mark = [&b"/*"[..], b"*/"].iter().position(|mark| rest.starts_with(mark));
        match mark {
            Some(0) => depth += 1,
            Some(_) => depth -= 1,
            None => {}
        }
        at += if mark.is_some() { 2 } else { 1 };
        if depth == 0 {
            break;
        }
    }
    at
}

/// Every name and keyword in `text`.
pub(super) fn names(text: &str) -> HashSet<&str> {
    lexemes(text).into_iter().map(|(_, name)| name).collect()
}

/// What `text` declares outside of any braces: (the byte where the name begins, what it is declared as, the name).
pub(super) fn declared(text: &str) -> Vec<(usize, &str, &str)> {
    let mut found = Vec::new();
    let mut depth = 0_usize;
    let lexemes = lexemes(text);
    for (index, (_, lexeme)) in lexemes.iter().enumerate() {
        match *lexeme {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "fn" | "struct" | "alias" | "const" | "var" | "override" if depth == 0 => {
                let mut after = &lexemes[index + 1..];
                if let Some((_, "<")) = after.first() {
                    let end = after.iter().position(|(_, end)| *end == ">").map_or(after.len(), |i| i + 1);
                    after = &after[end..];
                }
                found.extend(after.first().map(|(at, name)| (*at, *lexeme, *name)));
            }
            _ => {}
        }
    }
    found
}

/// Where `text` uses `name`, comments left out.
pub(super) fn place_of(text: &str, name: &str) -> Option<usize> {
    lexemes(text).into_iter().find(|(_, found)| *found == name).map(|(at, _)| at)
}

/// Where `text` first nests brackets deeper than `depth`, or has more than `length` names and signs in one statement, or
/// more than `depth` `else`s in one function. Compilers recurse that deep.
pub(super) fn too_nested(text: &str, depth: usize, length: usize) -> Option<usize> {
    let (mut open, mut since, mut branches) = (0_usize, 0, 0);
    for (at, lexeme) in lexemes(text) {
        since += 1;
        match lexeme {
            "(" | "[" => open += 1,
            ")" | "]" => open = open.saturating_sub(1),
            "{" => (open, since) = (open + 1, 0),
            "}" => (open, since) = (open.saturating_sub(1), 0),
            ";" => since = 0,
            "else" => branches += 1,
            "fn" => branches = 0,
            _ => {}
        }
        if open > depth || since > length || branches > depth {
            return Some(at);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_are_found_at_module_scope_only() {
        let text = "const a = 1.0; /* fn /* nested */ no() */ // struct no\nvar<private> b: f32;\n\
                    fn c(x: f32) -> f32 { const no = 2.0; var d = x; return d; }\nstruct e { f: f32 }\nalias é = f32;";
        let names: Vec<_> = declared(text)
            .into_iter()
            .map(|(at, kind, name)| (&text[at..at + name.len()], kind, name))
            .collect();
        assert_eq!(
            names[..4],
            [("a", "const", "a"), ("b", "var", "b"), ("c", "fn", "c"), ("e", "struct", "e")]
        );
        assert_eq!(names[4].2, "é");
        assert_eq!(names.len(), 5);
        assert!(!super::names(text).contains("nested"));
    }

    #[test]
    fn texts_cut_anywhere_are_read_to_their_end() {
        let text = "/* a /* b */ é */ fn f() { // c\n } } var<private é";
        for end in (0..=text.len()).filter(|end| text.is_char_boundary(*end)) {
            declared(&text[..end]);
        }
    }
}
