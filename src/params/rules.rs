//! Rules of the estimator, and how each is disabled to measure its effect.
//!
//! A rule that a number expresses is disabled by the value at which it has no effect; every other rule has a switch.
//! `cargo study ablate` disables them one at a time and counts the changes
//! ([docs/generated/ablation.md](../../docs/generated/ablation.md)).

use super::switches::Rules;
use super::table::Params;

/// A value that no measured quantity reaches.
const NEVER: f32 = 1e9;

/// A rule and how it is disabled.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Stage of the estimator to which it belongs.
    pub group: &'static str,
    /// Name.
    pub name: &'static str,
    /// Effect of the rule.
    pub meaning: &'static str,
    off: Off,
}

#[derive(Clone, Copy, Debug)]
enum Off {
    Switch(fn(&mut Rules)),
    Number(fn(&mut Params)),
}

impl Rule {
    /// Disables the rule.
    pub fn turn_off(&self, params: &mut Params) {
        match self.off {
            Off::Switch(off) => off(&mut params.rules),
            Off::Number(off) => off(params),
        }
    }
}

/// Returns all rules between echoes and status.
pub fn rules() -> impl Iterator<Item = Rule> {
    let switches = Rules::SWITCHES.iter();
    let switches = switches.map(|switch| Rule {
        group: switch.group,
        name: switch.name,
        meaning: switch.meaning,
        off: Off::Switch(switch.turn_off),
    });
    switches.chain(NUMBERS.iter().copied())
}

/// Makes the list of the rules that are disabled by a number.
macro_rules! numbers {
    ($( #[doc = $meaning:literal] $name:ident in $group:literal: |$p:ident| $off:expr; )*) => {
        /// Rules that are disabled by a number.
        const NUMBERS: &[Rule] = &[
            $(Rule {
                group: $group,
                name: stringify!($name),
                meaning: $meaning,
                off: Off::Number(|$p| $off),
            },)*
        ];
    };
}

numbers! {
    /// Weak echoes have less weight.
    credibility in "scene": |p| p.least_credibility = 1.0;
    /// A corner stronger than the ground before it may begin a flight.
    corner_begins in "scene": |p| p.corner_least_db = NEVER;
    /// Flights may contain landings.
    landings in "search": |p| p.longest_landing_m = 0.0;
    /// A single riser behind a landing costs more.
    lone_riser in "search": |p| p.lone_nats = 0.0;
    /// Echoes standing on a tread cost.
    clutter in "roles": |p| p.clutter_nats = 0.0;
    /// Echoes inside the solid cost.
    inside in "roles": |p| p.inside_nats = 0.0;
    /// Echoes above a riser cost.
    above in "roles": |p| p.above_nats = 0.0;
    /// A corner stronger than its tread gains.
    bright_corner in "roles": |p| p.bright_corner_nats = 0.0;
    /// Unexplained echoes cost.
    stray in "roles": |p| p.stray_nats = 0.0;
    /// A visible corner that is missing costs.
    no_corner in "roles": |p| p.no_corner_nats = 0.0;
    /// An edge that is missing costs.
    no_edge in "roles": |p| p.no_edge_nats = 0.0;
    /// A single riser that is too low is a threshold.
    lowest_step in "choice": |p| p.lowest_step_m = 0.0;
    /// A single riser that is too high is an obstacle.
    highest_step in "choice": |p| p.highest_step_m = NEVER;
    /// Any one riser or tread may be irregular.
    odd_step in "heights": |p| p.odd_rise_sigma_m = 1e-4;
    /// Reported standard deviations of heights exceed the model's.
    height_scale in "heights": |p| p.height_sigma_scale = 1.0;
    /// A credible echo on neither line costs.
    nosing_stray in "places": |p| p.nosing_stray_nats = 0.0;
    /// Calibration removes the shaft's angle bias.
    angle_bias in "calibration": |p| p.angle_bias_sigma_rad = 1e-6;
    /// Calibration removes the mount height's error.
    mount_height in "calibration": |p| p.mount_height_sigma_m = 1e-6;
    /// Calibration: echoes off the floor have less weight.
    cauchy in "calibration": |p| p.floor_cauchy_sigmas = 1e6;
    /// Calibration: corners have more weight than speckle.
    floor_corner in "calibration": |p| p.floor_corner_db = NEVER;
    /// A calibration with large corrections shows a wrong mounting.
    strain in "mount": |p| p.calibration_strain = NEVER;
    /// A floor supported better elsewhere shows a wrong mounting.
    floor_elsewhere in "mount": |p| p.floor_elsewhere_nats = NEVER;
    /// Lobes that are too narrow show wrong mirror angles.
    lobes_narrow in "mount": |p| p.beam_narrow = 0.0;
    /// Lobes that are too broad show wrong mirror angles.
    lobes_broad in "mount": |p| p.beam_broad = NEVER;
    /// A few lobes that are far too broad show wrong mirror angles.
    lobes_few in "mount": |p| p.beam_broad_few = NEVER;
}
