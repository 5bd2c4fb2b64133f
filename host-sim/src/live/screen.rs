//! The screen of `live`, drawn from the state of scanner and port.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Position, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};
use stairscan::verdict::Status;

use super::Ms;
use super::guarded;
use super::model::{Entry, Link, Pulse, State, Validity, Way};
use super::prompt::{HELP, Prompt};
use super::side;
use super::trouble::Trouble;
use crate::answer::{Answer, drop_words, maybe_words, metres};
use crate::counted::counted;

/// Minimum size of the terminal, columns and rows of characters.
const MIN_SIZE: (u16, u16) = (72, 22);
/// Width of the table of steps, characters.
const TABLE: u16 = 43;
/// Height of the guard's side view and strip above an answer, rows.
const GUARD: u16 = 9;
/// Minimum height of the side view of an answer below them, rows.
const MIN_VIEW: u16 = 8;
/// Height of side view and table from which on the last sentences have room below them, rows.
const MIDDLE: usize = 8;
/// Maximum height of the last sentences, rows.
const LOG: usize = 7;
/// Maximum number of reasons that are explained; further ones are only counted.
const REASONS: usize = 4;

/// Style of stale information.
const GREY: Style = Style::new().fg(Color::DarkGray);
const BOLD: Style = Style::new().add_modifier(Modifier::BOLD);
const WARN: Style = Style::new().fg(Color::Yellow);

/// Draws the screen at time `now`: port, answer, guard, side view, table of steps, `LIVE`, log, command line.
pub fn draw(frame: &mut Frame<'_>, state: &State, prompt: &Prompt, now: Ms) {
    let area = frame.area();
    if area.width < MIN_SIZE.0 || area.height < MIN_SIZE.1 {
        let text = format!(
            "This terminal has {} x {} characters; live needs {} x {}.",
            area.width, area.height, MIN_SIZE.0, MIN_SIZE.1
        );
        frame.render_widget(Paragraph::new(text).wrap(Wrap { trim: true }), area);
        return;
    }
    let width = usize::from(area.width);
    let mut head = title(state, width);
    head.extend(trouble(state, now, width));
    let mut verdict = verdict(state, now, width);
    verdict.extend(
        state
            .guard
            .iter()
            .flat_map(|guard| guarded::lines(guard, now)),
    );
    let pulse = pulse(state, now, width);
    let command_line = command_line(state, prompt, now, width);
    let lines = |count: usize| Constraint::Length(count as u16);
    let taken = head.len() + verdict.len() + pulse.len() + command_line.len();
    let room = usize::from(area.height).saturating_sub(taken);
    let rows = Layout::vertical([
        lines(head.len()),
        lines(verdict.len()),
        Constraint::Min(0),
        lines(pulse.len()),
        lines(match prompt.helping {
            true => HELP.len() + 2,
            false => room.saturating_sub(MIDDLE).min(LOG),
        }),
        lines(command_line.len()),
    ])
    .split(area);
    frame.render_widget(Paragraph::new(head), rows[0]);
    frame.render_widget(Paragraph::new(verdict), rows[1]);
    middle(frame, rows[2], state, now);
    frame.render_widget(Paragraph::new(pulse), rows[3]);
    match prompt.helping {
        true => help(frame, rows[4]),
        false => log(frame, rows[4], state),
    }
    frame.render_widget(Paragraph::new(command_line), rows[5]);
    let column = area.x + 3 + prompt.cursor as u16;
    frame.set_cursor_position(Position::new(
        column.min(area.right().saturating_sub(1)),
        rows[5].y,
    ));
}

/// Draws the last answer, or the guard while it sweeps; both, one above the other, where the terminal is high enough.
fn middle(frame: &mut Frame<'_>, area: Rect, state: &State, now: Ms) {
    let mut below = area;
    let answer = state.answer.as_ref().map(|(_, answer)| answer);
    let guard = state.guard.as_ref();
    if guard.is_some() || answer.is_none() && !state.sweeps.sweeps.is_empty() {
        let fresh = guard.is_some_and(|guard| guard.is_fresh(now));
        let [above, rest] =
            Layout::vertical([Constraint::Length(GUARD), Constraint::Min(0)]).areas(area);
        match (answer, rest.height >= MIN_VIEW) {
            (Some(_), true) => {
                guarded::draw(frame, above, guard, &state.sweeps, fresh);
                below = rest;
            }
            (Some(_), false) if !fresh => {}
            _ => return guarded::draw(frame, area, guard, &state.sweeps, fresh),
        }
    }
    let fresh = state.standing(now) == Validity::Fresh;
    let [view, steps] =
        Layout::horizontal([Constraint::Min(30), Constraint::Length(TABLE)]).areas(below);
    side::draw(frame, view, answer, fresh);
    table(frame, steps, answer, fresh);
}

/// Returns the lines with the port and its state.
fn title(state: &State, width: usize) -> Vec<Line<'static>> {
    let link = match &state.link {
        Link::Opening => "opening".to_owned(),
        Link::Open(_) if state.reopened > 0 => format!("open (reconnected {}x)", state.reopened),
        Link::Open(_) => "open".to_owned(),
        Link::Away(..) => "not open".to_owned(),
    };
    let speed = match state.baud {
        0 => String::new(),
        baud => format!(", {baud} baud"),
    };
    let about = match state.about.as_str() {
        "" => String::new(),
        about => format!(", {about}"),
    };
    let text = format!("{}{speed}{about}: {link}", state.port);
    styled(" stairscan live   ", &text, width, BOLD)
}

/// Returns the lines with the fault of the port and its remedies; none without a fault.
fn trouble(state: &State, now: Ms, width: usize) -> Vec<Line<'static>> {
    let (since, (what, helps)) = match (&state.link, state.unexpected_data(now)) {
        (Link::Away(since, trouble), _) => {
            let gone = matches!(trouble, Trouble::Unplugged(_));
            (gone.then_some(*since), trouble.explain(&state.port))
        }
        (_, Some(unexpected_data)) => (None, unexpected_data.explain(state.baud)),
        _ => return Vec::new(),
    };
    let since = since.map(|since| format!(", {} ago", span(now.saturating_sub(since))));
    let what = format!("{what}{}", since.unwrap_or_default());
    let red = Style::new().fg(Color::Red).add_modifier(Modifier::BOLD);
    let mut lines = styled(" ! ", &what, width, red);
    lines.extend(
        helps
            .iter()
            .flat_map(|help| styled("   ", help, width, WARN)),
    );
    lines
}

/// Returns the lines with the answer, its age, and its reasons with explanations.
fn verdict(state: &State, now: Ms, width: usize) -> Vec<Line<'static>> {
    let Some((_, answer)) = &state.answer else {
        return vec![Line::raw(" No answer yet.")];
    };
    let standing = state.standing(now);
    let age = span(state.age(now).unwrap_or(0));
    let old = match standing {
        Validity::Fresh => None,
        Validity::Unplugged => Some("the port is closed".to_owned()),
        Validity::Silent(ms) => Some(format!("no intact sentence for {}", span(ms))),
        Validity::Restarted => Some("the scanner has restarted since".to_owned()),
        Validity::Old => Some("too old to act on".to_owned()),
    };
    let (status, colour) = match answer.scan.status {
        Status::Ok => (" OK ", Color::Cyan),
        Status::Degraded => (" DEGRADED ", Color::Yellow),
        Status::Fault => (" FAULT ", Color::Red),
    };
    let (badge, text) = match &old {
        None => (Style::new().fg(Color::Black).bg(colour), Style::new()),
        Some(_) => (GREY.add_modifier(Modifier::REVERSED), GREY),
    };
    let mut first = vec![
        Span::raw(" "),
        Span::styled(status, badge),
        Span::styled(format!("  {}", words(answer)), text),
    ];
    if old.is_none() {
        first.push(Span::raw(format!("   age {age}")));
    }
    let mut lines = vec![Line::from(first)];
    if let Some(why) = old {
        lines.push(Line::styled(
            format!("   LAST ANSWER, {age} old: {why}"),
            WARN,
        ));
    }
    let reasons: Vec<_> = answer.scan.reasons.iter().collect();
    for reason in reasons.iter().take(REASONS) {
        let meaning = format!("{}: {}", reason.as_str(), reason.meaning());
        lines.extend(styled("   ", &meaning, width.saturating_sub(4), text));
    }
    if let Some(more @ 1..) = reasons.len().checked_sub(REASONS) {
        lines.push(Line::styled(
            format!("   and {more} more: see the last SCAN"),
            text,
        ));
    }
    lines
}

/// Wraps `text` behind `before` to lines of at most `width` characters, the further ones indented. Longer words are
/// divided.
fn styled(before: &str, text: &str, width: usize, style: Style) -> Vec<Line<'static>> {
    const INDENT: &str = "      ";
    let (mut lines, mut line) = (Vec::new(), before.to_owned());
    let mut begun = false;
    for word in text.split(' ') {
        let space = usize::from(begun);
        if begun && line.chars().count() + space + word.chars().count() > width {
            lines.push(std::mem::replace(&mut line, INDENT.to_owned()));
        } else if begun {
            line.push(' ');
        }
        for c in word.chars() {
            if line.chars().count() >= width.max(INDENT.len() + 1) {
                lines.push(std::mem::replace(&mut line, INDENT.to_owned()));
            }
            line.push(c);
        }
        begun = true;
    }
    lines.push(line);
    let lines = lines.into_iter();
    lines.map(|line| Line::styled(line, style)).collect()
}

/// Returns the summary of an answer without its status, for example `3 steps up, valid up to 1.0 m,
/// confidence 98.9 %`.
fn words(answer: &Answer) -> String {
    let summary = answer.summary();
    let said = summary.split_once(": ").map_or("", |(_, said)| said);
    let said = said.split_once(" (").map_or(said, |(said, _)| said);
    match answer.scan.confidence {
        None => said.to_owned(),
        Some(tenths) => format!("{said}, confidence {:.1} %", f64::from(tenths) / 10.0),
    }
}

/// Formats a duration as seconds, minutes or hours.
fn span(ms: Ms) -> String {
    match ms / 1000 {
        0..60 => format!("{:.1} s", ms as f64 / 1000.0),
        s @ 60..3600 => format!("{}:{:02} min", s / 60, s % 60),
        s => format!("{}:{:02} h", s / 3600, s / 60 % 60),
    }
}

/// Draws the table of steps, the `DROP` and the `MAYBE`s; grey if the answer is not `fresh`.
fn table(frame: &mut Frame<'_>, area: Rect, answer: Option<&Answer>, fresh: bool) {
    let style = if fresh { Style::new() } else { GREY };
    let mut lines = Vec::new();
    if let Some(answer) = answer.filter(|answer| !answer.steps.is_empty()) {
        lines.push(Line::styled(
            " #   distance ±2σ     height ±2σ quality",
            style,
        ));
        for s in &answer.steps {
            let pair = |value, sigma| {
                let (value, sigma) = (100.0 * metres(value), 200.0 * metres(sigma));
                format!("{value:6.1} ± {sigma:<4.1}")
            };
            let (distance, height) = (
                pair(s.distance, s.distance_sigma),
                pair(s.height, s.height_sigma),
            );
            let line = format!("{:>2}  {distance}   {height}   {:>3} %", s.index, s.quality);
            lines.push(Line::styled(line, style));
        }
    }
    if let Some(drop) = answer.and_then(|answer| answer.drop.as_ref()) {
        lines.push(Line::styled(format!(" | {}", drop_words(drop)), style));
    }
    for maybe in answer.map_or(&[][..], |answer| &answer.maybes) {
        lines.push(Line::styled(format!(" ? {}", maybe_words(maybe)), style));
    }
    let block = Block::bordered().title(" Steps, cm ");
    frame.render_widget(
        Paragraph::new(lines)
            .block(block)
            .wrap(Wrap { trim: false }),
        area,
    );
}

/// Returns the lines with the contents of the last `LIVE` sentence.
fn pulse(state: &State, now: Ms, width: usize) -> Vec<Line<'static>> {
    let Some(pulse) = &state.pulse else {
        return vec![Line::styled(" No LIVE yet.", GREY)];
    };
    let Pulse {
        state: what,
        scan,
        motion,
        counters: [motion_faults, refused, damaged, link],
        ..
    } = pulse;
    let up = span(u64::from(pulse.uptime_ms));
    let text = format!(
        "{what}, scan {scan}, up {up} | motion {motion}, {} | \
         refused {refused}, damaged {damaged}, link errors {link}",
        counted(*motion_faults, "fault")
    );
    let style = match state.standing(now) {
        Validity::Unplugged | Validity::Silent(_) => GREY,
        _ => Style::new(),
    };
    styled(" ", &text, width, style)
}

/// Draws the help.
fn help(frame: &mut Frame<'_>, area: Rect) {
    let lines: Vec<_> = HELP.map(Line::raw).into();
    let block = Block::bordered().title(" Help: Esc closes it; all commands: docs/user/report.md ");
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// Draws the last sentences except `LIVE`, the newest at the bottom, or earlier ones after scrolling back.
fn log(frame: &mut Frame<'_>, area: Rect, state: &State) {
    let title = match state.hidden {
        0 => " Last sentences (ms since start; > sent, x damaged) ".to_owned(),
        newer => format!(" Sentences (ms since start); {newer} newer ones: PageDown "),
    };
    let block = Block::bordered().title(title);
    let room = usize::from(block.inner(area).height);
    let line = |entry: &Entry| {
        let (mark, style) = match entry.way {
            Way::In => (' ', Style::new()),
            Way::Damaged => ('x', Style::new().fg(Color::Red)),
            Way::Out => ('>', Style::new().fg(Color::Cyan)),
            Way::Note => ('#', WARN),
        };
        Line::styled(format!("{:>8} {mark} {}", entry.at, entry.text), style)
    };
    let end = state.log.len().saturating_sub(state.hidden);
    let first = end.saturating_sub(room);
    let shown = state.log.iter().take(end).skip(first);
    let lines: Vec<_> = shown.map(line).collect();
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// Returns the command line, its note, and the reply to the last command.
fn command_line(state: &State, prompt: &Prompt, now: Ms, width: usize) -> Vec<Line<'static>> {
    let mut lines = vec![Line::from(vec![
        Span::styled(" > ", BOLD),
        Span::raw(prompt.text.clone()),
    ])];
    let help = "Enter sends, Up and Down: history, Esc clears, q ends, ? helps";
    lines.extend(match prompt.note.is_empty() {
        false => styled("   ", &prompt.note, width, WARN),
        true => styled("   ", help, width, GREY),
    });
    lines.extend(asked(state, now, width));
    lines
}

/// Returns the lines with the last command and its reply.
fn asked(state: &State, now: Ms, width: usize) -> Vec<Line<'static>> {
    let Some(asked) = &state.asked else {
        return vec![Line::raw("")];
    };
    let (text, style) = match &asked.reply {
        Some((at, text, good)) => {
            let took = span(at.saturating_sub(asked.at));
            let style = match good {
                true => Style::new().fg(Color::Cyan),
                false => WARN,
            };
            (format!("{text} (after {took})"), style)
        }
        None if asked.overdue(now) => (
            "no answer. Is the adapter's TX connected to J2 pin 3 (REPORT_RX)?".to_owned(),
            WARN,
        ),
        None => ("sent".to_owned(), GREY),
    };
    styled("   ", &format!("{}: {text}", asked.text), width, style)
}
