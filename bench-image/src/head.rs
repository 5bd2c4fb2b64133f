//! Header of each scan in the file of chirps: the part of its configuration that recordings contain.

use stairscan::config::{Config, Planes};

/// Maximum number of rows of a guard sweep; a scan has more.
pub const MAX_SWEEP_ROWS: u16 = 64;

/// Size of a header, bytes.
pub const SIZE: usize = 32;

/// Returns the header of a scan of `config`: eight little-endian words.
pub fn encode(config: &Config) -> [u8; SIZE] {
    let words = [
        config.radar.bandwidth_khz,
        u32::from(config.radar.samples) | u32::from(config.radar.real) << 16,
        config.mount.mirror_offset as u32,
        config.mount.mount_height as u32,
        config.mount.beamwidth as u32,
        u32::from(config.mount.plane == Planes::Height),
        config.sweep.first_angle as u32,
        config.sweep.angle_step as u32 | u32::from(config.sweep.angle_count) << 16,
    ];
    let mut bytes = [0; SIZE];
    for (to, word) in bytes.chunks_exact_mut(4).zip(words) {
        to.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// Returns the configuration of a scan with this header, with defaults for the rest.
pub fn decode(bytes: &[u8; SIZE]) -> Config {
    let (words, _) = bytes.as_chunks::<4>();
    let word = |k: usize| words.get(k).map_or(0, |&w| u32::from_le_bytes(w));
    let mut config = Config::default();
    config.radar.bandwidth_khz = word(0);
    config.radar.samples = word(1) as u16;
    config.radar.real = word(1) >> 16 != 0;
    config.mount.mirror_offset = word(2) as i32;
    config.mount.mount_height = word(3) as i32;
    config.mount.beamwidth = word(4) as i32;
    config.mount.plane = if word(5) == 0 {
        Planes::Depth
    } else {
        Planes::Height
    };
    config.sweep.first_angle = word(6) as i32;
    config.sweep.angle_step = (word(7) & 0xffff) as i32;
    config.sweep.angle_count = (word(7) >> 16) as u16;
    config
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut config = Config::default();
        config.mount.plane = Planes::Height;
        config.sweep.first_angle = -12_345;
        config.radar.real = true;
        assert_eq!(decode(&encode(&config)), config);
    }
}
