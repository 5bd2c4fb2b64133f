//! Tuned numbers of the default estimator, in the order of the stages that use them.

use super::entry::{Entry, Origin, params};
use super::posterior;
use super::switches::Rules;
use crate::math::{self, RAD_PER_DEG};

params! {
    "echoes" {
        /// Extent of an echo's own lobe in range, native bins.
        range_lobe_bins = 2.0, "", Derived, "Hann window: first zero at two bins";
        /// Maximum power above the noise of noise alone in a whole scan.
        sure_echo_db = 1.7, "dB", Derived, "an image holds some 5,000 independent places: noise exceeds it once in a million scans";
    }
    "echoes: calibration on the floor" {
        /// Standard deviation of the shaft's angle bias.
        angle_bias_sigma_rad = 0.25 * RAD_PER_DEG, "rad", Derived, "one step of the scan";
        /// Standard deviation of the mount height.
        mount_height_sigma_m = 0.005, "m", Custom, "tyres and castors under load, as for `floor_near_steps`";
        /// Maximum height difference of an echo that may be floor.
        floor_reach_m = 0.03, "m", Derived, "a bias of 1 degree at 1.7 m";
        /// Minimum level of an echo used for the floor.
        floor_least_db = 8.0, "dB", Hand;
        /// Minimum level of a corner at the foot of a riser.
        floor_corner_db = 20.0, "dB", Hand;
        /// Maximum width of such a corner's lobe, in units of a point scatterer's.
        floor_corner_width = 1.15, "", Hand;
        /// Standard deviation of such a corner's angle.
        floor_corner_rad = 0.06 * RAD_PER_DEG, "rad", Hand;
        /// Standard deviation of such a corner's height.
        floor_corner_m = 0.001, "m", Hand;
        /// Minimum standard deviation of the angle of a floor echo.
        floor_speckle_rad = 0.15 * RAD_PER_DEG, "rad", Hand;
        /// Minimum standard deviation of the height of a floor echo.
        floor_speckle_m = 0.004, "m", Hand;
        /// Standard deviation of a floor echo's angle by noise at 0 dB.
        floor_noise_rad = 0.5 * RAD_PER_DEG, "rad", Derived, "bound for the beam in steps of 0.25 degrees: 0.55 over the root of the power ratio";
        /// Distance from the floor at which an echo has half weight, standard deviations.
        floor_cauchy_sigmas = 3.0, "", Hand;
        /// Maximum correction by the calibration on the floor: sum of the squares of angle bias and mount-height error, in standard deviations.
        calibration_strain = 3.0, "", Hand, "0.43 degrees of angle bias, or 9 mm of height";
    }
    "echoes: evidence for the configured floor" {
        /// Minimum distance of an echo that is evidence for the floor.
        floor_from_m = 0.2, "m", Hand;
        /// Maximum distance of an echo that is evidence for the floor.
        floor_to_m = 2.0, "m", Hand;
        /// Maximum height difference of an echo that is evidence for the floor.
        floor_astray_m = 0.25, "m", Derived, "a mount 12 cm off, and 4 degrees at 2 m";
        /// Height interval of the search for the floor.
        floor_height_step_m = 0.004, "m", Derived, "twice the error of a height";
        /// Slope interval of the search for the floor.
        floor_slope_step_rad = 0.25 * RAD_PER_DEG, "rad", Derived, "one step of the scan";
        /// Maximum height difference of a floor that confirms the mounting, height intervals: 8 mm.
        floor_near_steps = 2.0, "", Derived, "5 mm of tyres and castors, and a step";
        /// Maximum slope of a floor that confirms the mounting, slope intervals: 0.75 degrees.
        floor_tilt_steps = 3.0, "", Derived, "0.4 degrees of homing error and 0.1 of pitch, and a step";
        /// Maximum height difference of the search, height intervals: 9.6 cm.
        floor_far_steps = 24.0, "", Derived, "a mount 8 cm off, and 4 steps";
        /// Maximum slope of the search, slope intervals: 5 degrees.
        floor_steep_steps = 20.0, "", Derived, "4 degrees off, and 4 steps";
        /// Maximum log-likelihood ratio of a floor elsewhere to one in its place.
        floor_elsewhere_nats = 2.0, "nats", Derived, "two thirds of what one echo can say";
        /// Minimum log-likelihood ratio of the configured floor to one elsewhere that confirms the mounting.
        floor_firm_nats = 1.0, "nats", Hand;
        /// Maximum angle of the first corner off the ground while the floor does not confirm the mounting.
        corner_astray_rad = 0.7 * RAD_PER_DEG, "rad", Hand, "own scenes: 5 of 506 answers that are ok have more, 1 of them without a floor";
        /// Maximum distance between that corner and the first step.
        foot_reach_m = 0.06, "m", Derived, "distance error by 3 degrees at 1.2 m";
        /// Minimum level of that corner.
        corner_astray_db = 12.0, "dB", Derived, "angle known to 0.25 degrees";
    }
    "the beam over the rows" {
        /// Minimum level of an echo whose lobe width is measured.
        beam_echo_db = 15.0, "dB", Derived, "width known to 3 %";
        /// Number of such echoes from which the limits for many echoes apply.
        beam_echoes = 3.0, "", Hand;
        /// Minimum median lobe width over the rows, in units of a point scatterer's; below it the rows are farther apart than configured.
        beam_narrow = 0.90, "", Derived, "a beam 10 % narrower than stated";
        /// Maximum width of the narrowest lobe.
        beam_broad = 1.18, "", Hand, "own scenes, tuning seeds: of 653 answers that are ok none has more than 1.17";
        /// Maximum width of the narrowest lobe of few echoes.
        beam_broad_few = 1.4, "", Hand, "own scenes, tuning seeds: of 392 answers that are ok none has more; 2 have more than 1.25";
        /// Maximum travel of the chair during a scan in which lobe widths are measured.
        beam_still_m = 0.01, "m", Derived, "a range bin";
    }
    "scene: places of echoes" {
        /// Standard deviation of an echo's height that does not depend on range.
        height_sigma_m = 0.010, "m", Hand, "edge and face merge into one lobe";
        /// Standard deviation of an echo's height per metre of range.
        height_sigma_rad = 0.5 * RAD_PER_DEG, "rad", Hand;
        /// Level up to which an echo has the minimum credibility.
        credible_from_db = 1.0, "dB", Hand;
        /// Level above it from which an echo has full credibility.
        credible_span_db = 9.0, "dB", Hand;
        /// Minimum credibility of an echo.
        least_credibility = 0.15, "", Hand;
        /// Minimum distance of a riser: side lobes show the floor below the mirror, and aliased walls lie nearer.
        nearest_riser_m = 0.36, "m", Hand;
        /// Maximum horizontal distance of echoes of one riser.
        column_m = 0.045, "m", Custom, "nosings overhang by up to 4 cm";
        /// Extent of the ground before a corner with which its level is compared.
        corner_before_m = 0.35, "m", Custom, "one going";
        /// Minimum level of a corner above the ground before it, and of a riser's corner above all else on its tread.
        corner_outshines_db = 8.0, "dB", Hand;
        /// Minimum level of an echo on the ground that may be a corner.
        corner_least_db = 14.0, "dB", Hand;
    }
    "roles: gains and costs going up" {
        /// An echo at a place known in x and y: corner, nosing, flash.
        point_nats = 5.4, "nats", Hand;
        /// An echo between them, on the riser.
        face_nats = 2.5, "nats", Hand;
        /// An echo on a tread or the floor.
        tread_nats = 1.1, "nats", Hand;
        /// A corner stronger than all else on its tread.
        bright_corner_nats = 1.1, "nats", Hand;
        /// SNR that is assumed for the strongest echo of a tread from which none was detected.
        tread_background_db = 3.0, "dB", Derived, "the weakest echo there is";
        /// An echo inside the solid.
        inside_nats = 2.1, "nats", Hand;
        /// An echo above the top of its own riser.
        above_nats = 3.3, "nats", Hand;
        /// An echo standing on a tread, or on the floor in front.
        clutter_nats = 2.5, "nats", Hand;
        /// Any other echo that the flight does not explain.
        stray_nats = 0.4, "nats", Hand;
        /// A closed riser whose inner corner is not detected.
        no_corner_nats = 1.8, "nats", Hand;
        /// Cost of each riser.
        step_nats = 1.6, "nats", Hand;
        /// A riser whose upper end is not detected.
        no_edge_nats = 1.5, "nats", Hand;
        /// Minimum gain at which a corner or an edge counts as detected.
        seen_nats = 0.8, "nats", Hand;
        /// Additional cost of a single riser behind a landing.
        lone_nats = 4.0, "nats", Hand;
    }
    "roles: limits" {
        /// Maximum height of a riser's foot above the mirror, or depth of its top below it, at which it flashes.
        flash_margin_m = 0.02, "m", Hand;
        /// Margin, beside its standard deviation, beyond which an echo is not on a surface: it is above, inside or clutter.
        off_margin_m = 0.02, "m", Hand;
    }
    "search: stairs going up" {
        /// Minimum going.
        least_going_m = posterior::GOINGS_M.low, "m", Custom, "steepest stairs in use";
        /// Maximum going.
        most_going_m = posterior::GOINGS_M.high, "m", Custom, "steps of parks and forecourts";
        /// Maximum length of a landing between two flights.
        longest_landing_m = 1.60, "m", Custom, "more than a door's leaf and a wheelchair's length";
        /// Maximum deviation of a riser from the place that its predecessors predict.
        riser_tolerance_m = 0.045, "m", Custom, "half an overhang and building tolerances";
        /// Minimum height of a single riser; a lower one is a threshold.
        lowest_step_m = 0.055, "m", Custom, "steps count from 6 cm on, less the error of a low riser's height";
        /// Maximum height of a single riser; a higher one is an obstacle.
        highest_step_m = 0.30, "m", Custom, "design contract of single rises: a rise of 6 to 30 cm is a step";
    }
    "heights: levels of the steps" {
        /// Standard deviation of a step from the straight flight.
        rise_sigma_m = 0.005, "m", Custom, "building codes allow 5 mm between neighbours";
        /// Standard deviation of an irregular riser or tread.
        odd_rise_sigma_m = 0.03, "m", Custom, "irregular steps of built stairs over which people stumble";
        /// Standard deviation of a flight's riser height by the likelihood of all echoes, and of the drop by the deepest tread.
        flight_rise_sigma_m = 0.02, "m", Hand, "calibration seeds: of the surest wrong answers four are single risers without an echo of their own level, 5 to 8 cm off";
        /// Factor on the standard deviation of reported heights, for errors outside the model.
        height_sigma_scale = 1.2, "", Hand;
        /// Minimum standard deviation of a height.
        least_height_sigma_m = 0.003, "m", Hand;
    }
    "nosings: places" {
        /// Standard deviation of the distance of a riser without echoes.
        inferred_x_sigma_m = 0.015, "m", Hand;
        /// Standard deviation of the angle of a nosing's echo.
        edge_angle_rad = 0.15 * RAD_PER_DEG, "rad", Hand;
        /// Maximum distance from a riser of echoes of its nosing, or of the riser behind its nosing.
        nosing_window_m = 0.065, "m", Custom, "noses of old and steep stairs overhang by up to 6 cm";
        /// Standard deviation of an echo from the vertical line to which it belongs.
        line_sigma_m = 0.004, "m", Hand, "range cells of two echoes that merge; roundings of 1 to 8 mm";
        /// Maximum height of the front of a tread.
        lip_m = 0.07, "m", Custom, "treads are 3 to 6 cm thick";
        /// Maximum height of the front of a tread, as a share of the rise.
        lip_share = 0.6, "", Custom, "a nosing leaves a part of the riser visible";
        /// Minimum height of the front of a tread.
        least_lip_m = 0.02, "m", Custom, "thinnest boards";
        /// Cost of a credible echo near a riser on neither line.
        nosing_stray_nats = 2.0, "nats", Hand;
        /// Standard deviation of the distance of a line with echoes.
        nosing_sigma_m = 0.0015, "m", Hand;
        /// Standard deviation of an overhang by the grid on which it is evaluated.
        overhang_grid_sigma_m = 0.0017, "m", Derived, "steps of 6 mm, even: over the root of 12";
    }
    "verdict" {
        /// Minimum margin to the runner-up; below it `close-rival` is reported.
        clear_lead_nats = 2.0, "nats", Derived, "seven to one";
        /// Minimum level of a step's strongest echo; below it `weak-echoes` is reported.
        weak_step_db = 8.0, "dB", Hand;
        /// Minimum SNR at which the riser after the last reported step would be detected.
        next_seen_db = 5.0, "dB", Hand;
        /// Decrease of the level from one riser to the next.
        fades_db = 6.0, "dB", Hand;
        /// Decrease of the level from a riser that flashes to the next.
        flash_fades_db = 25.0, "dB", Hand;
        /// Maximum standard deviation of a measured height; a larger one is reported as `inferred-step`.
        sure_height_m = 0.015, "m", Derived, "two standard deviations are 3 cm";
        /// Deviation of a step from the flight's line from which it is reported as `irregular-step`.
        irregular_m = 0.013, "m", Custom, "half an inch";
        /// Minimum level of echoes that contradict the flight where it leaves no room.
        in_the_way_db = 12.0, "dB", Hand;
        /// Level of 100 % detection quality.
        full_quality_db = 40.0, "dB", Custom, "a corner at a metre";
    }
    "fusion: from scan to scan" {
        /// Factor on a staircase's log-weight in the next scan.
        carried_share = 0.7, "", Hand, "a riser without echoes has none in the next scan either";
        /// Maximum log-weight of all earlier scans together.
        carried_most_nats = 4.0, "nats", Hand, "evidence of one scan beats any number of scans before";
        /// Minimum gain of a new staircase at which the scene counts as changed.
        scene_changed_nats = 8.0, "nats", Hand;
        /// Maximum distance of one step in two scans.
        same_step_m = 0.05, "m", Derived, "half the 10 cm within which steps are matched; odometry is better";
    }
    "health: the converter" {
        /// Maximum share of a chirp's samples at its own extreme.
        clipped_share = 0.05, "", Derived, "a tone's crest within one of 2^9 steps: a fiftieth, doubled";
        /// Maximum number of rows in which a bit between others does not change.
        lame_rows = 20.0, "", Derived, "a bit that is stuck rests in all rows; own scenes: 11 rows of a converter whose noise is within a bit";
        /// Maximum drift of the converter's offset during a scan, share of full scale.
        offset_walk = 0.45, "", Derived, "a leakage at full scale beats one and a half times in a chirp, which has a mean of 0.21 either way";
        /// Minimum level of the mirror's echo above its I/Q image.
        image_db = 22.0, "dB", Derived, "1.4 dB or 9 degrees of imbalance";
        /// Maximum difference of mirror echo and image that count as equal: one channel alone makes them so.
        twin_db = 3.0, "dB", Derived, "half the power";
        /// Minimum level of mirror echo and image above the noise.
        image_clear_db = 15.0, "dB", Derived, "noise exceeds it once in 10^13";
    }
    "health: levels from row to row" {
        /// Maximum drift of the level of the scanner's own structure.
        inside_drift_db = 3.0, "dB", Derived, "half the power";
        /// Maximum number of rows with a larger drift.
        strayed_rows = 2.0, "", Hand;
        /// Minimum rise of the noise above that of the rows before in a burst.
        burst_db = 7.0, "dB", Derived, "a flash's skirt rises by 2.4 dB a row at 5 degrees of beam, and the quartile of 30 cells errs by 1.3 dB";
        /// Maximum range error of the mirror's echo before calibration.
        mirror_place_m = 0.0225, "m", Derived, "one and a half native bins at 10 GHz: where on mirror and lens the echo comes from is not known before";
        /// Maximum range error of the mirror's echo against its calibration.
        mirror_moved_m = 0.003, "m", Derived, "a sweep 1.4 % too wide at 22 cm; ten times the error of its estimate";
        /// Minimum level above the mirror's echo of an obstruction between mirror and map.
        near_db = 0.0, "dB", Hand;
        /// Maximum number of rows with such an obstruction.
        near_rows = 8.0, "", Hand;
    }
    "health: the chair stands" {
        /// Maximum travel during a scan of a chair that stands.
        stood_m = 0.003, "m", Derived, "half of the detected travel";
        /// Maximum pitch during a scan of a chair that stands, by its controller; other motion is checked by the echoes.
        stood_rad = 0.1 * RAD_PER_DEG, "rad", Hand;
        /// Minimum level above the noise of echoes whose phase is used.
        phase_db = 25.0, "dB", Derived, "phase known to 2 degrees";
        /// Minimum number of phase changes from row to row.
        phase_turns = 16.0, "", Derived, "one lobe";
        /// Maximum mean phase change from row to row.
        phase_turned_deg = 4.0, "deg", Derived, "half of the change by 1 cm over 281 rows";
    }
    "health: the mirror turns" {
        /// Minimum level above the noise of their rows of cells that are compared.
        turning_db = 15.0, "dB", Derived, "noise exceeds it once in 10^13";
        /// Maximum difference of a compared cell to the strongest cell around it.
        jump_near_db = 3.0, "dB", Derived, "half the power; a cell in a null changes in any case";
        /// Usual difference of cells of neighbouring rows, for a beam of 20 rows; narrower beams are steeper.
        jump_usual_db = 1.5, "dB", Hand, "own scenes: 99 of 100 means of twelve cells";
        /// Maximum additional difference of all cells of two rows together.
        jump_db = 40.0, "dB", Hand, "own scenes: 99 of 100 answers that are ok have less than 34";
        /// Maximum counted difference of a cell.
        jump_clip_db = 20.0, "dB", Hand;
        /// Minimum number of cells of a jump: those of one echo.
        jump_cells = 3.0, "", Derived, "the window's lobe above CA-CFAR's threshold";
        /// Distance of compared rows, beam widths.
        still_lag_beams = 0.4, "", Derived, "a scatterer at the beam's axis is 3.8 dB down";
        /// Minimum mean difference of such rows while the mirror turns.
        still_db = 1.7, "dB", Derived, "noise alone at 15 dB";
        /// Minimum number of compared cells.
        still_cells = 2.0, "", Derived, "every other cell of an echo is compared";
        /// Maximum number of beam widths over which such rows may be equal.
        still_beams = 0.8, "", Hand, "own scenes: 99 of 100 answers that are ok have less than 0.6";
        /// Maximum number of rows over which such rows may be equal.
        still_rows = 8.0, "", Hand;
        /// Minimum mean level above the noise of a line through all rows.
        line_db = 12.0, "dB", Derived, "a weaker line does not reach the level of evaluated echoes";
        /// Maximum deviation of a row's level from the line's mean.
        line_spread_db = 3.0, "dB", Derived, "side lobes have nulls, a tone has none";
        /// Minimum share of rows with such a level at one range, which then comes from no echo by way of the mirror.
        line_share = 0.8, "", Hand;
        /// Range interval around the ground straight below the mirror, seen by side lobes, that is excluded from lines.
        plumb_m = 0.05, "m", Derived, "error of the mount height and the lobe in range";
        /// Maximum range of a line that blocks the view.
        blocked_m = 0.45, "m", Custom, "the nearest step that is reported";
    }
}

impl Params {
    /// Returns the credibility of an echo of this SNR, dB, 0…1: small near the noise, 1 well above it.
    pub fn credibility(&self, snr_db: f32) -> f32 {
        let share = (snr_db - self.credible_from_db) / self.credible_span_db;
        math::max(math::min(share, 1.0), self.least_credibility)
    }
}
