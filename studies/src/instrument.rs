//! Options of `table1` and `accuracy` for another radar module than the scenes'.

use std::fmt::Write as _;

use host_sim::scene::spec::SceneSpec;

/// Omitted values are those of the scenes.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Instrument {
    /// Centre frequency of every scene's chirp, GHz
    #[arg(long, value_name = "GHZ", value_parser = above_nothing)]
    carrier: Option<f64>,
    /// Bandwidth between the first and the last sample of a chirp, GHz
    #[arg(long, value_name = "GHZ", value_parser = above_nothing)]
    bandwidth: Option<f64>,
    /// Complex samples of a chirp
    #[arg(long, value_parser = clap::value_parser!(u16).range(16..=256))]
    samples: Option<u16>,
    /// Two-sided 3 dB width of the beam leaving the mirror, degrees
    #[arg(long, value_name = "DEG", value_parser = above_nothing)]
    beamwidth: Option<f64>,
}

fn above_nothing(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok();
    value
        .filter(|v| (1e-3..1e3).contains(v))
        .ok_or_else(|| "expected 0.001 to 1000".into())
}

impl Instrument {
    /// Replaces, in the scene `spec`, the properties of radar module and beam that were given as options; the others
    /// stay.
    pub fn apply(&self, spec: &mut SceneSpec) {
        let Self {
            carrier,
            bandwidth,
            samples,
            beamwidth,
        } = *self;
        let radar = &mut spec.radar;
        radar.carrier_hz = carrier.map_or(radar.carrier_hz, |ghz| 1e9 * ghz);
        radar.bandwidth_hz = bandwidth.map_or(radar.bandwidth_hz, |ghz| 1e9 * ghz);
        radar.samples_per_chirp = samples.map_or(radar.samples_per_chirp, usize::from);
        spec.mount.beamwidth_deg = beamwidth.unwrap_or(spec.mount.beamwidth_deg);
    }

    /// Returns those of the options that were given as command-line text, each after a space.
    pub fn options(&self) -> String {
        let mut out = String::new();
        for (name, value) in [
            ("carrier", self.carrier),
            ("bandwidth", self.bandwidth),
            ("samples", self.samples.map(f64::from)),
            ("beamwidth", self.beamwidth),
        ] {
            if let Some(value) = value {
                let _ = write!(out, " --{name} {value}");
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_is_put_before_the_scene() {
        let mut spec = SceneSpec::default();
        let other = Instrument {
            bandwidth: Some(5.233),
            samples: Some(256),
            ..Instrument::default()
        };
        other.apply(&mut spec);
        assert_eq!(
            (spec.radar.bandwidth_hz, spec.radar.samples_per_chirp),
            (5.233e9, 256)
        );
        assert_eq!(spec.radar.carrier_hz, SceneSpec::default().radar.carrier_hz);
        assert_eq!(other.options(), " --bandwidth 5.233 --samples 256");
        let mut same = SceneSpec::default();
        Instrument::default().apply(&mut same);
        assert_eq!(same, SceneSpec::default());
        assert_eq!(Instrument::default().options(), "");
    }
}
