//! What may be wrong with a port, in words for people, and what helps.

/// Why a port cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// There is none of this name; these there are.
    Missing(Vec<String>),
    /// The user may not; the group that may, if the port has one of its own.
    Forbidden(Option<String>),
    /// Another program holds it.
    Busy,
    /// What has that name is no serial port.
    NoPort,
    /// It was there and went away: what the system said of it.
    Unplugged(String),
    /// Anything else, as the system says it.
    Other(String),
}

impl Trouble {
    /// What is wrong with `port`, and then what helps, a line each.
    pub fn explain(&self, port: &str) -> (String, Vec<String>) {
        let text = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect();
        match self {
            Self::Missing(ports) if ports.is_empty() => (
                format!("no {port}, and no other serial port here"),
                text(&[
                    "Is the adapter plugged in? `dmesg | tail` shows whether the system has seen it.",
                    "A cable that only charges carries no data.",
                ]),
            ),
            Self::Missing(ports) => (
                format!("no {port}"),
                vec![format!("Ports here: {}", ports.join(", "))],
            ),
            Self::Forbidden(group) => {
                let group = group.as_deref().unwrap_or("dialout");
                (
                    format!("{port}: permission denied"),
                    vec![
                        format!("`sudo usermod -aG {group} $USER`, then log out and in again; or a udev rule:"),
                        "/etc/udev/rules.d/70-serial.rules: SUBSYSTEM==\"tty\", SUBSYSTEMS==\"usb\", TAG+=\"uaccess\""
                            .to_owned(),
                    ],
                )
            }
            Self::Busy => (
                format!("{port} is in use by another program"),
                vec![format!(
                    "`fuser -v {port}` says which; ModemManager lets go after some seconds."
                )],
            ),
            Self::NoPort => (
                format!("{port} is no serial port"),
                text(&["`cargo sim live` without a port lists those there are."]),
            ),
            Self::Unplugged(why) => (
                format!("{port} has gone ({why})"),
                text(&["Plug it in again: it is opened again by itself."]),
            ),
            Self::Other(why) => (format!("{port}: {why}"), Vec::new()),
        }
    }
}

/// What an open port gives instead of sentences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strange<'a> {
    /// Nothing at all.
    Nothing,
    /// Nothing any more.
    Silence,
    /// Bytes that are no text: another speed.
    Noise,
    /// Text of something else; a line of it.
    Others(&'a str),
    /// Sentences, but damaged.
    Damaged,
}

/// Speed of the report port.
pub const REPORT_BAUD: u32 = 115_200;

impl Strange<'_> {
    /// What is wrong, and then what helps, a line each.
    pub fn explain(&self, baud: u32) -> (String, Vec<String>) {
        let speed = match baud {
            REPORT_BAUD => "The scanner's speed is 115,200 baud, and so is this port's.".to_owned(),
            _ => format!(
                "The scanner's speed is 115,200 baud; this port is at {baud}: leave --baud away."
            ),
        };
        match self {
            Self::Nothing => (
                "the port is open, but says nothing (LIVE is due five times a second)".to_owned(),
                vec![
                    "Is the scanner powered? Is this its port, and not the radar link's or another adapter's?"
                        .to_owned(),
                    "TX and RX: J2 pin 2 (REPORT_TX) goes to the adapter's RX, pin 3 to its TX, pin 1 to ground."
                        .to_owned(),
                ],
            ),
            Self::Silence => (
                "the scanner has fallen silent (LIVE is due five times a second)".to_owned(),
                vec!["Its supply, or the line? Only `save` silences it, for some seconds.".to_owned()],
            ),
            Self::Noise => (
                "bytes come that are no text".to_owned(),
                vec![
                    speed,
                    "Otherwise a wrong port (the radar link is binary), or a UART wired without its level shifter."
                        .to_owned(),
                ],
            ),
            Self::Others(line) => (
                "something else talks here: text, but no sentence of a scanner".to_owned(),
                vec![
                    format!("It says: {}", line.chars().take(70).collect::<String>()),
                    "A wrong port? `cargo sim live` without a port lists those there are.".to_owned(),
                ],
            ),
            Self::Damaged => (
                "sentences come, but damaged: no checksum fits".to_owned(),
                vec![
                    speed,
                    "Otherwise a bad ground or a long cable; a scanner on its internal clock may be 4 % off."
                        .to_owned(),
                ],
            ),
        }
    }
}
