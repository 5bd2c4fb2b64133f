//! Loader and image in the emulator, from its slots and from the files for other programs.

use super::*;

/// The emulator's report port as a wire.
struct Socket(UnixStream);

impl Wire for Socket {
    fn receive(&mut self, buffer: &mut [u8]) -> Result<usize> {
        Ok(self.0.read(buffer).unwrap_or(0))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        Ok(self.0.write_all(bytes)?)
    }

    fn set_rate(&mut self, _: u32) -> Result<()> {
        Ok(())
    }
}

impl Socket {
    fn of(emulator: &Qemu) -> Self {
        let socket = emulator.report.try_clone().unwrap();
        socket.set_nonblocking(false).unwrap();
        let timeout = Some(Duration::from_millis(20));
        socket.set_read_timeout(timeout).unwrap();
        Self(socket)
    }

    /// The first line that `wanted` takes.
    fn wait<T>(&mut self, wanted: impl Fn(&str) -> Option<T>) -> T {
        let until = Instant::now() + Duration::from_secs(60);
        let mut all = Vec::new();
        let mut buffer = [0; 256];
        loop {
            let count = self.receive(&mut buffer).unwrap();
            all.extend(&buffer[..count]);
            let text = String::from_utf8_lossy(&all).into_owned();
            let mut whole = text
                .split_inclusive('\n')
                .filter(|line| line.ends_with('\n'));
            if let Some(found) = whole.find_map(|line| wanted(line.trim_end())) {
                return found;
            }
            assert!(Instant::now() < until, "{text}");
        }
    }
}

fn boots(line: &str) -> Option<()> {
    matches!(Sentence::parse(line), Ok(Sentence::Boot { .. })).then_some(())
}

/// The very loader in the emulator: the image runs from either slot, moved by its relocations; a flipped byte is refused and
/// said; of two the confirmed and whole one runs; and an update comes as far as a chip without a flash controller lets it.
#[test]
fn the_emulated_image_boots_through_the_loader_and_a_flipped_byte_is_refused() {
    let Some(elf) = elf() else { return };
    let package = Package::sign(elf, 0, &keys::development().unwrap()).unwrap();
    let slot = |slot, order| package.image(slot).slot(order);
    let mut flipped = slot(Slot::B, 2);
    flipped[200_000] ^= 0x10;

    // From slot B, with its seal right there, too: nothing is damaged.
    let emulator = Qemu::start_with(&[(Slot::B, slot(Slot::B, 1))]).unwrap();
    let mut port = Socket::of(&emulator);
    port.wait(boots);
    port.send(framed(&["stop"]).as_bytes()).unwrap();
    port.send(b"status\r\n").unwrap();
    port.wait(|line| match Sentence::parse(line) {
        Ok(Sentence::State { reasons, .. }) => {
            assert!(!reasons.to_string().contains("image"), "{line}");
            Some(())
        }
        _ => None,
    });
    drop(emulator);

    // The newer one is damaged: the older one runs, and that is said.
    let emulator =
        Qemu::start_with(&[(Slot::A, slot(Slot::A, 1)), (Slot::B, flipped.clone())]).unwrap();
    let mut port = Socket::of(&emulator);
    let line = port.wait(|line| LoaderLine::parse(line).map(|_| line.to_owned()));
    assert!(
        line.starts_with("$PSTR,LOADER,a,0,confirmed,damaged*"),
        "{line}"
    );
    port.wait(boots);
    drop(emulator);

    // Nothing else there: nothing is executed, and the loader takes requests.
    let emulator = Qemu::start_with(&[(Slot::B, flipped)]).unwrap();
    let mut port = Socket::of(&emulator);
    let line = port.wait(|line| LoaderLine::parse(line).map(|_| line.to_owned()));
    assert!(line.starts_with("$PSTR,LOADER,,0,empty,damaged*"), "{line}");
    drop(emulator);

    // From the running image into the loader, up to the flash that takes nothing.
    let emulator = Qemu::start_with(&[(Slot::A, slot(Slot::A, 1))]).unwrap();
    let mut port = Socket::of(&emulator);
    port.wait(boots);
    let client = Client::enter(port).unwrap();
    assert_eq!(client.spare(), Slot::B);
    is_refused_and_boots(client, &package, &emulator);
}

/// Sends an image to the loader, whose flash takes nothing in the emulator, and leaves it: the image before runs.
fn is_refused_and_boots(mut client: Client<Socket>, package: &Package, emulator: &Qemu) {
    let refused = client.send(package, 115_200, |_, _| ()).unwrap_err();
    assert!(
        format!("{refused:#}").contains("refused: flash"),
        "{refused:#}"
    );
    client.boot().unwrap();
    let mut port = Socket::of(emulator);
    port.wait(boots);
}

/// A confirmed image that crashes at once three times: the loader opens its window, says why, and takes requests; after
/// them the image runs again.
#[test]
fn a_confirmed_image_that_loops_ends_in_the_loader_s_window() {
    if !tools(&[Tool::Target, Tool::Emulator]) {
        return;
    }
    /// Control byte of the test build that panics.
    const PANIC: u8 = 0x02;
    let elf = image::build(&["provoke"]).unwrap();
    let package = Package::sign(&elf, 0, &keys::development().unwrap()).unwrap();
    let emulator = Qemu::start_with(&[(Slot::A, package.image(Slot::A).slot(1))]).unwrap();
    let mut port = Socket::of(&emulator);
    for _ in 0..3 {
        port.wait(boots);
        port.send(&[PANIC]).unwrap();
    }
    let line = port.wait(|line| LoaderLine::parse(line).map(|_| line.to_owned()));
    assert!(
        line.starts_with("$PSTR,LOADER,,0,confirmed,empty,resets*"),
        "{line}"
    );
    let client = Client::enter(port).unwrap();
    is_refused_and_boots(client, &package, &emulator);
}

/// The files for other programs hold what a debug probe writes: the loader, and an image that it executes. None replaces
/// another one unasked, and none is signed with a key that the loader does not trust.
#[test]
fn files_for_other_programs_hold_loader_and_image() {
    if !tools(&[Tool::Target, Tool::Emulator]) {
        return;
    }
    let dir = Scratch::new("update-image");
    let folder = dir.path().join("flash");
    let command = ["image", "-o", text(&folder)];
    let made = sim(&command);
    assert_eq!(made.status.code(), Some(0), "{}", reported(&made));
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    let whole = read("stairscan.bin");
    let parts = [0x0800_0000_u32, 0x0801_0000, layout::SLOTS].map(|at| {
        let name = format!("stairscan-{at:08x}.bin");
        let line = format!(
            "{name}: {} bytes, for address 0x{at:08x}\n",
            read(&name).len()
        );
        assert!(reported(&made).contains(&line), "{}", reported(&made));
        (at, read(&name))
    });
    assert_eq!(fs::read_dir(&folder).unwrap().count(), parts.len() + 2);
    let (mut erased, mut bytes, mut upper) = (vec![0xff; whole.len()], 0, 0);
    for record in ihex::Reader::new(&String::from_utf8(read("stairscan.hex")).unwrap()) {
        match record.unwrap() {
            ihex::Record::ExtendedLinearAddress(half) => upper = usize::from(half) << 16,
            ihex::Record::Data { offset, value } => {
                let at = upper + usize::from(offset) - 0x0800_0000;
                erased[at..at + value.len()].copy_from_slice(&value);
                bytes += value.len();
            }
            _ => {}
        }
    }
    assert_eq!(erased, whole);
    assert_eq!(
        bytes,
        parts.iter().map(|(_, part)| part.len()).sum::<usize>()
    );
    for (at, part) in &parts {
        assert_eq!(whole[(at - 0x0800_0000) as usize..][..part.len()], part[..]);
    }
    let [.., (_, image)] = parts;
    let emulator = Qemu::start_with(&[(Slot::A, image)]).unwrap();
    Socket::of(&emulator).wait(boots);

    let again = sim(&command);
    assert_eq!(again.status.code(), Some(1));
    assert!(reported(&again).contains("--force"), "{}", reported(&again));
    let key = dir.path().join("maker.key");
    keys::create(&key, false).unwrap();
    let foreign = sim(&[&command[..], &["--force", "--key", text(&key)]].concat());
    assert_eq!(foreign.status.code(), Some(1));
    assert!(
        reported(&foreign).contains("would not execute"),
        "{}",
        reported(&foreign)
    );
    assert_eq!(read("stairscan.bin"), whole);
}
