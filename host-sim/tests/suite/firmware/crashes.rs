//! Test builds with injected crashes, and what `cargo sim crash` makes of their sentences.

use super::*;

/// Returns what `cargo sim crash` makes of a sentence.
fn named(elf: &Path, sentence: &str) -> String {
    let output = sim(&["crash", elf.to_str().unwrap(), "--sentence", sentence]);
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert_eq!(output.status.code(), Some(0), "{sentence}: {text}");
    text
}

fn site(boot: &str) -> CrashSite {
    match Sentence::parse(boot) {
        Ok(Sentence::Boot(boot)) => boot.crash,
        other => panic!("{other:?} is no BOOT"),
    }
}

/// No exception frame fits on a stack that has overflowed: the frame pointer leads to the function.
fn overflow_is_named(elf: &Path, boot: &str) {
    let site = site(boot);
    assert_eq!((site.pc, site.place), (None, None), "{boot}");
    let text = named(elf, boot);
    for part in [
        "DACCVIOL",
        "STKERR, a bus fault",
        "the stack overflowed",
        "provoke::descend",
        "src/board/provoke.rs:",
        "PC: not known",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

fn panic_is_named(elf: &Path, boot: &str) {
    let source = std::fs::read_to_string(image::workspace().join("src/board/provoke.rs")).unwrap();
    let line = source.lines().position(|line| line.contains("panic!()"));
    let line = line.unwrap() + 1;
    assert_eq!(site(boot).address, None, "{boot}");
    let text = named(elf, boot);
    let place = format!(": src/board/provoke.rs:{line}:");
    assert!(text.contains(&place), "{place}: {text}");
    // An image of another revision is refused, and its lines are not shown.
    let Ok(Sentence::Boot(known)) = Sentence::parse(boot) else {
        panic!("{boot}");
    };
    let other = Sentence::Boot(BootLine {
        revision: "0123456789ab",
        ..known
    });
    let output = sim(&[
        "crash",
        elf.to_str().unwrap(),
        "--sentence",
        other.write().trim_end(),
    ]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("revision 0123456789ab"), "{text}");
    assert!(output.stdout.is_empty());
}

/// The frame's PC is on the stack, where code was executed; LR is behind the call.
fn execution_is_named(elf: &Path, sentence: &str) {
    let text = named(elf, sentence);
    for part in ["IACCVIOL", ": RAM", "src/board/provoke.rs:"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// Waits for the loader that three resets have forced to wait, and has it execute the image.
fn skip_window(session: &mut Session<'_>) {
    while !session
        .next_line("the loader's window")
        .unwrap()
        .contains(",resets*")
    {}
    let mut out = [0; MAX_FRAME];
    let boot = Frame {
        kind: Kind::Boot as u8,
        sequence: 1,
        payload: &[],
    };
    let count = encode(boot, &mut out);
    session.type_bytes(&out[..count]).unwrap();
}

/// Returns the next `BOOT`, which stands in one line with the loader's last answer: a frame has no line end.
fn boot_behind_a_frame(session: &mut Session<'_>) -> String {
    loop {
        let line = session.next_line("another boot").unwrap();
        if let Some(at) = line.find("$PSTR,BOOT,") {
            return line[at..].to_owned();
        }
    }
}

/// Test builds with injected crashes: overflow, panic and hang end in the fault path or with a watchdog reset, and
/// `stop` persists over them.
#[test]
fn crashes_end_in_the_fault_path() {
    if !tools(&[Tool::Target, Tool::Emulator]) {
        return;
    }
    let elf = image::build(&["provoke"]).unwrap();
    let recording = read("empty");
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let mut session = start(&elf, &playback, Waits::default());
    session.idle(Duration::from_millis(300)).unwrap();
    for (byte, reset, boots) in [(0x01, "memory-fault", 2), (0x02, "panic", 3)] {
        session.type_bytes(&[byte]).unwrap();
        let halt = session.next_halt().unwrap();
        assert_eq!(body(&halt), "HALT,crash");
        let boot = session.wait_for("another boot", |s| matches!(s, Sentence::Boot { .. }));
        let boot = boot.unwrap();
        assert!(
            boot.contains(&format!(",{reset},hsi-16,{boots},")),
            "{boot}"
        );
        match byte {
            0x01 => overflow_is_named(&elf, &boot),
            _ => panic_is_named(&elf, &boot),
        }
        let status = session.command("status").unwrap();
        // The reasons, then the state of the motion input and its age.
        assert!(
            body(&status).contains(",crash+internal-clock,absent,0,"),
            "{status}"
        );
    }
    assert_eq!(body(&session.command("stop").unwrap()), "DONE,stop");
    session.type_bytes(&[0x04]).unwrap();
    session.next_halt().unwrap();
    skip_window(&mut session);
    let boot = boot_behind_a_frame(&mut session);
    assert!(boot.contains(",memory-fault,"), "code in RAM: {boot}");
    execution_is_named(&elf, &boot);
    // The record stays until it is cleared.
    let crash = session.command("crash?").unwrap();
    assert!(body(&crash).starts_with("CRASH,memory-fault,3,"), "{crash}");
    execution_is_named(&elf, &crash);
    assert_eq!(
        body(&session.command("crash-clear").unwrap()),
        "DONE,crash-clear"
    );
    let crash = session.command("crash?").unwrap();
    assert_eq!(body(&crash), "CRASH,none,0,,,,,");
    let status = session.command("status").unwrap();
    assert!(body(&status).starts_with("STAT,idle,"), "{status}");
    assert!(body(&status).contains(",crash+crash-loop,"), "{status}");
    assert!(!session.shaft.enabled(), "the driver is off after a crash");

    let fed = session.watchdog_feeds();
    session.idle(Duration::from_millis(500)).unwrap();
    assert!(session.watchdog_feeds() > fed, "fed while all is well");
    session.type_bytes(&[0x03]).unwrap();
    session.idle(Duration::from_millis(200)).unwrap();
    let fed = session.watchdog_feeds();
    session.idle(Duration::from_millis(500)).unwrap();
    assert_eq!(
        session.watchdog_feeds(),
        fed,
        "nobody feeds it while the loop hangs"
    );
}
