//! Check and remedy for each reason code.

use stairscan::verdict::Reason;

use super::check::Check;

/// Returns the check in which a reason is reported.
pub fn check(reason: Reason) -> Check {
    use Reason as R;
    match reason {
        R::SelfTest | R::SettingsDamaged | R::Watchdog | R::Crash | R::CrashLoop => Check::Firmware,
        R::ImageDamaged | R::ImageUnsealed => Check::Seal,
        R::MemoryDamaged | R::Supply | R::InternalClock => Check::Chip,
        R::MotorStall | R::MotorDriver | R::MirrorStuck | R::AngleJump => Check::Motor,
        R::HomeNotFound | R::MirrorSlipped => Check::Home,
        R::EncoderSilent => Check::Encoder,
        R::LinkSilent | R::ModuleError | R::ModuleConfig | R::TooManyLost | R::LostRows => {
            Check::Module
        }
        R::Saturated
        | R::Silent
        | R::AdcBit
        | R::IqSwapped
        | R::ChannelDead
        | R::IqImbalance
        | R::DcDrift
        | R::Clipped
        | R::Interference
        | R::StaleChirp => Check::Signal,
        R::MirrorMissing | R::MirrorFrozen | R::GainDrift | R::RangeScale => Check::MirrorEcho,
        R::Unconfigured | R::Mount | R::NoEcho | R::BlockedView => Check::Mount,
        R::InferredStep
        | R::CloseRival
        | R::WeakEchoes
        | R::ShortHorizon
        | R::NoPromise
        | R::IrregularStep
        | R::Unconfirmed
        | R::Moving
        | R::MotionInput
        | R::SceneChanged
        | R::ScanNearer => Check::Answer,
    }
}

/// Returns the remedy for a reason, one sentence for the user.
pub fn fix(reason: Reason) -> &'static str {
    use Reason as R;
    match reason {
        R::SelfTest | R::MemoryDamaged => "Power off and on; if it stays, replace the chip.",
        R::SettingsDamaged => {
            "Reset the board; if it comes back, look at supply and ground of the chip."
        }
        R::Watchdog | R::Crash | R::CrashLoop => {
            "Look at the log over the debug probe (`cargo board`); then `start`. Twice the same: report it with that log."
        }
        R::ImageDamaged => "Flash the image again: `cargo board`.",
        R::ImageUnsealed => {
            "`cargo board` seals by itself; with other tools `cargo sim seal ELF` first."
        }
        R::Supply => {
            "Measure 3.3 V under load: 3.10 V at least while the motor turns and the module sweeps."
        }
        R::InternalClock => {
            "The 8 MHz crystal does not run: its solder joints and load capacitors."
        }
        R::MotorStall => {
            "STALL (PB1) is at stall-level: wire to the driver's DIAG, or the other stall-level; with nothing there, PB1 to ground."
        }
        R::MotorDriver => {
            "Motor's supply; PDN_UART with 1 kΩ from PB10, straight to PB11; MS1 and MS2 to ground; heat."
        }
        R::MirrorStuck => {
            "Does the mirror turn? Coupling, motor's wires (A+ A-, B+ B-), motor-current, speed."
        }
        R::AngleJump => {
            "Steps are lost, or the beam's width is not beamwidth: motor-current, acceleration, coupling."
        }
        R::HomeNotFound => {
            "HOME (PB0) did not rise within a turn. Press the switch by hand; then: does the motor turn? EN, motor's supply, wires."
        }
        R::MirrorSlipped => {
            "Coupling, loose switch, motor-current. In the first sweep with an encoder: its DIR is the wrong way round."
        }
        R::EncoderSilent => {
            "3.3 V at the AS5600; SCL PB8 and SDA PB9 with 4.7 kΩ to 3.3 V; the magnet 0.5 to 3 mm before it."
        }
        R::LinkSilent => {
            "Module's supply; TX and RX exchanged; `module` set to the one that is there (docs/design/modules.md); SPI level shifters."
        }
        R::ModuleError => {
            "What it reports is in docs/design/modules.md; `module` set to the one that is there?"
        }
        R::ModuleConfig => {
            "Its bandwidth or samples make no map, or it cannot add chirps: module-bandwidth, module-samples, chirps-per-row."
        }
        R::TooManyLost | R::LostRows => {
            "Chirps do not come in time: link's cable and ground, chirp-timeout, or sweep-mode stop."
        }
        R::Saturated => {
            "Too much signal: a reflector near the lens, the module's gain, a mirror that reflects into the lens."
        }
        R::Silent => {
            "The samples hold no signal: antenna's supply, converter, wrong module setting."
        }
        R::AdcBit | R::ChannelDead => {
            "The module's converter or one of its channels is broken, or a wire of it."
        }
        R::IqSwapped => {
            "I and Q are exchanged, or one has the wrong sign: module's wiring or its setting."
        }
        R::IqImbalance | R::DcDrift => {
            "Let the module warm up; if it stays, its mixer or supply is at fault."
        }
        R::Clipped => {
            "An amplifier before the converter is overdriven: gain, or a strong reflector near the lens."
        }
        R::Interference => {
            "Another radar or a switching supply: turn others off one after the other; shield, filter."
        }
        R::StaleChirp => {
            "The module sends the same chirp again: its firmware, or triggers that come too fast (sweep-mode stop)."
        }
        R::MirrorMissing => {
            "Is the mirror before the lens? Antenna towards it; mirror-offset; metal, not glass with its coat behind."
        }
        R::MirrorFrozen => "The module repeats one chirp: reset it.",
        R::GainDrift => {
            "Temperature, supply of the module, dirt or water on lens and mirror; then calibrate again."
        }
        R::RangeScale => {
            "Measure mirror-offset (lens to mirror centre); the module's clock and bandwidth; calibrate."
        }
        R::Unconfigured => {
            "`set` plane, mirror-offset, mount-height and home-angle, then `save`: `cargo sim settings PORT --set FILE --save`."
        }
        R::Mount => {
            "Measure mount-height; calibrate on the chair, on its tyres, with its load (docs/user/hardware.md)."
        }
        R::NoEcho => {
            "Is there a floor within 3 m? Lens, mirror, beam's direction (DIR: high turns it downwards), first-angle."
        }
        R::BlockedView => "An object is right before the mirror: cover, cable, foot rest.",
        R::Unconfirmed => {
            "Let it scan twice from one place; on the chair, send motion sentences (docs/design/motion.md)."
        }
        R::Moving => "Let it stand still, or send motion sentences (docs/design/motion.md).",
        R::MotionInput => {
            "Motion sentences are late or damaged: docs/design/motion.md says what to send, and how often."
        }
        R::ShortHorizon => {
            "Nothing to repair: less than the first metre of this scene was detected well enough."
        }
        R::NoPromise => "The paper's estimator has no horizon: `set estimator likelihood`.",
        R::InferredStep
        | R::CloseRival
        | R::WeakEchoes
        | R::IrregularStep
        | R::SceneChanged
        | R::ScanNearer => "Nothing to repair.",
    }
}
