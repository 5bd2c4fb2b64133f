//! Option bytes of a scanner's chip as text, and what to set in them.

use stairscan::scanner::option_bytes::{Brownout, OptionBytes, ReadProtection};

/// Sectors of the boot loader: its vector table and its code (`boot/src/layout.rs`).
const LOADER: [u32; 2] = [0, 4];
/// Number of sectors of the chip's flash.
const SECTORS: u32 = 12;

/// Returns the option bytes as text.
pub fn text(option_bytes: Option<OptionBytes>) -> String {
    let Some(bytes) = option_bytes else {
        return "unknown".to_owned();
    };
    let brownout = match bytes.brownout() {
        Brownout::Off => "brown-out reset off (1.8 V)",
        Brownout::Level1 => "brown-out reset level 1 (2.1 V)",
        Brownout::Level2 => "brown-out reset level 2 (2.4 V)",
        Brownout::Level3 => "brown-out reset level 3 (2.7 V)",
    };
    let read = match bytes.read_protection() {
        ReadProtection::Level0 => 0,
        ReadProtection::Level1 => 1,
        ReadProtection::Level2 => 2,
    };
    let protected: Vec<String> = (0..SECTORS)
        .filter(|&sector| bytes.is_protected(sector))
        .map(|sector| sector.to_string())
        .collect();
    let protected = match protected.is_empty() {
        true => "none".to_owned(),
        false => protected.join(", "),
    };
    format!(
        "{:08X}: {brownout}, read protection level {read}, write-protected sectors: {protected}",
        bytes.bits()
    )
}

/// Whether brown-out reset and write protection are as a scanner on a chair needs them.
pub fn is_safe(bytes: OptionBytes) -> bool {
    let protected = LOADER.iter().all(|&sector| bytes.is_protected(sector));
    bytes.brownout() == Brownout::Level3 && protected
}

/// Returns what to set, a line each, and how; empty if all is set.
pub fn fixes(bytes: OptionBytes) -> Vec<String> {
    let mut fixes = Vec::new();
    let mut names = Vec::new();
    if bytes.brownout() != Brownout::Level3 {
        names.push("BOR_LEV=0".to_owned());
        fixes.push(
            "BOR_LEV 0, brown-out reset level 3 (2.7 V): below it neither clock nor flash are specified."
                .to_owned(),
        );
    }
    let open = LOADER.iter().filter(|&&sector| !bytes.is_protected(sector));
    let open: Vec<String> = open.map(|sector| format!("nWRP{sector}=0")).collect();
    if !open.is_empty() {
        fixes.push(format!(
            "{}: a fault of the firmware cannot damage the boot loader.",
            open.join(", ")
        ));
        names.extend(open);
    }
    if bytes.read_protection() == ReadProtection::Level0 {
        names.push("RDP=0xBB".to_owned());
        fixes.push(
            "RDP 0xBB, read protection level 1, for a product: a probe reads no image; not on a board for development, for the way back erases the flash."
                .to_owned(),
        );
    }
    if !names.is_empty() {
        fixes.push(format!(
            "`STM32_Programmer_CLI -c port=SWD -ob {}`; with OpenOCD or probe-rs: docs/user/hardware.md, Option bytes.",
            names.join(" ")
        ));
    }
    fixes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(value: u32) -> OptionBytes {
        OptionBytes::of_register(value).unwrap()
    }

    #[test]
    fn a_new_chip_needs_all_three() {
        let new = of(0x0fff_aaed);
        assert!(!is_safe(new));
        assert_eq!(
            text(Some(new)),
            "0FFFAAEC: brown-out reset off (1.8 V), read protection level 0, write-protected sectors: none"
        );
        let fixes = fixes(new);
        let how = "-ob BOR_LEV=0 nWRP0=0 nWRP4=0 RDP=0xBB`";
        assert!(fixes.last().unwrap().contains(how), "{fixes:?}");
    }

    #[test]
    fn what_is_set_is_not_asked_for() {
        let product = of(0x0fee_bbe1);
        assert!(is_safe(product));
        assert_eq!(fixes(product), [""; 0]);
        assert!(text(Some(product)).ends_with("level 1, write-protected sectors: 0, 4"));
        // On a board for development only the read protection is left.
        let development = of(0x0fee_aae1);
        assert!(is_safe(development));
        assert_eq!(fixes(development).len(), 2);
        assert_eq!(text(None), "unknown");
    }
}
