//! Writes the linked crates as a CycloneDX 1.6 document (ECMA-424): a software bill of materials.
//!
//! The same lock file gives the same bytes: the document contains no time, random serial number or path.

use serde_json::{Value, json};

use super::graph::{Crate, Crates, Id, ROOT};

/// Crates of the toolchain that every image contains, with their licences: `core`, and the arithmetic for which the
/// chip has no instructions.
pub const TOOLCHAIN: [(&str, &str); 2] = [
    ("core", "MIT OR Apache-2.0"),
    (
        "compiler_builtins",
        "MIT AND Apache-2.0 WITH LLVM-exception AND (MIT OR Apache-2.0)",
    ),
];
/// Address of the repository of the Rust toolchain.
const RUST: &str = "https://github.com/rust-lang/rust";

/// Returns the CycloneDX document of these crates, including the image's own package, built by the
/// Rust version `toolchain`.
pub fn document(crates: &Crates, toolchain: &str) -> Value {
    let own = |id: &&Id| id.name == ROOT;
    let others = crates.iter().filter(|(id, _)| !own(id));
    let mut components: Vec<Value> = others.map(|(id, of)| component(id, of)).collect();
    components.extend(TOOLCHAIN.map(|(name, licence)| of_toolchain(name, licence, toolchain)));
    let mut dependencies: Vec<Value> = crates
        .iter()
        .map(|(id, of)| {
            let mut on: Vec<String> = of.depends.iter().map(purl).collect();
            if own(&id) {
                on.extend(TOOLCHAIN.map(|(name, _)| toolchain_ref(name, toolchain)));
            }
            json!({"ref": purl(id), "dependsOn": on})
        })
        .collect();
    dependencies.extend(TOOLCHAIN.map(|(name, _)| json!({"ref": toolchain_ref(name, toolchain)})));
    let image = crates.iter().find(|(id, _)| own(id));
    json!({
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": image.map(|(id, of)| firmware(id, of))},
        "components": components,
        "dependencies": dependencies,
    })
}

/// Returns the package URL of a crate, by which other parts of the document refer to it.
fn purl(id: &Id) -> String {
    format!("pkg:cargo/{}@{}", id.name, id.version)
}

fn toolchain_ref(name: &str, version: &str) -> String {
    format!("pkg:generic/rust-{name}@{version}")
}

/// Returns the component of the document that describes the image.
fn firmware(id: &Id, of: &Crate) -> Value {
    json!({
        "type": "firmware",
        "bom-ref": purl(id),
        "name": id.name,
        "version": id.version,
        "licenses": [{"expression": of.licence}],
        "purl": purl(id),
    })
}

fn component(id: &Id, of: &Crate) -> Value {
    let mut value = json!({
        "type": "library",
        "bom-ref": purl(id),
        "name": id.name,
        "version": id.version,
        "scope": "required",
    });
    if let Some(sum) = &of.checksum {
        value["hashes"] = json!([{"alg": "SHA-256", "content": sum}]);
    }
    value["licenses"] = json!([{"expression": of.licence}]);
    value["purl"] = purl(id).into();
    if !of.repository.is_empty() {
        value["externalReferences"] = json!([{"type": "vcs", "url": of.repository}]);
    }
    value
}

fn of_toolchain(name: &str, licence: &str, version: &str) -> Value {
    json!({
        "type": "library",
        "bom-ref": toolchain_ref(name, version),
        "name": name,
        "version": version,
        "scope": "required",
        "licenses": [{"expression": licence}],
        "purl": toolchain_ref(name, version),
        "externalReferences": [{"type": "vcs", "url": RUST}],
    })
}
