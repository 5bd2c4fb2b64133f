//! Emulator image: compares the results of the DSP instructions with those of their portable definitions, bit
//! by bit.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use bench_image::{arithmetic_check, stack};
    use cortex_m_rt::entry;
    use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;
    use stairscan::signal::range::packed::{Dsp, Portable};
    use stm32f4xx_hal as _;

    #[entry]
    fn main() -> ! {
        stack::enlarge(run)
    }

    extern "C" fn run() -> ! {
        let found = arithmetic_check::compare::<Dsp, Portable>();
        hprintln!("chirps {}", arithmetic_check::TOTAL);
        hprintln!("mismatches {}", found.mismatches);
        hprintln!("digest {:08x}", found.digest);
        debug::exit(EXIT_SUCCESS);
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        hprintln!("{}", info);
        debug::exit(EXIT_FAILURE);
        loop {
            cortex_m::asm::wfi();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for the emulator: see `cargo study twins`");
}
