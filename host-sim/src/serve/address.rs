//! Parses addresses to listen on, with warnings: address and port for Foxglove, interface and
//! domain for ROS 2.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

/// Default address of Foxglove: port 8765, reachable from this machine only.
pub const DEFAULT: &str = "127.0.0.1:8765";

/// Parses `ADDRESS:PORT`, `localhost:PORT`, or `PORT` alone, which listens on this machine only.
///
/// # Errors
/// The message describes the expected format.
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

/// Returns a warning if other machines can reach the address.
pub fn warning(address: SocketAddr) -> Option<String> {
    (!address.ip().is_loopback()).then(|| {
        format!(
            "warning: {address} is open to other machines: whoever reaches it can read along, without password and \
             encryption"
        )
    })
}

/// Returns the error message, with a remedy, for a server that cannot listen at `address`.
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

/// Default interface of ROS 2: loopback, reachable from this machine only.
pub const HERE: &str = "127.0.0.1";
/// Maximum ROS 2 domain whose ports are below 65536.
const LAST_DOMAIN: u16 = 232;
/// Environment variable that contains the domain of ROS 2 programs.
pub const DOMAIN_VARIABLE: &str = "ROS_DOMAIN_ID";

/// Parses the address of an interface of this machine.
///
/// # Errors
/// The message describes the expected format.
pub fn interface(text: &str) -> Result<Ipv4Addr, String> {
    let local = if text == "localhost" { HERE } else { text };
    local.parse().map_err(|_| {
        format!(
            "expected the IPv4 address of an interface of this machine, such as {HERE}, or 0.0.0.0 for all; a \
             serial port stands before --ros2"
        )
    })
}

/// Returns the ROS 2 domain: that of the flag, else that of the environment variable, else 0.
///
/// # Errors
/// The variable does not contain a domain; the message names it and its value.
pub fn domain(flag: Option<u16>, variable: Option<&str>) -> Result<u16, String> {
    match (flag, variable) {
        (Some(domain), _) => Ok(domain),
        (None, None | Some("")) => Ok(0),
        (None, Some(text)) => {
            parse_domain(text).map_err(|error| format!("{DOMAIN_VARIABLE}={text}: {error}"))
        }
    }
}

/// Parses a ROS 2 domain, 0 to 232.
///
/// # Errors
/// The message describes the expected format.
pub fn parse_domain(text: &str) -> Result<u16, String> {
    let domain = text.parse().ok().filter(|domain| *domain <= LAST_DOMAIN);
    domain.ok_or_else(|| format!("expected a domain from 0 to {LAST_DOMAIN}"))
}

/// Returns a warning if other machines can reach the interface.
pub fn interface_warning(interface: Ipv4Addr) -> Option<String> {
    (!interface.is_loopback()).then(|| {
        "warning: open to other machines: whoever reaches this one can read along and set the node's parameters, \
         without password and encryption"
            .to_owned()
    })
}
