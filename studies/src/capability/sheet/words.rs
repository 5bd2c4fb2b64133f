//! Texts of the data sheet: the measurement, the method and the terms.

use super::super::body::Body;
use super::super::document::Part;
use super::super::measure::SWEEPS;
use super::super::plan::{Cell, ground_name};
use super::super::results::{Heading, Times};

/// Text above the table of bodies under the reference condition: states that condition, and the kind of the bounds.
pub const REFERENCE: &str = "Reference condition: the body 1 m ahead, the chair standing, square to the edge and level, the \
    window clean, ground and body of wood, ceramic, concrete, carpet and grating in equal parts. `≥` and `≤` are one-sided 95 % \
    bounds by Clopper and Pearson. A full scan answers after the scan time; the last two columns are the guard's response time.";

/// Text above the table of the smallest detected sizes: states when a size counts as detected.
pub const SMALLEST: &str = "The smallest size that, like every larger one measured, is detected \
    with a probability of 99 %, or 90 %, at 95 % confidence; and the size from which on at most 1 % \
    of the answers are `ok` with free ground beyond the body. A dash: the cells have too few scenes \
    to show that share.";

/// Text above the table of all sizes behind all windows: states which sizes are hazards, and what water or dirt gives a
/// loss.
pub const SIZES: &str = "By definition of the guard, rises and drops of up to 4 cm are no hazards; \
    they are listed for completeness. The window's loss is taken from the level of all echoes \
    alike, out and back together. Rain in the air costs less than 0.1 dB over 2 m and back (Rec. \
    ITU-R P.838-3, 50 mm an hour at 94 GHz). Water on the window costs: a field falls to 1/e in \
    0.26 mm of water at 20 °C (Liebe, Hufford, Manabe 1991), so that a closed film takes 67 dB a \
    millimetre out and back. 3 dB are a film of 0.05 mm or dust, 10 dB one of 0.15 mm or mud in \
    part, 20 dB one of 0.3 mm, or a module with 20 dB less power.";

/// Text above the table of drives towards a body: states the drive, and the distances that are listed.
pub const APPROACH: &str = "Guard sweeps, ten a second, of a chair that drives towards the body and \
    has it 1 m ahead at the last of 14 sweeps; its odometry and pitch err as those of a driven \
    chair do. The last two columns are the distance of the body when half, and 95 %, of the drives \
    had named it. The drives are few, so the bounds are wide.";

/// Returns a cell's condition as text in brackets: distance, yaw, pitch, the window's loss, ground and speed.
pub fn condition(cell: &Cell) -> String {
    let c = &cell.condition;
    format!(
        "({} m, yaw {}°, pitch {:+}°, {} dB, {}, {} m/s)",
        c.distance_m,
        c.yaw_deg,
        c.pitch_deg,
        c.loss_db,
        ground_name(c.ground),
        c.speed
    )
}

/// Returns the text above the table of false alarms on level ground: which reports count as an alarm, and the
/// intervals, from `times`, on which the rates are based.
pub fn level(times: &Times) -> String {
    format!(
        "Level ground as far as the range. An alarm is a step or a drop reported by a scan, or a \
         rise, a drop or an obstacle named by any of {SWEEPS} guard sweeps of one place. Rates are \
         those of a scanner that is at a new place after every scan ({:.2} s) and after every \
         {SWEEPS} sweeps ({:.2} s). The last two columns are the share of answers whose free ground \
         ends before 1.05 m without a cause: the probability that the rule for posts and for rises \
         below 6 cm is met by chance at 1 m.",
        times.scan_s,
        SWEEPS as f64 * times.sweep_s
    )
}

/// Returns the text above the list of confidence bounds that the second draw contradicts: `broken` of the `bounds` that
/// were tested.
pub fn second(bounds: usize, broken: usize) -> String {
    let verdict = match broken {
        0 => "None is contradicted.".to_owned(),
        1 => "One is contradicted:".to_owned(),
        n => format!("{n} are contradicted:"),
    };
    format!(
        "The same cells were measured again with validation seeds. A bound of the first draw counts \
         as contradicted when the second draw's count would come with less than 5 % probability if \
         the bound were the true share; a few in a thousand are expected by chance. Of {bounds} \
         bounds {} hold. {verdict}",
        bounds - broken
    )
}

/// Returns the section on the causes that limit detection.
pub fn limits() -> Vec<Part> {
    let causes = [
        "A smooth upright post returns an echo only to a horizontal beam. The guard's rows point 8° \
         and more downwards and detect the post's foot; rough ground masks it. A scan has no \
         sentence for a post: most answers with a post in the beam are `degraded`, but some scans \
         are `ok` beyond one that is nearer than 1 m.",
        "A drop is detected by the end of the ground. The guard's free distance ends before a fall \
         of 6 cm and more. It names one of up to 10 cm, whose lower floor it sees; for a deeper one \
         no single place reaches a probability of one half. At 4 cm the lower floor often counts as \
         the ground.",
        "A grating scatters only from its bars, and a scan does not report its end.",
        "The guard's steepest row meets the ground 51 cm ahead, and the guard evaluates ground up \
         to 1.7 m: nearer and farther bodies are rarely named.",
        "A wet floor reflects like a mirror, and its echo is weak: most answers report no free \
         distance, and some a false step or drop. Loss at the window has the same effect.",
        "Cells of few scenes have wide bounds; use the bound. Each body is the only object, the \
         instrument has no fault, and the surfaces are the simulator's.",
    ];
    let causes = causes.map(str::to_owned).to_vec();
    vec![
        Part::Heading(2, "Limits".into()),
        Part::Text("Probable causes, from geometry and from the estimators' methods; none was measured separately.".into()),
        Part::List(causes),
    ]
}

/// Returns the title, the origin and the terms of a sheet.
pub fn head(head: &Heading) -> Vec<Part> {
    let Times { scan_s, sweep_s } = head.times;
    let bodies = Body::STANDARD.map(|body| format!("{}: {}", body.name(), body.dimensions()));
    vec![
        Part::Heading(1, "Capability sheet".into()),
        Part::Text(format!(
            "Made by `{}`: scenes of the project's own simulator with {} seeds, which were not used \
             for fitting or tuning. No figure here was measured with a real radar. Form and terms \
             follow safety sensors (IEC TS 61496-5, IEC TS 62998-1): a test body, a zone, a \
             response time, and a probability with a bound.",
            head.command, head.draw
        )),
        Part::Heading(2, "Terms".into()),
        Part::List(bodies.to_vec()),
        Part::List(vec![
            "Zone: 0.4 to 2.0 m ahead of the mirror, which turns 40 cm above the ground, in the \
             plane of the beam, at a yaw of up to 15° (the simulator's limit). A beam of 5° covers \
             4 cm to either side at 1 m: objects beside it are not evaluated."
                .into(),
            "Draws: in every scene the body stands up to 2.5 cm nearer or farther and 1° aslant; \
             mirror and tyres pitch the beam by 0.15° (standard deviation), unknown to the scanner; \
             texture of the materials is drawn over 8 dB, roughness over a factor of four. The \
             pitch of the tables is measured by the inclinometer."
                .into(),
            "A scan detects a step when it reports a step within 10 cm of the body's place, a drop \
             when it reports a drop or a step down there. For posts and for rises and drops below 6 \
             cm it is enough that the free distance of an `ok` answer ends at or before the body, 5 \
             cm allowed: little at 1 m, where the horizon of most `ok` answers ends without a cause \
             (last table). A fault detects nothing."
                .into(),
            format!(
                "The guard detects when one of {SWEEPS} sweeps from a standing chair ends its free distance at or before the body, 5 cm \
                 allowed, and names it: rise or obstacle for what stands, drop for what falls."
            ),
            "`ok` and free beyond: the dangerous opposite. The answer is `ok` and its free ground \
             ends more than 5 cm beyond the body; of guard sweeps any from the third on. The rest \
             are answers without a free distance there."
                .into(),
            format!(
                "Response time: {scan_s:.2} s of a full scan, first row to report, and up to twice that for what appears while the \
                 mirror turns; of the guard {sweep_s:.3} s a sweep, times the sweeps until the body is named. Both with a mirror that \
                 turns and a link of 3 Mbaud (`cargo sim timing`), the guard with `acceleration=4000000`."
            ),
        ]),
    ]
}
