//! The boot loader's names for the faults of the flash.

use stairscan_boot::refusal::Refusal;

use super::flash::FlashFault;

impl From<FlashFault> for Refusal {
    fn from(fault: FlashFault) -> Self {
        match fault {
            FlashFault::LowSupply => Refusal::Supply,
            FlashFault::PowerLost | FlashFault::Controller | FlashFault::Misuse => Refusal::Flash,
        }
    }
}
