//! Where to listen: an address and a port in, with what is to be said of them.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

/// Where Foxglove looks for a server: port 8765, here on this machine only.
pub const DEFAULT: &str = "127.0.0.1:8765";

/// Reads `ADDRESS:PORT`, `localhost:PORT`, or `PORT` alone, which is one of this machine only.
///
/// # Errors
/// Says what was expected.
pub fn parse(text: &str) -> Result<SocketAddr, String> {
    let here = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let local = text.strip_prefix("localhost:").unwrap_or(text);
    if let Ok(port) = local.parse() {
        return Ok(SocketAddr::new(here, port));
    }
    text.parse().map_err(|_| {
        format!(
            "expected ADDRESS:PORT with a numeric address and a port up to 65535, such as {DEFAULT}; \
             a serial port stands before --foxglove"
        )
    })
}

/// The warning that belongs to an address which other machines reach.
pub fn warning(address: SocketAddr) -> Option<String> {
    (!address.ip().is_loopback()).then(|| {
        format!(
            "warning: {address} is open to other machines: whoever reaches it can read along, without password and \
             encryption"
        )
    })
}

/// A server that cannot listen there, and what helps.
pub fn trouble(address: SocketAddr, error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    let help = match error.kind() {
        ErrorKind::AddrInUse => {
            "in use already, perhaps by another `live --foxglove`: end that one, or give another port, such as \
             --foxglove 8766"
        }
        ErrorKind::AddrNotAvailable => "no address of this machine",
        ErrorKind::PermissionDenied => "not permitted: ports below 1024 need privileges",
        _ => return format!("--foxglove {address}: {error}"),
    };
    format!("--foxglove {address}: {help}")
}
