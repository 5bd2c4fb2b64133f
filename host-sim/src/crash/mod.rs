//! From a crash that a scanner reports to words: file and line of its addresses, and the bits of the fault status.
//!
//! | module | content |
//! |---|---|
//! | [`report`] | the last crash in a scanner's sentences |
//! | [`cfsr`] | bits of register SCB_CFSR in words |
//! | [`image`] | functions, lines and panics of an ELF file |

pub mod cfsr;
pub mod image;
pub mod report;

use anyhow::{Result, bail};
use stairscan::report::CrashSite;
use stairscan_boot::layout::{FLOOR, LOADER_VECTORS, SLOT, SLOTS};

use self::image::Image;
use self::report::Report;

/// End of the flash of the scanner's chip.
const FLASH_END: u32 = LOADER_VECTORS + 0x10_0000;
/// Start of the settings in flash; they end where the anti-rollback counter begins.
const SETTINGS: u32 = LOADER_VECTORS + 0x4000;
/// Lowest value that the processor puts into LR at an exception (PM0214 2.3.7).
const EXCEPTION_RETURN: u32 = 0xffff_ffe0;

/// Checks that `image` is the one that crashed, by the revision that the scanner reports. Without a reported
/// revision, as of a lone `CRASH`, any image passes.
///
/// # Errors
/// The image was built from another revision; the message names the reported one.
pub fn check(image: &Image<'_>, report: &Report) -> Result<()> {
    match &report.revision {
        Some(revision) if !image.contains(revision.as_bytes()) => bail!(
            "the scanner runs an image of revision {revision}, and this file was built from another one: its lines \
             would be wrong. Build that revision, or take --force"
        ),
        _ => Ok(()),
    }
}

/// Returns the crash as text, one line for each value.
pub fn text(image: &Image<'_>, report: &Report) -> Result<String> {
    let CrashSite {
        pc,
        lr,
        cfsr,
        address,
        place,
    } = report.site;
    let mut lines = vec![format!("{} in boot {}", report.cause, report.boot)];
    if let Some(cfsr) = cfsr.filter(|&cfsr| cfsr != 0) {
        lines.push(format!("CFSR {cfsr:08X}: {}", cfsr::words(cfsr).join("; ")));
    }
    if let Some(address) = address {
        lines.push(format!("address {address:08X}: {}", area(image, address)));
    }
    if let Some(place) = place {
        let found = image.panic_at(place);
        let unknown = "no panic of this image has its hash";
        let at = found.unwrap_or_else(|| unknown.to_owned());
        lines.push(format!("panic {place:08X}: {at}"));
    }
    // The PC of a panic is a return address, as LR is.
    for (name, value, returns) in [("PC", pc, place.is_some()), ("LR", lr, true)] {
        match value {
            Some(value) => lines.push(format!(
                "{name} {value:08X}: {}",
                code(image, value, returns)?
            )),
            None => lines.push(format!("{name}: not known")),
        }
    }
    Ok(lines.join("\n") + "\n")
}

/// Returns the code at an address as text: functions, the innermost first, each with file and line. `returns`: the
/// address is that behind a call, whose line is meant.
fn code(image: &Image<'_>, address: u32, returns: bool) -> Result<String> {
    let address = address & !1;
    let in_slot = |slot: u32| (slot..slot + SLOT).contains(&address);
    if address >= EXCEPTION_RETURN {
        return Ok("an exception was being handled".to_owned());
    }
    // An image in slot B is that of slot A, moved.
    let (linked, moved) = if in_slot(SLOTS) {
        (address, "")
    } else if in_slot(SLOTS + SLOT) {
        (address - SLOT, " (slot b)")
    } else {
        return Ok(area(image, address));
    };
    let frames = image.frames(linked - if returns { 2 } else { 0 })?;
    if frames.is_empty() {
        return Ok("no code of this image".to_owned());
    }
    Ok(frames.join("\n    inlined into ") + moved)
}

/// Returns the kind of memory at an address as text.
fn area(image: &Image<'_>, address: u32) -> String {
    match address {
        0..0x0800_0000 => "nothing, as a null pointer",
        SETTINGS..FLOOR => "flash of the settings",
        LOADER_VECTORS..SLOTS => "flash of the boot loader",
        SLOTS..FLASH_END => "flash of an image",
        0x1000_0000..0x1001_0000 => "core-coupled memory",
        _ if image.guard().contains(&address) => "the guard below the stack: the stack overflowed",
        0x2000_0000..0x2002_0000 => "RAM",
        0x4000_0000..0x6000_0000 => "registers of a peripheral",
        0xe000_0000.. => "registers of the processor",
        _ => "no memory of this chip",
    }
    .to_owned()
}
