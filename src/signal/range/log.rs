//! Binary logarithm of integers in 1/256 octave, by table and count-leading-zeros.

/// Entry k: 256 · log2(1 + k / 64), rounded, for k = 0…64.
static MANTISSA: [u16; 65] = mantissa_table(0.0);

/// Entry k: 256 · log2(1 + (k + ½) / 64), rounded, for k = 0…63: the value at the middle of each interval, for
/// a look-up without interpolation.
static MIDDLE: [u8; 64] = {
    let full = mantissa_table(0.5);
    let mut table = [0; 64];
    let mut k = 0;
    while k < 64 {
        table[k] = full[k] as u8;
        k += 1;
    }
    table
};

const fn mantissa_table(offset: f32) -> [u16; 65] {
    let mut table = [0; 65];
    let mut k = 0;
    while k <= 64 {
        let x = 1.0 + (k as f32 + offset) / 64.0;
        table[k] = (256.0 * crate::math::log2(x) + 0.5) as u16;
        k += 1;
    }
    table
}

/// Returns 256 · log2(x), within ±1; -256 for 0.
#[inline]
pub fn log2_fine(x: u32) -> i32 {
    if x == 0 {
        return -256;
    }
    let zeros = x.leading_zeros();
    let normal = x << zeros;
    let k = (normal >> 25 & 63) as usize;
    let fraction = (normal >> 9 & 0xffff) as i32;
    let (low, high) = match MANTISSA.get(k..k + 2) {
        Some(&[low, high]) => (i32::from(low), i32::from(high)),
        _ => (0, 0),
    };
    (31 - zeros as i32) * 256 + low + (((high - low) * fraction + 0x8000) >> 16)
}

/// Returns 256 · log2(x), within ±4: one look-up, for cells of 1/8 octave. 0 is treated as 1.
#[inline(always)]
pub fn log2_coarse(x: u32) -> i32 {
    let zeros = (x | 1).leading_zeros();
    let k = (x << zeros >> 25 & 63) as usize;
    (31 - zeros as i32) * 256 + MIDDLE.get(k).map_or(0, |&m| i32::from(m))
}

/// Cell value of a tone at the converter's full scale, map units of 1/8 octave.
pub const FULL_SCALE: u8 = 247;

/// Number of 1/256 octaves in one map unit of 1/8 octave.
pub const FINE: i32 = 32;

/// Returns a logarithmic power, 1/256 octave above the map's zero, rounded to a cell's value (1/8 octave, 0 to
/// 255).
#[inline(always)]
pub fn to_cell(fine: i32) -> u8 {
    ((fine + FINE / 2) >> 5).clamp(0, 255) as u8
}

/// Writes the cell values of `power` to `cells`: its logarithm plus `offset` (both 1/256 octave), rounded.
///
/// Not inlined: inlined, its loop is compiled for its surroundings (2,699 instructions for 231 cells become
/// 3,566 in `bench`).
#[inline(never)]
pub fn fill_cells(power: &[u32], offset: i32, cells: &mut [u8]) {
    for (cell, &p) in cells.iter_mut().zip(power) {
        *cell = to_cell(log2_coarse(p) + offset);
    }
}

/// Returns 256 · log2(x) of a 64-bit number, within ±1; -256 for 0.
pub fn log2_wide(x: u64) -> i32 {
    let excess = 32u32.saturating_sub(x.leading_zeros());
    log2_fine((x >> excess) as u32) + 256 * excess as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn within_the_stated_error(shift in 0u32..32, noise in 0u32..=u32::MAX) {
            let x = (noise >> shift).max(1);
            let exact = f64::from(x).log2() * 256.0;
            prop_assert!((f64::from(log2_fine(x)) - exact).abs() <= 1.0);
            prop_assert!((f64::from(log2_coarse(x)) - exact).abs() <= 4.0);
        }

        #[test]
        fn wide_within_the_stated_error(shift in 0u32..64, noise in 0u64..=u64::MAX) {
            let x = (noise >> shift).max(1);
            prop_assert!((f64::from(log2_wide(x)) - (x as f64).log2() * 256.0).abs() <= 1.0);
        }
    }

    #[test]
    fn nothing_lies_below_zero() {
        assert_eq!(log2_fine(0), -256);
        assert_eq!(log2_coarse(0), log2_coarse(1));
    }
}
