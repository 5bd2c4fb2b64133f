//! Reads, creates and writes key files: one line of text each, the secret key readable by its owner
//! only.

use std::fs::{self, File};
use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use ed25519_dalek::{Signer, SigningKey};
use stairscan_boot::header::{HEADER, Header, SIGNED, sealed};
use stairscan_boot::key::{KEY, PublicKey};

use crate::output::no_stdout;
use crate::recording::{self, Readers, regular, write_together};

/// File with the secret key of development, which is in the repository and therefore not secret.
const DEVELOPMENT: &str = include_str!("../../../boot/keys/development.key");
/// Beginning of the line in the file of a secret key; the key follows in hexadecimal.
const SECRET: &str = "stairscan secret key ";
/// Beginning of the line in the file of a public key; the key follows in hexadecimal.
const PUBLIC: &str = "stairscan public key ";

/// Key from a file.
#[derive(Debug)]
pub enum Key {
    /// Secret key, from which the public key follows.
    Pair(SigningKey),
    /// Public key, with which a loader checks signatures.
    Public(PublicKey),
}

impl Key {
    /// Returns the public key.
    pub fn public(&self) -> PublicKey {
        match self {
            Key::Pair(pair) => PublicKey(pair.verifying_key().to_bytes()),
            Key::Public(key) => *key,
        }
    }

    /// Whether this is the development key, whose secret key is known to everybody.
    pub fn is_development(&self) -> bool {
        development().is_ok_and(|known| known.verifying_key().to_bytes() == self.public().0)
    }
}

/// Returns the secret key of development.
///
/// # Errors
/// The repository's file is no key.
pub fn development() -> Result<SigningKey> {
    match parse(DEVELOPMENT) {
        Ok(Key::Pair(pair)) => Ok(pair),
        _ => bail!("boot/keys/development.key: no secret key"),
    }
}

/// Formats bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Reads a file with a secret or a public key.
///
/// # Errors
/// Names the file and what it contains instead.
pub fn read(path: &Path) -> Result<Key> {
    regular(path)?;
    let name = || path.display().to_string();
    let text = recording::text(path)?;
    parse(&text).with_context(name)
}

/// Reads a file with a secret key, for signing.
///
/// # Errors
/// Names the file if it contains no secret key, or if others may read it.
pub fn read_secret(path: &Path) -> Result<SigningKey> {
    let Key::Pair(pair) = read(path)? else {
        bail!("{}: a public key: expected the secret half", path.display());
    };
    let mode = fs::metadata(path)?.permissions().mode();
    let known = Key::Pair(pair);
    ensure!(
        mode & 0o077 == 0 || known.is_development(),
        "{}: others may read this secret key: `chmod 600` it, or make another one if they have",
        path.display()
    );
    match known {
        Key::Pair(pair) => Ok(pair),
        Key::Public(_) => bail!("{}: a public key", path.display()),
    }
}

/// Reads a key of either kind from the text of its file.
///
/// # Errors
/// Names what is wrong with its first line.
pub fn parse(text: &str) -> Result<Key> {
    let line = text.lines().next().unwrap_or_default().trim_end();
    if let Some(digits) = line.strip_prefix(SECRET) {
        return Ok(Key::Pair(SigningKey::from_bytes(&bytes(digits)?)));
    }
    if let Some(digits) = line.strip_prefix(PUBLIC) {
        let key = bytes(digits)?;
        let point = ed25519_dalek::VerifyingKey::from_bytes(&key);
        ensure!(point.is_ok(), "no key: no point of the curve");
        return Ok(Key::Public(PublicKey(key)));
    }
    bail!("no key: expected a line that begins with `{SECRET}` or `{PUBLIC}`")
}

fn bytes(digits: &str) -> Result<[u8; KEY]> {
    ensure!(
        digits.len() == 2 * KEY && digits.bytes().all(|b| b.is_ascii_hexdigit()),
        "no key: expected {} hex digits",
        2 * KEY
    );
    let mut key = [0; KEY];
    for (k, byte) in key.iter_mut().enumerate() {
        *byte = u8::from_str_radix(&digits[2 * k..2 * k + 2], 16)?;
    }
    Ok(key)
}

/// Returns the path of the public key's file beside that of the secret key: the suffix is `pub`.
pub fn public_path(path: &Path) -> PathBuf {
    path.with_extension("pub")
}

/// Creates a key pair from the system's random numbers, writes the secret key to `path` and the
/// public key beside it, and returns the public key. Existing files are replaced only with `force`.
///
/// # Errors
/// Names the file that exists, or cannot be written.
pub fn create(path: &Path, force: bool) -> Result<PublicKey> {
    let public = public_path(path);
    ensure!(
        public != path,
        "{}: the public half gets that name: expected another one",
        path.display()
    );
    no_stdout(path)?;
    ensure!(
        path.extension().is_some_and(|suffix| suffix == "key"),
        "{}: expected a name that ends in .key, which this repository's .gitignore keeps out of commits",
        path.display()
    );
    let free = || {
        [path, &public].into_iter().try_for_each(|file| {
            ensure!(
                force || fs::symlink_metadata(file).is_err(),
                "{}: exists: expected another name, or --force to replace it. Images signed with a key that is lost cannot \
                 be followed by others",
                file.display()
            );
            Ok(())
        })
    };
    free()?;
    let mut seed = [0; KEY];
    let random = File::open("/dev/urandom").and_then(|mut source| source.read_exact(&mut seed));
    random.context("/dev/urandom")?;
    let pair = SigningKey::from_bytes(&seed);
    let key = PublicKey(pair.verifying_key().to_bytes());
    let secret = format!("{SECRET}{}\n", hex(&seed));
    let half = format!("{PUBLIC}{}\n", hex(&key.0));
    let files = [
        (path, secret.as_bytes(), Readers::Owner),
        (&*public, half.as_bytes(), Readers::All),
    ];
    write_together(&files, free)?;
    Ok(key)
}

/// Returns the header with its signature.
pub fn sign(key: &SigningKey, header: &Header) -> [u8; HEADER] {
    let message: [u8; SIGNED] = header.message();
    sealed(&message, &key.sign(&message).to_bytes())
}
