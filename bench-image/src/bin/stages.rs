//! Emulator image: prints the instruction count of every stage, one `name count` a line.
//!
//! Whole scans come from the file `scans` in the emulator's working directory, one after the other: a
//! [header](bench_image::header) and the rows' chirps.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use bench_image::counter::Counter;
    use bench_image::header;
    use bench_image::host_file::HostFile;
    use bench_image::stack;
    use core::hint::black_box;
    use core::ptr::addr_of_mut;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;
    use microfft::Complex32;
    use stairscan::Iq;
    use stairscan::config::{Config, MAX_SAMPLES, RadarConfig};
    use stairscan::motion::Drive;
    use stairscan::observer::{Event, Observer};
    #[cfg(feature = "ablation")]
    use stairscan::params::Numbers;
    use stairscan::pipeline::Pipeline;
    use stairscan::report::sentence::{ScanId, write_scan};
    use stairscan::scanner::DataPath;
    use stairscan::signal::grid::{BinWindow, Row};
    use stairscan::signal::image::WORDS;
    use stairscan::signal::range::cfar::Cfar;
    use stairscan::signal::range::packed::{Native, Packed};
    use stairscan::signal::range::window::{self, ChirpLevels, Window};
    use stairscan::signal::range::{RangeProcessor, fft, log};
    use stairscan::verdict::{Conditions, Outcome};
    use stm32f4xx_hal as _;

    // Input and output of a stage pass through `black_box`: inlined into the counting loop, a stage with an
    // unused result would not be computed.

    /// Repetitions of a stage, which average out the timer's resolution of 6 instructions.
    const ROUNDS: u32 = 100;

    #[entry]
    fn main() -> ! {
        if let Some(peripherals) = cortex_m::Peripherals::take() {
            scans(&mut Counter::new(peripherals.SYST));
        }
        // The single stages need a larger stack, where the image of the scans was.
        stack::enlarge(single_stages)
    }

    extern "C" fn single_stages() -> ! {
        // SAFETY: the counter of the scans, which used the timer, is gone.
        let peripherals = unsafe { cortex_m::Peripherals::steal() };
        let mut counter = Counter::new(peripherals.SYST);
        transforms(&mut counter);
        chirp_stages(&mut counter);
        debug::exit(EXIT_SUCCESS);
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Returns a chirp with leakage, mirror, two echoes and noise-like dither, with a peak near half scale.
    fn chirp(samples: usize) -> impl Iterator<Item = Iq> {
        let mut dither = 1u32;
        (0..samples).map(move |n| {
            let mut sum = (1000.0, -500.0);
            for (turns, amplitude) in [(1.6, 8000.0), (14.7, 2000.0), (60.2, 900.0), (90.0, 60.0)] {
                let angle = core::f32::consts::TAU * turns * n as f32 / samples as f32;
                let (sin, cos) = stairscan::math::sin_cos(angle % core::f32::consts::TAU);
                sum = (sum.0 + amplitude * cos, sum.1 + amplitude * sin);
            }
            dither = dither.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            Iq::new(
                sum.0 as i16 + (dither >> 28) as i16,
                sum.1 as i16 + (dither >> 24 & 15) as i16,
            )
        })
    }

    /// Counts one transform of 256 complex points, input and output included, and the one of `microfft`.
    #[inline(never)]
    fn transforms(counter: &mut Counter) {
        let mut input = [Packed::ZERO; 256];
        for (to, x) in input.iter_mut().zip(chirp(256)) {
            *to = x.into();
        }
        let mut buffers = [[Packed::ZERO; 256]; 2];
        let mut bins = [Packed::ZERO; 256];
        let count = counter.count(ROUNDS, || {
            let (buffers, bins) = (black_box(&mut buffers), black_box(&mut bins));
            fft::transform::<Native, Packed, 256>(black_box(&input), buffers, bins)
        });
        hprintln!("fft256 {}", count);
        let mut floats = input.map(|x| Complex32::new(x.re().into(), x.im().into()));
        let count = counter.count(ROUNDS, || {
            let _ = microfft::complex::cfft_256(black_box(&mut floats));
        });
        hprintln!("microfft_f32 {}", count);
    }

    /// Counts each pass over one chirp of 200 samples, and the whole chirp.
    #[inline(never)]
    fn chirp_stages(counter: &mut Counter) {
        let mut samples = [Iq::default(); 200];
        for (to, x) in samples.iter_mut().zip(chirp(200)) {
            *to = x;
        }
        let config = Config::default();
        let mut window = Window::empty();
        window.shape(200, 256);
        let count = counter.count(ROUNDS, || ChirpLevels::of::<Native>(black_box(&samples)));
        hprintln!("levels {}", count);
        let levels = ChirpLevels::of::<Native>(&samples);
        let mut data = [Packed::ZERO; 256];
        let count = counter.count(ROUNDS, || {
            let (levels, window) = (black_box(&levels), black_box(&window));
            window::window_and_first_stage::<Native, 256>(
                black_box(&samples),
                levels,
                window,
                black_box(&mut data),
            )
        });
        hprintln!("window {}", count);
        let seen =
            window::window_and_first_stage::<Native, 256>(&samples, &levels, &window, &mut data);
        let (mut spare, mut power) = ([Packed::ZERO; 256], [0u32; 256]);
        let count = counter.count(ROUNDS, || {
            let (spare, power) = (black_box(&mut spare), black_box(&mut power));
            fft::finish::<Native, u32, 256>(black_box(&mut data), spare, power, seen)
        });
        hprintln!("stages {}", count);
        row_stages(counter, &config, &window, &power);
        // The same chirp, interpreted as 400 real samples.
        for (name, real) in [("chirp", false), ("chirp_real", true)] {
            let radar = RadarConfig {
                real,
                ..config.radar
            };
            hprintln!("{} {}", name, whole(counter, &radar, &config, &samples));
        }
    }

    /// Counts the processing from a chirp to a row of the map.
    #[inline(never)]
    fn whole(
        counter: &mut Counter,
        radar: &RadarConfig,
        config: &Config,
        samples: &[Iq; 200],
    ) -> u32 {
        // SAFETY: the only reference to the static while this function runs.
        let processor = unsafe { &mut *addr_of_mut!(RANGE) };
        let Ok(()) = processor.configure(radar, &config.mount, &config.cfar) else {
            return 0;
        };
        let bins = usize::from(processor.kept().count);
        let (mut cells, mut mask) = ([0; 256], [0; 8]);
        counter.count(ROUNDS, || {
            let mut row = Row {
                cells: &mut cells[..bins],
                mask: &mut mask[..bins.div_ceil(32)],
            };
            processor.process(black_box(samples), &mut row)
        })
    }

    /// Counts the stages from power to a row.
    #[inline(never)]
    fn row_stages(counter: &mut Counter, config: &Config, window: &Window, power: &[u32; 256]) {
        let kept = BinWindow::new(&config.radar, &config.mount, &config.cfar);
        let power = &power[kept.first.into()..][..kept.count.into()];
        let (mut cells, mut mask) = ([0; 256], [0; 8]);
        let count = counter.count(ROUNDS, || {
            log::fill_cells(black_box(power), 1000, black_box(&mut cells))
        });
        hprintln!("cells {}", count);
        let mut cfar = Cfar::empty();
        cfar.shape(&config.cfar, kept, window);
        let count = counter.count(ROUNDS, || {
            cfar.detect::<Native>(black_box(power), black_box(&mut mask))
        });
        hprintln!("cfar {}", count);
    }

    #[cfg(not(feature = "ablation"))]
    static mut PIPELINE: Pipeline = Pipeline::new();
    #[cfg(feature = "ablation")]
    static mut PIPELINE: Pipeline = Pipeline::with(Numbers::of(&patched::NUMBERS));
    static mut RANGE: RangeProcessor = RangeProcessor::idle();

    /// Tuned numbers of an image for the emulator: the host writes others into its ELF file in place of `NUMBERS`, to
    /// measure the effect of each rule.
    #[cfg(feature = "ablation")]
    mod patched {
        use stairscan::params::Params;

        // Used: the linker's optimiser would merge it with the default numbers and drop its symbol.
        #[used]
        pub static NUMBERS: Params = Params::DEFAULT;
    }

    /// Observer that counts the instructions of each stage after the last row.
    struct Laps<'c> {
        counter: &'c Counter,
        since: u32,
        counts: [u32; 3],
    }

    impl Observer for Laps<'_> {
        fn listens(&self) -> bool {
            false
        }

        fn event(&mut self, event: Event<'_>) {
            if let Event::Done(stage) = event {
                let count = self.counter.lap(&mut self.since);
                if let Some(place) = self.counts.get_mut(stage as usize) {
                    *place = count;
                }
            }
        }
    }

    /// Address of the second memory in the emulator: SRAM3, as on an STM32F427.
    const SECOND_MEMORY: usize = 0x2002_0000;

    /// Processes the scans of the host's file with the whole pipeline.
    #[inline(never)]
    fn scans(counter: &mut Counter) {
        // SAFETY: the only reference to the static, made once.
        let pipeline = unsafe { &mut *addr_of_mut!(PIPELINE) };
        // SAFETY: the emulator's SRAM extends over this address, the linker places nothing there, and this is the only
        // reference, made once.
        let words = unsafe { &mut *(SECOND_MEMORY as *mut [u32; WORDS]) };
        pipeline.memory_mut().lend(words);
        let Some(mut file) = HostFile::open(c"scans") else {
            return;
        };
        let mut bytes = [0; header::SIZE];
        while file.read(&mut bytes) {
            let config = header::decode(&bytes);
            if config.sweep.angle_count <= header::MAX_SWEEP_ROWS {
                sweep(counter, pipeline, &config, &mut file);
            } else {
                scan(counter, pipeline, &config, &mut file);
            }
        }
    }

    /// Processes one scan and prints `scan CHIRP ROW POST …`: the maximum over its chirps (samples to row of
    /// the map, with the health checks), the maximum over its rows (with the estimator's work during the scan),
    /// the instructions from the last row to the last byte of the report, and each stage of these: the
    /// estimator's, and the report.
    #[inline(never)]
    fn scan(counter: &mut Counter, pipeline: &mut Pipeline, config: &Config, file: &mut HostFile) {
        let ready = pipeline.begin(config, 1).is_ok();
        let (mut worst_chirp, mut worst_row) = (0, 0);
        for k in 0..config.sweep.angle_count {
            if !ready || !chirp_of(file, config, pipeline) {
                return;
            }
            let ((), chirp) = counter.once(|| pipeline.process_row(k));
            worst_chirp = worst_chirp.max(chirp);
            let ((), rest) = counter.once(|| pipeline.complete(k));
            worst_row = worst_row.max(chirp + rest);
        }
        let mut since = counter.now();
        let mut laps = Laps {
            since,
            counter,
            counts: [0; 3],
        };
        let outcome = pipeline.conclude_observed(&Drive::STANDING, Conditions::GOOD, &mut laps);
        let [echoes, search, dimensions] = laps.counts;
        let ((), report) = counter.once(|| report(&outcome));
        let post = counter.lap(&mut since);
        hprintln!(
            "scan {} {} {} {} {} {} {}",
            worst_chirp,
            worst_row,
            post,
            echoes,
            search,
            dimensions,
            report
        );
    }

    /// Reads the next row's chirp; returns whether there was one.
    #[inline(never)]
    fn chirp_of(file: &mut HostFile, config: &Config, pipeline: &mut Pipeline) -> bool {
        let mut bytes = [0; 4 * MAX_SAMPLES];
        let bytes = &mut bytes[..4 * usize::from(config.radar.samples)];
        if !file.read(bytes) {
            return false;
        }
        let samples = bytes.as_chunks::<4>().0;
        for (to, &[i0, i1, q0, q1]) in pipeline.samples().iter_mut().zip(samples) {
            *to = Iq::new(i16::from_le_bytes([i0, i1]), i16::from_le_bytes([q0, q1]));
        }
        true
    }

    /// Processes one guard sweep and prints `sweep COUNT`: the instructions from the last row to the result,
    /// health checks included.
    #[inline(never)]
    fn sweep(counter: &mut Counter, pipeline: &mut Pipeline, config: &Config, file: &mut HostFile) {
        let ready = pipeline.begin_guard(config, 1).is_ok();
        for k in 0..config.sweep.angle_count {
            if !ready || !chirp_of(file, config, pipeline) {
                return;
            }
            pipeline.row(k);
        }
        let (word, count) = counter.once(|| pipeline.guard(&Drive::STANDING, Conditions::GOOD));
        black_box(word.free_m());
        hprintln!("sweep {}", count);
    }

    /// Writes the sentences of an outcome.
    #[inline(never)]
    fn report(outcome: &Outcome) {
        let mut sum = 0u32;
        write_scan(ScanId::FIRST, 0, outcome, |line| {
            sum = line
                .bytes()
                .fold(sum, |sum, byte| sum.wrapping_add(byte.into()));
        });
        black_box(sum);
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
    println!("an image for the emulator: see `cargo study bench`");
}
