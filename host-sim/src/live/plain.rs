//! Output without a screen: one line for each answer, guard sweep and fault of the port.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};

use super::Ms;
use super::model::{Event, Link};
use super::port::Source;
use super::session::Session;
use super::talk::PortFault;

/// Interval at which a source that sends nothing is checked.
const WAIT: Duration = Duration::from_millis(100);

/// Follows `source` until `stop` is set. `print` gets each line of text. Times count from `started`, like those of
/// the source.
///
/// # Errors
/// The port cannot be opened at the beginning. A port that disappears later is waited for.
pub fn run(
    started: Instant,
    source: &Source,
    session: &mut Session<'_>,
    stop: &AtomicBool,
    print: &mut dyn FnMut(&str),
) -> Result<()> {
    let mut opened = false;
    let mut unexpected_data = None;
    while !stop.load(Ordering::Relaxed) {
        let (at, event) = match source.events.recv_timeout(WAIT) {
            Ok(came) => came,
            Err(RecvTimeoutError::Timeout) => {
                let now = started.elapsed().as_millis() as Ms;
                let state = &session.state;
                let found = state.unexpected_data(now).map(|s| s.explain(state.baud).0);
                if found != unexpected_data {
                    found.iter().for_each(|what| print(what));
                    unexpected_data = found;
                }
                continue;
            }
            Err(RecvTimeoutError::Disconnected) if source.is_log => return Ok(()),
            Err(RecvTimeoutError::Disconnected) => bail!("{}: has ended", session.state.port),
        };
        let (link, answers) = (session.state.link.clone(), session.state.answers);
        let sweeps = session.state.guard.as_ref().map(|guard| guard.count);
        session.take(at, &event);
        match (&event, &session.state.answer) {
            (Event::Failed(trouble), _) if !opened => {
                let (what, help) = trouble.explain(&session.state.port);
                bail!(PortFault { what, help });
            }
            (Event::Failed(trouble), _) if session.state.link != link => {
                print(&trouble.explain(&session.state.port).0);
            }
            (Event::Opened, _) => {
                opened = true;
                if matches!(link, Link::Away(..)) {
                    print(&format!("{}: open again", session.state.port));
                }
            }
            (_, Some((_, answer))) if session.state.answers > answers => print(&answer.summary()),
            _ => {}
        }
        if let Some(guard) = &session.state.guard
            && Some(guard.count) != sweeps
        {
            print(&guard.text());
        }
    }
    Ok(())
}
