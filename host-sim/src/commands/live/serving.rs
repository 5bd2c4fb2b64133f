//! `live --foxglove` and `live --ros2`: starts the requested service, or the program that contains
//! it.

use std::net::{Ipv4Addr, SocketAddr};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Error, Result};

#[cfg(any(feature = "foxglove", feature = "ros2"))]
use super::offered::{self, Offer};
use super::watching::{self, Args};
use crate::serve::address;
#[cfg(not(all(feature = "foxglove", feature = "ros2")))]
use crate::serve::other_build;

/// Publishes the source by the requested service until the session ends; `None` if no service is requested.
pub fn run(args: &Args, started: Instant) -> Result<Option<ExitCode>> {
    if args.foxglove.is_some() || args.ros2.is_some() {
        // A program without the service is built anew, which takes minutes.
        watching::check(args)?;
    }
    Ok(match (args.foxglove, args.ros2) {
        (Some(address), _) => Some(foxglove(args, started, address)?),
        (None, Some(interface)) => {
            let variable = std::env::var(address::DOMAIN_VARIABLE).ok();
            let domain = address::domain(args.domain, variable.as_deref()).map_err(Error::msg)?;
            Some(ros2(args, started, (interface, domain))?)
        }
        (None, None) => None,
    })
}

#[cfg(not(feature = "foxglove"))]
fn foxglove(_: &Args, _: Instant, _: SocketAddr) -> Result<ExitCode> {
    match other_build::start("foxglove")? {}
}

#[cfg(feature = "foxglove")]
fn foxglove(args: &Args, started: Instant, address: SocketAddr) -> Result<ExitCode> {
    use crate::serve::server::Server;

    offered::run(args, started, &|offer: &Offer| {
        Ok(Box::new(Server::start(address, offer.streams)?))
    })
}

#[cfg(not(feature = "ros2"))]
fn ros2(_: &Args, _: Instant, _: (Ipv4Addr, u16)) -> Result<ExitCode> {
    match other_build::start("ros2")? {}
}

#[cfg(feature = "ros2")]
fn ros2(args: &Args, started: Instant, (interface, domain): (Ipv4Addr, u16)) -> Result<ExitCode> {
    use crate::serve::node::RosNode;

    offered::run(args, started, &|offer: &Offer| {
        let node = RosNode::start(interface, domain, offer.streams, offer.mount_height_m)?;
        Ok(Box::new(node))
    })
}
