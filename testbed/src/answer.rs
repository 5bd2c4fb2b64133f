//! Assessments of scans that a test does not compute.

use stairscan::drive::Agreement;
use stairscan::verdict::{Assessment, Validity};

/// Returns the assessment of an answer that is `ok` under good conditions.
pub fn sure() -> Assessment {
    Assessment {
        echo_found: true,
        valid: Some(Validity {
            horizon_m: 2.0,
            confidence: 0.999,
            first_step: 1.0,
        }),
        ..Assessment::nothing(Agreement::STANDING)
    }
}
