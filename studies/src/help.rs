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
            ],
        ),
        ("Faults and endurance", &["faults", "soak"]),
        ("Tuned numbers", &["params", "ablate", "fit"]),
        ("The image", &["budget", "bench", "snr", "twins", "sbom"]),
        ("Documents", &["hardware", "reasons"]),
    ],
    examples: &[
        ("accuracy", &["accuracy --draw tuning --list"]),
        ("sequences", &["sequences"]),
        ("guard", &["guard --list", "guard --draw reporting"]),
        ("drives", &["drives --list", "drives --draw reporting"]),
        ("sbom", &["sbom", "sbom crates"]),
        (
            "capability",
            &[
                "capability --body post --scenes 10",
                "capability --draw reporting -o capability.html",
            ],
        ),
        (
            "faults",
            &["faults --scenes 1", "faults --guard --scenes 1"],
        ),
        ("soak", &["soak --scans 1000 --seed 1", "soak --days 30"]),
        ("table1", &["table1", "table1 --estimator paper"]),
        ("ablate", &["ablate", "ablate clear_of_steps --scenes 20"]),
        ("compare", &["compare before.jsonl after.jsonl"]),
        ("params", &["params", "params --sensitivity"]),
        (
            "hardware",
            &["hardware power", "hardware wiring -o wiring.svg"],
        ),
        ("reasons", &["reasons"]),
        ("fit", &["fit --force", "fit -o hazards.rs"]),
        (
            "budget",
            &["budget recordings/stair_a recordings/descending"],
        ),
        ("bench", &["bench"]),
        ("snr", &["snr"]),
        ("twins", &["twins"]),
    ],
};
