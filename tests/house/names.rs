//! Type names that the firmware's sources use more than once.

use std::collections::BTreeMap;

use syn::Item;

use super::sources::{Sources, attributes, is_test};

/// Returns the names of types, traits and aliases that are defined in two places of `sources`, with the
/// places. Tests are exempt, as are associated types and `cfg` alternatives of one module.
pub fn shared(sources: &Sources) -> Vec<String> {
    let mut places: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for file in &sources.files {
        walk(&file.syntax.items, &mut |name, module, line| {
            let module = format!("{}{module}", file.path);
            let at = format!("{}:{line}", file.path);
            places.entry(name).or_default().entry(module).or_insert(at);
        });
    }
    let twice = places.into_iter().filter(|(_, at)| at.len() > 1);
    let tell = |(name, at): (String, BTreeMap<String, String>)| {
        let at: Vec<String> = at.into_values().collect();
        format!("the type name {name} is defined at {}", at.join(", "))
    };
    twice.map(tell).collect()
}

/// Calls `found` with name, inline module and line of each type of `items` that is compiled without tests.
fn walk(items: &[Item], found: &mut dyn FnMut(String, &str, usize)) {
    inner(items, "", found);
}

fn inner(items: &[Item], module: &str, found: &mut dyn FnMut(String, &str, usize)) {
    for item in items.iter().filter(|item| !is_test(attributes(item))) {
        let name = match item {
            Item::Enum(i) => &i.ident,
            Item::Struct(i) => &i.ident,
            Item::Trait(i) => &i.ident,
            Item::Type(i) => &i.ident,
            Item::Union(i) => &i.ident,
            Item::Mod(i) => {
                if let Some((_, items)) = &i.content {
                    inner(items, &format!("{module}::{}", i.ident), found);
                }
                continue;
            }
            _ => continue,
        };
        found(name.to_string(), module, name.span().start().line);
    }
}

#[test]
fn a_shared_name_is_reported_with_its_places() {
    let sources = Sources::new(
        "stairscan",
        [
            (
                "src/a.rs",
                "struct A;\nenum B {}\n#[cfg(test)]\nmod tests {\n    struct C;\n}\n#[cfg(x)]\ntype D = u8;\n#[cfg(not(x))]\ntype D = u16;\n",
            ),
            (
                "src/b.rs",
                "pub trait A {}\nstruct C;\nimpl C {\n    type D = u8;\n}\nmod inner {\n    type B = u8;\n}\n",
            ),
        ],
    );
    assert_eq!(
        shared(&sources),
        [
            "the type name A is defined at src/a.rs:1, src/b.rs:1",
            "the type name B is defined at src/a.rs:2, src/b.rs:7"
        ]
    );
}
