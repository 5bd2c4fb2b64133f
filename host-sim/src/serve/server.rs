//! The Foxglove server: the crate `foxglove` as an [`Outlet`].

use std::net::SocketAddr;
use std::sync::Arc;

use anyhow::{Result, anyhow};
use foxglove::{
    ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer,
    WebSocketServerHandle,
};

use super::address;
use super::streams::{Outlet, Service, Stream};

/// A running Foxglove server.
pub struct Server {
    handle: WebSocketServerHandle,
    channels: Vec<(Stream, Arc<RawChannel>)>,
    address: SocketAddr,
    // Dropping it closes the channels.
    _context: Arc<Context>,
}

impl Server {
    /// Listens at `address` and offers `streams`.
    ///
    /// # Errors
    /// The server cannot listen; the message names the address and a remedy.
    pub fn start(address: SocketAddr, streams: &[Stream]) -> Result<Self> {
        let context = Context::new();
        let channels = streams.iter().map(|&stream| {
            let of = stream.channel();
            let schema = Schema::new(of.schema, of.schema_encoding, of.definition.into_bytes());
            let channel = ChannelBuilder::new(of.topic)
                .context(&context)
                .schema(schema)
                .message_encoding(of.encoding)
                .build_raw()?;
            Ok((stream, channel))
        });
        let channels = channels.collect::<Result<_, FoxgloveError>>()?;
        let server = WebSocketServer::new()
            .name(concat!("stairscan ", env!("CARGO_PKG_VERSION")))
            .context(&context)
            .bind(address.ip().to_string(), address.port());
        let handle = server.start_blocking().map_err(|error| match error {
            FoxgloveError::Bind(error) | FoxgloveError::IoError(error) => {
                anyhow!(address::trouble(address, &error))
            }
            error => anyhow!("--foxglove {address}: {error}"),
        })?;
        Ok(Self {
            address: SocketAddr::new(address.ip(), handle.port()),
            handle,
            channels,
            _context: context,
        })
    }

    fn channel(&self, stream: Stream) -> Option<&RawChannel> {
        let found = self.channels.iter().find(|(of, _)| *of == stream);
        found.map(|(_, channel)| &**channel)
    }
}

impl Outlet for Server {
    fn wanted(&self, stream: Stream) -> bool {
        self.channel(stream).is_some_and(RawChannel::has_sinks)
    }

    fn publish(&self, stream: Stream, message: &[u8], stamp_ns: u64) {
        if let Some(channel) = self.channel(stream) {
            channel.log_with_meta(message, PartialMetadata::with_log_time(stamp_ns));
        }
    }
}

impl Service for Server {
    fn place(&self) -> String {
        format!("Foxglove: open the connection ws://{}", self.address)
    }

    fn warning(&self) -> Option<String> {
        address::warning(self.address)
    }

    /// Closes the connections and waits until that is done.
    fn stop(self: Box<Self>) {
        self.handle.stop().wait_blocking();
    }
}
