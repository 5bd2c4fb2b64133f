//! Signed images: keys in files, the same image for either slot, and its way into a scanner, on the host and in the emulator.

mod emulated;

use std::collections::BTreeSet;
use std::fs;
use std::io::{Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::Result;
use host_sim::emulate::image::{self, workspace};
use host_sim::emulate::qemu::Qemu;
use host_sim::emulate::tools::{TARGET, Tool};
use host_sim::update::client::{Client, LoaderLine};
use host_sim::update::keys;
use host_sim::update::package::Package;
use host_sim::update::wire::Wire;
use serialport::{SerialPort, TTYPort};
use stairscan::report::{BootLine, LiveLine, Sentence};
use stairscan::scanner::command::{Command as Line, framed, parse};
use stairscan::scanner::handover::Handover;
use stairscan::scanner::resets::Resets;
use stairscan_boot::floor::Floor;
use stairscan_boot::force::AtReset;
use stairscan_boot::frame::{ANSWER, Decoder, Frame, MAX_FRAME, encode};
use stairscan_boot::header::Header;
use stairscan_boot::key::PublicKey;
use stairscan_boot::layout;
use stairscan_boot::receive::{Effect, Receiver};
use stairscan_boot::slot::{Slot, Slots};
use stairscan_boot::start::{Asked, Loader};
use stairscan_boot::tell;
use testbed::{Flash, Power};

use crate::common::{Scratch, elf, sim, tools};

fn reported(output: &Output) -> String {
    String::from_utf8([&output.stdout[..], &output.stderr].concat()).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_secret_key_is_its_owner_s_alone_and_never_replaced_unasked() {
    let dir = Scratch::new("update-keys");
    let file = dir.path().join("maker.key");
    let public = dir.path().join("maker.pub");
    let new = |more: &[&str]| sim(&[&["keys", "new", text(&file)], more].concat());
    let made = new(&[]);
    assert_eq!(made.status.code(), Some(0), "{}", reported(&made));
    assert_eq!(
        fs::metadata(&file).unwrap().permissions().mode() & 0o777,
        0o600
    );
    let first = fs::read_to_string(&file).unwrap();
    for gone in [None, Some(&file)] {
        if let Some(gone) = gone {
            fs::remove_file(gone).unwrap();
        }
        // One of both is enough to refuse.
        let again = new(&[]);
        assert_eq!(again.status.code(), Some(1));
        assert!(reported(&again).contains("--force"), "{}", reported(&again));
    }
    fs::write(&file, &first).unwrap();
    let forced = new(&["--force"]);
    assert_eq!(forced.status.code(), Some(0), "{}", reported(&forced));
    assert_ne!(fs::read_to_string(&file).unwrap(), first);
    assert_eq!(
        fs::metadata(&file).unwrap().permissions().mode() & 0o777,
        0o600
    );
    assert_eq!(
        fs::read_dir(dir.path()).unwrap().count(),
        2,
        "nothing is left over"
    );
    let shown = sim(&["keys", "show", text(&public)]);
    assert!(
        reported(&shown).contains("public key"),
        "{}",
        reported(&shown)
    );
    assert!(
        !reported(&shown).contains("development"),
        "{}",
        reported(&shown)
    );
    // A name that git would take up is refused, and what is written is ignored.
    let named = sim(&["keys", "new", text(&dir.path().join("secret"))]);
    assert_eq!(named.status.code(), Some(1));
    assert!(reported(&named).contains(".key"), "{}", reported(&named));
    let ignored = include_str!("../../../.gitignore");
    for suffix in ["*.key", "*.pub", "*.signed"] {
        assert!(ignored.lines().any(|line| line == suffix), "{suffix}");
    }
    // A secret key that others may read signs nothing.
    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    let open = keys::read_secret(&file).unwrap_err().to_string();
    assert!(open.contains("chmod 600"), "{open}");
    let wrong = keys::read_secret(&public).unwrap_err().to_string();
    assert!(wrong.contains("public key"), "{wrong}");
    fs::write(&public, "stairscan public key 00\n").unwrap();
    assert!(keys::read(&public).is_err());
}

/// What a scanner at work says five times a second.
const LIVE: LiveLine<'_> = LiveLine {
    state: "scanning",
    scan: 1,
    uptime_ms: 1,
    age_ms: None,
    motion: "absent",
    motion_faults: 0,
    refused: 0,
    port_errors: 0,
    link_errors: 0,
};

/// A scanner on a pseudo-terminal: the loader's own code over flash in memory, and as much of an image as an update meets.
struct Device {
    path: String,
    pulled: Arc<AtomicBool>,
    /// Frames that are still answered before the supply goes; and comes again.
    supply: Arc<AtomicU32>,
    thread: JoinHandle<()>,
}

struct Inside {
    port: TTYPort,
    loader: Loader<Flash<{ layout::SLOT_SECTOR }>, Flash<{ layout::FLOOR_SECTOR }>, PublicKey>,
    in_loader: bool,
    on_trial: bool,
    /// Number of resets as the loader counts them.
    resets: Option<Resets>,
    /// Whether the image that stands in slot A first resets the chip again and again, and hears nothing.
    loops: bool,
    running: Option<Slot>,
    /// Whether self-tests pass.
    good: bool,
    line: Vec<u8>,
    decoder: Decoder,
    receiver: Receiver,
}

impl Inside {
    fn say(&mut self, bytes: &[u8]) {
        let _ = self.port.write_all(bytes);
    }

    fn reset(&mut self, handed: Option<Handover>) {
        self.decoder.reset();
        self.receiver = Receiver::new(30, true);
        let found = AtReset {
            handed,
            resets: self.resets,
            held: false,
        };
        let (forced, left) = found.decide(|| self.loader.has_trial());
        self.resets = left;
        let asked = match handed {
            Some(Handover::Confirm) => Asked::Confirm,
            _ => Asked::Nothing,
        };
        let start = match forced {
            None => self.loader.start(asked),
            Some(_) => None,
        };
        if let Some(line) = tell::sentence(&mut self.loader, start, handed, forced) {
            self.say(line.bytes());
        }
        self.running = start.map(|start| start.slot);
        self.in_loader = start.is_none();
        self.on_trial = start.is_some_and(|start| start.trial.is_some());
        if self.on_trial {
            self.resets = None;
        }
        if !self.in_loader {
            let boot = Sentence::Boot(BootLine {
                version: "0.1.0",
                revision: "test",
                reset: "software",
                clock: "hse-168",
                boots: 1,
                settings: 0,
                serial: [0; 3],
                ..BootLine::default()
            });
            self.say(boot.write().as_bytes());
        }
    }

    /// A line to the image.
    fn execute(&mut self) {
        let line = String::from_utf8_lossy(&std::mem::take(&mut self.line)).into_owned();
        match parse(&line) {
            Ok(Line::Stop) => {
                let done = Sentence::Done { command: "stop" }.write();
                self.say(done.as_bytes());
            }
            Ok(Line::Update) => {
                self.receiver = Receiver::new(30, true);
                self.in_loader = true;
            }
            Ok(Line::SelfTest) if self.on_trial && self.good => {
                self.reset(Some(Handover::Confirm));
            }
            Ok(Line::SelfTest) => {
                let fail = Sentence::Fail {
                    command: "selftest",
                    field: "home-not-found",
                    expected: "a test that passes",
                };
                self.say(fail.write().as_bytes());
            }
            _ => {}
        }
    }

    fn take(&mut self, byte: u8, supply: &AtomicU32) {
        if !self.in_loader {
            match byte {
                b'\r' | b'\n' if !self.line.is_empty() => self.execute(),
                b'\r' | b'\n' => {}
                _ => self.line.push(byte),
            }
            return;
        }
        let Some(frame) = self.decoder.push(byte) else {
            return;
        };
        if supply.fetch_sub(1, Ordering::Relaxed) == 1 {
            supply.store(u32::MAX, Ordering::Relaxed);
            self.resets = None;
            return self.reset(None);
        }
        let (kind, sequence) = (frame.kind, frame.sequence);
        let Some((answer, effect)) = self.receiver.handle(frame, &mut self.loader) else {
            return;
        };
        let mut out = [0; MAX_FRAME];
        let frame = Frame {
            kind: kind | ANSWER,
            sequence,
            payload: answer.bytes(),
        };
        let count = encode(frame, &mut out);
        self.say(&out[..count]);
        if effect == Effect::Reset {
            self.reset(Some(Handover::Execute));
        }
    }
}

impl Device {
    /// With `first` in slot A as a debug probe leaves it.
    fn plug_in(first: &Package, good: bool) -> Self {
        Self::with(first, good, false)
    }

    /// Likewise; `loops`: that image crashes half a second after each boot.
    fn with(first: &Package, good: bool, loops: bool) -> Self {
        let mut flash = vec![0xff; 2 * layout::SLOT as usize];
        let slot = first.image(Slot::A).slot(1);
        flash[..slot.len()].copy_from_slice(&slot);
        let key = PublicKey(keys::development().unwrap().verifying_key().to_bytes());
        let (mut master, slave) = TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        master.set_timeout(Duration::from_millis(5)).unwrap();
        let pulled = Arc::new(AtomicBool::new(false));
        let supply = Arc::new(AtomicU32::new(u32::MAX));
        let (ended, left) = (pulled.clone(), supply.clone());
        let thread = std::thread::spawn(move || {
            let _slave = slave;
            let power = Power::new(0);
            let mut inside = Inside {
                port: master,
                loader: Loader {
                    slots: Slots::new(Flash::with(flash, &power), layout::SLOTS),
                    floor: Floor::new(Flash::new(1, &power)),
                    keys: key,
                },
                in_loader: false,
                on_trial: false,
                resets: None,
                loops,
                running: None,
                good,
                line: Vec::new(),
                decoder: Decoder::new(),
                receiver: Receiver::new(30, true),
            };
            inside.reset(None);
            let mut crash = Instant::now();
            let mut buffer = [0; 512];
            let mut last = Instant::now();
            while !ended.load(Ordering::Relaxed) {
                if !inside.in_loader && last.elapsed() > Duration::from_millis(100) {
                    last = Instant::now();
                    inside.say(Sentence::Live(LIVE).write().as_bytes());
                }
                let mut count = inside.port.read(&mut buffer).unwrap_or(0);
                if inside.loops && inside.running == Some(Slot::A) {
                    count = 0;
                    if crash.elapsed() > Duration::from_millis(500) {
                        crash = Instant::now();
                        inside.reset(None);
                    }
                }
                for &byte in &buffer[..count] {
                    inside.take(byte, &left);
                }
            }
        });
        Self {
            path,
            pulled,
            supply,
            thread,
        }
    }

    fn unplug(self) {
        self.pulled.store(true, Ordering::Relaxed);
        self.thread.join().unwrap();
    }
}

/// An image of some kilobytes in both slots, signed with the development key.
fn package(seed: u8, number: u32, change: impl Fn(&mut Header)) -> Package {
    let key = keys::development().unwrap();
    let payload: Vec<u8> = (0..140_000_u32)
        .map(|k| ((k * 31) >> 3) as u8 ^ seed)
        .collect();
    Package::of(&key, |slot| {
        let mut header = Package::header(&payload, slot, number, &key);
        change(&mut header);
        (header, payload.clone())
    })
}

fn write(dir: &Scratch, name: &str, bytes: &[u8]) -> String {
    let path = dir.path().join(name);
    fs::write(&path, bytes).unwrap();
    text(&path).to_owned()
}

/// A signed image that is cut off is named as such, with the number of bytes that are missing.
#[test]
fn keys_show_says_how_much_of_a_signed_image_is_missing() {
    let dir = Scratch::new("update-cut");
    let bytes = package(1, 3, |_| ()).bytes();
    let (header, payload) = (144, 140_000);
    assert_eq!(bytes.len(), 2 * (header + payload));
    for (held, words) in [
        (
            100,
            "cut off: 100 of 144 bytes of the header for slot a".to_owned(),
        ),
        (
            header + 1000,
            format!(
                "cut off: 1000 of 140000 bytes of the image for slot a; {} bytes are missing",
                bytes.len() - header - 1000
            ),
        ),
        (
            header + payload + 44,
            "cut off: 44 of 144 bytes of the header for slot b; 140100 bytes are missing"
                .to_owned(),
        ),
        (
            bytes.len() - 7,
            "cut off: 139993 of 140000 bytes of the image for slot b; 7 bytes are missing"
                .to_owned(),
        ),
    ] {
        let file = write(&dir, "cut", &bytes[..held]);
        let shown = sim(&["keys", "show", &file]);
        assert_eq!(shown.status.code(), Some(1), "{}", reported(&shown));
        let text = reported(&shown);
        assert!(
            text.contains(&words) && text.contains("cut: "),
            "{words}: {text}"
        );
    }
    let mut flipped = bytes.clone();
    flipped[1000] ^= 1;
    let shown = sim(&["keys", "show", &write(&dir, "flipped", &flipped)]);
    assert!(reported(&shown).contains("damaged"), "{}", reported(&shown));
    let shown = sim(&["keys", "show", &write(&dir, "text", b"hello\n")]);
    assert!(
        reported(&shown).contains("no key: expected"),
        "{}",
        reported(&shown)
    );
}

#[test]
fn an_update_goes_through_a_loss_of_power_to_its_confirmation_and_back() {
    let dir = Scratch::new("update-whole");
    let device = Device::plug_in(&package(1, 0, |_| ()), true);
    let file = write(&dir, "new", &package(2, 0, |_| ()).bytes());
    // The supply goes in the midst of the transfer: behind greetings, rate, header, and 130 KB.
    device.supply.store(136, Ordering::Relaxed);
    let broken = sim(&["update", &device.path, &file]);
    assert_eq!(broken.status.code(), Some(1), "{}", reported(&broken));
    assert!(
        reported(&broken).contains("repeat the command"),
        "{}",
        reported(&broken)
    );
    let update = sim(&["update", &device.path, &file]);
    assert_eq!(update.status.code(), Some(0), "{}", reported(&update));
    let said = reported(&update);
    for part in [
        "slot a: confirmed",
        "goes to slot b",
        "from byte 130560 on",
        "at 3000000 baud",
        "confirmed: the self-test has passed",
        "development key",
    ] {
        assert!(said.contains(part), "{part} in {said}");
    }
    let shown = sim(&["update", &device.path, "--show"]);
    assert!(
        reported(&shown).contains("slot b: confirmed"),
        "{}",
        reported(&shown)
    );
    let back = sim(&["update", &device.path, "--back"]);
    assert_eq!(back.status.code(), Some(0), "{}", reported(&back));
    let shown = sim(&["update", &device.path, "--show"]);
    assert!(
        reported(&shown).contains("slot b: given-up"),
        "{}",
        reported(&shown)
    );
    // A higher number is the end of the old one.
    let file = write(&dir, "newer", &package(3, 7, |_| ()).bytes());
    let update = sim(&["update", &device.path, &file]);
    assert_eq!(update.status.code(), Some(0), "{}", reported(&update));
    let older = write(&dir, "older", &package(4, 6, |_| ()).bytes());
    let refused = sim(&["update", &device.path, &older]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        reported(&refused).contains("older-version"),
        "{}",
        reported(&refused)
    );
    let refused = sim(&["update", &device.path, "--back"]);
    assert!(
        reported(&refused).contains("no-way-back"),
        "{}",
        reported(&refused)
    );
    device.unplug();
}

#[test]
fn a_confirmed_image_that_crashes_again_and_again_is_replaced() {
    let dir = Scratch::new("update-loop");
    let device = Device::with(&package(1, 0, |_| ()), true, true);
    let file = write(&dir, "new", &package(2, 0, |_| ()).bytes());
    let update = sim(&["update", &device.path, &file]);
    assert_eq!(update.status.code(), Some(0), "{}", reported(&update));
    let said = reported(&update);
    assert!(
        said.contains("confirmed: the self-test has passed"),
        "{said}"
    );
    device.unplug();
}

#[test]
fn each_wrong_file_has_its_own_answer() {
    let dir = Scratch::new("update-refused");
    let device = Device::plug_in(&package(1, 3, |_| ()), true);
    let good = package(2, 3, |_| ());
    let bytes = good.bytes();
    let mut flipped = bytes.clone();
    flipped[100_000] ^= 1;
    let mut header = bytes.clone();
    for at in [100, bytes.len() / 2 + 100] {
        header[at] ^= 1;
    }
    let other = |change: fn(&mut Header)| package(2, 3, change).bytes();
    let wrong = [
        ("cut-off", bytes[..200_000].to_vec(), "cut off"),
        ("flipped", flipped, "damaged"),
        ("signature", header, "bad-signature"),
        ("key", other(|h| h.key_id[0] ^= 1), "wrong-key"),
        ("chip", other(|h| h.chip ^= 1), "other-chip"),
        ("slot", other(|h| h.base ^= 0x10_0000), "other-slot"),
        ("older", package(2, 2, |_| ()).bytes(), "older-version"),
        ("text", b"# no image\n".repeat(40), "no signed image"),
        ("empty", Vec::new(), "cut off"),
        ("longer", [&bytes[..], b"x"].concat(), "too many"),
    ];
    for (name, bytes, answer) in wrong {
        let file = write(&dir, name, &bytes);
        let refused = sim(&["update", &device.path, &file]);
        assert_eq!(
            refused.status.code(),
            Some(1),
            "{name}: {}",
            reported(&refused)
        );
        assert!(
            reported(&refused).contains(answer),
            "{name}: {}",
            reported(&refused)
        );
    }
    device.unplug();
}

#[test]
fn an_image_whose_self_test_fails_is_not_confirmed() {
    let dir = Scratch::new("update-faulty");
    let device = Device::plug_in(&package(1, 0, |_| ()), false);
    let file = write(&dir, "new", &package(2, 0, |_| ()).bytes());
    let update = sim(&["update", &device.path, &file, "--wait", "1"]);
    assert_eq!(update.status.code(), Some(1), "{}", reported(&update));
    assert!(
        reported(&update).contains("home-not-found"),
        "{}",
        reported(&update)
    );
    device.unplug();
}

/// The loader holds no crate that its list does not name, nor the other way round.
#[test]
fn the_crates_of_the_loader_are_those_of_the_list() {
    let crates = |package: &str| -> BTreeSet<String> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let output = Command::new(cargo)
            .current_dir(workspace())
            .args(["tree", "--package", package, "--target", TARGET])
            .args(["--locked", "--edges", "normal", "--prefix", "none"])
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let lines = text.lines().filter(|line| !line.contains('('));
        let whole = lines.filter_map(|line| line.split_once(" v"));
        whole
            .map(|(name, version)| format!("`{name}` {version}"))
            .collect()
    };
    let document = fs::read_to_string(workspace().join("docs/generated/supply-chain.md")).unwrap();
    let (_, list) = document.split_once("## Crates of the boot loader").unwrap();
    let (list, _) = list.split_once("\n## ").unwrap();
    let rows = list.lines().filter_map(|line| line.strip_prefix("| `"));
    let rows = rows.filter_map(|row| row.split_once(" |"));
    let named: BTreeSet<String> = rows.map(|(name, _)| format!("`{name}")).collect();
    let image = crates("stairscan");
    assert!(image.len() > 20, "{image:?}");
    let loader: BTreeSet<String> = crates("stairscan-boot")
        .difference(&image)
        .cloned()
        .collect();
    assert_eq!(loader, named);
}
