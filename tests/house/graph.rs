//! Import graph by file: from `use` and from paths within the code, without tests.
//!
//! A re-exported name (`pub use`) counts for its importers as the name of the file that defines it. The
//! re-export itself also counts as an import.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use super::sources::{File, Sources, attributes, is_test};

/// Maximum length of a chain of re-exports.
const PASSED_ON: usize = 8;

/// The files and their imports.
pub struct Graph<'a> {
    files: &'a [File],
    /// From importing to imported file, with the line of the first import.
    arrows: BTreeMap<usize, BTreeMap<usize, usize>>,
}

impl<'a> Graph<'a> {
    pub fn new(sources: &'a Sources) -> Self {
        let files = &sources.files[..];
        let index = Index::new(sources);
        let mut arrows: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
        for (from, file) in files.iter().enumerate() {
            let mut collector = Collector {
                name: &sources.name,
                module: file.module.clone(),
                paths: Vec::new(),
            };
            collector.visit_file(&file.syntax);
            for (path, line) in collector.paths {
                if let Some(to) = index.resolve(&path, PASSED_ON)
                    && to != from
                {
                    arrows.entry(from).or_default().entry(to).or_insert(line);
                }
            }
        }
        Self { files, arrows }
    }

    fn tell(&self, from: usize, to: usize) -> String {
        let line = self.arrows[&from][&to];
        let (from, to) = (&self.files[from].path, &self.files[to].path);
        format!("{from}:{line} imports {to}")
    }

    /// Returns for every file that imports itself through the files that `within` selects a shortest
    /// cycle; each cycle is reported once.
    pub fn circles(&self, within: impl Fn(&File) -> bool) -> Vec<String> {
        let mut reported = BTreeSet::new();
        let mut circles = Vec::new();
        for start in (0..self.files.len()).filter(|k| within(&self.files[*k])) {
            let Some(circle) = self.circle(start, &within) else {
                continue;
            };
            let members: BTreeSet<usize> = circle.iter().copied().collect();
            if reported.insert(members) {
                let ends = circle.iter().skip(1).chain(circle.first());
                let arrows = circle.iter().zip(ends).map(|(a, b)| self.tell(*a, *b));
                circles.push(format!("circle: {}", arrows.collect::<Vec<_>>().join(", ")));
            }
        }
        circles
    }

    /// Returns a shortest path from `start` back to it.
    fn circle(&self, start: usize, within: &impl Fn(&File) -> bool) -> Option<Vec<usize>> {
        let mut before: BTreeMap<usize, usize> = BTreeMap::new();
        let mut queue = VecDeque::from([start]);
        while let Some(at) = queue.pop_front() {
            for &to in self.arrows.get(&at).into_iter().flat_map(BTreeMap::keys) {
                if to == start {
                    let mut way = vec![at];
                    while way[way.len() - 1] != start {
                        way.push(before[&way[way.len() - 1]]);
                    }
                    way.reverse();
                    return Some(way);
                }
                if within(&self.files[to]) && !before.contains_key(&to) {
                    before.insert(to, at);
                    queue.push_back(to);
                }
            }
        }
        None
    }

    /// Returns the imports from a folder of `way` into a later one.
    pub fn arrows_back(&self, way: &[&str]) -> Vec<String> {
        let place = |file: usize| way.iter().position(|folder| self.files[file].is_in(folder));
        let arrows = self.arrows.iter();
        let arrows = arrows.flat_map(|(from, tos)| tos.keys().map(move |to| (*from, *to)));
        let back = arrows.filter(
            |&(from, to)| matches!((place(from), place(to)), (Some(from), Some(to)) if from < to),
        );
        back.map(|(from, to)| format!("back up the way of the data: {}", self.tell(from, to)))
            .collect()
    }
}

impl Graph<'_> {
    /// Returns all imports: the importing file, the imported one, and the place.
    pub fn imports(&self) -> impl Iterator<Item = (&File, &File, String)> {
        let arrows = self.arrows.iter();
        let arrows = arrows.flat_map(|(from, tos)| tos.keys().map(move |to| (*from, *to)));
        arrows.map(|(from, to)| (&self.files[from], &self.files[to], self.tell(from, to)))
    }
}

/// Definitions of names.
struct Index {
    /// The file of each module.
    modules: BTreeMap<Vec<String>, usize>,
    /// Names that a module re-exports, and their targets.
    passed_on: BTreeMap<Vec<String>, BTreeMap<String, Vec<String>>>,
    /// Modules that a module re-exports completely (`*`).
    all_of: BTreeMap<Vec<String>, Vec<Vec<String>>>,
    /// Names that a module defines.
    defined: BTreeMap<Vec<String>, BTreeSet<String>>,
}

impl Index {
    fn new(sources: &Sources) -> Self {
        let mut index = Self {
            modules: BTreeMap::new(),
            passed_on: BTreeMap::new(),
            all_of: BTreeMap::new(),
            defined: BTreeMap::new(),
        };
        for (k, file) in sources.files.iter().enumerate() {
            // `lib.rs` comes before `main.rs`, and is the usual meaning of `crate`.
            index.modules.entry(file.module.clone()).or_insert(k);
            for item in &file.syntax.items {
                match item {
                    syn::Item::Use(item) if !matches!(item.vis, syn::Visibility::Inherited) => {
                        for (path, name) in leaves(&item.tree) {
                            let path = absolute(&sources.name, &file.module, &path);
                            match name {
                                Some(name) => {
                                    let names = index.passed_on.entry(file.module.clone());
                                    names.or_default().insert(name, path);
                                }
                                None => {
                                    let all = index.all_of.entry(file.module.clone());
                                    all.or_default().push(path);
                                }
                            }
                        }
                    }
                    item => {
                        let names = index.defined.entry(file.module.clone()).or_default();
                        names.extend(name_of(item));
                    }
                }
            }
        }
        index
    }

    /// Returns the file that defines the target of `path` (from the crate's root).
    fn resolve(&self, path: &[String], deep: usize) -> Option<usize> {
        let length = (0..=path.len())
            .rev()
            .find(|n| self.modules.contains_key(&path[..*n]))?;
        let (module, rest) = path.split_at(length);
        let Some((name, rest)) = rest.split_first().filter(|_| deep > 0) else {
            return self.modules.get(module).copied();
        };
        if let Some(to) = self.passed_on.get(module).and_then(|names| names.get(name)) {
            let path = [&to[..], rest].concat();
            return self.resolve(&path, deep - 1);
        }
        let all = self.all_of.get(module).into_iter().flatten();
        let holds = |to: &&Vec<String>| self.defined.get(*to).is_some_and(|d| d.contains(name));
        match all.clone().find(holds) {
            Some(to) => self.modules.get(to).copied(),
            None => self.modules.get(module).copied(),
        }
    }
}

fn name_of(item: &syn::Item) -> Option<String> {
    use syn::Item;
    Some(match item {
        Item::Const(i) => i.ident.to_string(),
        Item::Enum(i) => i.ident.to_string(),
        Item::Fn(i) => i.sig.ident.to_string(),
        Item::Static(i) => i.ident.to_string(),
        Item::Struct(i) => i.ident.to_string(),
        Item::Trait(i) => i.ident.to_string(),
        Item::Type(i) => i.ident.to_string(),
        _ => return None,
    })
}

/// Returns the paths of a `use`, each with its local name; `None` for all names of a module.
fn leaves(tree: &syn::UseTree) -> Vec<(Vec<String>, Option<String>)> {
    match tree {
        syn::UseTree::Path(path) => {
            let first = path.ident.to_string();
            let prefix = |(rest, name): (Vec<String>, Option<String>)| {
                // `use a::{self}` is `a`.
                let name = name.map(|n| if n == "self" { first.clone() } else { n });
                let rest = rest.into_iter().filter(|part| part != "self");
                (std::iter::once(first.clone()).chain(rest).collect(), name)
            };
            leaves(&path.tree).into_iter().map(prefix).collect()
        }
        syn::UseTree::Name(name) => {
            vec![(vec![name.ident.to_string()], Some(name.ident.to_string()))]
        }
        syn::UseTree::Rename(name) => {
            vec![(vec![name.ident.to_string()], Some(name.rename.to_string()))]
        }
        syn::UseTree::Glob(_) => vec![(Vec::new(), None)],
        syn::UseTree::Group(group) => group.items.iter().flat_map(leaves).collect(),
    }
}

/// Converts `path`, as written in `module` of the crate `name`, to a path from the crate's root. Names
/// of other crates lead nowhere, since no module has them. The binary uses the crate's own name.
fn absolute(name: &str, module: &[String], path: &[String]) -> Vec<String> {
    let mut base = module.to_vec();
    let mut rest = path;
    match rest.first().map(String::as_str) {
        Some(first) if first == "crate" || first == name => return rest[1..].to_vec(),
        Some("self") => rest = &rest[1..],
        _ => {
            while let Some((first, others)) = rest.split_first()
                && first == "super"
            {
                base.pop();
                rest = others;
            }
        }
    }
    base.extend(rest.iter().cloned());
    base
}

/// All paths in a file that may lead into another, from the crate's root, with their lines.
struct Collector<'a> {
    /// The crate's name.
    name: &'a str,
    module: Vec<String>,
    paths: Vec<(Vec<String>, usize)>,
}

impl Collector<'_> {
    fn add(&mut self, path: &[String], line: usize) {
        // A single name comes from a `use`, which is counted separately.
        if path.len() > 1 || path.first().is_some_and(|p| p == "super") {
            self.paths
                .push((absolute(self.name, &self.module, path), line));
        }
    }

    /// Searches the arguments of a macro call, which are not parsed, for names joined by `::`.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut line = 0;
        let mut colons = 0;
        for token in tokens {
            match &token {
                TokenTree::Ident(name) if colons == 2 && !path.is_empty() => {
                    path.push(name.to_string());
                    colons = 0;
                    continue;
                }
                TokenTree::Punct(p) if p.as_char() == ':' && !path.is_empty() && colons < 2 => {
                    colons += 1;
                    continue;
                }
                _ => self.add(&std::mem::take(&mut path), line),
            }
            colons = 0;
            match &token {
                TokenTree::Ident(name) => {
                    line = name.span().start().line;
                    path.push(name.to_string());
                }
                TokenTree::Group(group) => self.tokens(group.stream()),
                _ => {}
            }
        }
        self.add(&path, line);
    }
}

impl<'ast> Visit<'ast> for Collector<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        visit::visit_item_mod(self, item);
        self.module.pop();
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        for (path, _) in leaves(&item.tree) {
            // A single name is a crate, or a module of this file.
            let path = absolute(self.name, &self.module, &path);
            self.paths.push((path, item.span().start().line));
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        self.add(&names, path.span().start().line);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.visit_path(&call.path);
        self.tokens(call.tokens.clone());
    }

    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles(texts: &[(&str, &str)]) -> Vec<String> {
        Graph::new(&Sources::new("stairscan", texts.iter().copied())).circles(|_| true)
    }

    const LIB: (&str, &str) = ("src/lib.rs", "pub mod a;\npub mod b;");

    #[test]
    fn a_circle_is_found_however_it_is_written() {
        for (a, b) in [
            ("use crate::b::f;", "use crate::a::g;"),
            ("use super::b;", "use super::a::{self, g};"),
            ("fn g() { crate::b::f() }", "fn f() { super::a::g() }"),
            (
                "fn g() { m!(1, crate::b::f()); }",
                "fn f(x: crate::a::T) {}",
            ),
            ("mod inner { use super::super::b; }", "use stairscan::a::T;"),
            ("use crate::{b::*};", "impl crate::a::T for S {}"),
            ("fn g() { use super::b::f; }", "const X: u8 = super::a::Y;"),
        ] {
            let found = circles(&[LIB, ("src/a.rs", a), ("src/b.rs", b)]);
            let expected = "circle: src/a.rs:1 imports src/b.rs, src/b.rs:1 imports src/a.rs";
            assert_eq!(found, [expected], "{a} {b}");
        }
    }

    #[test]
    fn what_is_no_circle() {
        for (a, b) in [
            (
                "use crate::b::f;",
                "#[cfg(test)]\nmod tests { use crate::a::g; }",
            ),
            ("use crate::b::f;", "use core::a::g; fn f() { a::g() }"),
            (
                "use crate::b::f;",
                "use other::a::g; fn f() { other::a::g() }",
            ),
            ("use crate::b::f;", "#[cfg(test)]\nuse crate::a::g;"),
            ("use crate::b::f;", "pub(super) fn f() {}"),
            ("use crate::b::f;", "/// See [`crate::a::g`].\nfn f() {}"),
        ] {
            let found = circles(&[LIB, ("src/a.rs", a), ("src/b.rs", b)]);
            assert_eq!(found, Vec::<String>::new(), "{a} {b}");
        }
    }

    /// Re-exports of a folder count as the file that defines them.
    #[test]
    fn through_a_folder_to_the_file() {
        let folder = [
            ("src/lib.rs", "pub mod a;"),
            (
                "src/a/mod.rs",
                "mod b;\nmod c;\nmod d;\npub use b::{T as U};\npub use d::*;",
            ),
            ("src/a/b.rs", "pub struct T;"),
            ("src/a/c.rs", "use crate::a::U;\nuse super::V;"),
            ("src/a/d.rs", "pub struct V;"),
        ];
        assert_eq!(circles(&folder), Vec::<String>::new());
        let mut knotted = folder;
        knotted[1].1 = "mod b;\nmod c;\nmod d;\npub use b::{T as U};\npub use d::*;\npub struct W;";
        knotted[2].1 = "use super::W;\npub struct T;";
        let expected =
            "circle: src/a/mod.rs:4 imports src/a/b.rs, src/a/b.rs:1 imports src/a/mod.rs";
        assert_eq!(circles(&knotted), [expected]);
        // A name of a child module, without `self::`.
        knotted[1].1 = "mod b;\npub struct W;\nfn f() { b::g() }";
        assert_eq!(circles(&knotted).len(), 1);
    }

    #[test]
    fn arrows_back_up_the_way() {
        let sources = Sources::new(
            "stairscan",
            [
                ("src/lib.rs", "mod early; mod late;"),
                ("src/early/mod.rs", "\nuse crate::late::f;"),
                ("src/late/mod.rs", "fn f() {}"),
                ("src/late/g.rs", "use crate::early::h;"),
            ],
        );
        let graph = Graph::new(&sources);
        let back = graph.arrows_back(&["early", "late"]);
        let words = "src/early/mod.rs:2 imports src/late/mod.rs";
        assert_eq!(back, [format!("back up the way of the data: {words}")]);
        let back = graph.arrows_back(&["late", "early"]);
        assert_eq!(back.len(), 1, "{back:?}");
    }
}
