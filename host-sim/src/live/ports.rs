//! The serial ports of this machine.

use std::fmt::Write as _;
use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::Path;

use serialport::{SerialPortInfo, SerialPortType};

use super::trouble::Trouble;

/// Directory in which Linux lists its terminals.
const TERMINALS: &str = "/sys/class/tty";
/// Directory in which udev links each connected device's stable name to its port.
const BY_ID: &str = "/dev/serial/by-id";

/// Returns all serial ports of this machine, those on USB first.
fn available() -> Vec<SerialPortInfo> {
    // Without that directory the library would end the program.
    if cfg!(target_os = "linux") && !Path::new(TERMINALS).is_dir() {
        return Vec::new();
    }
    let mut ports = serialport::available_ports().unwrap_or_default();
    let rank = |port: &SerialPortInfo| !matches!(port.port_type, SerialPortType::UsbPort(_));
    ports.sort_by(|a, b| (rank(a), &a.port_name).cmp(&(rank(b), &b.port_name)));
    ports
}

/// Returns the names of all serial ports, those on USB first.
pub fn names() -> Vec<String> {
    available().into_iter().map(|port| port.port_name).collect()
}

/// Returns a list of the serial ports as text, with device and stable name; empty if there are none.
pub fn list() -> String {
    let mut out = String::new();
    for port in available() {
        let what = match &port.port_type {
            SerialPortType::UsbPort(usb) => {
                let words = [&usb.manufacturer, &usb.product, &usb.serial_number];
                let words: Vec<&str> = words.into_iter().flatten().map(String::as_str).collect();
                format!("USB {:04x}:{:04x} {}", usb.vid, usb.pid, words.join(" "))
            }
            SerialPortType::BluetoothPort => "Bluetooth".to_owned(),
            SerialPortType::PciPort => "built in".to_owned(),
            SerialPortType::Unknown => String::new(),
        };
        let alias = alias(Path::new(&port.port_name));
        let line = format!("  {:<14} {what}", port.port_name);
        let _ = writeln!(out, "{}", line.trim_end());
        if let Some(alias) = alias {
            let _ = writeln!(out, "  {:<14} also {alias}, whatever its number", "");
        }
    }
    out
}

/// Returns the stable path by which udev lists `port`, whatever its number; `None` if it lists none.
fn alias(port: &Path) -> Option<String> {
    let port = fs::canonicalize(port).ok()?;
    let entries = fs::read_dir(BY_ID).ok()?.flatten();
    let mut paths = entries.map(|entry| entry.path());
    let found = paths.find(|path| fs::canonicalize(path).is_ok_and(|to| to == port))?;
    Some(found.display().to_string())
}

/// Returns the cause for which `path` could not be opened.
pub fn trouble(path: &str, error: &serialport::Error) -> Trouble {
    use std::io::ErrorKind;
    let Ok(found) = fs::metadata(path) else {
        return Trouble::Missing(names());
    };
    match error.kind {
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            Trouble::Forbidden(group_name(found.gid()))
        }
        _ if !found.file_type().is_char_device() => Trouble::NoPort,
        // The library's error for a port that is locked.
        serialport::ErrorKind::NoDevice => Trouble::Busy,
        _ if error.description.contains("typewriter") => Trouble::NoPort,
        _ => Trouble::Other(error.description.clone()),
    }
}

/// Returns the name of the group `id`; `None` for root's, which no user should be added to, or if there is no such
/// group.
fn group_name(id: u32) -> Option<String> {
    let groups = fs::read_to_string("/etc/group").ok()?;
    let mut rows = groups
        .lines()
        .map(|line| line.split(':').collect::<Vec<_>>());
    let row = rows.find(|row| row.get(2).is_some_and(|text| text.parse() == Ok(id)))?;
    (id != 0).then(|| row[0].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serialport::{Error, ErrorKind};

    #[test]
    fn what_keeps_a_port_shut_is_distinguished() {
        let denied = Error::new(ErrorKind::Io(std::io::ErrorKind::PermissionDenied), "");
        assert!(matches!(
            trouble("/dev/null", &denied),
            Trouble::Forbidden(_)
        ));
        let busy = Error::new(ErrorKind::NoDevice, "");
        assert_eq!(trouble("/dev/null", &busy), Trouble::Busy);
        assert_eq!(trouble("/etc/hostname", &busy), Trouble::NoPort);
        assert!(matches!(
            trouble("/dev/no-such-port", &busy),
            Trouble::Missing(_)
        ));
        // The library's actual error for a device that is not a terminal.
        let error = serialport::new("/dev/null", 115_200).open().unwrap_err();
        assert_eq!(trouble("/dev/null", &error), Trouble::NoPort);
    }

    #[test]
    fn a_group_has_its_name() {
        assert_eq!(group_name(0), None);
        assert_eq!(group_name(u32::MAX), None);
    }
}
