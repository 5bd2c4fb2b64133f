//! The boot loader without the chip: what a signed image is, which slot is executed, and how a new image is received.
//!
//! Bytes of two slots and of a small log come in over `embedded_storage`'s traits, requests of the host as frames; a decision
//! comes out, or an answer. Everything here runs on the host, where tests cut the power at every write and erasure.
//!
//! | module | what it is |
//! |---|---|
//! | [`layout`] | addresses in the chip's flash |
//! | [`header`] | the signed header of an image |
//! | [`key`] | public keys and the check of a signature |
//! | [`refusal`] | why an image is not taken or not executed |
//! | [`slot`] | the two slots: header, payload, marks |
//! | [`floor`] | the anti-rollback counter |
//! | [`start`] | which slot is executed |
//! | [`force`] | whether the loader waits for a host all the same |
//! | [`tell`] | the sentence that says so |
//! | [`frame`] | frames between host and loader |
//! | [`receive`] | a new image in, answers out |
//!
//! The method is two slots and no copy: an image is signed for the slot that it is linked for, written to the slot that does
//! not run, and executed from there. Nothing is ever moved, so that a power cut meets one slot at most, and never the one
//! that has been confirmed.
#![cfg_attr(not(test), no_std)]

pub mod floor;
pub mod force;
pub mod frame;
pub mod header;
pub mod key;
pub mod layout;
pub mod receive;
pub mod refusal;
pub mod slot;
pub mod start;
pub mod tell;
