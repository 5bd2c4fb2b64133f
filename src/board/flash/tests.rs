//! The driver on a model of the flash controller's registers (RM0090 3.6, 3.9).

use std::cell::{Cell, RefCell};

use stairscan::scanner::Settings;
use stairscan::scanner::store::Store;

use super::*;

/// Beginning of the flash.
const FLASH: u32 = 0x0800_0000;
/// Sizes of the sectors, KB (RM0090, table 5).
const SECTORS: [usize; 12] = [16, 16, 16, 16, 64, 128, 128, 128, 128, 128, 128, 128];

/// The settings' region of the image.
type SettingsFlash = Sectors<Model, { 16 * 1024 }, 2>;
/// The slots' region of the loader.
type SlotFlash = Sectors<Model, { 128 * 1024 }, 6>;

/// A defect that the driver is tested against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Defect {
    None,
    /// Each write of FLASH_CR begins from the reset value, as `cr().write(|w| …)` does.
    ControlFromReset,
    /// The keys come in the other order.
    KeysSwapped,
    /// The busy flag stays set after an operation.
    Stuck,
    /// An operation ends with these flags of FLASH_SR.
    Flags(u32),
    /// The supply falls after this number of operations.
    Supply(u32),
}

/// Registers and content of the flash. What silicon would not forgive is a complaint.
struct Model {
    defect: Defect,
    access: u32,
    status: u32,
    control: u32,
    /// Keys that have been written in the right order.
    keys: usize,
    /// A wrong key: locked until the next reset.
    blocked: bool,
    operations: u32,
    /// Polls until the operation under way ends.
    busy: Cell<u32>,
    /// Whether a cache may hold content from before an operation.
    stale: bool,
    bytes: Vec<u8>,
    complaints: RefCell<Vec<String>>,
}

impl Model {
    fn new(defect: Defect) -> Self {
        Self {
            defect,
            // As the clock's set-up leaves it: 5 wait states, prefetch, both caches.
            access: 0b111 << 8 | 5,
            // An error of somebody before.
            status: 1 << 7,
            control: LOCK,
            keys: 0,
            blocked: false,
            operations: 0,
            busy: Cell::new(0),
            stale: false,
            // Nothing is blank by itself.
            bytes: vec![0x5a; 1024 * 1024],
            complaints: RefCell::default(),
        }
    }

    fn complain(&self, what: &str) {
        self.complaints.borrow_mut().push(what.to_owned());
    }

    fn begin(&mut self) {
        self.operations += 1;
        self.stale = true;
        self.busy.set(3);
        match self.defect {
            Defect::Stuck => self.busy.set(u32::MAX),
            Defect::Flags(flags) => self.status |= flags,
            _ => {}
        }
    }

    fn key(&mut self, key: u32) {
        let mut right = KEYS;
        if self.defect == Defect::KeysSwapped {
            right.reverse();
        }
        if self.control & LOCK == 0 || self.blocked || right[self.keys] != key {
            self.complain("a wrong key");
            self.blocked = true;
            self.control |= LOCK;
            return;
        }
        self.keys += 1;
        if self.keys == right.len() {
            self.keys = 0;
            self.control &= !LOCK;
        }
    }

    fn control(&mut self, value: u32) {
        if self.busy.get() > 0 {
            self.complain("FLASH_CR written during an operation");
        }
        if self.control & LOCK != 0 {
            return self.complain("FLASH_CR written while locked");
        }
        if value & !(OPERATION | START | LOCK) != 0 {
            self.complain("reserved bits or interrupts");
        }
        self.control = match self.defect {
            Defect::ControlFromReset => value | LOCK,
            _ => value,
        };
        if self.control & START != 0 {
            self.erase();
            self.control &= !START;
        }
    }

    fn erase(&mut self) {
        if self.control & (ERASE | PROGRAM | 0b11 << 8) != ERASE | WORDWISE || self.status != 0 {
            self.complain("an erasure that is not selected, or after an error");
        }
        let number = (self.control >> SECTOR_SHIFT & 0b1111) as usize;
        let from: usize = SECTORS[..number].iter().sum();
        self.bytes[from * 1024..(from + SECTORS[number]) * 1024].fill(0xff);
        self.begin();
    }

    fn caches(&mut self, value: u32) {
        // Each cache's reset bit stands two above its enable bit.
        if (value >> 2) & (value | self.access) & CACHES != 0 {
            self.complain("a cache reset while it is enabled");
        }
        if value & CACHE_RESETS == CACHE_RESETS {
            self.stale = false;
        }
        self.access = value;
    }
}

impl Controller for Model {
    fn get(&self, register: Register) -> u32 {
        match register {
            Register::Access => self.access,
            Register::Key => 0,
            Register::Control => self.control,
            Register::Status => {
                let left = self.busy.get();
                let forever = left == u32::MAX;
                self.busy.set(if forever {
                    left
                } else {
                    left.saturating_sub(1)
                });
                self.status | if left > 0 { BUSY } else { 0 }
            }
        }
    }

    fn set(&mut self, register: Register, value: u32) {
        match register {
            Register::Access => self.caches(value),
            Register::Key => self.key(value),
            Register::Status => self.status &= !(value & FLAGS),
            Register::Control => self.control(value),
        }
    }

    fn write_word(&mut self, address: u32, word: u32) {
        if self.control & (LOCK | PROGRAM | ERASE | 0b11 << 8) != PROGRAM | WORDWISE
            || self.status != 0
        {
            self.status |= 1 << 7;
            return self.complain("a word that is not selected, or after an error");
        }
        let place = (address - FLASH) as usize;
        let bytes = &mut self.bytes[place..place + 4];
        let both = bytes.iter_mut().zip(word.to_le_bytes());
        both.for_each(|(byte, new)| *byte &= new);
        self.begin();
    }

    fn fetch(&self, address: u32, bytes: &mut [u8]) {
        if self.stale && self.access & CACHES != 0 {
            self.complain("a read through a cache that was not emptied");
        }
        let place = (address - FLASH) as usize;
        bytes.copy_from_slice(&self.bytes[place..place + bytes.len()]);
    }

    fn supplied(&self) -> bool {
        !matches!(self.defect, Defect::Supply(after) if self.operations >= after)
    }

    fn wait(&self, at_most_us: u32, mut ended: impl FnMut() -> bool) -> bool {
        (0..at_most_us).any(|_| ended())
    }
}

fn settings_flash(defect: Defect) -> SettingsFlash {
    Sectors::new(Model::new(defect), FLASH + 16 * 1024, 1)
}

fn slot_flash(defect: Defect) -> SlotFlash {
    Sectors::new(Model::new(defect), FLASH + 128 * 1024, 5)
}

/// Asserts that the controller is locked with nothing selected, the caches are as before, and nothing was
/// complained about.
fn left_in_order<const S: usize, const N: usize>(region: &mut Sectors<Model, S, N>) {
    let model = region.chip();
    assert_eq!(*model.complaints.borrow(), [""; 0]);
    assert_eq!(model.control & (LOCK | OPERATION | START), LOCK);
    assert_eq!(model.access, 0b111 << 8 | 5);
}

#[test]
fn words_are_written_into_erased_sectors_of_both_regions() {
    let mut settings = settings_flash(Defect::None);
    settings.erase(16 * 1024, 32 * 1024).unwrap();
    settings
        .write(16 * 1024 + 8, &[1, 2, 3, 4, 5, 6, 7, 8])
        .unwrap();
    let mut back = [0; 12];
    settings.read(16 * 1024 + 4, &mut back).unwrap();
    assert_eq!(back, [255, 255, 255, 255, 1, 2, 3, 4, 5, 6, 7, 8]);
    left_in_order(&mut settings);
    let blank = |model: &Model| {
        let from = model.bytes.iter().position(|&b| b != 0x5a);
        let to = model.bytes.iter().rposition(|&b| b != 0x5a);
        (from.unwrap(), to.unwrap() + 1)
    };
    assert_eq!(blank(settings.chip()), (32 * 1024, 48 * 1024));

    let mut slots = slot_flash(Defect::None);
    slots.erase(3 * 128 * 1024, 6 * 128 * 1024).unwrap();
    left_in_order(&mut slots);
    assert_eq!(blank(slots.chip()), (512 * 1024, 896 * 1024));
}

/// The defect that no setting could be saved with: a write of FLASH_CR from its reset value locks the controller.
#[test]
fn a_control_register_that_is_written_from_its_reset_value_is_noticed() {
    let mut flash = settings_flash(Defect::ControlFromReset);
    assert_eq!(flash.check(), Err(FlashError::Controller));
    assert_eq!(flash.erase(0, 16 * 1024), Err(FlashError::Controller));
    assert_eq!(flash.write(0, &[0; 4]), Err(FlashError::Controller));
    assert_eq!(flash.chip().operations, 0);
    assert_eq!(settings_flash(Defect::None).check(), Ok(()));
}

#[test]
fn a_controller_that_stays_locked_is_an_error() {
    let mut flash = settings_flash(Defect::KeysSwapped);
    assert_eq!(flash.check(), Err(FlashError::Controller));
    assert_eq!(flash.write(0, &[0; 4]), Err(FlashError::Controller));
    assert_eq!(flash.chip().operations, 0);
}

#[test]
fn an_operation_that_does_not_end_or_reports_an_error_has_failed() {
    let errors = [1, 4, 5, 6, 7].map(|bit| Defect::Flags(1 << bit));
    for defect in errors.into_iter().chain([Defect::Stuck]) {
        let mut flash = settings_flash(defect);
        let erased = flash.erase(0, 16 * 1024);
        assert_eq!(erased, Err(FlashError::Failed), "{defect:?}");
        let mut flash = settings_flash(defect);
        let written = flash.write(0, &[0; 8]);
        assert_eq!(written, Err(FlashError::Failed), "{defect:?}");
        assert_eq!(flash.chip().operations, 1, "{defect:?}");
    }
    // The end of an operation is no error.
    let mut flash = settings_flash(Defect::Flags(1));
    assert_eq!(flash.erase(0, 16 * 1024), Ok(()));
}

/// An error of an operation does not fail the next one.
#[test]
fn flags_are_cleared_before_an_operation() {
    let mut flash = settings_flash(Defect::Flags(1 << 4));
    assert_eq!(flash.erase(0, 16 * 1024), Err(FlashError::Failed));
    flash.chip().defect = Defect::None;
    assert_eq!(flash.erase(0, 16 * 1024), Ok(()));
    left_in_order(&mut flash);
}

#[test]
fn nothing_is_written_below_the_supply_that_32_bits_need() {
    let mut flash = settings_flash(Defect::Supply(0));
    assert_eq!(flash.check(), Err(FlashError::Supply));
    assert_eq!(flash.erase(0, 16 * 1024), Err(FlashError::Supply));
    assert_eq!(flash.write(0, &[0; 4]), Err(FlashError::Supply));
    assert_eq!(flash.chip().operations, 0);
    left_in_order(&mut flash);
    // It falls between two sectors.
    let mut flash = settings_flash(Defect::Supply(1));
    assert_eq!(flash.erase(0, 32 * 1024), Err(FlashError::Supply));
    assert_eq!(flash.chip().operations, 1);
    left_in_order(&mut flash);
}

#[test]
fn ranges_outside_or_not_of_whole_units_are_refused() {
    let mut flash = settings_flash(Defect::None);
    let place = Err(FlashError::Place);
    assert_eq!(flash.erase(0, 4), place);
    assert_eq!(flash.erase(16 * 1024, 0), place);
    assert_eq!(flash.erase(0, 48 * 1024), place);
    assert_eq!(flash.write(2, &[0; 4]), place);
    assert_eq!(flash.write(0, &[0; 3]), place);
    assert_eq!(flash.write(32 * 1024, &[0; 4]), place);
    let mut bytes = [0; 4];
    flash.read(32 * 1024 - 2, &mut bytes).unwrap();
    assert_eq!(bytes, [0x5a, 0x5a, 0xff, 0xff]);
    assert_eq!(flash.chip().operations, 0);
}

#[test]
fn settings_are_saved_and_read_back_over_the_driver() {
    let mut store = Store::new(settings_flash(Defect::None));
    let mut settings = Settings::default();
    assert_eq!(store.load(), None);
    for angle in ["100", "200"] {
        settings.set("mirror-echo", angle).unwrap();
        assert_eq!(store.save(&settings), Ok(()));
        assert_eq!(store.load(), Some(settings));
    }
    left_in_order(store.flash_mut());
}
