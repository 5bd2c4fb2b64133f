//! Texts of the data sheet: the measurement, the method and the terms.

use super::super::body::Body;
use super::super::document::Part;
use super::super::measure::SWEEPS;
use super::super::plan::{Cell, ground_name};
use super::super::results::{Heading, Times};

/// Text above the table of bodies under the reference condition: states that condition, and the kind of the bounds.
pub const REFERENCE: &str = "Reference condition: the body 1 m ahead, the chair standing, square to the edge and level, the \
    window clean, ground and body of wood, ceramic, concrete, carpet and grating in equal parts. `≥` and `≤` are one-sided 95 % \
    bounds (Clopper-Pearson). The last two columns are the guard's response time.";

/// Text above the table of the smallest detected sizes: states when a size counts as detected.
pub const SMALLEST: &str = "The smallest size that, like every larger one measured, is detected with 99 %, or 90 %, at 95 % \
    confidence; and the size from which on at most 1 % of the answers are `ok` with free ground beyond the body. A dash: too \
    few scenes to show that; windows with dashes only are left out.";

/// Text above the table of all sizes behind a clean window: states which sizes are no hazards.
pub const SIZES: &str = "Rises and drops of up to 4 cm are no hazards by definition of the guard.";

/// Text above the table of all sizes behind windows with loss: states what water or dirt gives a loss.
pub const LOSSES: &str = "The loss holds for all echoes, out and back together: 3 dB are a water film of 0.05 mm or dust, 10 dB \
    one of 0.15 mm or mud in part, 20 dB one of 0.3 mm (67 dB a millimetre at 20 °C: Liebe, Hufford, Manabe 1991), or a module \
    with 20 dB less power. Rain in the air costs less than 0.1 dB over 2 m and back (Rec. ITU-R P.838-3, 50 mm an hour at 94 \
    GHz). Cells: detected, `ok` and free beyond, by the scan; the same by the guard. Bounds are in the next section.";

/// Text above the table of bounds: states what the tables after it contain.
pub const CHANGED: &str = "Each of the following tables changes one condition of the reference, whose figures are in the first \
    table. A column of *free beyond* without any is left out. Bounds of the counts:";

/// Text above the table of drives towards a body: states the drive, and the distances that are listed.
pub const APPROACH: &str = "Guard sweeps, ten a second, of a chair that drives towards the body and has it 1 m ahead at the \
    last of 14 sweeps, with errors of odometry and pitch. The last two columns are the distance of the body when half, and 95 \
    %, of the drives had named it.";

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
        "An alarm is a step or a drop reported by a scan, or a hazard named by any of {SWEEPS} guard \
         sweeps of one place. Rates are those of a scanner that is at a new place after every scan \
         ({:.2} s) and after every {SWEEPS} sweeps ({:.2} s). The last two columns count answers whose \
         free ground ends before 1.05 m without a cause: by chance they meet the rule for posts and \
         for rises below 6 cm at 1 m.",
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
        "The same cells with validation seeds: a bound is contradicted when the second count has a \
         probability below 5 % if the bound is the true share. Of {bounds} bounds {} hold. {verdict}",
        bounds - broken
    )
}

/// Returns the section on the causes that limit detection.
pub fn limits() -> Vec<Part> {
    let causes = [
        "A smooth upright post returns an echo only to a horizontal beam. The guard's rows point 8° \
         and more downwards and detect its foot; rough ground masks it. A scan has no sentence for a \
         post: most answers are `degraded`, but some are `ok` beyond one nearer than 1 m.",
        "A drop is detected by the end of the ground. The guard's free distance ends before a fall \
         of 6 cm and more; it names one of up to 10 cm, whose lower floor it sees. At 4 cm the lower \
         floor often counts as the ground.",
        "A grating scatters only from its bars, and a scan does not report its end.",
        "The guard's steepest row meets the ground 51 cm ahead, and the guard evaluates ground up \
         to 1.7 m: nearer and farther bodies are rarely named.",
        "The echo of a wet floor is weak: most answers report no free distance, and some a false \
         step or drop. Loss at the window has the same effect.",
        "On wet or glass ground an answer may be `ok` with a drop, from 0.8 m on, that is not there: \
         the weak echo ends as at an edge. It stops a chair, and its free distance ends there.",
        "Each body is the only object, the instrument has no fault, and the surfaces are the \
         simulator's.",
    ];
    let causes = causes.map(str::to_owned).to_vec();
    vec![
        Part::Heading(2, "Limits".into()),
        Part::Text(
            "Probable causes, from geometry and method; none was measured separately.".into(),
        ),
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
             for fitting or tuning; no figure here is of a real radar. Form and terms follow safety \
             sensors (IEC TS 61496-5, IEC TS 62998-1).",
            head.command, head.draw
        )),
        Part::Heading(2, "Terms".into()),
        Part::List(bodies.to_vec()),
        Part::List(vec![
            "Zone: 0.4 to 2.0 m ahead of the mirror, which turns 40 cm above the ground, in the \
             plane of the beam, at a yaw of up to 15°. A beam of 5° covers 4 cm to either side at 1 m: \
             objects beside it are not evaluated."
                .into(),
            "Draws: the body stands up to 2.5 cm nearer or farther and 1° aslant; the beam's pitch has \
             an unknown error of 0.15° (standard deviation); texture of the materials is drawn over 8 \
             dB, roughness over a factor of four. The inclinometer measures the pitch of the tables."
                .into(),
            "A scan detects a step when it reports one within 10 cm of the body's place, a drop when \
             it reports a drop or a step down there; a post, or a rise or drop below 6 cm, when the \
             free distance of an `ok` answer ends at or before the body, 5 cm allowed: at 1 m most \
             `ok` answers do so without a cause (last table)."
                .into(),
            format!(
                "The guard detects when one of {SWEEPS} sweeps from a standing chair ends its free distance at or before the body, 5 cm \
                 allowed, and names it: rise or obstacle, or drop."
            ),
            "`ok` and free beyond, the dangerous opposite: the answer is `ok` and its free ground ends \
             more than 5 cm beyond the body; of guard sweeps any from the third on. The rest are \
             answers without a free distance there."
                .into(),
            format!(
                "Response time: {scan_s:.2} s of a full scan, and up to twice that for what appears while the mirror turns; of the \
                 guard {sweep_s:.3} s a sweep, times the sweeps until the body is named. Both with a link of 3 Mbaud (`cargo sim \
                 timing`), the guard with `acceleration=4000000`."
            ),
        ]),
    ]
}
