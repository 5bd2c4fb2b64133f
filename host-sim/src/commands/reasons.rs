//! `reasons`: prints the table of reasons, as in docs/reasons.md.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;
use stairscan::verdict::{Reason, ReasonEffect};

use super::emit;

/// Heading and introduction of the page.
const HEAD: &str = "\
# Reasons

Made by `cargo sim reasons` from the one table of them, [`src/verdict/reasons.rs`](../src/verdict/reasons.rs).
What they mean stands in the [README](../README.md#what-comes-out-and-what-to-do-with-it), the C header and `--help`.
A status is decided by [`src/verdict/status.rs`](../src/verdict/status.rs) from plain values, and by no reason.
Names in the conditions are those of [parameters.md](parameters.md) and [hardware.md](hardware.md#settings).

| effect | on the answer |
|---|---|
| **fault** | there is none |
| **doubt** | about the instrument: `degraded`, with a horizon and a confidence of 0 |
| **degraded** | `degraded`, with its horizon |
| **word** | none: for people and logs, also beside `ok` |

A reason with two effects has a condition for each.

";

/// Prints the page.
pub fn run() -> Result<ExitCode> {
    emit(&page());
    Ok(ExitCode::SUCCESS)
}

/// Returns the page: each reason with its effect and its condition.
fn page() -> String {
    let mut out = format!("{HEAD}| reason | effect | told when |\n|---|---|---|\n");
    for reason in Reason::ALL {
        let effects: Vec<&str> = (reason.effects().iter())
            .map(|effect: &ReasonEffect| effect.as_str())
            .collect();
        let _ = writeln!(
            out,
            "| `{}` | {} | {} |",
            reason.as_str(),
            effects.join(", "),
            reason.condition()
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_document_holds_the_table() {
        let document = include_str!("../../../docs/reasons.md");
        assert!(document == page(), "sh docs/make reasons");
    }
}
