//! Finds assignments of a status outside of `src/verdict`.

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use super::sources::{File, attributes, is_test};

/// The type of a status.
const STATUS: &str = "Status";
/// Macros that only compare.
const COMPARING: [&str; 4] = ["matches", "assert", "debug_assert", "assert_eq"];

/// Returns the places where `file` writes a status: it assigns one to a field, or uses one of its values outside of a
/// pattern or comparison. Tests are exempt.
pub fn written(file: &File) -> Vec<String> {
    let mut finder = Finder { found: Vec::new() };
    finder.visit_file(&file.syntax);
    let tell = |(line, what): (usize, &str)| format!("{}:{line}: {what}", file.path);
    finder.found.into_iter().map(tell).collect()
}

struct Finder {
    /// Line and text.
    found: Vec<(usize, &'static str)>,
}

/// Whether a path ends in a value of the status.
fn names_value(path: &syn::Path) -> bool {
    let mut segments = path.segments.iter().rev().skip(1);
    segments.next().is_some_and(|s| s.ident == STATUS)
}

fn is_value(expression: &syn::Expr) -> bool {
    matches!(expression, syn::Expr::Path(path) if names_value(&path.path))
}

impl Finder {
    /// Searches the arguments of a macro call, which `syn` does not parse.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut colons = None;
        for token in tokens {
            match &token {
                TokenTree::Ident(name) if name == STATUS => {
                    colons = Some((0, name.span().start().line));
                    continue;
                }
                TokenTree::Punct(p) if p.as_char() == ':' => {
                    colons = colons.map(|(n, line)| (n + 1, line));
                    continue;
                }
                TokenTree::Ident(_) => {
                    if let Some((2, line)) = colons {
                        self.found.push((line, "a status in a macro"));
                    }
                }
                TokenTree::Group(group) => self.tokens(group.stream()),
                _ => {}
            }
            colons = None;
        }
    }
}

impl<'ast> Visit<'ast> for Finder {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    // A pattern only reads.
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        let compares = matches!(binary.op, syn::BinOp::Eq(_) | syn::BinOp::Ne(_));
        for side in [&binary.left, &binary.right] {
            if !(compares && is_value(side)) {
                self.visit_expr(side);
            }
        }
    }

    fn visit_expr_assign(&mut self, assign: &'ast syn::ExprAssign) {
        if let syn::Expr::Field(field) = &*assign.left
            && matches!(&field.member, syn::Member::Named(name) if name == "status")
        {
            let line = assign.span().start().line;
            self.found.push((line, "assigns a status"));
        }
        visit::visit_expr_assign(self, assign);
    }

    fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
        if names_value(&path.path) {
            let line = path.span().start().line;
            self.found.push((line, "makes a status"));
        }
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        if !COMPARING.iter().any(|name| call.path.is_ident(name)) {
            self.tokens(call.tokens.clone());
        }
    }

    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> usize {
        written(&File::parse("src/a.rs", text)).len()
    }

    #[test]
    fn a_status_may_be_read() {
        let text = "fn f(o: &Outcome) -> bool {\n    match o.status() {\n        Status::Ok => true,\n        \
                    crate::verdict::Status::Fault | Status::Degraded => o.status() != Status::Ok,\n    }\n}\n\
                    fn g(s: Status) -> bool {\n    matches!(s, Status::Ok) && Status::Fault == s\n}\n\
                    #[cfg(test)]\nmod tests {\n    fn h() -> Status { Status::Ok }\n}\n";
        assert_eq!(found(text), 0);
    }

    #[test]
    fn a_status_may_not_be_written() {
        for text in [
            "fn f(v: &mut V) { v.status = other; }",
            "fn f() -> Status { Status::Ok }",
            "fn f() -> V { V { status: crate::verdict::Status::Fault } }",
            "fn f(v: &mut V) { v.verdict.status = v.status; }",
            "fn f(a: bool) -> Status { if a { Status::Ok } else { old() } }",
            "fn f(v: &mut V) { set(v, Status::Degraded) }",
            "fn f() { vec![Status::Ok] }",
            "const S: Status = Status::Ok;",
        ] {
            assert_eq!(found(text), 1, "{text}");
        }
    }
}
