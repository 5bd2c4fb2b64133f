//! A document of headings, text, tables and drawings, as Markdown and as an HTML page.

use std::fmt::Write as _;

use host_sim::html;

/// A table. Each row has as many cells as the head.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub head: Vec<String>,
    /// Rows from top to bottom, each with one text a column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates an empty table with these columns.
    pub fn new(head: &[&str]) -> Self {
        Self {
            head: head.iter().map(|name| (*name).to_owned()).collect(),
            rows: Vec::new(),
        }
    }
}

/// A part of a document. Texts may contain `code` but no other Markdown.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// A heading with its level, from 1.
    Heading(usize, String),
    /// A paragraph.
    Text(String),
    /// A list.
    List(Vec<String>),
    /// A table.
    Table(Table),
    /// A drawing.
    Figure {
        /// File name of the drawing, without a directory.
        file: String,
        /// Alternative text; the HTML page also prints it below the drawing.
        alt: String,
        /// The drawing's SVG text.
        svg: String,
    },
}

/// Returns the document as Markdown, which refers to its drawings as files in `directory`.
pub fn markdown(parts: &[Part], directory: &str) -> String {
    let blocks = parts.iter().map(|part| match part {
        Part::Heading(level, text) => format!("{} {text}\n", "#".repeat(*level)),
        Part::Text(text) => format!("{text}\n"),
        Part::List(items) => items.iter().map(|item| format!("- {item}\n")).collect(),
        Part::Table(table) => rows_of(table),
        Part::Figure { file, alt, .. } => format!("![{alt}]({directory}/{file})\n"),
    });
    blocks.collect::<Vec<_>>().join("\n")
}

fn rows_of(table: &Table) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule = format!("|{}\n", "---|".repeat(table.head.len()));
    let rows: String = table.rows.iter().map(|row| line(row)).collect();
    line(&table.head) + &rule + &rows
}

/// Returns the document as one HTML page that contains its drawings and needs no network.
pub fn page(title: &str, parts: &[Part]) -> String {
    let mut body = String::new();
    for part in parts {
        let _ = match part {
            Part::Heading(level, text) => writeln!(body, "<h{level}>{}</h{level}>", marked(text)),
            Part::Text(text) => writeln!(body, "<p>{}</p>", marked(text)),
            Part::List(items) => {
                let items: String = items
                    .iter()
                    .map(|i| format!("<li>{}</li>", marked(i)))
                    .collect();
                writeln!(body, "<ul>{items}</ul>")
            }
            Part::Table(table) => writeln!(body, "{}", cells_of(table)),
            Part::Figure { alt, svg, .. } => {
                writeln!(
                    body,
                    "<figure>{svg}<figcaption>{}</figcaption></figure>",
                    marked(alt)
                )
            }
        };
    }
    html::article(title, &body)
}

fn cells_of(table: &Table) -> String {
    let row = |cells: &[String], tag: &str| {
        let cells = cells
            .iter()
            .map(|c| format!("<{tag}>{}</{tag}>", marked(c)));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = table.rows.iter().map(|r| row(r, "td")).collect();
    format!(
        "<div class=\"table\"><table>\n{}{rows}</table></div>",
        row(&table.head, "th")
    )
}

/// Returns a text escaped for HTML, in which pieces between backticks become `<code>` elements.
fn marked(text: &str) -> String {
    let pieces = text.split('`').enumerate();
    let piece = |(k, piece): (usize, &str)| match k % 2 {
        0 => html::escaped(piece),
        _ => format!("<code>{}</code>", html::escaped(piece)),
    };
    pieces.map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts() -> Vec<Part> {
        let mut table = Table::new(&["a", "b"]);
        table.rows.push(vec!["1 < 2".into(), "`ok`".into()]);
        vec![
            Part::Heading(2, "Sizes".into()),
            Part::Text("What is `ok` & more.".into()),
            Part::Table(table),
            Part::List(vec!["one".into(), "two".into()]),
            Part::Figure {
                file: "post.svg".into(),
                alt: "a post".into(),
                svg: "<svg/>".into(),
            },
        ]
    }

    #[test]
    fn markdown_has_every_part() {
        let expected = "## Sizes\n\nWhat is `ok` & more.\n\n| a | b |\n|---|---|\n| 1 < 2 | `ok` |\n\n\
                        - one\n- two\n\n![a post](pictures/post.svg)\n";
        assert_eq!(markdown(&parts(), "pictures"), expected);
    }

    #[test]
    fn a_page_is_escaped_and_holds_its_drawings() {
        let page = page("A sheet", &parts());
        for piece in [
            "<title>A sheet</title>",
            "<h2>Sizes</h2>",
            "<p>What is <code>ok</code> &amp; more.</p>",
            "<td>1 &lt; 2</td><td><code>ok</code></td>",
            "<figure><svg/><figcaption>a post</figcaption></figure>",
        ] {
            assert!(page.contains(piece), "{piece}:\n{page}");
        }
        assert!(!page.contains("{{") && !page.contains("http://") && !page.contains("https://"));
    }
}
