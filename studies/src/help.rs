//! The commands of `cargo study` in groups, with examples.

use host_sim::commands::help::Texts;

/// Texts of `cargo study`.
pub const STUDY: Texts = Texts {
    program: "cargo study",
    groups: &[
        (
            "Accuracy",
            &[
                "accuracy",
                "sequences",
                "guard",
                "drives",
                "capability",
                "table1",
                "compare",
                "coherent",
            ],
        ),
        ("Faults and endurance", &["faults", "shift", "soak"]),
        ("Tuned numbers", &["params", "ablate", "fit"]),
        ("The image", &["budget", "bench", "snr", "twins", "sbom"]),
        ("Documents", &["hardware", "reasons"]),
    ],
    examples: include_str!("examples.txt"),
};
