//! Guard sweeps as they are received: the last `GUARD` sentence, the mean interval, a bar of the free distance against
//! the watch distance, and the sweeps before.

use std::collections::VecDeque;

use stairscan::report::GuardLine;
use stairscan::scanner::settings::GuardConfig;
use stairscan::verdict::{HazardKind, Status};

use super::Ms;
use crate::answer::metres;

/// Free distance that fills the bar, metres: the range of a guard sweep.
pub const FULL_M: f64 = 2.0;
/// Number of characters of the bar: 5 cm each.
const CELLS: usize = 40;
/// Maximum age of a `GUARD` sentence, ms; an older one is stale (docs/user/controller.md: people step in).
const OLDEST: Ms = 500;
/// Maximum number of sweeps that are kept.
const MAX_SWEEPS: usize = 240;
/// Unit of the setting `watch-distance`, metres.
const M_PER_HUNDREDTH_MM: f64 = 1e-5;
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
    /// Watch distance: with `watch on` a hazard that is nearer triggers a full scan, metres.
    watch_m: f64,
}

/// Guard sweeps before the last one, and the watch distance.
#[derive(Clone, Debug)]
pub struct SweepHistory {
    /// The last sweeps, oldest first; `None` where the guard paused or the scanner restarted.
    pub sweeps: VecDeque<Option<GuardLine>>,
    /// Watch distance, metres: the default until the scanner reports another.
    watch_m: f64,
}

impl Default for SweepHistory {
    fn default() -> Self {
        Self {
            sweeps: VecDeque::new(),
            watch_m: f64::from(GuardConfig::default().watch_distance) * M_PER_HUNDREDTH_MM,
        }
    }
}

impl SweepHistory {
    /// Adds the sweep of `guard`, after a gap if the guard has paused before.
    pub fn push(&mut self, guard: &Guard) {
        if guard.interval.is_none() {
            self.gap();
        }
        self.keep(Some(guard.line));
    }

    /// Adds a gap after the last sweep, if there is one.
    fn gap(&mut self) {
        if self.sweeps.back().is_some_and(Option::is_some) {
            self.keep(None);
        }
    }

    fn keep(&mut self, sweep: Option<GuardLine>) {
        if self.sweeps.len() == MAX_SWEEPS {
            self.sweeps.pop_front();
        }
        self.sweeps.push_back(sweep);
    }

    /// Takes the watch distance from a `CONF` sentence; other settings are ignored.
    pub fn configure(&mut self, key: &str, value: &str) {
        if let ("watch-distance", Ok(hundredths)) = (key, value.parse::<u32>()) {
            self.watch_m = f64::from(hundredths) * M_PER_HUNDREDTH_MM;
        }
    }

    /// Returns the watch distance, metres.
    pub fn watch_m(&self) -> f64 {
        self.watch_m
    }
}

impl Guard {
    /// Returns the state after a sentence that arrived at `now`, from the state before.
    pub fn after(before: Option<&Self>, now: Ms, line: GuardLine, watch_m: f64) -> Self {
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
            watch_m,
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

    /// Returns the free distance as a bar, one mark for each 5 cm of 2 m, with `|` at the watch distance.
    pub fn bar(&self) -> String {
        let cells = |m: f64| (m.clamp(0.0, FULL_M) / FULL_M * CELLS as f64).floor() as usize;
        let (full, watch) = (
            cells(self.line.free.map_or(0.0, metres)),
            cells(self.watch_m),
        );
        let cell = |k: usize| match k {
            _ if k == watch => '|',
            _ if k < full => '#',
            _ => '.',
        };
        format!("[{}]", (0..CELLS).map(cell).collect::<String>())
    }

    /// Returns the free distance against the watch distance, as text.
    pub fn distances(&self) -> String {
        let free = match (self.line.status, self.line.free) {
            (Status::Fault, _) | (_, None) => "free distance unknown".to_owned(),
            (_, Some(free)) => format!("free {:.2} m", metres(free)),
        };
        format!("{free}, watch {:.2} m", self.watch_m)
    }

    /// Returns what ends the free distance, confidence, reasons, number and rate of sweeps, as text.
    pub fn details(&self) -> String {
        let line = &self.line;
        let rate = self
            .interval
            .map(|ms| format!(", {:.1} a second", 1000.0 / ms.max(1.0)));
        let reasons = match line.reasons.is_empty() {
            true => String::new(),
            false => format!(", {}", line.reasons),
        };
        format!(
            "{}, {:.1} %{reasons}, sweep {}{}",
            ended(line.hazard),
            f64::from(line.confidence) / 10.0,
            line.sweep,
            rate.unwrap_or_default()
        )
    }

    /// Returns bar, status, distances and details as one line of text.
    pub fn text(&self) -> String {
        let status = self.line.status.as_str();
        format!(
            "{} {status} {}, {}",
            self.bar(),
            self.distances(),
            self.details()
        )
    }
}

/// Returns the text for the hazard that ends the free distance.
const fn ended(ending: HazardKind) -> &'static str {
    match ending {
        HazardKind::None => "nothing in range",
        HazardKind::Rise => "then a rise",
        HazardKind::Drop => "then a drop",
        HazardKind::Obstacle => "then an obstacle",
        HazardKind::Unknown => "then no detected ground",
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
    fn the_bar_follows_the_free_distance_and_marks_the_watch_distance() {
        let mut history = SweepHistory::default();
        let near = Guard::after(
            None,
            100,
            word(1, "ok,1000.0,rise,99.8,"),
            history.watch_m(),
        );
        let bar = |full: usize, before: usize, mark: usize, behind: usize| {
            let (full, before) = ("#".repeat(full), ".".repeat(before));
            format!("[{full}{before}{}{}]", "|".repeat(mark), ".".repeat(behind))
        };
        assert_eq!(near.bar(), bar(20, 10, 1, 9));
        let words = "ok free 1.00 m, watch 1.50 m, then a rise, 99.8 %, sweep 1";
        assert_eq!(near.text(), format!("{} {words}", near.bar()));
        history.configure("mount-height", "40000");
        history.configure("watch-distance", "60000");
        let watched = Guard::after(
            None,
            100,
            word(1, "ok,1000.0,rise,99.8,"),
            history.watch_m(),
        );
        assert!(
            watched.text().contains("watch 0.60 m")
                && watched.bar().starts_with("[############|###")
        );
        let fault = Guard::after(None, 100, word(2, "fault,,unknown,0.0,motor-stall"), 2.0);
        assert_eq!(fault.bar(), bar(0, 40, 0, 0));
        assert!(
            fault.text().contains("free distance unknown"),
            "{}",
            fault.text()
        );
    }

    #[test]
    fn it_tells_how_often_words_come_and_when_they_are_stale() {
        let line = word(1, "ok,1000.0,none,99.8,");
        let mut guard = Guard::after(None, 0, line, 1.5);
        for k in 1..20 {
            guard = Guard::after(Some(&guard), 100 * k, line, 1.5);
        }
        assert!(
            guard.text().ends_with(", 10.0 a second"),
            "{}",
            guard.text()
        );
        assert!(guard.is_fresh(2_400) && !guard.is_fresh(2_401));
        let later = Guard::after(Some(&guard), 9_000, line, 1.5);
        assert!(!later.text().contains("a second") && later.count == 21);
    }

    #[test]
    fn news_are_status_and_what_ends_it() {
        let first = Guard::after(None, 0, word(1, "ok,1000.0,none,99.8,"), 1.5);
        let same = Guard::after(Some(&first), 100, word(2, "ok,900.0,none,99.7,"), 1.5);
        let other = Guard::after(Some(&same), 200, word(3, "ok,900.0,rise,99.7,"), 1.5);
        assert!(
            first.has_changed(None)
                && !same.has_changed(Some(&first))
                && other.has_changed(Some(&same))
        );
    }

    #[test]
    fn the_history_keeps_the_last_sweeps_with_gaps() {
        let (mut history, mut guard) = (SweepHistory::default(), None);
        let mut at = 0;
        for sweep in 1..=300 {
            at += if sweep % 100 == 0 { 3_000 } else { 100 };
            let next = Guard::after(guard.as_ref(), at, word(sweep, "ok,900.0,none,99.7,"), 1.5);
            history.push(&next);
            guard = Some(next);
        }
        assert_eq!(history.sweeps.len(), MAX_SWEEPS);
        let sweeps: Vec<_> = history
            .sweeps
            .iter()
            .rev()
            .map(|s| s.map(|line| line.sweep))
            .collect();
        assert_eq!(sweeps[..3], [Some(300), None, Some(299)]);
        assert_eq!(sweeps[101..104], [Some(200), None, Some(199)]);
        // After a restart, but not twice.
        history.push(&Guard::after(
            None,
            at,
            word(1, "fault,,unknown,0.0,motor-stall"),
            1.5,
        ));
        let end: Vec<_> = history
            .sweeps
            .iter()
            .rev()
            .take(3)
            .map(Option::is_some)
            .collect();
        assert_eq!(end, [true, false, true]);
    }
}
