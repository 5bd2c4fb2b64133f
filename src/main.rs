//! The one image for the STM32F405; on a host it only says how to flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(any(target_os = "none", test))]
#[cfg_attr(not(target_os = "none"), allow(dead_code))]
mod board;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "stairscan is firmware: `cargo flash` writes it to the board, `cargo sim` replays it here"
    );
}

#[cfg(target_os = "none")]
mod image {
    use core::mem::MaybeUninit;
    use core::ptr::addr_of_mut;

    use cortex_m_rt::entry;
    use defmt_rtt as _;
    use stairscan::pipeline::Pipeline;
    use stairscan::scan::link::FrameLink;
    use stairscan::scan::mirror::Stepper;
    use stairscan::scan::{Scanner, Settings};
    use stm32f4xx_hal::pac;

    use crate::board::motor::Handle;
    use crate::board::uart::LinkPort;
    use crate::board::{self, Hardware};

    #[cfg(not(feature = "provoke"))]
    type Report = crate::board::uart::ReportPort;
    #[cfg(feature = "provoke")]
    type Report = crate::board::provoke::Trap<crate::board::uart::ReportPort>;

    type ChipScanner = Scanner<
        Stepper<Handle>,
        FrameLink<LinkPort>,
        Report,
        board::ChipBoard,
        &'static mut Pipeline,
    >;

    /// All of a scan's memory; zero bits, so it costs no flash.
    static mut PIPELINE: Pipeline = Pipeline::new();
    /// Queues and state: too large for the stack.
    static mut SCANNER: MaybeUninit<ChipScanner> = MaybeUninit::uninit();

    #[entry]
    fn main() -> ! {
        // SAFETY: the entry point runs once, and nothing took them before.
        let (core, chip) = unsafe { (cortex_m::Peripherals::steal(), pac::Peripherals::steal()) };
        let hardware = board::start(core, chip);
        let Hardware {
            mirror,
            link,
            report,
            board,
            identity,
            time,
            mut watchdog,
        } = hardware;
        #[cfg(feature = "provoke")]
        let report = crate::board::provoke::Trap(report);
        // SAFETY: the only reference to it, taken once.
        let pipeline = unsafe { &mut *addr_of_mut!(PIPELINE) };
        // SAFETY: likewise.
        let place = unsafe { &mut *addr_of_mut!(SCANNER) };
        let hardware = (mirror, link, report, board);
        let scanner = place.write(Scanner::new(
            hardware,
            pipeline,
            Settings::default(),
            identity,
            time.now(),
        ));
        defmt::info!(
            "stairscan {=str} {=str}",
            identity.version,
            identity.revision
        );
        defmt::info!("clock {=str}, reset {=str}", identity.clock, identity.reset);
        let mut state = "";
        loop {
            scanner.step(time.now());
            let now = time.now();
            watchdog.attend(now, scanner.healthy(now));
            if scanner.state() != state {
                state = scanner.state();
                defmt::info!("{=str}, scan {=u32}", state, scanner.scans());
            }
        }
    }
}
