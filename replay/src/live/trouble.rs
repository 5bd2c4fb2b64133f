//! Explanations and remedies for faults of a port.

use super::talker::sender;

/// Cause for which a port cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// There is no port of this name; the names of the existing ones.
    Missing(Vec<String>),
    /// No permission to open the port; the group of users that has permission, unless that is root's.
    Forbidden(Option<String>),
    /// Another program has the port open.
    Busy,
    /// The path is not a serial port.
    NoPort,
    /// The port has disappeared; the system's error message.
    Unplugged(String),
    /// Any other fault; the system's error message.
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
                    "Is the adapter plugged in? `dmesg | tail` shows whether the system has detected it.",
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
                    "`fuser -v {port}` shows which; ModemManager releases it after some seconds."
                )],
            ),
            Self::NoPort => (
                format!("{port} is no serial port"),
                text(&["`cargo sim live` without a port lists those there are."]),
            ),
            Self::Unplugged(why) => (
                format!("{port} has gone ({why})"),
                text(&["Plug it in again: it is reopened automatically."]),
            ),
            Self::Other(why) => (format!("{port}: {why}"), Vec::new()),
        }
    }
}

/// Data that an open port delivers instead of intact sentences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnexpectedData<'a> {
    /// No data since the port was opened.
    Nothing,
    /// No data any more; sentences were received before.
    Silence,
    /// Bytes that are not text: probably another baud rate.
    Noise,
    /// Text lines of another device; the last one, or the last by which the device is recognised.
    Others(&'a str),
    /// Sentences with a right checksum that this program does not know, such as the boot loader's; the last one.
    Unknown(&'a str),
    /// Frames of the radar link.
    Link,
    /// Mostly damaged sentences, and none that is intact.
    Damaged,
}

/// Baud rate of the scanner's report port.
pub const REPORT_BAUD: u32 = 115_200;

impl UnexpectedData<'_> {
    /// Returns the fault and its remedies, one line each. `baud` is the baud rate at which the port is open.
    pub fn explain(&self, baud: u32) -> (String, Vec<String>) {
        let speed = match baud {
            REPORT_BAUD => "The scanner's speed is 115,200 baud, and so is this port's.".to_owned(),
            _ => {
                format!("The scanner's speed is 115,200 baud; this port is at {baud}: omit --baud.")
            }
        };
        match self {
            Self::Nothing => (
                "the port is open, but the scanner sends nothing (LIVE is due five times a second)".to_owned(),
                vec![
                    "Is the scanner powered? Is this its port, and not the radar link's or another adapter's?"
                        .to_owned(),
                    "TX and RX: J2 pin 2 (REPORT_TX) goes to the adapter's RX, pin 3 to its TX, pin 1 to ground."
                        .to_owned(),
                ],
            ),
            Self::Silence => (
                "the scanner has stopped sending (LIVE is due five times a second)".to_owned(),
                vec!["Its supply, or the line? Only `save` interrupts it, for some seconds.".to_owned()],
            ),
            Self::Noise => (
                "the bytes are not text".to_owned(),
                vec![
                    speed,
                    "Otherwise a wrong port (the radar link is binary), or a UART wired without its level shifter."
                        .to_owned(),
                ],
            ),
            Self::Others(line) => (
                format!("{} sends here: text, but no sentence of a scanner", sender(line)),
                vec![
                    format!("Received: {}", line.chars().take(70).collect::<String>()),
                    "A wrong port? `cargo sim live` without a port lists those there are.".to_owned(),
                ],
            ),
            Self::Unknown(line) if line.contains("PSTR,LOADER,") => (
                "the boot loader reports, and then no image".to_owned(),
                vec![
                    format!("Received: {line}"),
                    "Does its image crash? `cargo sim update` sends another.".to_owned(),
                ],
            ),
            Self::Unknown(line) => (
                "sentences with a right checksum that this program does not know".to_owned(),
                vec![
                    format!("Received: {line}"),
                    "A newer firmware? Use the program of its revision.".to_owned(),
                ],
            ),
            Self::Link => (
                "frames of the radar link are received, not the report".to_owned(),
                vec![
                    "The report is at J2 pin 2 (REPORT_TX); `cargo sim record` records the link."
                        .to_owned(),
                ],
            ),
            Self::Damaged => (
                "sentences are received damaged: no checksum is correct".to_owned(),
                vec![
                    speed,
                    "Otherwise a bad ground or a long cable; a scanner on its internal clock may be 4 % off."
                        .to_owned(),
                ],
            ),
        }
    }

    /// Returns, as text, what a file has instead of intact sentences.
    pub fn in_a_file(&self) -> String {
        match self {
            Self::Nothing | Self::Silence => "it is empty".to_owned(),
            Self::Noise => "its bytes are not text".to_owned(),
            Self::Others(line) => {
                let line: String = line.chars().take(70).collect();
                format!("it holds text of {}: {line}", sender(&line))
            }
            Self::Unknown(line) if line.contains("PSTR,LOADER,") => {
                format!("it holds sentences of the boot loader: {line}")
            }
            Self::Unknown(line) => {
                format!(
                    "it holds sentences that this program does not know, as of a newer firmware: {line}"
                )
            }
            Self::Link => "it holds frames of the radar link".to_owned(),
            Self::Damaged => "its sentences are damaged".to_owned(),
        }
    }
}
