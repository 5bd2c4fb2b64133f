//! Encodes echoes and particles as numpy's structured arrays: little-endian, packed, in the order of the fields. The
//! dtypes are defined in `package/stairscan/_types.py`; numpy refuses bytes of another length.

use stairscan::model::{GroundKind, Staircase};
use stairscan::observer::trace::Scatterer;

/// Number of letters of a text field (numpy's `U12`).
const LETTERS: usize = 12;

/// Appends a text, four bytes a letter.
fn word(bytes: &mut Vec<u8>, text: &str) {
    let letters = text.chars().map(u32::from).chain(std::iter::repeat(0));
    letters
        .take(LETTERS)
        .for_each(|letter| bytes.extend(letter.to_le_bytes()));
}

fn floats(bytes: &mut Vec<u8>, values: &[f32]) {
    values
        .iter()
        .for_each(|value| bytes.extend(value.to_le_bytes()));
}

/// Appends an echo with its role under the best hypothesis.
pub fn echo(bytes: &mut Vec<u8>, scatterer: &Scatterer) {
    let e = &scatterer.echo;
    floats(
        bytes,
        &[
            e.x_m,
            e.y_m,
            e.range_m,
            e.range_sigma_m,
            e.angle_rad,
            e.angle_sigma_rad,
            e.snr_db,
            e.width,
        ],
    );
    word(bytes, scatterer.role.as_str());
    bytes.push(scatterer.role.contradicts().into());
}

/// Appends a particle: a staircase or another kind of ground, and its probability.
pub fn particle(bytes: &mut Vec<u8>, staircase: &Staircase, probability: f32) {
    let (kind, at_m, slope) = match staircase.kind {
        GroundKind::Nothing => ("nothing", f32::NAN, f32::NAN),
        GroundKind::Ramp { from_m, slope } => ("ramp", from_m, slope),
        GroundKind::Drop { at_m } => ("drop", at_m, f32::NAN),
        GroundKind::Stairs => ("stairs", f32::NAN, f32::NAN),
        GroundKind::Descent => ("descent", f32::NAN, f32::NAN),
        GroundKind::Box => ("box", f32::NAN, f32::NAN),
        GroundKind::Threshold => ("threshold", f32::NAN, f32::NAN),
    };
    floats(bytes, &[probability]);
    word(bytes, kind);
    bytes.push(staircase.steps);
    bytes.push(staircase.open.into());
    floats(
        bytes,
        &[staircase.overhang_m, staircase.wall_m, at_m, slope],
    );
    for values in [&staircase.x_m, &staircase.top_m] {
        for (k, value) in values.iter().enumerate() {
            let risen = k < usize::from(staircase.steps);
            floats(bytes, &[if risen { *value } else { f32::NAN }]);
        }
    }
}
