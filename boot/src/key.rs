//! Public keys, and the check of a signature.

use ed25519_dalek::{Signature, VerifyingKey};

/// Bytes of a public key, as of a secret one.
pub const KEY: usize = 32;
/// Bytes of a signature.
pub const SIGNATURE: usize = 64;
/// Bytes by which a header names its key.
pub const KEY_ID: usize = 8;

/// The check of a header's signature: Ed25519, and in tests of power cuts a faster one.
pub trait Signatures {
    /// Returns the name of the key that is trusted.
    fn key_id(&self) -> [u8; KEY_ID];
    /// Returns whether the trusted key signed `message`.
    fn signed(&self, message: &[u8], signature: &[u8; SIGNATURE]) -> bool;
}

/// A public key of Ed25519 (RFC 8032).
#[derive(Clone, Copy, Debug)]
pub struct PublicKey(pub [u8; KEY]);

impl PublicKey {
    /// Name of a public key: its first bytes.
    pub fn id(&self) -> [u8; KEY_ID] {
        let [a, b, c, d, e, f, g, h, ..] = self.0;
        [a, b, c, d, e, f, g, h]
    }
}

impl Signatures for PublicKey {
    fn key_id(&self) -> [u8; KEY_ID] {
        self.id()
    }

    fn signed(&self, message: &[u8], signature: &[u8; SIGNATURE]) -> bool {
        let Ok(key) = VerifyingKey::from_bytes(&self.0) else {
            return false;
        };
        // Strict: keys and points of small order, by which one signature would fit many messages, are refused.
        key.verify_strict(message, &Signature::from_bytes(signature))
            .is_ok()
    }
}
