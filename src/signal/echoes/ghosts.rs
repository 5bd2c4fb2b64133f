//! Artefacts of a strong echo: one function per artefact, which returns its maximum level relative to the echo,
//! dB.

use super::echo::Echo;
use super::lobe::GAUSSIAN_DB;
use crate::math;
use crate::params::Params;

/// Level of an artefact that cannot occur at this range and angle, dB relative to the echo: below the dynamic range of
/// any receiver.
const NEVER_DB: f32 = -99.0;

/// A maximum of the filtered map that may be a ghost: an artefact of a stronger echo.
#[derive(Clone, Copy, Debug)]
pub struct Suspect {
    /// Range from the radar (not from the mirror), native range bins of c/2B.
    pub native_bin: f32,
    /// Angle of the beam, radians: below the horizontal (depth plane), or forward from straight down (height plane).
    pub angle_rad: f32,
    /// SNR: filtered power over the median of the filtered map, dB.
    pub snr_db: f32,
    /// Whether enough rows around it have a CA-CFAR detection, so that it is distinct from its surroundings in
    /// range.
    pub stands_out: bool,
}

/// Maximum levels of the instrument's artefacts around an echo: side lobes, range skirt, phase noise, I/Q
/// image.
#[derive(Clone, Copy, Debug)]
pub struct Ghosts<'p> {
    /// Parameters, among them the levels of the artefacts.
    pub params: &'p Params,
    /// Standard deviation in angle of a point scatterer's lobe, radians.
    pub lobe_sigma_rad: f32,
    /// Sum of the native bins of an echo and of its image at the negative frequency: the number of samples of a
    /// chirp; infinite for real samples, which have no image.
    pub image_sum: f32,
}

impl Ghosts<'_> {
    /// Returns whether an artefact of `echo`, at the suspect's range and angle, can be as strong as the suspect.
    pub fn explain(&self, echo: &Echo, suspect: &Suspect) -> bool {
        let bins = (suspect.native_bin - echo.native_bin).abs();
        let turn = (suspect.angle_rad - echo.angle_rad) / self.lobe_sigma_rad;
        let lobe_db = -GAUSSIAN_DB * turn * turn;
        let artefacts = [
            self.antenna_db(bins, lobe_db),
            self.range_skirt_db(bins, lobe_db),
            self.oscillator_noise_db(bins, lobe_db, suspect.stands_out),
            self.iq_image_db(suspect.native_bin + echo.native_bin, lobe_db),
        ];
        let highest = artefacts.into_iter().fold(NEVER_DB, math::max);
        suspect.snr_db - echo.snr_db < highest
    }

    /// Returns the maximum level, dB relative to the echo, of its lobe over the angle: main lobe of the beam, or
    /// two-way side lobes at any angle. They lie at the echo's range: `bins` is the suspect's distance from it, native
    /// bins; `lobe_db` is the level of the echo's filtered main lobe at the suspect's angle, dB relative to its peak.
    fn antenna_db(&self, bins: f32, lobe_db: f32) -> f32 {
        let p = self.params;
        if bins >= p.range_lobe_bins {
            return NEVER_DB;
        }
        let pattern_db = math::max(lobe_db + p.main_lobe_margin_db, -p.side_lobe_db);
        pattern_db - p.range_curvature_db * bins * bins
    }

    /// Returns the maximum level, dB relative to the echo, of the skirt over the range of a chirp that is not exactly
    /// linear. It lies in the echo's beam (`lobe_db`: level of the echo's filtered main lobe at the suspect's angle)
    /// and near its range (`bins`: the suspect's distance from it, native bins).
    fn range_skirt_db(&self, bins: f32, lobe_db: f32) -> f32 {
        if bins > self.params.skirt_bins {
            return NEVER_DB;
        }
        lobe_db + self.params.same_beam_margin_db - self.params.skirt_db
    }

    /// Returns the maximum level of the oscillator's phase noise, dB relative to the echo: at every range beyond the
    /// skirt, in the echo's beam (`lobe_db`: level of the echo's filtered main lobe at the suspect's angle). It raises
    /// whole stretches of range, so it does not explain a maximum that is distinct from its surroundings
    /// (`stands_out`).
    fn oscillator_noise_db(&self, bins: f32, lobe_db: f32, stands_out: bool) -> f32 {
        if bins <= self.params.skirt_bins || stands_out {
            return NEVER_DB;
        }
        lobe_db + self.params.same_beam_margin_db - self.params.oscillator_noise_db
    }

    /// Returns the maximum level of the image that an I/Q imbalance makes of the echo at the negative frequency, dB
    /// relative to the echo. `sum_of_bins` is the sum of the native bins of echo and suspect: if the suspect is the
    /// image, it is the number of samples of a chirp.
    fn iq_image_db(&self, sum_of_bins: f32, lobe_db: f32) -> f32 {
        if (sum_of_bins - self.image_sum).abs() >= self.params.image_bins {
            return NEVER_DB;
        }
        lobe_db + self.params.same_beam_margin_db - self.params.iq_image_db
    }
}
