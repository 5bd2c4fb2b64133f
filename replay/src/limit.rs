//! The controller's speed limit, as in `controller/stairscan.h`: free distance in, maximum speed
//! out.
//!
//! Chairs use the C function. This one serves drives on the host. A test of the C sources compares
//! the two.

/// Properties of a chair that its controller assumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Brakes {
    /// Maximum time from the computation of the speed limit until the next cycle's command takes
    /// effect, ms.
    pub latency_ms: u32,
    /// Minimum deceleration when the chair brakes, mm/s².
    pub deceleration_mm_s2: u32,
    /// Maximum age of a free distance, ms; with an older one the chair must stop.
    pub max_age_ms: u32,
}

/// Free distance ahead of a chair, with its age and the speed since.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreeAhead {
    /// Free distance before the chair's foremost point, mm.
    pub free_mm: u32,
    /// Time since the free distance was measured, ms.
    pub age_ms: u32,
    /// Maximum forward speed over the last `age_ms` plus latency, mm/s.
    pub max_speed_mm_s: u32,
}

/// Returns the maximum speed `v`, mm/s, for which `fastest · age + max(fastest, v) · latency + v² /
/// (2 · deceleration) ≤ free`, where `fastest` is [`FreeAhead::max_speed_mm_s`]. Returns 0 if there
/// is no such speed, if the age is above the maximum, or if the deceleration is 0.
pub fn max_speed(ground: &FreeAhead, chair: &Brakes) -> u32 {
    let wide = u128::from;
    // Both sides in micrometres times the deceleration.
    let stops = |speed: u32| {
        let reaction = wide(ground.max_speed_mm_s.max(speed)) * wide(chair.latency_ms);
        let way = wide(ground.max_speed_mm_s) * wide(ground.age_ms) + reaction;
        let brake = wide(chair.deceleration_mm_s2);
        way * brake + 500 * wide(speed) * wide(speed) <= 1000 * wide(ground.free_mm) * brake
    };
    if ground.age_ms > chair.max_age_ms || chair.deceleration_mm_s2 == 0 {
        return 0;
    }
    let bits = (0..u32::BITS).rev().map(|bit| 1 << bit);
    bits.fold(0, |limit, bit| match stops(limit | bit) {
        true => limit | bit,
        false => limit,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHAIR: Brakes = Brakes {
        latency_ms: 200,
        deceleration_mm_s2: 1000,
        max_age_ms: 100,
    };

    #[test]
    fn the_limits_are_those_of_the_page() {
        let limit = |free_mm, age_ms, max_speed_mm_s| {
            let ground = FreeAhead {
                free_mm,
                age_ms,
                max_speed_mm_s,
            };
            max_speed(&ground, &CHAIR)
        };
        // docs/user/controller.md, first and last column.
        assert_eq!(
            [50, 300, 1000].map(|free| limit(free, 0, 0)),
            [174, 600, 1228]
        );
        assert_eq!(
            [50, 300, 1000].map(|free| limit(free, 100, 500)),
            [0, 534, 1192]
        );
        assert_eq!(limit(1000, 101, 0), 0);
    }
}
