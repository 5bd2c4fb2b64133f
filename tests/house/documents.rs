//! Checks the links of the documents: each leads to a file and, if it names one, to a heading.

use std::fs;
use std::path::{Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// A document's links, and the anchors of its headings.
struct Document {
    path: PathBuf,
    links: Vec<String>,
    anchors: Vec<String>,
}

/// Returns the anchor of a heading: letters, digits and hyphens, a hyphen for each space.
fn anchor(heading: &str) -> String {
    let kept = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
        _ => None,
    };
    heading
        .trim()
        .to_lowercase()
        .chars()
        .filter_map(kept)
        .collect()
}

impl Document {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let (mut links, mut anchors) = (Vec::new(), Vec::new());
        let mut heading = None;
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    links.push(dest_url.into_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    anchors.extend(heading.take().map(|h: String| anchor(&h)));
                }
                Event::Text(words) | Event::Code(words) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&words);
                    }
                }
                _ => {}
            }
        }
        Self {
            path: path.to_owned(),
            links,
            anchors,
        }
    }
}

/// Returns all broken links, with their documents.
pub fn dead_links(root: &Path, documents: &[PathBuf]) -> Vec<String> {
    let read: Vec<Document> = documents.iter().map(|path| Document::read(path)).collect();
    assert!(
        read.iter().any(|d| !d.links.is_empty()),
        "no links in {}",
        root.display()
    );
    let mut dead = Vec::new();
    for document in &read {
        let local = |link: &&String| !link.contains("://");
        for link in document.links.iter().filter(local) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() {
                document.path.clone()
            } else {
                document.path.with_file_name(file)
            };
            let Ok(found) = target.canonicalize() else {
                dead.push(format!("{}: {link}: no such file", document.path.display()));
                continue;
            };
            let headed = read.iter().find(|d| d.path == found);
            if let (Some(there), false) = (headed, heading.is_empty())
                && !there.anchors.iter().any(|a| a == heading)
            {
                dead.push(format!(
                    "{}: {link}: no such heading",
                    document.path.display()
                ));
            }
        }
    }
    dead
}
