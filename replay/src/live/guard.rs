//! Guard sweeps as they are received: the last `GUARD` sentence, the mean interval, and a bar of the
//! free distance.

use stairscan::report::GuardLine;
use stairscan::verdict::{HazardKind, Status};

use super::Ms;
use crate::answer::metres;

/// Free distance that fills the bar, metres: the range of a guard sweep.
const FULL_M: f64 = 2.0;
/// Number of characters of the bar: 5 cm each.
const CELLS: usize = 40;
/// Maximum age of a `GUARD` sentence, ms; an older one is stale (docs/user/controller.md: people step in).
const OLDEST: Ms = 500;
/// Weight of the newest interval in the moving average of the intervals between `GUARD` sentences.
const NEWEST: f64 = 0.2;

/// State of the guard, from its sentences.
#[derive(Clone, Debug)]
pub struct Guard {
    /// The last `GUARD` sentence.
    pub line: GuardLine,
    /// Number of `GUARD` sentences received.
    pub count: u64,
    /// Arrival time of the last `GUARD` sentence, ms since the session began.
    came: Ms,
    /// Moving average of the interval between sentences, ms; `None` for the first one and after a pause.
    interval: Option<f64>,
}

impl Guard {
    /// Returns the state after a sentence that arrived at `now`, from the state before.
    pub fn after(before: Option<&Self>, now: Ms, line: GuardLine) -> Self {
        let gap = before.map(|before| now.saturating_sub(before.came) as f64);
        // After a pause, for a full scan or because of a broken line, the average restarts.
        let gap = gap.filter(|gap| *gap <= OLDEST as f64);
        let mean = before.and_then(|before| before.interval);
        let interval = gap.map(|gap| mean.map_or(gap, |mean| mean + NEWEST * (gap - mean)));
        Self {
            line,
            count: before.map_or(0, |before| before.count) + 1,
            came: now,
            interval,
        }
    }

    /// Whether the last sentence is not stale at `now`.
    pub fn is_fresh(&self, now: Ms) -> bool {
        now.saturating_sub(self.came) <= OLDEST
    }

    /// Whether status, hazard or reasons differ from those of the sentence before. The distance is ignored.
    pub fn has_changed(&self, before: Option<&Self>) -> bool {
        let same = |other: &Self| {
            let (a, b) = (&self.line, &other.line);
            (a.status, a.hazard, a.reasons) == (b.status, b.hazard, b.reasons)
        };
        !before.is_some_and(same)
    }

    /// Returns the free distance as a bar, one mark for each 5 cm of 2 m.
    pub fn bar(&self) -> String {
        let free_m = self.line.free.map_or(0.0, metres).clamp(0.0, FULL_M);
        let full = (free_m / FULL_M * CELLS as f64).floor() as usize;
        format!("[{}{}]", "#".repeat(full), ".".repeat(CELLS - full))
    }

    /// Returns bar, status, free distance, confidence, reasons, number and rate of sweeps as one line of text.
    pub fn text(&self) -> String {
        let line = &self.line;
        let free = match (line.status, line.free) {
            (Status::Fault, _) | (_, None) => "free distance unknown".to_owned(),
            (_, Some(free)) => format!("free {:.2} m{}", metres(free), ended(line.hazard)),
        };
        let rate = self
            .interval
            .map(|ms| format!(", {:.1} a second", 1000.0 / ms.max(1.0)));
        let reasons = match line.reasons.is_empty() {
            true => String::new(),
            false => format!(", {}", line.reasons),
        };
        format!(
            "{} {} {free}, {:.1} %{reasons}, sweep {}{}",
            self.bar(),
            line.status.as_str(),
            f64::from(line.confidence) / 10.0,
            line.sweep,
            rate.unwrap_or_default()
        )
    }
}

/// Returns the text for the hazard that ends the free distance.
const fn ended(ending: HazardKind) -> &'static str {
    match ending {
        HazardKind::None => ", nothing in range",
        HazardKind::Rise => " to a rise",
        HazardKind::Drop => " to a drop",
        HazardKind::Obstacle => " to an obstacle",
        HazardKind::Unknown => ", no ground detected beyond",
    }
}

#[cfg(test)]
mod tests {
    use stairscan::report::Sentence;

    use super::*;

    fn word(sweep: u32, rest: &str) -> GuardLine {
        let body = format!("PSTR,GUARD,{sweep},{rest}");
        let line = format!("${body}*{:08X}", stairscan::report::sentence::crc32(&body));
        match Sentence::parse(&line).unwrap() {
            Sentence::Guard(line) => line,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_bar_follows_the_free_distance() {
        let guard = Guard::after(None, 100, word(1, "ok,1000.0,rise,99.8,"));
        assert_eq!(
            guard.bar(),
            format!("[{}{}]", "#".repeat(20), ".".repeat(20))
        );
        assert_eq!(
            guard.text(),
            format!("{} ok free 1.00 m to a rise, 99.8 %, sweep 1", guard.bar())
        );
        let fault = Guard::after(None, 100, word(2, "fault,,unknown,0.0,motor-stall"));
        assert_eq!(fault.bar(), format!("[{}]", ".".repeat(40)));
        assert!(
            fault.text().contains("free distance unknown"),
            "{}",
            fault.text()
        );
    }

    #[test]
    fn it_tells_how_often_words_come_and_when_they_are_stale() {
        let line = word(1, "ok,1000.0,none,99.8,");
        let mut guard = Guard::after(None, 0, line);
        for k in 1..20 {
            guard = Guard::after(Some(&guard), 100 * k, line);
        }
        assert!(
            guard.text().ends_with(", 10.0 a second"),
            "{}",
            guard.text()
        );
        assert!(guard.is_fresh(2_400) && !guard.is_fresh(2_401));
        let later = Guard::after(Some(&guard), 9_000, line);
        assert!(!later.text().contains("a second") && later.count == 21);
    }

    #[test]
    fn news_are_status_and_what_ends_it() {
        let first = Guard::after(None, 0, word(1, "ok,1000.0,none,99.8,"));
        let same = Guard::after(Some(&first), 100, word(2, "ok,900.0,none,99.7,"));
        let other = Guard::after(Some(&same), 200, word(3, "ok,900.0,rise,99.7,"));
        assert!(
            first.has_changed(None)
                && !same.has_changed(Some(&first))
                && other.has_changed(Some(&same))
        );
    }
}
