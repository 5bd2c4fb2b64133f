//! The diagram of imports between folders in docs/design/architecture.md: generated from the imports, compared with them,
//! and searched for cycles.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::graph::Graph;
use super::sources::File;

/// A node: its name, and the folders and files of `src/` that it represents.
pub type Part = (&'static str, &'static [&'static str]);
/// A layer of the diagram: its title and its nodes.
pub type Layer = (&'static str, &'static [Part]);

/// Importing and imported node, with the first import.
type Arrows = BTreeMap<(String, String), String>;

/// Returns the node that a file belongs to; `None` for files that are left out.
fn part_of(layers: &[Layer], file: &File) -> Option<&'static str> {
    let parts = layers.iter().flat_map(|(_, parts)| *parts);
    let mut found = parts.filter(|(_, folders)| folders.iter().any(|folder| file.is_in(folder)));
    found.next().map(|(name, _)| *name)
}

/// Returns the node of a file in the search for cycles: its node of the diagram, or else its folder in `src/`, or itself
/// where it stands right there; `None` for `lib.rs`, which declares the others.
fn node_of(layers: &[Layer], file: &File) -> Option<String> {
    let inner = file.path.strip_prefix("src/")?;
    let name = inner.split('/').next()?.trim_end_matches(".rs");
    let part = part_of(layers, file).unwrap_or(name);
    (name != "lib").then(|| part.to_owned())
}

/// Returns the folders of `src/` that belong to no node and are not in `left_out`.
pub fn forgotten(layers: &[Layer], left_out: &[&str], files: &[File]) -> Vec<String> {
    let mut folders = BTreeSet::new();
    for file in files {
        let parts: Vec<&str> = file.path.split('/').collect();
        let known = left_out.iter().any(|folder| file.is_in(folder));
        if parts.len() > 2 && !known && part_of(layers, file).is_none() {
            folders.insert(format!("src/{} stands in no layer", parts[1]));
        }
    }
    folders.into_iter().collect()
}

/// Returns the imports between nodes, where `node` returns that of a file.
fn imports(graph: &Graph<'_>, node: impl Fn(&File) -> Option<String>) -> Arrows {
    let mut arrows = Arrows::new();
    for (from, to, place) in graph.imports() {
        if let (Some(from), Some(to)) = (node(from), node(to))
            && from != to
        {
            arrows.entry((from, to)).or_insert(place);
        }
    }
    arrows
}

/// Returns the imports between the nodes of the diagram.
fn drawn_imports(layers: &[Layer], graph: &Graph<'_>) -> Arrows {
    imports(graph, |file| part_of(layers, file).map(str::to_owned))
}

/// Returns the shortest path along `arrows` from `start` back to it.
fn circle<'a>(arrows: &'a Arrows, start: &'a str) -> Option<Vec<&'a str>> {
    let mut ways = vec![vec![start]];
    let mut seen = BTreeSet::new();
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            let last = way[way.len() - 1];
            for (_, to) in arrows.keys().filter(|(from, _)| from == last) {
                if to == start {
                    return Some(way);
                }
                if seen.insert(to) {
                    longer.push([&way[..], &[to]].concat());
                }
            }
        }
        ways = longer;
    }
    None
}

/// Returns for every node that imports itself, directly or through others, a shortest cycle with an import for each
/// of its arrows. Each cycle is reported once. Nodes are those of the diagram, and all other folders and files of `src/`.
pub fn circles(layers: &[Layer], graph: &Graph<'_>) -> Vec<String> {
    let arrows = imports(graph, |file| node_of(layers, file));
    let mut reported = BTreeSet::new();
    let mut found = Vec::new();
    let starts: BTreeSet<&str> = arrows.keys().map(|(from, _)| from.as_str()).collect();
    for start in starts {
        let Some(circle) = circle(&arrows, start) else {
            continue;
        };
        if reported.insert(circle.iter().copied().collect::<BTreeSet<_>>()) {
            let ends = circle.iter().skip(1).chain(circle.first());
            let pairs = circle.iter().zip(ends);
            let tell = |(from, to): (&&str, &&str)| {
                let place = &arrows[&((*from).to_owned(), (*to).to_owned())];
                format!("{from} --> {to} ({place})")
            };
            let pairs: Vec<String> = pairs.map(tell).collect();
            found.push(format!("circle: {}", pairs.join(", ")));
        }
    }
    found
}

/// Returns the mermaid block of the diagram.
fn block(layers: &[Layer], arrows: &Arrows) -> String {
    let mut out = String::from("```mermaid\nflowchart TB\n");
    for (k, (title, parts)) in layers.iter().enumerate() {
        let _ = writeln!(out, "    subgraph layer{k} [\"{title}\"]");
        for (name, _) in *parts {
            let _ = writeln!(out, "        {name}");
        }
        out += "    end\n";
    }
    for (name, _) in layers.iter().flat_map(|(_, parts)| *parts) {
        let to = arrows.keys().filter(|(from, _)| from == name);
        let to: Vec<&str> = to.map(|(_, to)| to.as_str()).collect();
        if !to.is_empty() {
            let _ = writeln!(out, "    {name} --> {}", to.join(" & "));
        }
    }
    out + "```\n"
}

/// Returns the arrows of a document's diagram.
fn drawn(document: &str) -> BTreeSet<(String, String)> {
    let block = document.split("```mermaid\n").nth(1).unwrap_or("");
    let block = block.split("```").next().unwrap_or("");
    let mut arrows = BTreeSet::new();
    for (from, to) in block.lines().filter_map(|line| line.split_once("-->")) {
        for to in to.split('&') {
            arrows.insert((from.trim().to_owned(), to.trim().to_owned()));
        }
    }
    arrows
}

/// Returns the differences between `document` and the imports, followed by the correct block; empty if they agree.
pub fn differences(layers: &[Layer], graph: &Graph<'_>, document: &str) -> Vec<String> {
    let (imports, drawn) = (drawn_imports(layers, graph), drawn(document));
    let mut found = Vec::new();
    for (arrow, place) in imports.iter().filter(|(arrow, _)| !drawn.contains(*arrow)) {
        found.push(format!("no arrow {} --> {}: {place}", arrow.0, arrow.1));
    }
    for (from, to) in drawn.iter().filter(|arrow| !imports.contains_key(*arrow)) {
        found.push(format!("an arrow too many: {from} --> {to}"));
    }
    let block = block(layers, &imports);
    if !document.contains(&block) {
        found.push(format!("the block to paste:\n\n{block}"));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sources::Sources;

    const LAYERS: &[Layer] = &[
        ("above", &[("a", &["a", "main"])]),
        ("below", &[("b", &["b"]), ("c", &["c"])]),
    ];

    fn sources() -> Sources {
        Sources::new(
            "stairscan",
            [
                (
                    "src/lib.rs",
                    "pub mod a;\npub mod b;\npub mod c;\nmod leaf;",
                ),
                ("src/main.rs", "use stairscan::c::g;"),
                ("src/leaf.rs", "pub fn l() {}"),
                ("src/a/mod.rs", "use crate::b::f;\nuse crate::leaf::l;"),
                (
                    "src/b/mod.rs",
                    "#[cfg(test)]\nuse crate::c::g;\npub fn f() {}",
                ),
                ("src/c/mod.rs", "pub fn g() {}"),
            ],
        )
    }

    fn found(document: &str) -> Vec<String> {
        let sources = sources();
        differences(LAYERS, &Graph::new(&sources), document)
    }

    const RIGHT: &str = "```mermaid\nflowchart TB\n    subgraph layer0 [\"above\"]\n        a\n    end\n    \
                         subgraph layer1 [\"below\"]\n        b\n        c\n    end\n    a --> b & c\n```\n";

    #[test]
    fn the_diagram_of_the_imports_differs_from_none() {
        assert_eq!(found(&format!("Text.\n\n{RIGHT}\nText.\n")), [""; 0]);
    }

    #[test]
    fn an_arrow_that_is_missing_or_too_many_is_named_and_the_block_printed() {
        let missing = found(&RIGHT.replace(" & c", ""));
        assert_eq!(
            missing[0],
            "no arrow a --> c: src/main.rs:1 imports src/c/mod.rs"
        );
        assert_eq!(missing[1], format!("the block to paste:\n\n{RIGHT}"));
        let more = found(&RIGHT.replace("b & c\n", "b & c\n    b --> c\n"));
        assert_eq!(more[0], "an arrow too many: b --> c");
        assert_eq!(found("No diagram.").len(), 3);
    }

    /// Returns the cycles among three folders: `b` imports `c`, whose source is `text`.
    fn round(text: &str) -> Vec<String> {
        let sources = Sources::new(
            "stairscan",
            [
                ("src/lib.rs", "pub mod a;\npub mod b;\npub mod c;"),
                ("src/a/mod.rs", "use crate::b::f;"),
                ("src/b/mod.rs", "use crate::c::g;"),
                ("src/b/other.rs", "pub fn f() {}"),
                ("src/c/mod.rs", text),
            ],
        );
        circles(LAYERS, &Graph::new(&sources))
    }

    #[test]
    fn a_circle_of_folders_is_found_though_no_file_imports_itself() {
        assert_eq!(round("#[cfg(test)]\nuse crate::a::h;"), [""; 0]);
        let of_two = "circle: b --> c (src/b/mod.rs:1 imports src/c/mod.rs), \
                      c --> b (src/c/mod.rs:1 imports src/b/other.rs)";
        assert_eq!(round("use crate::b::other::f;"), [of_two]);
        let through_another = "circle: a --> b (src/a/mod.rs:1 imports src/b/mod.rs), \
                               b --> c (src/b/mod.rs:1 imports src/c/mod.rs), \
                               c --> a (src/c/mod.rs:1 imports src/a/mod.rs)";
        assert_eq!(round("use crate::a::h;"), [through_another]);
    }

    #[test]
    fn a_circle_through_a_file_or_a_folder_outside_the_diagram_is_found() {
        let sources = Sources::new(
            "stairscan",
            [
                ("src/lib.rs", "pub mod b;\npub mod leaf;\npub mod numbers;"),
                ("src/b/mod.rs", "use crate::leaf::l;\npub fn f() {}"),
                ("src/leaf.rs", "pub use crate::numbers::N;\npub fn l() {}"),
                ("src/numbers/mod.rs", "use crate::b::f;\npub struct N;"),
            ],
        );
        let found = circles(LAYERS, &Graph::new(&sources));
        let expected = "circle: b --> leaf (src/b/mod.rs:1 imports src/leaf.rs), \
                        leaf --> numbers (src/leaf.rs:1 imports src/numbers/mod.rs), \
                        numbers --> b (src/numbers/mod.rs:1 imports src/b/mod.rs)";
        assert_eq!(found, [expected]);
    }

    #[test]
    fn a_new_folder_is_not_forgotten() {
        let files = sources().files;
        assert_eq!(forgotten(LAYERS, &[], &files), [""; 0]);
        let fewer = &LAYERS[..1];
        let expected = ["src/b stands in no layer", "src/c stands in no layer"];
        assert_eq!(forgotten(fewer, &[], &files), expected);
        assert_eq!(forgotten(fewer, &["b"], &files), expected[1..]);
    }
}
