//! Counts the instructions of each release, in QEMU: `cargo xtask budget` builds, runs and reads it.
//!
//! With `-icount shift=0` QEMU's clock advances by a nanosecond for each instruction, and the timer TIM2 of its machine
//! `netduinoplus2` counts nanoseconds: a difference of two readings is a number of instructions, exactly and always the
//! same. Instructions, not cycles: flash wait states and the pipeline come on top on silicon. The image of either board
//! runs on that machine, since both have flash and RAM at the same addresses, and a Cortex-M4 runs the code of an M3.
//!
//! Inputs are the worst that occur: all 225 neurons trained, all 12 sensors detecting, encoders counting, the obstacle
//! memory full. Each line `count NAME N` is the most that any of several moments took.
#![no_std]
#![no_main]
#![expect(
    unsafe_code,
    reason = "one register is written whole, and the reader of the time is a bare register"
)]

use controller_core::config::Config;
use controller_core::controller::Mode;
use controller_core::localisation::obstacle::FieldCentre;
use controller_core::motor_control::Beyond;
use controller_core::reflex::Latched;
use controller_core::scalar::Scalar;
use controller_core::sensing::proximity;
use controller_core::units::{EncoderCounts, Point, Pose};
use core::cell::RefCell;
use core::hint::black_box;
use cortex_m_rt::entry;
use critical_section::Mutex;
use firmware::board::{Real, pac};
use firmware::controller::{Fast, Slow};
use protocol::convert::neuron_index;
use protocol::endpoint::Job;
use protocol::frame::{self, Decoder, FRAME_BYTES_MAX};
use protocol::map_file::NeuronRecord;
use protocol::message::{COLUMNS, FromBoard, FromHost, ROWS, Readings, SENSORS, Scan};
use semihosting::println;

/// Moments that are tried.
const MOMENTS: u16 = 24;

// Not on the stack: one of the boards has 8 KiB.
static SLOW: Mutex<RefCell<Option<Slow>>> = Mutex::new(RefCell::new(None));

#[entry]
fn main() -> ! {
    let Some(peripherals) = pac::Peripherals::take() else { semihosting::process::exit(1) };
    let timer = &peripherals.TIM2;
    // SAFETY: any period is valid.
    timer.arr().write(|w| unsafe { w.bits(u32::MAX) });
    timer.cr1().write(|w| w.cen().set_bit());
    critical_section::with(|cs| {
        let mut slow = SLOW.borrow(cs).borrow_mut();
        measure(slow.insert(Slow::new(parameters(&Config::default()))));
    });
    semihosting::process::exit(0)
}

fn now() -> u32 {
    // SAFETY: the counter is only read.
    unsafe { pac::TIM2::steal() }.cnt().read().bits()
}

/// Instructions of a call; those of the measuring itself are taken off.
fn instructions(call: impl FnOnce()) -> u32 {
    let start = now();
    let empty = now().wrapping_sub(start);
    let start = now();
    call();
    now().wrapping_sub(start).saturating_sub(empty)
}

/// The most that any moment takes.
fn report(name: &str, mut call: impl FnMut(u16)) {
    let most = (0..MOMENTS).map(|moment| instructions(|| call(moment))).max().unwrap_or_default();
    println!("count {name} {most}");
}

fn parameters(config: &Config) -> controller_core::config::Parameters<Real, SENSORS> {
    config.build().unwrap_or_else(|_| semihosting::process::exit(1))
}

/// The papers' form: nothing of ours beside the fields, and wide fields.
fn papers() -> Config {
    let mut config = Config::default();
    config.reaching.far_share = 0.0;
    config.reaching.beyond = Beyond::OwnWeight;
    config.cooperative.cruise_share = 0.0;
    config.cooperative.obstacle_centre = FieldCentre::Neuron;
    config.cooperative.target_amplitude = 1.0;
    config.cooperative.target_bearing_sigma_rad = 1.06;
    config.cooperative.target_distance_sigma_m = 0.07;
    config.cooperative.obstacle_bearing_sigma_rad = 0.21;
    config.cooperative.obstacle_behind_sigma_m = 3.5;
    config.cooperative.obstacle_front_sigma_m = 0.035;
    config.cooperative.sweep_strength = 0.0;
    config.cooperative.memory_ms = 0;
    config.cooperative.mover_headway_s = 0.0;
    config.cooperative.detour_patience_ms = 0;
    config
}

/// A map as training leaves it: every neuron's matrix is that of a differential drive.
fn train(slow: &mut Slow) {
    let (map, steps) = slow.deliberation.map_mut();
    *steps = 2000;
    for index in (0..).map_while(neuron_index::<COLUMNS, ROWS>) {
        let record = NeuronRecord::of(map, index);
        let trained = NeuronRecord { left: [-0.3, 1.0], right: [0.3, 1.0], has_won: true, ..record };
        trained.put(map, index);
    }
}

fn share(moment: u16) -> f32 {
    f32::from(moment) / f32::from(MOMENTS)
}

/// All sensors see something, at distances that differ by sensor and moment.
fn ranges(moment: u16) -> [Option<f32>; SENSORS] {
    let mut range = 0.01 + 0.05 * share(moment);
    core::array::from_fn(|_| {
        range = if range > 0.15 { range - 0.13 } else { range + 0.037 };
        Some(range)
    })
}

/// All sensors see something so near that every way is obstructed.
fn near(moment: u16) -> [Option<f32>; SENSORS] {
    let mut range = 0.001 + 0.01 * share(moment);
    core::array::from_fn(|_| {
        range = if range > 0.015 { range - 0.013 } else { range + 0.004 };
        Some(range)
    })
}

fn job(moment: u16) -> Job<Real> {
    let real = Real::from_f32;
    let pose =
        Pose { x_m: real(0.02 * share(moment)), y_m: real(0.0), heading_rad: real(3.0 * share(moment)) };
    Job {
        latched: Latched {
            now: u64::from(moment) * 256,
            pose,
            target: Some(Point { x_m: real(0.9), y_m: real(-0.4 + share(moment)) }),
            arrivals: 0,
            goals: 0,
            turn_counts: i32::from(moment) * 100,
        },
        scan: Some(proximity::Scan { range_m: ranges(moment).map(|range| range.map(real)) }),
        exploration: [real(0.5), real(-0.5)],
        learns: false,
    }
}

fn measure(slow: &mut Slow) {
    let real = Real::from_f32;
    train(slow);

    slow.parameters = parameters(&papers());
    report("papers_target_and_integration", |moment| {
        black_box(slow.reach(black_box(&job(moment).latched)));
    });
    report("papers_avoidance_and_integration", |moment| {
        black_box(slow.avoid(black_box(&job(moment))));
    });

    slow.parameters = parameters(&Config::default());
    slow.deliberation.restart();
    report("target_and_integration", |moment| {
        black_box(slow.reach(black_box(&job(moment).latched)));
    });
    report("avoidance_and_integration", |moment| {
        black_box(slow.avoid(black_box(&job(moment))));
    });
    report("boxed_in", |moment| {
        let scan = Some(proximity::Scan { range_m: near(moment).map(|range| range.map(real)) });
        black_box(slow.avoid(black_box(&Job { scan, ..job(moment) })));
    });
    report("training_step", |moment| {
        let job = Job { learns: true, ..job(moment) };
        black_box(slow.avoid(black_box(&job)));
    });
    report("map_hash", |_| {
        black_box(slow.deliberation.map().hash());
    });
    report("parameters_commit", |_| {
        black_box(Config::default().build::<Real, SENSORS>().is_ok());
    });

    let mut fast = Fast::new(slow.parameters.reflex.clone());
    let goal = job(0).latched.target;
    // One checkpoint always fits.
    let _ = fast.reflex.checkpoints.replace_all(goal.as_slice());
    fast.reflex.gate.arm();
    fast.reflex.set_mode(Mode::Navigate, 0);
    let mut counts = 0;
    report("servo", |moment| {
        counts += 1 + i32::from(moment) % 3;
        let encoders = EncoderCounts { left: counts, right: counts * 2 };
        let now = u64::from(moment);
        black_box(fast.reflex.tick(&fast.parameters, now, black_box(encoders)));
        black_box(fast.reflex.arrive(&fast.parameters, now));
    });
    report("millisecond", |moment| {
        counts += 1 + i32::from(moment) % 3;
        fast.sense(&readings(moment, counts));
        black_box(fast.tick());
    });

    let mut buffer = [0; FRAME_BYTES_MAX];
    let frame = frame::encode(1, &FromHost::Step(readings(1, counts)), &mut buffer).unwrap_or_default();
    let mut decoder = Decoder::<FromHost>::new();
    report("frame_of_readings", |_| {
        frame.iter().for_each(|&byte| {
            black_box(decoder.push(black_box(byte)).is_some());
        });
    });
    let (outputs, _) = fast.tick();
    let report_of_outputs = FromBoard::Outputs(outputs);
    report("frame_of_outputs", |_| {
        let mut buffer = [0; FRAME_BYTES_MAX];
        black_box(frame::encode(0, black_box(&report_of_outputs), &mut buffer).is_ok());
    });
}

fn readings(moment: u16, counts: i32) -> Readings {
    Readings {
        tick: u64::from(moment),
        encoders: EncoderCounts { left: counts, right: counts * 2 },
        pose_fix: Some(Pose { x_m: 0.1, y_m: 0.2, heading_rad: 0.3 }),
        scan: Some(Scan { ranges_m: ranges(moment) }),
        exploration: Some([0.5, -0.5]),
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    semihosting::process::exit(1)
}
