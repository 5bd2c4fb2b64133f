//! `reasons`: prints the table of reasons, as in docs/reasons.md.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;
use stairscan::verdict::{Reason, ReasonEffect};

use super::emit;

/// Heading and introduction of docs/reasons.md.
const HEAD: &str = "# Reasons

Made by `cargo study reasons` from the table [`src/verdict/reasons.rs`](../src/verdict/reasons.rs).
[`src/verdict/status.rs`](../src/verdict/status.rs) decides the status from plain values, not from reasons.
Names in the conditions are those of [parameters.md](generated/parameters.md) and [hardware.md](user/hardware.md#settings).

| effect | on the answer |
|---|---|
| **fault** | no answer |
| **instrument** | failed health check: `degraded`, with a horizon and a confidence of 0 |
| **degraded** | `degraded`, with its horizon |
| **info** | none: information for people and logs, also with `ok` |

A reason with two effects has a condition for each.

";

/// Prints docs/reasons.md.
pub fn run() -> Result<ExitCode> {
    emit(&page());
    Ok(ExitCode::SUCCESS)
}

/// Returns docs/reasons.md: each reason with its meaning, its effect on the answer and its condition.
fn page() -> String {
    let mut out = format!("{HEAD}| reason | means | effect | condition |\n|---|---|---|---|\n");
    for reason in Reason::ALL {
        let effects: Vec<&str> = (reason.effects().iter())
            .map(|effect: &ReasonEffect| effect.as_str())
            .collect();
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} |",
            reason.as_str(),
            reason.meaning(),
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
