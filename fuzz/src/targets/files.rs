//! Files of signed updates: the first byte selects the kind of file, the rest is its content.
//!
//! | first byte, modulo 3 | file | must hold |
//! |---|---|---|
//! | 0 | package of `keys sign` | what is parsed is written as the same bytes |
//! | 1 | key | a public key is one that the boot loader can verify with |
//! | 2 | ELF file of the image | both payloads have the same length, within a slot |

use host_sim::update::keys::{self, Key};
use host_sim::update::package::Package;
use host_sim::update::slots;
use stairscan_boot::layout::SLOT;

/// Parses the file.
pub fn run(data: &[u8]) {
    let Some((kind, content)) = data.split_first() else {
        return;
    };
    match kind % 3 {
        0 => package(content),
        1 => key(content),
        _ => elf(content),
    }
}

fn package(content: &[u8]) {
    if let Ok(package) = Package::parse(content) {
        assert_eq!(package.bytes(), content);
    }
}

fn key(content: &[u8]) {
    let Ok(text) = str::from_utf8(content) else {
        return;
    };
    if let Ok(Key::Public(public)) = keys::parse(text) {
        assert!(ed25519_dalek::VerifyingKey::from_bytes(&public.0).is_ok());
    }
}

fn elf(content: &[u8]) {
    let Ok([slots::Payload(a), slots::Payload(b)]) = slots::parse(content) else {
        return;
    };
    assert_eq!(a.len(), b.len());
    assert!(a.len().is_multiple_of(4) && a.len() < SLOT as usize);
}
