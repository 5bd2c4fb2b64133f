//! The source files of a crate, parsed, without their tests.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use syn::spanned::Spanned;

/// One source file.
pub struct File {
    /// Path below the crate's directory, with slashes: `src/signal/radar/link.rs`.
    pub path: String,
    /// Its module path; empty for a crate's root.
    pub module: Vec<String>,
    pub text: String,
    pub syntax: syn::File,
}

/// The files of a crate that are compiled without tests.
pub struct Sources {
    /// The crate's name in paths: `host_sim`.
    pub name: String,
    pub files: Vec<File>,
}

impl File {
    pub fn parse(path: &str, text: &str) -> Self {
        let inner = path.strip_prefix("src/").unwrap_or(path);
        let inner = inner.strip_suffix(".rs").unwrap_or(inner);
        let mut module: Vec<String> = inner.split('/').map(str::to_owned).collect();
        if ["mod", "lib", "main"].contains(&module[module.len() - 1].as_str()) {
            module.pop();
        }
        Self {
            path: path.to_owned(),
            module,
            text: text.to_owned(),
            syntax: syn::parse_file(text)
                .unwrap_or_else(|e| panic!("{path}:{}: {e}", e.span().start().line)),
        }
    }

    /// Whether it is in `src/FOLDER`, or is `src/FOLDER.rs`.
    pub fn is_in(&self, folder: &str) -> bool {
        let below = self.path.strip_prefix(&format!("src/{folder}"));
        below.is_some_and(|rest| rest.starts_with('/') || rest == ".rs")
    }

    /// Whether it is part of a table of parameters: `params.rs`, `params_levels.rs`, `params/…`.
    pub fn is_params(&self) -> bool {
        self.path.split('/').any(|part| part.starts_with("params"))
    }

    /// Returns the number of lines without tests.
    pub fn lines(&self) -> usize {
        let tests = self
            .syntax
            .items
            .iter()
            .filter(|item| is_test(attributes(item)));
        let of_tests = tests.map(|item| {
            let span = item.span();
            span.end().line + 1 - span.start().line
        });
        self.text.lines().count() - of_tests.sum::<usize>()
    }
}

impl Sources {
    /// Reads all `.rs` files of the crate `name` below `root` (`…/src`) that are not test modules.
    pub fn read(name: &str, root: &Path) -> Self {
        let mut texts = BTreeMap::new();
        for entry in walkdir::WalkDir::new(root).sort_by_file_name() {
            let entry = entry.unwrap();
            if entry.path().extension().is_some_and(|e| e == "rs") {
                let below = entry.path().strip_prefix(root).unwrap();
                let parts: Vec<_> = below.iter().map(|p| p.to_string_lossy()).collect();
                let text = std::fs::read_to_string(entry.path()).unwrap();
                texts.insert(format!("src/{}", parts.join("/")), text);
            }
        }
        let texts = texts.iter();
        Self::new(
            name,
            texts.map(|(path, text)| (path.as_str(), text.as_str())),
        )
    }

    /// From pairs of path and text.
    pub fn new<'a>(name: &str, texts: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let mut files: Vec<File> = texts
            .into_iter()
            .map(|(path, text)| File::parse(path, text))
            .collect();
        let tests: Vec<Vec<String>> = files.iter().flat_map(test_modules).collect();
        files.retain(|file| !tests.iter().any(|test| file.module.starts_with(test)));
        let name = name.to_owned();
        Self { name, files }
    }

    /// Returns the folders of `src/` that contain more than `share` of its lines.
    pub fn large_folders(&self, share: f64) -> Vec<Folder> {
        let total: usize = self.files.iter().map(File::lines).sum();
        let mut folders: BTreeMap<&str, usize> = BTreeMap::new();
        for file in &self.files {
            let mut parts = file.path.split('/').skip(1);
            if let (Some(folder), Some(_)) = (parts.next(), parts.next()) {
                *folders.entry(folder).or_default() += file.lines();
            }
        }
        let large = folders
            .iter()
            .filter(|(_, lines)| **lines as f64 > share * total as f64);
        let tell = |(name, lines): (&&str, &usize)| Folder {
            name: (*name).to_owned(),
            lines: *lines,
            total,
            share,
        };
        large.map(tell).collect()
    }
}

/// A folder of `src/` with more than its share of the lines.
#[derive(Debug)]
pub struct Folder {
    pub name: String,
    lines: usize,
    total: usize,
    share: f64,
}

impl fmt::Display for Folder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = 100.0 * self.lines as f64 / self.total as f64;
        write!(
            f,
            "src/{}: {} of {} lines, {percent:.1} %, at most {:.0} %",
            self.name,
            self.lines,
            self.total,
            100.0 * self.share
        )
    }
}

/// Returns the modules of `file` that are separate files and are compiled for tests only.
fn test_modules(file: &File) -> Vec<Vec<String>> {
    let modules = file.syntax.items.iter().filter_map(|item| match item {
        syn::Item::Mod(m) if m.content.is_none() && is_test(&m.attrs) => Some(m.ident.to_string()),
        _ => None,
    });
    modules
        .map(|name| [&file.module[..], &[name]].concat())
        .collect()
}

/// Whether an item with `attributes` is compiled for tests only.
pub fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let mut test = false;
        if attribute.path().is_ident("cfg") {
            let _ = attribute.parse_nested_meta(|meta| {
                test |= meta.path.is_ident("test");
                if meta.path.is_ident("all") {
                    meta.parse_nested_meta(|inner| {
                        test |= inner.path.is_ident("test");
                        skip(&inner)
                    })?;
                }
                skip(&meta)
            });
        }
        test || attribute.path().is_ident("test")
    })
}

/// Skips the tokens after a name within `cfg`.
fn skip(meta: &syn::meta::ParseNestedMeta<'_>) -> syn::Result<()> {
    if meta.input.peek(syn::Token![=]) {
        meta.value()?.parse::<syn::Lit>()?;
    } else if meta.input.peek(syn::token::Paren) {
        let inner;
        syn::parenthesized!(inner in meta.input);
        inner.parse::<proc_macro2::TokenStream>()?;
    }
    Ok(())
}

/// Returns the attributes of an item.
pub fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    use syn::Item;
    match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::ExternCrate(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::ForeignMod(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Union(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

#[test]
fn tests_are_left_out() {
    let sources = Sources::new(
        "stairscan",
        [
            ("src/lib.rs", "mod a;\n#[cfg(test)]\nmod tests;\n"),
            ("src/tests.rs", "fn f() {}\n"),
            ("src/tests/deep.rs", "fn f() {}\n"),
            (
                "src/a.rs",
                "fn f() {}\n\n#[cfg(all(test, unix))]\nmod tests {\n    fn g() {}\n}\n",
            ),
            ("src/b.rs", "#[cfg(not(test))]\nfn f() {}\n"),
        ],
    );
    let lines: Vec<_> = sources
        .files
        .iter()
        .map(|f| (f.path.as_str(), f.lines()))
        .collect();
    assert_eq!(lines, [("src/lib.rs", 1), ("src/a.rs", 2), ("src/b.rs", 2)]);
}

#[test]
fn a_large_folder_is_named() {
    let sources = Sources::new(
        "stairscan",
        [
            ("src/lib.rs", "\n\n\n\n\n\n"),
            ("src/a/mod.rs", "\n\n"),
            ("src/a/b.rs", "\n"),
            ("src/c/mod.rs", "\n"),
        ],
    );
    assert!(sources.large_folders(0.3).is_empty());
    let large = sources.large_folders(0.25);
    let reported: Vec<String> = large.iter().map(ToString::to_string).collect();
    assert_eq!(reported, ["src/a: 3 of 10 lines, 30.0 %, at most 25 %"]);
}
