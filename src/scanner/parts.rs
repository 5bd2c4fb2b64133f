//! The parts that a scanner is made of, each behind its trait.

use super::board::Board;
use super::chain::DataPath;
use super::mirror::Mirror;
use super::reports::Reports;
use crate::motion::Odometry;
use crate::port::BytePort;
use crate::signal::radar::module::RadarModule;

/// The scanner's hardware, each part behind its trait.
#[derive(Clone, Copy, Debug)]
pub struct Hardware<M, L, P, B> {
    /// The mirror ([`Mirror`]).
    pub mirror: M,
    /// The radar module ([`RadarModule`]).
    pub link: L,
    /// The report port ([`BytePort`]).
    pub port: P,
    /// The rest of the board ([`Board`]).
    pub board: B,
}

/// Larger parts that a scanner borrows, so that one on a small stack can keep them elsewhere.
#[derive(Debug)]
pub struct LentParts<'a> {
    /// Outgoing sentences.
    pub reports: &'a mut Reports,
    /// Motion input.
    pub odometry: &'a mut Odometry,
}

/// Types of the parts that a scanner is made of.
pub trait Parts {
    /// The mirror.
    type Mirror: Mirror;
    /// The radar module.
    type Module: RadarModule;
    /// The report port.
    type Port: BytePort;
    /// The rest of the board.
    type Board: Board;
    /// The way from chirps to answers.
    type Data: DataPath;
}

impl<M: Mirror, L: RadarModule, P: BytePort, B: Board, D: DataPath> Parts
    for (Hardware<M, L, P, B>, D)
{
    type Mirror = M;
    type Module = L;
    type Port = P;
    type Board = B;
    type Data = D;
}
