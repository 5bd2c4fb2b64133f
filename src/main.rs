//! Firmware image for the STM32F405; on a host it only prints how to flash it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(any(target_os = "none", test))]
#[cfg_attr(not(target_os = "none"), allow(dead_code))]
mod board;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "stairscan is firmware: `cargo board` writes it to the board, `cargo sim` replays it here"
    );
}

/// Tasks of the image by priority, the highest first: bytes of the radar module, which come every 10 µs at 1 Mbaud and
/// cannot wait; step pulses and the edges of home switch and stall output, which share the motor; bytes of commands and
/// motor driver, 87 µs apart, and the end of a sleep; and the scanner's loop, which has the remaining time or sleeps.
#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use core::mem::MaybeUninit;
    use defmt_rtt as _;
    use stairscan::motion::Odometry;
    use stairscan::pipeline::Pipeline;
    use stairscan::scanner::encoder::EncodedMirror;
    use stairscan::scanner::mirror::Stepper;
    use stairscan::scanner::rest::Rest;
    #[cfg(feature = "demo")]
    use stairscan::scanner::shaft::SimShaft;
    use stairscan::scanner::{Hardware, LentParts, Reports, Scanner};
    use stm32f4xx_hal::pac;

    use crate::board::motor::{Locked, Motor};
    use crate::board::uart::Receiver;
    use crate::board::{self, BoardParts, Interrupts, Queues};

    #[shared]
    struct Shared {
        motor: Motor,
    }

    #[local]
    struct Local {
        link: Receiver<pac::USART1>,
        report: Receiver<pac::USART2>,
        driver: Receiver<pac::USART3>,
        parts: BoardParts,
    }

    #[init(local = [queues: Queues = Queues::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (parts, interrupts) =
            board::start(cx.core.SYST, cx.core.MPU, cx.device, cx.local.queues);
        let Interrupts {
            motor,
            link,
            report,
            driver,
        } = interrupts;
        let local = Local {
            link,
            report,
            driver,
            parts,
        };
        (Shared { motor }, local)
    }

    // Map and estimator are all zero bits, so they take no flash.
    #[idle(
        shared = [motor],
        local = [
            parts,
            pipeline: Pipeline = Pipeline::new(),
            // Not all zero: initialised values would lie in flash, too.
            reports: MaybeUninit<Reports> = MaybeUninit::uninit(),
            odometry: MaybeUninit<Odometry> = MaybeUninit::uninit(),
        ]
    )]
    fn idle(cx: idle::Context) -> ! {
        let BoardParts {
            link,
            report,
            driver,
            encoder,
            board,
            identity,
            time,
            watchdog,
            sleep,
            mpu,
        } = cx.local.parts;
        #[cfg(feature = "provoke")]
        let report = crate::board::provoke::Trap(report);
        #[cfg(not(feature = "demo"))]
        let saved = board.saved();
        #[cfg(feature = "demo")]
        let saved = Some(board::demo::settings());
        identity.serial = board::serial_number::read();
        if let Some(mpu) = mpu.take() {
            let (state, words) = board::second_memory::find(mpu, identity.health.internal_clock);
            identity.second_memory = state;
            if let Some(words) = words {
                cx.local.pipeline.memory_mut().lend(words);
            }
        }
        let mirror = EncodedMirror::new(
            Stepper::with_driver(Locked(cx.shared.motor), driver),
            encoder,
        );
        #[cfg(feature = "demo")]
        let (mirror, link) = {
            // Without pulses and requests neither pins nor ports do anything.
            drop((mirror, link));
            (SimShaft::default(), board::demo::Recorded::default())
        };
        let hardware = Hardware {
            mirror,
            link,
            port: report,
            board,
        };
        let mut scanner = Scanner::new(
            hardware,
            cx.local.pipeline,
            LentParts {
                reports: cx.local.reports.write(Reports::new()),
                odometry: cx.local.odometry.write(Odometry::new()),
            },
            saved,
            *identity,
            time.now(),
        );
        defmt::info!(
            "stairscan {=str} {=str}",
            identity.version,
            identity.revision
        );
        defmt::info!("clock {=str}, reset {=str}", identity.clock, identity.reset);
        let mut state = "";
        let mut before = Rest::None;
        loop {
            scanner.step(time.now());
            let now = time.now();
            watchdog.attend(now, scanner.healthy(now));
            if scanner.state() != state {
                state = scanner.state();
                defmt::info!("{=str}, scan {=u32}", state, scanner.scans());
            }
            // One step may make another due; so it sleeps only after two that leave nothing to do.
            let rest = scanner.rest(now);
            sleep.wait(rest.min(before));
            before = rest;
        }
    }

    #[task(binds = USART1, local = [link], priority = 3)]
    fn receive_chirp(cx: receive_chirp::Context) {
        cx.local.link.receive();
    }

    #[task(binds = SysTick, shared = [motor], priority = 2)]
    fn step_mirror(mut cx: step_mirror::Context) {
        cx.shared.motor.lock(Motor::tick);
    }

    #[task(binds = EXTI0, shared = [motor], priority = 2)]
    fn home_edge(mut cx: home_edge::Context) {
        cx.shared.motor.lock(Motor::home_edge);
    }

    #[task(binds = EXTI1, shared = [motor], priority = 2)]
    fn stall_edge(mut cx: stall_edge::Context) {
        cx.shared.motor.lock(Motor::stall_edge);
    }

    #[task(binds = TIM2, priority = 1)]
    fn end_sleep(_: end_sleep::Context) {
        board::sleep::end();
    }

    #[task(binds = USART2, local = [report], priority = 1)]
    fn receive_command(cx: receive_command::Context) {
        cx.local.report.receive();
    }

    #[task(binds = USART3, local = [driver], priority = 1)]
    fn receive_status(cx: receive_status::Context) {
        cx.local.driver.receive();
    }
}
