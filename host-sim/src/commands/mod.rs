//! The program's commands, one module each.

pub mod profile;
pub mod replay;
pub mod score;

use anyhow::Result;
use clap::ValueEnum;
use stairscan::config::{Config, EstimatorKind};

use crate::replay::Options;

/// How results are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    #[default]
    Text,
    /// For programs; nothing else goes to stdout.
    Json,
}

/// What can be chosen for every scan.
#[derive(clap::Args, Clone, Debug)]
pub struct Settings {
    /// From map to steps: `paper`, ...
    #[arg(long, value_parser = parse_estimator, default_value = EstimatorKind::default().as_str())]
    estimator: EstimatorKind,
    /// Seed of the particles' random numbers
    #[arg(long, default_value_t = 1)]
    seed: u32,
}

fn parse_estimator(name: &str) -> Result<EstimatorKind, String> {
    let names: Vec<&str> = EstimatorKind::ALL.iter().map(|k| k.as_str()).collect();
    EstimatorKind::from_name(name).ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

impl Settings {
    /// The configuration on top of which a recording brings its own values.
    pub fn config(&self) -> Result<Config> {
        Ok(Config {
            estimator: self.estimator,
            seed: self.seed,
            ..Config::default()
        })
    }

    /// How to scan.
    pub fn options(&self, config: Config) -> Options {
        Options {
            config,
            ..Options::default()
        }
    }

    /// Name of the chosen estimator.
    pub fn estimator_name(&self) -> &'static str {
        self.estimator.as_str()
    }

    /// The first seed.
    pub fn seed(&self) -> u32 {
        self.seed
    }
}
