//! What the modules of a crate import, read from its sources.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::str::FromStr;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// What each one imports, with an example of where.
pub type Graph = BTreeMap<String, BTreeMap<String, String>>;

/// Names from the root of a crate; of a module or of something in one.
type Names = Vec<String>;

/// Names with spaces between them.
pub fn names(text: &str) -> Names {
    text.split_whitespace().map(ToOwned::to_owned).collect()
}

/// A module as its file has it, without its tests.
#[derive(Debug, Default)]
struct Module {
    children: BTreeSet<String>,
    macros: BTreeSet<String>,
    /// As written, from `crate`, `super` or `self`, or in a `use`.
    paths: Vec<Names>,
    /// What it imports, by the names that this has in it.
    imports: BTreeMap<String, Names>,
}

/// The modules of a crate.
#[derive(Debug, Default)]
pub struct Modules(BTreeMap<Names, Module>);

impl Modules {
    /// - `folder`: where the files of the module's children are.
    pub fn read(&mut self, at: &Names, file: &Path, folder: &Path) {
        let source = fs::read_to_string(file).unwrap();
        self.add(at, TokenStream::from_str(&source).unwrap());
        for child in self.0[at].children.clone() {
            let (inside, beside) = (folder.join(&child), folder.join(format!("{child}.rs")));
            let file = if beside.exists() { beside } else { inside.join("mod.rs") };
            let at = [&at[..], &[child]].concat();
            if !self.0.contains_key(&at) {
                self.read(&at, &file, &inside);
            }
        }
    }

    fn add(&mut self, at: &Names, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut module = self.0.remove(at).unwrap_or_default();
        let (mut k, mut inline) = (0, Vec::new());
        while k < tokens.len() {
            match &tokens[k] {
                _ if is_left_out(&tokens[k..]) => k += item_len(&tokens[k..]),
                token if is_word(token, "use") => {
                    let (paths, len) = paths(&tokens[k + 1..]);
                    for (path, name) in paths {
                        module.imports.insert(name, path.clone());
                        module.paths.push(path);
                    }
                    k += 1 + len;
                }
                token if is_word(token, "mod") => {
                    let child = tokens[k + 1].to_string();
                    if let Some(body) = braces(&tokens[k + 2]) {
                        inline.push(([&at[..], std::slice::from_ref(&child)].concat(), body));
                    }
                    module.children.insert(child);
                    k += 3;
                }
                token if is_word(token, "macro_rules") => {
                    module.macros.insert(tokens[k + 2].to_string());
                    k += 3;
                }
                token if ["crate", "super", "self"].iter().any(|start| is_word(token, start)) => {
                    let (paths, len) = paths(&tokens[k..]);
                    module.paths.extend(paths.into_iter().map(|(path, _)| path));
                    k += len;
                }
                TokenTree::Group(group) => {
                    self.0.insert(at.clone(), module);
                    self.add(at, group.stream());
                    module = self.0.remove(at).unwrap_or_default();
                    k += 1;
                }
                _ => k += 1,
            }
        }
        self.0.insert(at.clone(), module);
        inline.into_iter().for_each(|(at, body)| self.add(&at, body));
    }

    /// The module that defines what a path of the module `at` leads to; `None` in another crate.
    fn definer(&self, at: &Names, path: &[String], depth: usize) -> Option<Names> {
        let module = &self.0[at];
        let Some((first, rest)) = path.split_first().filter(|_| depth < 30) else {
            return Some(at.clone());
        };
        match first.as_str() {
            "crate" => return self.inside(&Vec::new(), rest, depth),
            "self" => return self.inside(at, rest, depth),
            "super" => return self.inside(&at[..at.len() - 1].to_vec(), rest, depth),
            _ => {}
        }
        if module.children.contains(first) {
            return self.inside(&[&at[..], std::slice::from_ref(first)].concat(), rest, depth);
        }
        let import = module.imports.get(first).filter(|import| import[..] != *path)?;
        self.definer(at, &[&import[..], rest].concat(), depth + 1)
    }

    /// As [`Self::definer`], of a path that starts in the module.
    fn inside(&self, at: &Names, path: &[String], depth: usize) -> Option<Names> {
        if path.first().is_some_and(|first| first == "super") {
            return self.definer(at, path, depth);
        }
        let found = self.definer(at, path, depth);
        let is_root_macro = |module: &Module| path.len() == 1 && module.macros.contains(&path[0]);
        let of_macro = || self.0.iter().find(|(_, module)| is_root_macro(module));
        match found {
            None if at.is_empty() => of_macro().map(|(at, _)| at.clone()),
            None => Some(at.clone()),
            found => found,
        }
    }

    /// What imports what among the children of each module. What a module and its own children have of
    /// each other does not count.
    pub fn graphs(&self) -> BTreeMap<Names, Graph> {
        let mut graphs: BTreeMap<Names, Graph> = BTreeMap::new();
        for at in self.0.keys().filter(|at| !at.is_empty()) {
            let (own, parent) = at.split_last().unwrap();
            graphs.entry(parent.to_vec()).or_default().entry(own.clone()).or_default();
        }
        for (at, module) in &self.0 {
            for path in &module.paths {
                let Some(to) = self.definer(at, path, 0) else {
                    assert!(path[0] != "crate", "{path:?} of {at:?} is nowhere");
                    continue;
                };
                let common = at.iter().zip(&to).take_while(|(a, b)| a == b).count();
                let (Some(from), Some(import)) = (at.get(common), to.get(common)) else { continue };
                let graph = graphs.get_mut(&at[..common]).unwrap();
                let example = format!("{} of {}", path.join("::"), at.join("::"));
                graph.get_mut(from).unwrap().insert(import.clone(), example);
            }
        }
        graphs
    }
}

/// Whether what follows is only in tests or in the documentation.
fn is_left_out(tokens: &[TokenTree]) -> bool {
    let [TokenTree::Punct(hash), TokenTree::Group(attribute), ..] = tokens else { return false };
    let text = attribute.stream().to_string().replace(' ', "");
    let starts = ["cfg(test)", "cfg(doc)", "cfg(all(test,"];
    hash.as_char() == '#' && starts.iter().any(|start| text.starts_with(start))
}

/// Number of tokens of an item with attributes: to its semicolon, or to its body in braces.
fn item_len(tokens: &[TokenTree]) -> usize {
    let items = ["use", "mod", "fn", "impl", "struct", "enum", "const", "static", "type"];
    let is_item = |token: &TokenTree| items.iter().any(|word| is_word(token, word));
    let kind = tokens.iter().position(is_item).expect("an item follows");
    let ends_by_body = !is_word(&tokens[kind], "use");
    let is_end =
        |token: &TokenTree| is_punct(token, ';') || ends_by_body && braces(token).is_some();
    kind + 1 + tokens[kind..].iter().position(is_end).expect("items end")
}

fn is_word(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(found) if found == word)
}

fn is_punct(token: &TokenTree, punct: char) -> bool {
    matches!(token, TokenTree::Punct(found) if found.as_char() == punct)
}

/// What is in braces.
fn braces(token: &TokenTree) -> Option<TokenStream> {
    match token {
        TokenTree::Group(group) => (group.delimiter() == Delimiter::Brace).then(|| group.stream()),
        _ => None,
    }
}

/// The paths of a tree such as `crate::a::{b, c as d}` with the names that they import, and how many
/// tokens it has.
fn paths(tokens: &[TokenTree]) -> (Vec<(Names, String)>, usize) {
    let mut path: Names = Vec::new();
    let mut k = 0;
    while let Some(token) = tokens.get(k) {
        if let Some(parts) = braces(token) {
            return (in_braces(&path, parts), k + 1);
        }
        let TokenTree::Ident(word) = token else { break };
        path.push(word.to_string());
        k += 1;
        if !matches!(&tokens[k..], [a, b, ..] if is_punct(a, ':') && is_punct(b, ':')) {
            break;
        }
        k += 2;
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if let [word, alias, ..] = &tokens[k..]
        && is_word(word, "as")
    {
        name = alias.to_string();
        k += 2;
    }
    (vec![(path, name)], k)
}

/// As [`paths`], of the part in braces after a path.
fn in_braces(path: &[String], parts: TokenStream) -> Vec<(Names, String)> {
    let parts: Vec<TokenTree> = parts.into_iter().collect();
    let parts = parts.split(|token| is_punct(token, ',')).filter(|part| !part.is_empty());
    let joined = |(rest, name): (Names, String)| {
        let rest = if rest[..] == ["self"] { &rest[1..] } else { &rest[..] };
        let joined = [path, rest].concat();
        let name = if name == "self" { joined.last().unwrap().clone() } else { name };
        (joined, name)
    };
    parts.flat_map(|part| paths(part).0).map(joined).collect()
}

#[test]
fn imports_are_read_from_sources() {
    let mut modules = Modules::default();
    let mut add = |at: &str, source: &str| {
        modules.add(&names(at), TokenStream::from_str(source).unwrap());
    };
    add("", "mod high; mod low; mod middle; mod tool; pub use low::{Thing as Object, other};");
    add(
        "high",
        r#"
        mod part;
        mod rest;
        use std::fmt::{self, Debug};
        use crate::{Object, middle::*};
        fn text() -> &'static str { "crate::tool" } // crate::tool
        #[cfg(test)]
        mod tests { use crate::tool; }
        #[cfg(doc)]
        use crate::tool::{self, Doc};
        "#,
    );
    add("high part", "fn f() { super::rest::go(crate::name!()) }");
    add("high rest", "use super::super::low;");
    add("middle", "mod deep { pub fn g() -> super::super::low::Thing { loop {} } }");
    add("low", "pub struct Thing; macro_rules! name { () => {} }");
    add("tool", "");
    let graphs = modules.graphs();
    let imports =
        |at: &str, name: &str| -> Names { graphs[&names(at)][name].keys().cloned().collect() };
    assert_eq!(imports("", "high"), ["low", "middle"]);
    assert_eq!(imports("", "middle"), ["low"]);
    assert_eq!(imports("", "low"), [""; 0]);
    assert_eq!(imports("high", "part"), ["rest"]);
    assert_eq!(imports("high", "rest"), [""; 0]);
}
