//! Finds writes of chip registers that begin from a reset value other than 0.
//!
//! `register.write(|w| …)` sets the fields that the closure names, and all others to their values at reset. Where
//! these are not 0, the write sets bits that nobody named, as LOCK of FLASH_CR, by which no setting could be saved.
//! `modify` begins from what the register holds. A whole value may be written if a comment says why.

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

/// A register whose reset value is not 0: peripheral, register, section of RM0090.
pub type Register = (&'static str, &'static str, &'static str);

/// Such registers of the peripherals that image and loader use. Names of ports and timers are without letter or
/// number.
pub const REGISTERS: &[Register] = &[
    ("flash", "cr", "3.9"),
    ("flash", "optcr", "3.9"),
    ("pwr", "cr", "5.4.1"),
    ("rcc", "cr", "7.3.1"),
    ("rcc", "pllcfgr", "7.3.2"),
    ("rcc", "ahb1enr", "7.3.10"),
    ("rcc", "ahb1lpenr", "7.3.15"),
    ("rcc", "ahb2lpenr", "7.3.16"),
    ("rcc", "ahb3lpenr", "7.3.17"),
    ("rcc", "apb1lpenr", "7.3.18"),
    ("rcc", "apb2lpenr", "7.3.19"),
    ("rcc", "csr", "7.3.21"),
    ("rcc", "plli2scfgr", "7.3.23"),
    ("gpio", "moder", "8.4.1"),
    ("gpio", "ospeedr", "8.4.3"),
    ("gpio", "pupdr", "8.4.4"),
    ("iwdg", "rlr", "21.4.3"),
    ("spi", "sr", "28.5.3"),
    ("spi", "crcpr", "28.5.5"),
    ("spi", "i2spr", "28.5.9"),
    ("usart", "sr", "30.6.1"),
    ("dbgmcu", "idcode", "38.6.1"),
];

/// Peripherals of [`REGISTERS`] as files of the register crate.
pub const PERIPHERALS: &[&str] = &[
    "flash", "pwr", "rcc", "gpioa", "gpiob", "gpioi", "iwdg", "spi1", "usart1", "dbgmcu", "tim5",
    "tim11", "exti", "syscfg",
];

/// Returns the writes in a file with the text `text` that begin from a reset value other than 0 and have no reason: a
/// comment on the line above, or above the comments there, with the words "reset value".
pub fn writes(path: &str, text: &str) -> Vec<String> {
    let mut finder = Finder {
        lines: text.lines().collect(),
        found: Vec::new(),
    };
    finder.visit_file(&syn::parse_file(text).unwrap_or_else(|e| panic!("{path}: {e}")));
    let tell = |(line, what): (usize, String)| format!("{path}:{line}: {what}");
    finder.found.into_iter().map(tell).collect()
}

struct Finder<'a> {
    lines: Vec<&'a str>,
    /// Line and text.
    found: Vec<(usize, String)>,
}

impl Finder<'_> {
    /// Whether the comment above the statement that has the line `line` speaks of the reset value.
    fn reasoned(&self, line: usize) -> bool {
        let above = self.lines[..line - 1].iter().rev();
        let ends = |text: &str| {
            let code = text.split("//").next().unwrap_or_default().trim_end();
            code.ends_with([';', '{', '}', ','])
        };
        above
            .take_while(|text| !ends(text))
            .any(|text| text.contains("//") && text.contains("reset value"))
    }

    fn call(&mut self, receiver: &syn::Expr, line: usize) {
        let syn::Expr::MethodCall(register) = receiver else {
            return;
        };
        let (name, of) = (register.method.to_string(), peripheral(&register.receiver));
        let known = REGISTERS.iter().find(|(peripheral, register, _)| {
            *register == name && of.as_deref().is_none_or(|of| of == *peripheral)
        });
        if let Some((peripheral, _, section)) = known
            && !self.reasoned(line)
        {
            let what = format!(
                "{peripheral}.{name}().write begins from a reset value that is not 0 (RM0090 {section}): modify, or give the reason in a comment with the words \"reset value\""
            );
            self.found.push((line, what));
        }
    }

    /// Searches the arguments of a macro call for calls, which are not parsed there.
    fn tokens(&mut self, tokens: TokenStream) {
        if let Ok(expr) = syn::parse2::<syn::Expr>(tokens.clone()) {
            return self.visit_expr(&expr);
        }
        for token in tokens {
            if let TokenTree::Group(group) = token {
                self.tokens(group.stream());
            }
        }
    }
}

/// Returns the peripheral that an expression names by its last word, such as `rcc`, `p.RCC` or `registers()`; `None` if that
/// is no known peripheral.
fn peripheral(expr: &syn::Expr) -> Option<String> {
    let word = match expr {
        syn::Expr::Path(path) => path.path.segments.last()?.ident.to_string(),
        syn::Expr::Field(field) => match &field.member {
            syn::Member::Named(name) => name.to_string(),
            syn::Member::Unnamed(_) => return None,
        },
        syn::Expr::Call(call) => return peripheral(&call.func),
        syn::Expr::Paren(inner) => return peripheral(&inner.expr),
        syn::Expr::Reference(inner) => return peripheral(&inner.expr),
        _ => return None,
    };
    let word = word.to_lowercase();
    let known = |name: &&str| word.starts_with(name);
    let timers = ["tim", "exti", "syscfg"];
    let mut names = REGISTERS.iter().map(|(peripheral, ..)| *peripheral);
    let found = names.find(known).or_else(|| timers.into_iter().find(known));
    found.map(str::to_owned)
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if call.method == "write" && call.args.len() == 1 {
            self.call(&call.receiver, call.method.span().start().line);
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.tokens(call.tokens.clone());
    }
}

/// Returns the registers of a file of the register crate whose reset value there is not 0. `file` is its name without
/// `.rs`.
pub fn of_crate(file: &str, text: &str) -> Option<String> {
    let (_, behind) = text.split_once("impl crate::Resettable for ")?;
    let (body, _) = behind.split_once('}')?;
    body.contains("RESET_VALUE").then(|| file.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The six places of the two flash drivers as they were when no setting could be saved.
    #[test]
    fn the_writes_that_locked_the_flash_controller_are_found() {
        for text in [
            "fn f(&mut self) { self.regs.cr().write(|w| w.psize().set(WORDWISE)); }",
            "fn f(&mut self) { self.regs.cr().write(|w| w.lock().set_bit()); }",
            "fn f(&mut self) { self.regs\n.cr()\n.write(|w| w.psize().set(WORDWISE).pg().set_bit()); }",
            "fn f() { regs().cr().write(|w| w.psize().set(WORDWISE)); }",
            "fn f() { let erase = |k: usize| { regs().cr().write(|w| { w.ser().set_bit() }); }; }",
            "fn f() { assert!(flash.cr().write(|w| w)); }",
            "fn f() { p.FLASH.cr().write(|w| w); }",
        ] {
            let text = match text.contains("self") {
                true => format!("impl S {{ {text} }}"),
                false => text.to_owned(),
            };
            let found = writes("src/board/flash.rs", &text);
            assert_eq!(found.len(), 1, "{text}: {found:?}");
            assert!(found[0].contains("flash.cr().write"), "{found:?}");
        }
    }

    #[test]
    fn registers_that_are_0_after_reset_and_whole_values_with_a_reason_are_not() {
        for text in [
            "fn f() { rcc.cfgr().write(|w| w); }",
            "fn f() { tim.sr().write(|w| w); timer.sr(); flash.cr().modify(|_, w| w); }",
            "fn f() { flash.sr().write(|w| w); pwr.csr().modify(|r, w| w); }",
            "fn f() {\n// Not from the reset value: all of it.\nflash.cr().write(|w| w);\n}",
            "fn f() {\n// All of it, the reset value, too.\n// SAFETY: any.\nflash\n.cr()\n.write(|w| w);\n}",
            "fn f() { memory.write(k, word); port.write(bytes); }",
        ] {
            let found = writes("src/board/a.rs", text);
            assert!(found.is_empty(), "{text}: {found:?}");
        }
        // A reason holds for one statement.
        let text =
            "fn f() {\n// The reset value.\nflash.cr().write(|w| w);\nflash.cr().write(|w| w);\n}";
        assert_eq!(writes("src/board/a.rs", text).len(), 1);
    }

    #[test]
    fn a_reset_value_is_read_from_the_register_crate() {
        let of =
            |body: &str| of_crate("cr", &format!("impl crate::Resettable for CRrs {{{body}}}"));
        let set = of("\n    const RESET_VALUE: u32 = 0x8000_0000;\n");
        assert_eq!(set.as_deref(), Some("cr"));
        assert_eq!(of(""), None);
    }
}
