//! Tuned numbers of the default estimator, in the order of the stages that use them.

use super::entry::{Entry, Origin, params};
use super::posterior;
use super::switches::Rules;
use crate::math::RAD_PER_DEG;

params! {
    "echoes: responses of the instrument" {
        /// Curvature of the window's main lobe in range, dB per squared native bin.
        range_curvature_db = 6.0, "dB", Derived, "Hann window: -6.0 dB at one bin";
        /// Standard deviation of a filtered level that no model of one scatterer explains.
        lobe_model_db = 0.10, "dB", Derived, "ripple of the triangle against the beam, rounding of cells";
        /// Standard deviation that the noise gives a filtered level at 0 dB above it.
        level_noise_db = 1.3, "dB", Derived, "exponential noise averaged over one and a half beams";
    }
    "echoes: what noise and stronger echoes make" {
        /// Filtered power above the noise that counts.
        echo_margin_db = 2.8, "dB", Derived, "noise exceeds it once in some hundred independent places";
        /// Power above the noise that noise alone does not make in a whole scan.
        sure_echo_db = 4.5, "dB", Derived, "a map holds some thousand independent places";
        /// By how much the lower third over a bin's angles must exceed the noise to be taken for side lobes.
        side_lobes_seen_db = 0.9, "dB", Hand;
        /// Where side lobes are seen, an echo that CA-CFAR does not tell must stand this high above.
        side_lobe_margin_db = 9.0, "dB", Hand;
        /// Two-way side lobes of the beam below its peak, worst case, any angle at the same range.
        side_lobe_db = 17.0, "dB", Hand, "one-way pedestal of the simulators' antennas, with margin";
        /// By how much the beam's flank may be higher than a Gaussian's.
        main_lobe_margin_db = 3.0, "dB", Hand;
        /// The same where the ghost is a copy at another range.
        same_beam_margin_db = 1.0, "dB", Hand;
        /// Reach of an echo's own lobe in range, native bins.
        range_lobe_bins = 2.0, "", Derived, "Hann window: first zero at two bins";
        /// Range skirts below the echo (sweep non-linearity, phase noise near the carrier).
        skirt_db = 25.0, "dB", Hand;
        /// How far they reach, native bins.
        skirt_bins = 9.0, "", Hand;
        /// I/Q image below the echo.
        iq_image_db = 30.0, "dB", Derived, "5 % and 3 degrees of imbalance";
        /// How far from its place the image may peak, native bins.
        image_bins = 2.5, "", Derived, "the lobe's reach and half a bin";
        /// Phase noise of a strong echo below it: every range, same angle.
        oscillator_noise_db = 40.0, "dB", Hand;
    }
    "echoes: calibration on the floor" {
        /// Standard deviation of the shaft's angle bias.
        angle_bias_sigma_rad = 0.25 * RAD_PER_DEG, "rad", Derived, "one step of the scan";
        /// Standard deviation of the mount height.
        mount_height_sigma_m = 0.002, "m", Custom, "tyres and castors under load";
        /// Echoes within this height may be floor.
        floor_reach_m = 0.03, "m", Derived, "a bias of 1 degree at 1.7 m";
        /// Weaker echoes say nothing of the floor.
        floor_least_db = 8.0, "dB", Hand;
        /// A corner at the foot of a riser is at least this strong …
        floor_corner_db = 20.0, "dB", Hand;
        /// … no wider than this in units of a point scatterer's lobe …
        floor_corner_width = 1.15, "", Hand;
        /// … and exact in angle …
        floor_corner_rad = 0.06 * RAD_PER_DEG, "rad", Hand;
        /// … and height.
        floor_corner_m = 0.001, "m", Hand;
        /// Speckle of the floor is known no better than this in angle …
        floor_speckle_rad = 0.15 * RAD_PER_DEG, "rad", Hand;
        /// … and height.
        floor_speckle_m = 0.004, "m", Hand;
        /// Angle error of a floor echo from noise at 0 dB.
        floor_noise_rad = 0.5 * RAD_PER_DEG, "rad", Derived, "bound for the beam in steps of 0.25 degrees: 0.55 over the root of the power ratio";
        /// Echoes so many standard deviations off the floor count half.
        floor_cauchy_sigmas = 3.0, "", Hand;
        /// Angle bias and mount-height error that the floor shows are no larger than this, their squares in standard deviations added.
        calibration_strain = 3.0, "", Hand, "own scenes, tuning seeds: none of 389 answers that are ok has more than 2.5; a mount 5 mm off has 2.8";
    }
    "echoes: the floor in its place" {
        /// Echoes say something of the floor from this distance on …
        floor_from_m = 0.2, "m", Hand;
        /// … up to this one …
        floor_to_m = 2.0, "m", Hand;
        /// … if they lie within this of its height.
        floor_astray_m = 0.25, "m", Derived, "a mount 12 cm off, and 4 degrees at 2 m";
        /// An echo has no weight from this on down …
        witness_from_db = 3.0, "dB", Hand;
        /// … its weight is 1 this much above it …
        witness_span_db = 15.0, "dB", Hand;
        /// … and this at most.
        witness_most = 1.5, "", Hand;
        /// Error of an echo's height that no other number holds.
        witness_sigma_bins = 0.17, "bins", Derived, "2 mm at 10 GHz: a coarser radar blends edge and face over more";
        /// Step between heights that are tried.
        floor_height_step_m = 0.004, "m", Derived, "twice the error of a height";
        /// Step between slopes that are tried.
        floor_slope_step_rad = 0.25 * RAD_PER_DEG, "rad", Derived, "one step of the scan";
        /// Steps of height within which a floor is in its place: 8 mm.
        floor_near_steps = 2.0, "", Derived, "5 mm of tyres and castors, and a step";
        /// Steps of slope within which it is: 0.75 degrees.
        floor_tilt_steps = 3.0, "", Derived, "0.4 degrees of homing error and 0.1 of pitch, and a step";
        /// Steps of height that are tried: 9.6 cm.
        floor_far_steps = 24.0, "", Derived, "a mount 8 cm off, and 4 steps";
        /// Steps of slope that are tried: 5 degrees.
        floor_steep_steps = 20.0, "", Derived, "4 degrees off, and 4 steps";
        /// A floor elsewhere may have so much more support, in weights of echoes.
        floor_elsewhere = 1.4, "", Hand, "own scenes: 99 of 100 answers that are ok have less";
        /// From so much support on elsewhere …
        floor_alone = 0.5, "", Hand, "half an echo 18 dB above the noise";
        /// … the floor in its place must have such a share of that.
        floor_here_share = 0.25, "", Hand, "own scenes, tuning seeds: 2 of 320 answers that are ok have less";
        /// Where the floor is not shown by so much better in its place than elsewhere …
        floor_firm = 0.1, "", Hand;
        /// … its corner may be so far off …
        corner_astray_rad = 0.7 * RAD_PER_DEG, "rad", Hand, "own scenes: 5 of 506 answers that are ok have more, 1 of them without a floor";
        /// … if it stands so near the first step …
        foot_reach_m = 0.06, "m", Derived, "what 3 degrees at 1.2 m do to a distance";
        /// … and so far above the noise.
        corner_astray_db = 12.0, "dB", Derived, "angle known to 0.25 degrees";
    }
    "the beam over the rows" {
        /// Echoes so far above the noise show how wide their lobes are over the rows.
        beam_echo_db = 15.0, "dB", Derived, "width known to 3 %";
        /// So many of them show whether half of them are too narrow, or all of them a little too wide.
        beam_echoes = 3.0, "", Hand;
        /// Half of them are wider than this, a point scatterer's lobe being 1, if rows are as far apart as they are said to be, …
        beam_narrow = 0.94, "", Hand, "own scenes, tuning seeds: of 653 answers that are ok none has less than 0.95";
        /// … and the narrowest is no wider than this.
        beam_broad = 1.18, "", Hand, "own scenes, tuning seeds: of 653 answers that are ok none has more than 1.17";
        /// The same of the narrowest where they are fewer.
        beam_broad_few = 1.4, "", Hand, "own scenes, tuning seeds: of 392 answers that are ok none has more; 2 have more than 1.25";
        /// In the scan of a chair that drives farther than this lobes are narrower.
        beam_still_m = 0.01, "m", Derived, "a range bin";
    }
    "scene: places of echoes" {
        /// Height error of an echo whatever its range.
        height_sigma_m = 0.010, "m", Hand, "edge and face melt into one lobe";
        /// Height error of an echo per metre of range.
        height_sigma_rad = 0.5 * RAD_PER_DEG, "rad", Hand;
        /// Echoes below this have the least credibility …
        credible_from_db = 1.0, "dB", Hand;
        /// … and full credibility this much above it.
        credible_span_db = 9.0, "dB", Hand;
        /// Least credibility of an echo.
        least_credibility = 0.15, "", Hand;
        /// Nearer than this the floor below the mirror is seen by side lobes, and folded walls lie.
        nearest_riser_m = 0.36, "m", Hand;
        /// Echoes this close in x belong to one riser.
        column_m = 0.045, "m", Custom, "nosings overhang by up to 4 cm";
        /// A corner outshines the ground this far before it.
        corner_before_m = 0.35, "m", Custom, "one going";
        /// By how much it does, and a riser's corner everything else on its tread.
        corner_outshines_db = 8.0, "dB", Hand;
        /// An echo on the ground that is weaker is not taken for a corner.
        corner_least_db = 14.0, "dB", Hand;
    }
    "roles: gains and costs going up" {
        /// An echo at a place known in x and y: corner, nosing, flash.
        point_nats = 5.4, "nats", Hand;
        /// Between them, on the riser.
        face_nats = 2.5, "nats", Hand;
        /// On a tread or the floor.
        tread_nats = 1.1, "nats", Hand;
        /// A corner that outshines everything else on its tread.
        bright_corner_nats = 1.1, "nats", Hand;
        /// Strongest echo of a tread that shows none.
        tread_background_db = 3.0, "dB", Derived, "the weakest echo there is";
        /// An echo inside the solid.
        inside_nats = 2.1, "nats", Hand;
        /// An echo above the top of its own riser.
        above_nats = 3.3, "nats", Hand;
        /// An echo standing on a tread, or on the floor in front.
        clutter_nats = 2.5, "nats", Hand;
        /// Anything else that the flight does not explain.
        stray_nats = 0.4, "nats", Hand;
        /// A closed riser whose inner corner is not seen.
        no_corner_nats = 1.8, "nats", Hand;
        /// Each further riser must pay for itself.
        step_nats = 1.6, "nats", Hand;
        /// A riser whose upper end is not seen.
        no_edge_nats = 1.5, "nats", Hand;
        /// A corner or an edge is seen if it gains this.
        seen_nats = 0.8, "nats", Hand;
        /// Further cost of a single riser behind a landing.
        lone_nats = 4.0, "nats", Hand;
    }
    "roles: where each begins and ends" {
        /// A riser flashes if its foot is at most this much above the mirror, or its top at most this much below.
        flash_margin_m = 0.02, "m", Hand;
        /// An echo off a surface by more, beside its deviation, is not on it: it is above, inside or clutter.
        off_margin_m = 0.02, "m", Hand;
    }
    "search: stairs going up" {
        /// Least going.
        least_going_m = posterior::GOINGS_M.0, "m", Custom, "steepest stairs in use";
        /// Largest going.
        most_going_m = posterior::GOINGS_M.1, "m", Custom, "steps of parks and forecourts";
        /// Longest landing between two flights.
        longest_landing_m = 1.60, "m", Custom, "more than a door's leaf and a wheelchair's length";
        /// A riser may stand this far from where its predecessors lead.
        riser_tolerance_m = 0.045, "m", Custom, "half an overhang and what builders are off";
        /// A single riser lower than this is a threshold.
        lowest_step_m = 0.055, "m", Custom, "steps count from 6 cm on, less the error of a low riser's height";
        /// A single riser higher than this is an obstacle.
        highest_step_m = 0.30, "m", Custom, "design contract of single rises: what rises by 6 to 30 cm is a step";
    }
    "heights: levels of the steps" {
        /// A step's own departure from the straight flight.
        rise_sigma_m = 0.005, "m", Custom, "building codes allow 5 mm between neighbours";
        /// Standard deviation by which an irregular riser or tread departs.
        odd_rise_sigma_m = 0.03, "m", Custom, "irregular steps of built stairs that people stumble over";
        /// Error of a flight's riser height by the likelihood of all echoes, and of the drop by the deepest tread.
        flight_rise_sigma_m = 0.02, "m", Hand, "calibration seeds: of the surest wrong answers four are single risers that show no level of their own, 5 to 8 cm off";
        /// Factor on the standard deviation of reported heights, for what the model leaves out.
        height_sigma_scale = 1.2, "", Hand;
        /// No height is known better.
        least_height_sigma_m = 0.003, "m", Hand;
    }
    "nosings: where they stand" {
        /// Distance error of a riser that shows nothing.
        inferred_x_sigma_m = 0.015, "m", Hand;
        /// Angle error of a nosing's echo.
        edge_angle_rad = 0.15 * RAD_PER_DEG, "rad", Hand;
        /// Echoes this far from where a riser stands may be its nosing's or the riser's behind its nosing.
        nosing_window_m = 0.065, "m", Custom, "noses of old and steep stairs overhang by up to 6 cm";
        /// How far an echo may lie off the upright line that it belongs to.
        line_sigma_m = 0.004, "m", Hand, "range cells of two echoes that melt; roundings of 1 to 8 mm";
        /// Front of a tread at most …
        lip_m = 0.07, "m", Custom, "treads are 3 to 6 cm thick";
        /// … and at most this share of the rise.
        lip_share = 0.6, "", Custom, "a nosing leaves some of the riser to be seen";
        /// Front of a tread at least.
        least_lip_m = 0.02, "m", Custom, "thinnest boards";
        /// A credible echo near a riser on neither line.
        nosing_stray_nats = 2.0, "nats", Hand;
        /// Distance error of a line that shows.
        nosing_sigma_m = 0.0015, "m", Hand;
        /// Error of an overhang by the grid on which they are weighed.
        overhang_grid_sigma_m = 0.0017, "m", Derived, "steps of 6 mm, even: over the root of 12";
    }
    "verdict" {
        /// Another explanation within this score of the winner is a close rival.
        clear_lead_nats = 2.0, "nats", Derived, "seven to one";
        /// A step whose strongest echo is weaker rests on little.
        weak_step_db = 8.0, "dB", Hand;
        /// Weaker than this a further step would not have been seen.
        next_seen_db = 5.0, "dB", Hand;
        /// From one face to the next echoes get weaker by as much …
        fades_db = 6.0, "dB", Hand;
        /// … and by as much from one that looks straight at the mirror.
        flash_fades_db = 25.0, "dB", Hand;
        /// A height with a larger standard deviation gets the word `inferred-step`.
        sure_height_m = 0.015, "m", Derived, "two standard deviations are 3 cm";
        /// A step this far off the others' line is one that a foot stumbles over.
        irregular_m = 0.013, "m", Custom, "half an inch";
        /// Echoes stronger than this that stand where the flight leaves no room are in the way.
        in_the_way_db = 12.0, "dB", Hand;
        /// Full marks of a step's quality.
        full_quality_db = 40.0, "dB", Custom, "a corner at a metre";
    }
    "fusion: from scan to scan" {
        /// How much the logarithm of a staircase's weight counts in the next scan.
        carried_share = 0.7, "", Hand, "a riser that shows nothing shows nothing again";
        /// All earlier scans together count so much at most, in the weight of what may stand there.
        carried_most_nats = 4.0, "nats", Hand, "evidence of one scan beats any number of scans before";
        /// The scene has changed where a staircase that was not thought of before explains a scan better by so much.
        scene_changed_nats = 8.0, "nats", Hand;
        /// Two steps of two scans are the same within this distance.
        same_step_m = 0.05, "m", Derived, "half the 10 cm within which steps are matched; odometry is better";
    }
    "health: the converter" {
        /// Share of a chirp's samples that may stand at its own extreme.
        clipped_share = 0.05, "", Derived, "a tone's crest within one of 2^9 steps: a fiftieth, doubled";
        /// Rows in which a bit between others may stay at rest.
        lame_rows = 20.0, "", Derived, "a bit that is stuck rests in all rows; own scenes: 11 rows of a converter whose noise is within a bit";
        /// So far the converter's offset may walk during a scan, share of full scale.
        offset_walk = 0.45, "", Derived, "a leakage at full scale beats one and a half times in a chirp, which has a mean of 0.21 either way";
        /// From so far below the mirror's echo on its image is one too many.
        image_db = 22.0, "dB", Derived, "1.4 dB or 9 degrees of imbalance";
        /// An image within this of the mirror's echo is its twin: one channel alone makes it.
        twin_db = 3.0, "dB", Derived, "half the power";
        /// Mirror and image tell something from so far above the noise on.
        image_clear_db = 15.0, "dB", Derived, "noise exceeds it once in 10^13";
    }
    "health: levels from row to row" {
        /// What the scanner shows of itself stays within this.
        inside_drift_db = 3.0, "dB", Derived, "half the power";
        /// Rows that may stray from it.
        strayed_rows = 2.0, "", Hand;
        /// Noise this far above that of the rows before is a burst.
        burst_db = 7.0, "dB", Derived, "a flash's skirt rises by 2.4 dB a row at 5 degrees of beam, and the quartile of 30 cells errs by 1.3 dB";
        /// The mirror's echo may lie so far off its place before anybody has calibrated it.
        mirror_place_m = 0.0225, "m", Derived, "one and a half native bins at 10 GHz: where on mirror and lens the echo comes from is not known before";
        /// And so far off its place by calibration.
        mirror_moved_m = 0.003, "m", Derived, "a sweep 1.4 % too wide at 22 cm; what the estimate of its place errs by, ten times";
        /// Something between mirror and map that is so much stronger than the mirror's echo is in the way.
        near_db = 0.0, "dB", Hand;
        /// Rows that may show it.
        near_rows = 8.0, "", Hand;
    }
    "health: the chair stands" {
        /// A chair stands that goes by less during a scan …
        stood_m = 0.003, "m", Derived, "half of what is found";
        /// … and pitches by less, as its controller says: how far others are moved is checked otherwise.
        stood_rad = 0.1 * RAD_PER_DEG, "rad", Hand;
        /// Echoes this far above the noise tell of their phase.
        phase_db = 25.0, "dB", Derived, "phase known to 2 degrees";
        /// So many turns from row to row tell something.
        phase_turns = 16.0, "", Derived, "one lobe";
        /// From row to row the phase may go on by so much.
        phase_turned_deg = 4.0, "deg", Derived, "half of what 1 cm over 281 rows makes";
    }
    "health: the mirror turns" {
        /// Cells this far above the noise of their rows are compared.
        turning_db = 15.0, "dB", Derived, "noise exceeds it once in 10^13";
        /// Cells are compared where the stronger of two is within this of the strongest around.
        jump_near_db = 3.0, "dB", Derived, "half the power; what lies in a null changes at any rate";
        /// Cells of neighbouring rows usually differ by less, at a beam of 20 rows; narrower beams are steeper.
        jump_usual_db = 1.5, "dB", Hand, "own scenes: 99 of 100 means of twelve cells";
        /// All cells of two rows together differ by so much more at most.
        jump_db = 40.0, "dB", Hand, "own scenes: 99 of 100 answers that are ok have less than 34";
        /// A difference counts so much at most.
        jump_clip_db = 20.0, "dB", Hand;
        /// Cells that make a jump: those of one echo.
        jump_cells = 3.0, "", Derived, "the window's lobe above CA-CFAR's threshold";
        /// Rows this far apart must differ, beam widths …
        still_lag_beams = 0.4, "", Derived, "a scatterer at the beam's axis is 3.8 dB down";
        /// … by so much in the mean …
        still_db = 1.7, "dB", Derived, "noise alone at 15 dB";
        /// … if so many cells are compared …
        still_cells = 2.0, "", Derived, "every other cell of an echo is looked at";
        /// … and they may not for so many beam widths …
        still_beams = 0.8, "", Hand, "own scenes: 99 of 100 answers that are ok have less than 0.6";
        /// … and rows.
        still_rows = 8.0, "", Hand;
        /// Something so far above the noise in the mean of all rows …
        line_db = 12.0, "dB", Derived, "a line below it does not reach the echoes that are weighed";
        /// … that stays within this of its mean …
        line_spread_db = 3.0, "dB", Derived, "side lobes have nulls, a tone has none";
        /// … in so large a share of the rows, at one range, is no echo by way of the mirror.
        line_share = 0.8, "", Hand;
        /// The floor straight below the mirror, seen by side lobes, is no such line: its range is this exact.
        plumb_m = 0.05, "m", Derived, "error of the mount height and the lobe in range";
        /// Nearer than this it stands in the way.
        blocked_m = 0.45, "m", Custom, "the nearest step that is reported";
    }
}
