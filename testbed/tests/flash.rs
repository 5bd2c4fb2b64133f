//! Tests of the flash: what it refuses, and what a power cut leaves.

use embedded_storage::nor_flash::NorFlash;
use testbed::{Flash, FlashFault, Power};

const SECTOR: usize = 16;

fn flash() -> Flash<SECTOR> {
    Flash::new(2, &Power::new(1))
}

#[test]
fn a_bit_is_set_by_an_erasure_only() {
    let mut flash = flash();
    flash.counts_misuse = true;
    flash.write(4, &[0xf0, 0, 0xff, 1]).unwrap();
    assert!(flash.write(4, &[0xf1, 0, 0xff, 1]).is_err());
    assert!(flash.write(6, &[0; 4]).is_err());
    assert!(flash.write(32, &[0; 4]).is_err());
    assert_eq!(flash.misused, 3);
    flash.erase(0, SECTOR as u32).unwrap();
    flash.write(4, &[0x11, 0, 0xff, 0]).unwrap();
    assert!(flash.erase(4, SECTOR as u32 + 4).is_err());
    assert_eq!((flash.erasures, flash.words), (vec![1, 0], 2));
}

#[test]
#[should_panic(expected = "written twice without an erasure: 0x4")]
fn misuse_is_a_panic_unless_it_is_counted() {
    let mut flash = flash();
    flash.write(4, &[0xf0, 0, 0xff, 1]).unwrap();
    let _ = flash.write(4, &[0xf0, 0, 0xff, 1]);
}

#[test]
fn a_power_cut_leaves_an_operation_half_done_and_refuses_the_next() {
    let mut flash = flash();
    flash.cut_after(Some(2));
    let words = [0_u8; 12];
    assert_eq!(flash.write(0, &words), Err(FlashFault::PowerLost));
    assert_eq!(flash.bytes[..4], [0; 4]);
    assert_ne!(flash.bytes[4..8], [0; 4]);
    assert_eq!(flash.bytes[8..], [0xff; 24]);
    assert_eq!(flash.write(8, &[0; 4]), Err(FlashFault::PowerLost));
    assert_eq!(flash.bytes[8..], [0xff; 24]);
    let mut fork = flash.fork();
    fork.cut_after(None);
    fork.write(8, &[0; 4]).unwrap();
    assert_eq!(flash.power.borrow().left, Some(0));
}

#[test]
fn a_fault_on_command_changes_nothing() {
    let mut flash = flash();
    flash.refuses = Some(FlashFault::LowSupply);
    assert_eq!(flash.write(0, &[0; 4]), Err(FlashFault::LowSupply));
    assert_eq!(flash.erase(0, 16), Err(FlashFault::LowSupply));
    flash.refuses = None;
    flash.deaf = true;
    assert_eq!(flash.write(0, &[0; 4]), Ok(()));
    assert_eq!(flash.bytes, [0xff; 32]);
}
