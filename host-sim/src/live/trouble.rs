//! Explanations and remedies for faults of a port.

/// Why a port cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// There is no port of this name; these exist.
    Missing(Vec<String>),
    /// No permission; the group that has it, if the port has its own.
    Forbidden(Option<String>),
    /// Another program holds it.
    Busy,
    /// The path is not a serial port.
    NoPort,
    /// The port has disappeared; the system's message.
    Unplugged(String),
    /// Any other fault; the system's message.
    Other(String),
}

impl Trouble {
    /// Returns the fault of `port` and its remedies, one line each.
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

/// Data of an open port that are not sentences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strange<'a> {
    /// Nothing at all.
    Nothing,
    /// No more data.
    Silence,
    /// Bytes that are not text: probably another baud rate.
    Noise,
    /// Text of another device; one line of it.
    Others(&'a str),
    /// Damaged sentences.
    Damaged,
}

/// Baud rate of the report port.
pub const REPORT_BAUD: u32 = 115_200;

impl Strange<'_> {
    /// Returns the fault and its remedies, one line each.
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
