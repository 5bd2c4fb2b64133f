//! The link with a port that takes bytes in pieces, and with modules that misbehave.

use super::*;
use crate::signal::radar::FrameLink;
use crate::signal::radar::module::{FrameError, RadarModule};
use crate::testing::framed::encode;
use crate::testing::port::{Device, Port, Wires};

/// A link over a port that records.
fn link() -> FrameLink<Port> {
    let mut port = Port::default();
    port.wires.room = 100;
    FrameLink::new(port)
}

fn answer(link: &mut FrameLink<Port>, kind: FrameKind, sequence: u16, payload: &[u8]) {
    link.port.type_in(encode(kind, sequence, payload));
}

const NOW: Micros = Micros(u32::MAX - 5);

#[test]
fn a_request_after_an_hour_s_pause_goes_out_at_once() {
    let mut link = link();
    // Stopped right after a change of the rate.
    link.frames.unsure = false;
    link.frames.quiet = Some(NOW.plus(SWITCH_US));
    for minutes in [10, 40, 60, 70] {
        link.port.device.clear();
        let now = NOW.plus(minutes * 60_000_000);
        link.program(now, &RequestedSettings::DEFAULT, 100_000);
        assert!(!link.port.device.is_empty(), "{minutes} minutes");
        link.frames.quiet = Some(NOW.plus(SWITCH_US));
    }
}

#[test]
fn request_goes_out_in_pieces_and_settings_come_back() {
    let mut link = link();
    link.port.wires.room = 5;
    link.program(NOW, &RequestedSettings::DEFAULT, 100_000);
    // First the break, in case the module is at another rate, and a pause for the change of its rate.
    assert!(link.settings(NOW).is_pending());
    assert_eq!(link.port.device, [0, 0]);
    assert!(link.settings(NOW.plus(SWITCH_US - 1)).is_pending());
    assert_eq!(link.port.device, [0, 0]);
    let now = NOW.plus(SWITCH_US);
    for _ in 0..4 {
        assert!(link.settings(now).is_pending());
    }
    let mut decoder = Decoder::new();
    let last = link.port.device.iter().map(|&b| decoder.push(b)).last();
    assert_eq!(last, Some(Ok(Progress::Complete)));
    assert_eq!(decoder.frame().unwrap().kind, FrameKind::Configure);
    let radar = RadarConfig::default();
    let payload = frame::settings_payload(&radar, Ability::NONE);
    answer(&mut link, FrameKind::Settings, 1, &payload);
    assert_eq!(link.settings(NOW), Poll::Ready(Ok(radar)));
}

#[test]
fn late_and_repeated_chirps_are_not_taken() {
    let mut link = link();
    let mut samples = [Iq::default(); 2];
    link.trigger(NOW, 0, 1000);
    link.trigger(NOW, 250, 1000);
    answer(&mut link, FrameKind::Chirp, 1, &[9; 8]);
    assert!(link.poll(NOW, &mut samples).is_pending());
    assert_eq!(
        link.poll(NOW.plus(1000), &mut samples),
        Poll::Ready(Err(LinkError::Sequence))
    );
    link.trigger(NOW, 500, 1000);
    answer(&mut link, FrameKind::Chirp, 2, &[9; 8]);
    answer(&mut link, FrameKind::Chirp, 3, &[1, 0, 2, 0, 3, 0, 4, 0]);
    assert_eq!(link.poll(NOW, &mut samples), Poll::Ready(Ok(())));
    assert_eq!(samples, [Iq::new(1, 2), Iq::new(3, 4)]);
}

fn two_under_way() -> FrameLink<Port> {
    let mut link = link();
    link.port.wires.room = 100;
    link.frames.unsure = false;
    link.trigger(NOW, 0, 1000);
    assert!(!link.trigger_ahead(NOW, 0, 1000), "it never said it could");
    link.program(NOW, &RequestedSettings::DEFAULT, 1000);
    let ability = Ability {
        ahead: true,
        ..Ability::NONE
    };
    let payload = frame::settings_payload(&RadarConfig::default(), ability);
    answer(&mut link, FrameKind::Settings, 2, &payload);
    assert!(link.settings(NOW).is_ready() && link.frames.wire().ahead);
    link.frames.sequence = 0;
    assert!(
        !link.trigger_ahead(NOW, 0, 1000),
        "there is nothing to be ahead of"
    );
    link.trigger(NOW, 0, 1000);
    assert!(link.trigger_ahead(NOW, 250, 2000));
    assert!(!link.trigger_ahead(NOW, 500, 2000), "two are enough");
    link
}

#[test]
fn a_module_that_cannot_add_chirps_is_refused_for_several_only() {
    for (chirps, adds) in [(1, false), (1, true), (8, false), (8, true)] {
        let mut link = link();
        link.port.wires.room = 100;
        link.frames.unsure = false;
        let requested = RequestedSettings {
            chirps,
            ..RequestedSettings::DEFAULT
        };
        link.program(NOW, &requested, 1000);
        let ability = Ability {
            adds,
            ..Ability::NONE
        };
        let payload = frame::settings_payload(&RadarConfig::default(), ability);
        answer(&mut link, FrameKind::Settings, 1, &payload);
        let result = match chirps == 1 || adds {
            true => Ok(RadarConfig::default()),
            false => Err(LinkError::Unable),
        };
        assert_eq!(link.settings(NOW), Poll::Ready(result), "{chirps} {adds}");
    }
}

const ONE: [u8; 4] = [1, 0, 2, 0];
const TWO: [u8; 4] = [3, 0, 4, 0];

#[test]
fn two_chirps_under_way_come_one_after_the_other() {
    let mut link = two_under_way();
    let mut samples = [Iq::default()];
    answer(&mut link, FrameKind::Chirp, 1, &ONE);
    answer(&mut link, FrameKind::Chirp, 2, &TWO);
    assert_eq!(link.poll(NOW, &mut samples), Poll::Ready(Ok(())));
    assert_eq!(samples, [Iq::new(1, 2)]);
    assert!(link.trigger_ahead(NOW, 500, 3000));
    assert_eq!(link.poll(NOW, &mut samples), Poll::Ready(Ok(())));
    assert_eq!(samples, [Iq::new(3, 4)]);
    let late = link.poll(NOW.plus(3000), &mut samples);
    assert_eq!(late, Poll::Ready(Err(LinkError::Timeout)));
}

/// A lost chirp costs only its own row, and no time: the next answer shows that it is lost.
#[test]
fn a_lost_chirp_costs_its_own_row_alone() {
    let mut samples = [Iq::default()];
    let mut link = two_under_way();
    answer(&mut link, FrameKind::Chirp, 2, &TWO);
    let lost = Poll::Ready(Err(LinkError::Sequence));
    assert_eq!(link.poll(NOW, &mut samples), lost);
    assert_eq!(samples, [Iq::default()], "not the other row's samples");
    assert_eq!(link.poll(NOW, &mut samples), Poll::Ready(Ok(())));
    assert_eq!(samples, [Iq::new(3, 4)]);

    let mut link = two_under_way();
    answer(&mut link, FrameKind::Chirp, 1, &ONE);
    link.port.wires.incoming[9].value ^= 1;
    answer(&mut link, FrameKind::Chirp, 2, &TWO);
    let damaged = Poll::Ready(Err(LinkError::Frame(FrameError::Crc)));
    assert_eq!(link.poll(NOW, &mut samples), damaged);
    assert_eq!(link.poll(NOW, &mut samples), Poll::Ready(Ok(())));
    assert_eq!(samples, [Iq::new(3, 4)]);

    // Each request has its own deadline, and late answers are assigned to none.
    let mut link = two_under_way();
    let timeout = Poll::Ready(Err(LinkError::Timeout));
    assert_eq!(link.poll(NOW.plus(1000), &mut samples), timeout);
    answer(&mut link, FrameKind::Chirp, 1, &ONE);
    assert!(link.poll(NOW.plus(1001), &mut samples).is_pending());
    answer(&mut link, FrameKind::Chirp, 2, &TWO);
    let two = link.poll(NOW.plus(1002), &mut samples);
    assert_eq!((two, samples), (Poll::Ready(Ok(())), [Iq::new(3, 4)]));

    // A new scan requests the settings: pending requests are discarded.
    let mut link = two_under_way();
    answer(&mut link, FrameKind::Chirp, 2, &TWO);
    assert_eq!(link.poll(NOW, &mut samples), lost);
    link.program(NOW, &RequestedSettings::DEFAULT, 1000);
    assert!(link.settings(NOW).is_pending());
}

/// A device that always sends another byte.
struct Babble(u64);

impl Device for Babble {
    fn receive(&mut self, _: u8, _: u64, _: &mut Wires) {}

    fn send(&mut self) -> Option<u8> {
        self.0 += 1;
        Some(0)
    }
}

#[test]
fn a_module_that_never_falls_silent_is_a_timeout() {
    let mut link = FrameLink::new(Port::new(Babble(0)));
    let mut samples = [Iq::default(); 2];
    link.trigger(NOW, 0, 1000);
    assert!(link.port.device.0 <= u64::from(MAX_READ));
    while link.poll(NOW.plus(999), &mut samples).is_pending() && link.port.device.0 < 1 << 20 {}
    let late = link.poll(NOW.plus(1000), &mut samples);
    assert!(matches!(late, Poll::Ready(Err(_))), "{late:?}");
    assert!(link.port.device.0 <= (1 << 20) + u64::from(2 * MAX_READ));
}

#[test]
fn every_error_has_its_type() {
    let mut samples = [Iq::default(); 2];
    let mut link = link();
    let mut poll = |link: &mut FrameLink<Port>, now| link.poll(now, &mut samples);
    link.trigger(NOW, 0, 1000);
    assert!(poll(&mut link, NOW.plus(999)).is_pending());
    let timeout = Poll::Ready(Err(LinkError::Timeout));
    assert_eq!(poll(&mut link, NOW.plus(1000)), timeout);
    link.trigger(NOW, 0, 1000);
    answer(&mut link, FrameKind::Chirp, 2, &[0; 8]);
    link.port.wires.incoming[12].value ^= 1;
    let crc = Poll::Ready(Err(LinkError::Frame(FrameError::Crc)));
    assert_eq!(poll(&mut link, NOW), crc);
    link.trigger(NOW, 0, 1000);
    answer(&mut link, FrameKind::Error, 3, &[2]);
    let module = Poll::Ready(Err(LinkError::Module(2)));
    assert_eq!(poll(&mut link, NOW), module);
    for (sequence, kind, length) in [(4, FrameKind::Settings, 8), (5, FrameKind::Chirp, 7)] {
        link.trigger(NOW, 0, 1000);
        answer(&mut link, kind, sequence, &[0; 8][..length]);
        let wrong = Poll::Ready(Err(LinkError::Answer));
        assert_eq!(poll(&mut link, NOW), wrong);
    }
}

mod rates;
