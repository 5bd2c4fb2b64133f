//! Recordings: metadata as text up to a zero byte, then the samples. A parsed recording can be written
//! and parsed again, and is either scanned or refused with a message.

use host_sim::playback::Playback;
use host_sim::recording::Recording;
use host_sim::setup;
use stairscan::config::Config;
use stairscan::scanner::Settings;

/// Processes the pair.
pub fn run(data: &[u8]) {
    let end = data.iter().position(|&b| b == 0).unwrap_or(data.len());
    let (text, samples) = data.split_at(end);
    let Ok(text) = str::from_utf8(text) else {
        return;
    };
    let mut padded = samples.get(1..).unwrap_or_default().to_vec();
    // A changed number of samples must not always end the test of the metadata.
    if let Err(error) = Recording::parse("fuzzed", text, &padded) {
        assert!(!format!("{error:#}").is_empty());
        padded.resize(expected(&format!("{error:#}")).unwrap_or(padded.len()), 0);
    }
    let Ok(recording) = Recording::parse("fuzzed", text, &padded) else {
        return;
    };
    let again = recording.metadata_text().expect("what was read is JSON");
    let again = Recording::parse("fuzzed", &again, &padded).expect("what was written is read");
    assert_eq!(again.meta.angles_deg, recording.meta.angles_deg);
    assert_eq!(again.samples, recording.samples);
    for scan in 0..recording.scans().min(8) {
        let alone = recording.scan(scan);
        assert_eq!(
            alone.samples.len(),
            recording.chirps_per_scan() * recording.meta.samples_per_chirp
        );
        if let Ok((config, schedule)) = setup::config(&recording, scan, &Config::default()) {
            assert_eq!(config.validate(), Ok(()));
            assert_eq!(schedule.chirps.len(), usize::from(config.sweep.angle_count));
            // The map may be too small, but validation must give a result.
            let settings = Settings {
                config,
                ..Settings::default()
            };
            let _ = settings.validate();
        }
    }
    if let Ok(playback) = Playback::new(&recording, &Config::default()) {
        let commands = playback.commands_after(0);
        assert!(
            commands
                .iter()
                .all(|(key, value)| !key.is_empty() && !value.is_empty())
        );
    }
}

/// Returns the number of bytes of samples that a message requires, if it is small.
fn expected(message: &str) -> Option<usize> {
    let (_, rest) = message.split_once("expected ")?;
    let count: usize = rest.split(' ').next()?.parse().ok()?;
    message
        .contains("captures of")
        .then_some(count)
        .filter(|&n| n < 1 << 20)
}
