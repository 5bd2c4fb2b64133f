//! Option bytes of the STM32F405: brown-out reset, read and write protection, from register FLASH_OPTCR.

/// Bits of FLASH_OPTCR that the chip loads from its option bytes (RM0090 3.9): nWRP, RDP, nRST_STDBY, nRST_STOP,
/// WDG_SW, BOR_LEV. The others start and lock their writing.
const LOADED: u32 = 0x0fff_ffec;
/// Position of nWRP: twelve bits, 0 where a sector is write-protected.
const WRITABLE: u32 = 16;
/// Position of RDP, eight bits.
const READ_PROTECTION: u32 = 8;
/// Position of BOR_LEV, two bits.
const BROWNOUT: u32 = 2;
/// Content of the option bytes of a new chip (RM0090 3.9, reset value of FLASH_OPTCR).
#[cfg(test)]
const NEW: u32 = 0x0fff_aaec;

/// Content of the option bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OptionBytes(u32);

/// Supply voltage below which the chip is held in reset (DS8626, embedded reset and power control block).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brownout {
    /// 1.8 V: only the power-on reset.
    Off,
    /// Level 1: 2.1 V.
    Level1,
    /// Level 2: 2.4 V.
    Level2,
    /// Level 3: 2.7 V, from which on 32 bits may be written at a time.
    Level3,
}

/// Protection of the flash from being read by a debug probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadProtection {
    /// None.
    Level0,
    /// Reading is locked; going back to level 0 erases the flash.
    Level1,
    /// Reading, debugging and the option bytes are locked for good.
    Level2,
}

impl OptionBytes {
    /// Returns the content of the option bytes from the value of FLASH_OPTCR; `None` for 0, which no chip has: the
    /// emulator, which has no flash controller.
    pub const fn of_register(value: u32) -> Option<Self> {
        match value {
            0 => None,
            _ => Some(Self(value & LOADED)),
        }
    }

    /// Returns the bits of FLASH_OPTCR that come from the option bytes, as `BOOT` reports them.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Returns the level of the brown-out reset.
    pub const fn brownout(self) -> Brownout {
        match self.0 >> BROWNOUT & 0b11 {
            0b00 => Brownout::Level3,
            0b01 => Brownout::Level2,
            0b10 => Brownout::Level1,
            _ => Brownout::Off,
        }
    }

    /// Returns the level of the read protection.
    pub const fn read_protection(self) -> ReadProtection {
        match self.0 >> READ_PROTECTION & 0xff {
            0xaa => ReadProtection::Level0,
            0xcc => ReadProtection::Level2,
            _ => ReadProtection::Level1,
        }
    }

    /// Whether the sector with this number, 0 to 11, is write-protected.
    pub const fn is_protected(self, sector: u32) -> bool {
        self.0 >> WRITABLE >> sector & 1 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_chip_has_no_protection() {
        // Its register has OPTLOCK set.
        let new = OptionBytes::of_register(NEW | 1).unwrap();
        assert_eq!(new.bits(), NEW);
        assert_eq!(new.brownout(), Brownout::Off);
        assert_eq!(new.read_protection(), ReadProtection::Level0);
        assert!((0..12).all(|sector| !new.is_protected(sector)));
        assert_eq!(OptionBytes::of_register(0), None);
    }

    #[test]
    fn each_field_is_read_from_its_bits() {
        let of = |value| OptionBytes::of_register(value).unwrap();
        let levels = [0x0fff_aae1, 0x0fff_aae5, 0x0fff_aae9, 0x0fff_aaed];
        let levels = levels.map(|value| of(value).brownout());
        let expected = [
            Brownout::Level3,
            Brownout::Level2,
            Brownout::Level1,
            Brownout::Off,
        ];
        assert_eq!(levels, expected);
        let product = of(0x0fee_55e1);
        assert_eq!(product.read_protection(), ReadProtection::Level1);
        let protected: Vec<_> = (0..12).filter(|&k| product.is_protected(k)).collect();
        assert_eq!(protected, [0, 4]);
        assert_eq!(of(0x0fff_cce1).read_protection(), ReadProtection::Level2);
    }
}
