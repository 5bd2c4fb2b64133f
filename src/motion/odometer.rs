//! Errors of the chair's odometer, and the maximum distance between two sweeps' echoes of one scatterer.

use crate::params::motion::{ODOMETER_SCALE_ERROR, SAME_PLACE_M};

/// Returns the maximum distance between two sweeps' echoes of one scatterer after `moved_m` metres of travel by
/// odometry, metres: [`SAME_PLACE_M`] plus one and a half times the scale error.
pub fn same_place_m(moved_m: f32) -> f32 {
    const SHARE: f32 = 1.5 * ODOMETER_SCALE_ERROR;
    SAME_PLACE_M + SHARE * moved_m.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sweeps_tolerance_grows_by_three_per_cent_of_the_way() {
        for moved_m in [0.0, 0.05, -0.4, 3.0f32] {
            let expected = 0.012 + 0.03 * moved_m.abs();
            assert_eq!(same_place_m(moved_m).to_bits(), expected.to_bits());
        }
    }
}
