//! The loop of `live` over keys, time and screen.

use std::io::{IsTerminal, stdout};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use ratatui::crossterm::event::{self, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::Ms;
use super::port::Source;
use super::prompt::{Key, Own, Prompt};
use super::screen;
use super::session::Session;

/// Time between two frames.
const FRAME: Duration = Duration::from_millis(50);

/// Shows the events of `source` until the user ends it. Times count from `started`, like those of the source.
///
/// # Errors
/// There is no terminal, or it cannot be drawn on.
pub fn run(started: Instant, source: &Source, session: &mut Session<'_>) -> Result<()> {
    ensure!(
        stdout().is_terminal(),
        "stdout: expected a terminal to draw on"
    );
    let mut terminal = ratatui::try_init()?;
    let keys = keys();
    let mut view = View {
        session,
        prompt: Prompt::default(),
    };
    let done = loop {
        let now = started.elapsed().as_millis() as Ms;
        while let Ok((at, event)) = source.events.try_recv() {
            view.session.take(at, &event);
        }
        let drawn = terminal.draw(|frame| {
            screen::draw(frame, &view.session.state, &view.prompt, now);
        });
        if let Err(error) = drawn {
            break Err(error).context("the terminal was closed");
        }
        match view.keys(&keys, source, now) {
            Ok(true) => {}
            Ok(false) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    ratatui::restore();
    done
}

/// Starts a thread that reads the keys, and returns their receiver. On a terminal that has hung up, the library's
/// read never returns; the next frame then finds that the terminal is gone. The thread ends with the program.
fn keys() -> Receiver<KeyEvent> {
    let (sender, keys) = mpsc::channel();
    std::thread::spawn(move || {
        while let Ok(event) = event::read() {
            if let event::Event::Key(key) = event
                && sender.send(key).is_err()
            {
                break;
            }
        }
    });
    keys
}

/// The session on the screen, with the command line.
struct View<'a, 'b> {
    session: &'a mut Session<'b>,
    prompt: Prompt,
}

impl View<'_, '_> {
    /// Waits for keys for the time of a frame and handles them. Returns whether to continue.
    fn keys(&mut self, keys: &Receiver<KeyEvent>, source: &Source, now: Ms) -> Result<bool> {
        let mut wait = FRAME;
        loop {
            match keys.recv_timeout(wait) {
                Ok(key) if key.kind == KeyEventKind::Release => {}
                Ok(key) if !self.key(key, source, now) => return Ok(false),
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return Ok(true),
                Err(RecvTimeoutError::Disconnected) => bail!("no keys can be read any more"),
            }
            wait = Duration::ZERO;
        }
    }

    /// Handles one key. Returns whether to continue.
    fn key(&mut self, key: KeyEvent, source: &Source, now: Ms) -> bool {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        let edit = match key.code {
            KeyCode::Char('c' | 'd') if control => return false,
            KeyCode::Char(_) if control => return true,
            KeyCode::Enter => return self.enter(source, now),
            KeyCode::Char(c) => match self.prompt.at_once(c) {
                Some(own) => return self.own(own),
                None => Key::Char(c),
            },
            KeyCode::Backspace => Key::Backspace,
            KeyCode::Delete => Key::Delete,
            KeyCode::Left => Key::Left,
            KeyCode::Right => Key::Right,
            KeyCode::Home => Key::Home,
            KeyCode::End => Key::End,
            KeyCode::Up => Key::Up,
            KeyCode::Down => Key::Down,
            KeyCode::Esc => Key::Clear,
            KeyCode::PageUp => {
                self.session.state.older();
                return true;
            }
            KeyCode::PageDown => {
                self.session.state.newer();
                return true;
            }
            _ => return true,
        };
        self.prompt.key(edit);
        true
    }

    /// Executes a command to this program. Returns whether to continue.
    fn own(&mut self, own: Own) -> bool {
        self.prompt.helping ^= own == Own::Help;
        own != Own::Quit
    }

    /// Handles the typed line. Returns whether to continue.
    fn enter(&mut self, source: &Source, now: Ms) -> bool {
        match self.prompt.own() {
            Some(own) => return self.own(own),
            None if !self.session.state.is_open() => {
                self.prompt.note = "the port is not open: nothing can be sent".to_owned();
            }
            None => {
                if let Some(line) = self.prompt.enter() {
                    self.session.keep(now, '>', &line);
                    self.session.state.sent(now, &line);
                    // A source that has ended has already reported it.
                    let _ = source.lines.send(line);
                }
            }
        }
        true
    }
}
