//! Words that the glossary replaces, where they still stand in comments, help texts and documents.

use pulldown_cmark::{Event, Options, Parser, Tag};

/// A phrase that does not stand in prose, and the term that does.
pub struct Replaced {
    words: Vec<String>,
    term: String,
}

impl Replaced {
    pub fn phrase(&self) -> String {
        self.words.join(" ")
    }
}

/// The phrases of the last column of the glossary's tables, separated by commas.
pub fn replaced(glossary: &str) -> Vec<Replaced> {
    let rows = glossary
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.strip_suffix('|'));
    let rows = rows.filter_map(|row| {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        match cells[..] {
            [term, _, phrases] if phrases != "instead of" => Some((term, phrases)),
            _ => None,
        }
    });
    let phrases = rows.flat_map(|(term, phrases)| {
        phrases.split(',').map(move |phrase| Replaced {
            words: words(phrase).flatten().collect(),
            term: term.to_owned(),
        })
    });
    phrases.filter(|phrase| !phrase.words.is_empty()).collect()
}

/// Words of `text` in lower case. `None` stands for punctuation, which no phrase crosses; a hyphen is a space.
fn words(text: &str) -> impl Iterator<Item = Option<String>> {
    let mut words = Vec::new();
    let mut word = String::new();
    for c in text.chars().chain([' ']) {
        if c.is_alphanumeric() || c == '\'' {
            word.extend(c.to_lowercase());
            continue;
        }
        if !word.is_empty() {
            words.push(Some(std::mem::take(&mut word)));
        }
        if !c.is_whitespace() && c != '-' {
            words.push(None);
        }
    }
    words.into_iter()
}

/// The words of a Markdown text with their lines. Code, HTML and the targets of links are left out.
fn prose(markdown: &str) -> Vec<(usize, Option<String>)> {
    let mut found = Vec::new();
    let mut code = false;
    let mut line = 1;
    let mut counted = 0;
    for (event, range) in Parser::new_ext(markdown, Options::ENABLE_TABLES).into_offset_iter() {
        if range.start > counted {
            line += markdown[counted..range.start].matches('\n').count();
            counted = range.start;
        }
        match event {
            Event::Text(text) if !code => found.extend(words(&text).map(|word| (line, word))),
            Event::SoftBreak | Event::HardBreak => {}
            Event::Start(Tag::Emphasis | Tag::Strong) => {}
            Event::Start(Tag::CodeBlock(_)) => code = true,
            Event::End(pulldown_cmark::TagEnd::CodeBlock) => code = false,
            Event::End(pulldown_cmark::TagEnd::Emphasis | pulldown_cmark::TagEnd::Strong) => {}
            _ => found.push((line, None)),
        }
    }
    found
}

/// The comments of a source file as a Markdown text, each in its line.
pub fn comments(source: &str) -> String {
    let comment = |line: &str| {
        let at = line.find("//")?;
        let (code, comment) = line.split_at(at);
        let whole = code.trim().is_empty();
        let behind = code.ends_with(' ') && code.matches('"').count() % 2 == 0;
        let text = comment.trim_start_matches(['/', '!']);
        (whole || behind).then(|| text.strip_prefix(' ').unwrap_or(text).to_owned())
    };
    let lines = source.lines().map(|line| comment(line).unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Each place of a Markdown text where a replaced phrase stands: line, phrase, term.
pub fn found<'a>(markdown: &str, replaced: &'a [Replaced]) -> Vec<(usize, &'a Replaced)> {
    let prose = prose(markdown);
    let mut places = Vec::new();
    for (at, (line, _)) in prose.iter().enumerate() {
        let stands = |phrase: &&Replaced| {
            let here = prose[at..].iter().map(|(_, word)| word.as_deref());
            phrase
                .words
                .iter()
                .map(|w| Some(w.as_str()))
                .eq(here.take(phrase.words.len()))
        };
        places.extend(replaced.iter().filter(stands).map(|p| (*line, p)));
    }
    places
}

/// One violation a place, of the text that stands in `path`.
pub fn violations(path: &str, markdown: &str, replaced: &[Replaced]) -> Vec<String> {
    let found = found(markdown, replaced).into_iter();
    found
        .map(|(line, p)| {
            let (phrase, term) = (p.phrase(), &p.term);
            format!("{path}:{line}: \"{phrase}\": the glossary's term is \"{term}\"")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLOSSARY: &str = "# Glossary\n\n| term | meaning | instead of |\n|---|---|---|\n\
        | horizon | how far | how far it vouches, vouched |\n| scan | a pass | |\n| false step | none there | made up |\n";

    #[test]
    fn phrases_come_from_the_last_column() {
        let replaced = replaced(GLOSSARY);
        let phrases: Vec<String> = replaced.iter().map(Replaced::phrase).collect();
        assert_eq!(phrases, ["how far it vouches", "vouched", "made up"]);
    }

    #[test]
    fn a_phrase_is_found_over_the_end_of_a_line_and_in_emphasis() {
        let text = "Is *vouched* for, or\nmade\nup, and made-up. Not made. Up.\n\n| a | Vouched |\n|---|---|\n";
        let lines: Vec<usize> = found(text, &replaced(GLOSSARY))
            .iter()
            .map(|(line, _)| *line)
            .collect();
        assert_eq!(lines, [1, 2, 3, 5]);
    }

    #[test]
    fn code_and_targets_of_links_are_left_out() {
        let text = "`vouched`, [that](vouched.md)\n\n```text\nvouched\n```\n\n    vouched\n";
        assert_eq!(found(text, &replaced(GLOSSARY)).len(), 0);
    }

    #[test]
    fn comments_are_found_and_strings_are_not() {
        let source = "//! Made up.\n\nlet a = \"// made up\"; // vouched\n/// `vouched`,\n/// made up\nfn made_up() {}\n";
        assert_eq!(
            violations("a.rs", &comments(source), &replaced(GLOSSARY)),
            [
                "a.rs:1: \"made up\": the glossary's term is \"false step\"",
                "a.rs:5: \"made up\": the glossary's term is \"false step\"",
            ]
        );
        let behind = "let a = 1; // vouched\n";
        assert_eq!(found(&comments(behind), &replaced(GLOSSARY)).len(), 1);
    }
}
