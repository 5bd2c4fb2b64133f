//! Finds numbers outside of parameter tables and named constants.

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use super::sources::{File, attributes, is_test};

/// Numbers that need no name: none, one, a pair, the middle.
const PLAIN: [f64; 4] = [0.0, 1.0, 2.0, 0.5];

/// Returns the numbers of `file` that are neither in its tests nor in a constant with a comment
/// above it.
pub fn stray(file: &File) -> Vec<String> {
    let mut finder = Finder {
        lines: file.text.lines().collect(),
        constant: None,
        found: Vec::new(),
    };
    finder.visit_file(&file.syntax);
    let tell = |(line, what): (usize, String)| format!("{}:{line}: {what}", file.path);
    finder.found.into_iter().map(tell).collect()
}

struct Finder<'a> {
    lines: Vec<&'a str>,
    /// Name of the current constant without a comment.
    constant: Option<String>,
    /// Line and text.
    found: Vec<(usize, String)>,
}

impl Finder<'_> {
    fn literal(&mut self, literal: &syn::Lit) {
        let value = match literal {
            syn::Lit::Int(int) => int.base10_digits().parse::<f64>(),
            syn::Lit::Float(float) => float.base10_digits().parse::<f64>(),
            _ => return,
        };
        if value.is_ok_and(|value| PLAIN.contains(&value)) {
            return;
        }
        let text = match literal {
            syn::Lit::Int(int) => int.to_string(),
            syn::Lit::Float(float) => float.to_string(),
            _ => return,
        };
        let what = match &self.constant {
            Some(name) => format!("the constant {name} = … {text} has no comment just above it"),
            None => format!("the number {text} stands in no table of parameters"),
        };
        self.found.push((literal.span().start().line, what));
    }

    /// Searches the arguments of a macro call, which are not parsed.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut after_dot = false;
        for token in tokens {
            match &token {
                TokenTree::Group(group) => self.tokens(group.stream()),
                // After a dot it is the field of a tuple.
                TokenTree::Literal(literal) if !after_dot => {
                    self.literal(&syn::Lit::new(literal.clone()));
                }
                _ => {}
            }
            let dot = matches!(&token, TokenTree::Punct(p) if p.as_char() == '.');
            // Two dots are a range.
            after_dot = dot && !after_dot;
        }
    }

    /// Whether a comment ends on the line before `line`, or `attributes` hold one.
    fn commented(&self, attributes: &[syn::Attribute], line: usize) -> bool {
        let above = line.checked_sub(2).and_then(|k| self.lines.get(k));
        attributes.iter().any(|a| a.path().is_ident("doc"))
            || above.is_some_and(|text| text.trim_start().starts_with("//"))
    }

    /// Visits a constant unless a comment explains it.
    fn constant(
        &mut self,
        attributes: &[syn::Attribute],
        name: &syn::Ident,
        line: usize,
        look: impl FnOnce(&mut Self),
    ) {
        if !self.commented(attributes, line) {
            let outer = self.constant.replace(name.to_string());
            look(self);
            self.constant = outer;
        }
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_test(&item.attrs) {
            visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.constant(
            &item.attrs,
            &item.ident,
            item.span().start().line,
            |finder| {
                visit::visit_item_const(finder, item);
            },
        );
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.constant(
            &item.attrs,
            &item.ident,
            item.span().start().line,
            |finder| {
                visit::visit_item_static(finder, item);
            },
        );
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.constant(
            &item.attrs,
            &item.ident,
            item.span().start().line,
            |finder| {
                visit::visit_impl_item_const(finder, item);
            },
        );
    }

    fn visit_trait_item_const(&mut self, item: &'ast syn::TraitItemConst) {
        self.constant(
            &item.attrs,
            &item.ident,
            item.span().start().line,
            |finder| {
                visit::visit_trait_item_const(finder, item);
            },
        );
    }

    fn visit_lit(&mut self, literal: &'ast syn::Lit) {
        self.literal(literal);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.tokens(call.tokens.clone());
    }

    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}

    fn visit_type_array(&mut self, array: &'ast syn::TypeArray) {
        // Not the length.
        self.visit_type(&array.elem);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        stray(&File::parse("src/infer/a.rs", text))
    }

    #[test]
    fn a_bare_number_is_found_wherever_it_stands() {
        for (text, number) in [
            ("fn f() -> f32 { 3.5 }", "3.5"),
            ("fn f(x: u8) -> bool { matches!(x, 0 | 7) }", "7"),
            ("fn f(x: u8) -> u8 { match x { 9 => 0, _ => 1 } }", "9"),
            ("fn f() -> [u8; 5] { [0; 5] }", "5"),
            ("fn f(x: f32) { assert!(x > g(1e-6f32)); }", "1e-6f32"),
            ("fn f() { for _ in 0..12_u8 {} }", "12_u8"),
            ("fn f(x: [u8; 4]) { g!(x[0..3]); }", "3"),
            ("enum E { A = 4 }", "4"),
            ("impl S { fn f() -> i32 { -3 } }", "3"),
        ] {
            let found = found(text);
            let words = format!("src/infer/a.rs:1: the number {number} stands");
            assert!(
                found.len() == 1 && found[0].starts_with(&words),
                "{text}: {found:?}"
            );
        }
    }

    #[test]
    fn plain_numbers_and_what_is_no_value_are_not() {
        for text in [
            "fn f() -> f32 { 0.5 + 1.0 - 2f32 * 0_f32 + 0x1 as f32 }",
            "fn f(x: (u8, u8, u8, u8)) -> u8 { x.3 }",
            "fn f(x: (u8, (u8, u8, u8, u8))) { g!(x.1.3, x.1); }",
            "struct S { a: [f32; 17] }",
            "#[repr(align(4))]\nstruct S;",
            "#[cfg(test)]\nmod tests { fn f() -> u8 { 42 } }",
            "#[test]\nfn f() { g(42) }",
            "fn f() -> &'static str { \"42\" }",
        ] {
            assert_eq!(found(text), Vec::<String>::new(), "{text}");
        }
    }

    #[test]
    fn a_constant_needs_a_comment() {
        for text in [
            "/// From the beam's width.\nconst A: f32 = 3.5;",
            "// From the beam's width.\nconst A: f32 = 3.5;",
            "/// From the beam's width.\n#[rustfmt::skip]\nstatic A: [f32; 3] = [3.0, 4.0, 5.0];",
            "impl S {\n    /// From the beam's width.\n    const A: f32 = 3.5;\n}",
        ] {
            assert_eq!(found(text), Vec::<String>::new(), "{text}");
        }
        for text in [
            "const A: f32 = 3.5;",
            "// Of something else.\n\nconst A: f32 = 3.5;",
            "/// Of another one.\nconst B: f32 = 4.5;\nconst A: f32 = 3.5;",
            "impl S {\n    const A: f32 = 3.5;\n}",
        ] {
            let found = found(text);
            let words = "the constant A = … 3.5 has no comment just above it";
            assert!(
                found.len() == 1 && found[0].ends_with(words),
                "{text}: {found:?}"
            );
        }
    }
}
