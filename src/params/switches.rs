//! Switches of the estimator's rules that cannot be disabled by a number.

use crate::verdict::Reasons;

/// Switch of a rule.
#[derive(Clone, Copy, Debug)]
pub struct RuleSwitch {
    /// Stage of the estimator to which the rule belongs.
    pub group: &'static str,
    /// Name of the rule.
    pub name: &'static str,
    /// Effect of the rule, one sentence.
    pub meaning: &'static str,
    /// Returns whether the rule is enabled.
    pub is_on: fn(&Rules) -> bool,
    /// Disables the rule.
    pub turn_off: fn(&mut Rules),
    /// Offset of the switch in [`Rules`], bytes; equal on host and chip.
    pub offset: usize,
}

/// Makes the switches and their list.
macro_rules! switches {
    ($( $(#[doc = $meaning:literal])* $name:ident in $group:literal; )*) => {
        /// Switches of the rules that cannot be disabled by a number; all are enabled in the released firmware.
        #[derive(Clone, Debug, PartialEq)]
        #[repr(C)]
        pub struct Rules {
            $( $(#[doc = $meaning])* pub $name: bool, )*
            /// Reasons about the instrument that are ignored.
            pub muted: Reasons,
        }

        impl Rules {
            /// All rules enabled.
            pub const ALL: Self = Self { $($name: true,)* muted: Reasons::NONE };

            /// All switches, in the order of the fields.
            pub const SWITCHES: &[RuleSwitch] = &[
                $(RuleSwitch {
                    group: $group,
                    name: stringify!($name),
                    meaning: concat!($($meaning),*),
                    is_on: |rules| rules.$name,
                    turn_off: |rules| rules.$name = false,
                    offset: core::mem::offset_of!(Self, $name),
                },)*
            ];
        }
    };
}

switches! {
    /// One face between two may be undetected.
    skipped_face in "search";
    /// Walls behind a flight are tried.
    walls_behind in "choice";
    /// Particles: ramps that are too steep for the ground.
    ramp_particles in "particles";
    /// Particles: a flight without its last steps.
    less in "particles";
    /// Particles: one irregular rise.
    odd in "particles";
    /// Particles: one more riser behind the last.
    behind in "particles";
    /// Particles: steps, boxes and thresholds on bare ground.
    single in "particles";
    /// Particles: ground that ends.
    drops in "particles";
    /// The best flight is also evaluated in the other build, open or closed.
    other_build in "choice";
    /// Overhangs are tried besides the measured one.
    overhang_starts in "choice";
    /// A flash masks the echo of a corner or an edge beside it.
    masks in "heights";
    /// Nosings are located by the two vertical lines of nosing and riser.
    nosing_lines in "places";
    /// No horizon ends next to a step.
    clear_of_steps in "horizon";
    /// No horizon reaches a step whose expanded uncertainty is larger than 8 cm.
    measured_to in "horizon";
    /// The first corner off the floor's level shows a wrong mounting.
    corner_astray in "mount";
}
