//! The application: tasks, what they share, and who may interrupt whom. The same for both boards.
//!
//! | task | priority | released | deadline | when it is missed |
//! | --- | --- | --- | --- | --- |
//! | [`usart`](app::usart) | 6 | by each byte of the link | the next byte | the frame is damaged, and asked for again |
//! | [`servo`](app::servo) | 5 | each millisecond | the next millisecond | counted; motors rest for a second |
//! | [`decode`](app::decode) | 4 | by bytes received | none | the ring runs over: as a damaged frame |
//! | [`report`](app::report) | 4 | by the servo | the next millisecond | the newer report replaces the older |
//! | [`avoid`](app::avoid) | 3 | each 128 ms, or training step | its next release | counted, release left out; motors rest |
//! | [`reach`](app::reach) | 2 | each 256 ms | its next release | likewise |
//! | [`serve`](app::serve) | 1 | by a request | none | the next request is dropped and counted |
//! | [`idle`](app::idle) | 0 | | | |
//!
//! Periods are multiples of the servo's, which hardware times, so they do not drift. Periodic tasks rest in lockstep,
//! where [`serve`](app::serve) computes whole ticks.
//!
//! What tasks share is locked by priority ceilings: `slow` at that of avoidance, so that the servo never waits for a
//! field, `fast` at the servo's, and held as long as it takes to compute a millisecond or to copy a command. Slow tasks
//! work on what the servo has latched at their release; preemption changes when a command is ready, not which.
//!
//! An emergency stop takes the power off the motors in [`decode`](app::decode), whatever request is being answered.
#![no_std]
#![no_main]

mod fault;

mod link;

#[rtic::app(device = firmware::board::pac, peripherals = true)]
mod app {
    use controller_core::config::Config;
    use core::mem::MaybeUninit;
    use cortex_m::peripheral::SCB;
    use cortex_m::peripheral::syst::SystClkSource;
    use firmware::board::{Board, Real, This, pac::Interrupt};
    use firmware::controller::{Fast, Slow};
    use firmware::drivers::motors::{self, Motors};
    use firmware::drivers::stopwatch;
    use firmware::drivers::usart::Usart;
    use firmware::drivers::watchdog::Watchdog;
    use firmware::emulator::{self, Emulator, Input};
    use firmware::log;
    use firmware::watch::Watch;
    use heapless::spsc::{Consumer, Producer, Queue};
    use protocol::endpoint::{Identity, Job, Session};
    use protocol::frame::{DELIMITER, Decoder, FRAME_BYTES_MAX, Frame};
    use protocol::message::{FromBoard, FromHost, SENSORS, TimeBase};

    use crate::fault::{epoch, halt};
    use crate::link::{Line, Locked, Reports, Sink, deliver};

    /// Bytes between the USART and who decodes them: more than come while the servo computes.
    const RECEIVED_BYTES: usize = 64;
    /// Bytes between who sends and the USART: a report has room, longer frames are sent in parts.
    const TO_SEND_BYTES: usize = 96;

    /// Interrupts that the hardware leaves free, each the release of a task.
    const DECODE: Interrupt = Interrupt::EXTI0;
    const REPORT: Interrupt = Interrupt::EXTI1;
    const AVOID: Interrupt = Interrupt::EXTI2;
    const REACH: Interrupt = Interrupt::EXTI3;
    const SERVE: Interrupt = Interrupt::EXTI4;

    #[shared]
    struct Shared {
        fast: Fast,
        slow: &'static mut Slow,
        watch: Watch,
        decoder: Decoder<FromHost>,
        /// The request to answer next.
        request: Option<Frame<FromHost>>,
        avoidance: Option<Job<Real>>,
        target: Option<Job<Real>>,
        reports: Reports,
        line: Line,
    }

    #[local]
    struct Local {
        usart: Usart,
        received: Producer<'static, u8>,
        to_decode: Consumer<'static, u8>,
        to_send: Consumer<'static, u8>,
        motors: Motors,
        watchdog: Watchdog,
        session: Session,
        sink: Sink,
        input: Option<Input>,
    }

    #[init(local = [
        slow: MaybeUninit<Slow> = MaybeUninit::uninit(),
        ring_in: Queue<u8, RECEIVED_BYTES> = Queue::new(),
        ring_out: Queue<u8, TO_SEND_BYTES> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let clocks = This::start_clocks(&cx.device);
        This::route_pins(&cx.device);
        This::start_stopwatch(&cx.device, &clocks);
        let mut fifos = None;
        if clocks.is_emulated() {
            let emulator = Emulator::open();
            if let Some(file) = emulator.log {
                log::to_file(file);
            }
            fifos = emulator.fifos;
        }
        let build_id = env!("EKM_BUILD_ID");
        defmt::info!("{=str} ({=str}) build {=str}", This::ID.name(), scalar_name(), build_id);
        defmt::info!("{}", clocks);

        let Ok(parameters) = Config::default().build::<Real, SENSORS>() else {
            defmt::error!("the default parameters do not fit the number type of this board");
            halt();
        };
        let fast = Fast::new(parameters.reflex.clone());
        // Built in place, and in RAM that needs no image in flash.
        let slow = cx.local.slow.write(Slow::new(parameters));
        let session = Session::new(Identity { board: This::ID, build_id }, epoch());

        let (received, to_decode) = cx.local.ring_in.split();
        let (ring_out, to_send) = cx.local.ring_out.split();
        let (input, sink) = match fifos {
            Some(fifos) => (Some(fifos.input), Sink::Fifo(fifos.output)),
            None => (None, Sink::Usart),
        };
        let mut timer = cx.core.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(clocks.core_hz / 1000 - 1);
        timer.clear_current();
        timer.enable_interrupt();
        // Over FIFOs there is no real time, and an emulator is faster without a timer's interrupts.
        if input.is_none() {
            timer.enable_counter();
        }
        rtic::pend(SERVE);
        (
            Shared {
                fast,
                slow,
                watch: Watch::default(),
                decoder: Decoder::new(),
                request: None,
                avoidance: None,
                target: None,
                reports: Reports::default(),
                line: Line::new(ring_out),
            },
            Local {
                usart: Usart::start(cx.device.USART1, &clocks),
                received,
                to_decode,
                to_send,
                motors: Motors::start(cx.device.TIM3, &clocks),
                watchdog: Watchdog::new(cx.device.IWDG),
                session,
                sink,
                input,
            },
        )
    }

    /// Bytes in, bytes out.
    #[task(binds = USART1, priority = 6, local = [usart, received, to_send])]
    fn usart(cx: usart::Context) {
        let usart::LocalResources { usart, received, to_send, .. } = cx.local;
        if let Some(byte) = usart.receive() {
            // A full ring loses the byte, and so the frame.
            let _ = received.enqueue(byte);
            rtic::pend(DECODE);
        }
        while usart.has_room() {
            let Some(byte) = to_send.dequeue() else { break };
            usart.send(byte);
        }
        usart.notify_room(to_send.ready());
    }

    /// A millisecond of real time.
    #[task(
        binds = SysTick,
        priority = 5,
        local = [motors, watchdog],
        shared = [fast, watch, avoidance, target, reports]
    )]
    fn servo(cx: servo::Context) {
        stopwatch::count();
        let now_us = This::micros();
        let servo::LocalResources { motors, watchdog, .. } = cx.local;
        let servo::SharedResources { fast, watch, avoidance, target, reports, .. } = cx.shared;
        (fast, watch, avoidance, target, reports).lock(|fast, watch, avoidance, target, reports| {
            if !watch.is_real_time {
                watchdog.feed();
                return;
            }
            watchdog.start();
            watch.servo_begins(now_us, fast.readings_age_ms());
            let (missed, is_new) = watch.missed_recently();
            if is_new {
                defmt::warn!("a deadline was missed at tick {=u64}", fast.tick);
            }
            fast.reflex.supervision.deadline_missed = missed;
            let (outputs, job) = fast.tick();
            if outputs.stopped.is_some() {
                motors::stop();
            } else {
                motors.drive(outputs.wheel_drive);
            }
            if let Some(job) = job {
                if (job.learns || job.released.avoidance) && watch.avoidance.release(now_us) {
                    *avoidance = Some(job);
                    rtic::pend(AVOID);
                }
                if job.released.target && !job.learns && watch.target.release(now_us) {
                    *target = Some(Job { scan: None, ..job });
                    rtic::pend(REACH);
                }
            }
            reports.put(outputs);
            rtic::pend(REPORT);
            if watch.all_in_time() {
                watchdog.feed();
            }
            watch.servo_ends(This::micros(), SCB::is_pendst_pending());
        });
    }

    /// Bytes to frames; what cannot wait is done at once, the rest is left to [`serve`].
    #[task(binds = EXTI0, priority = 4, local = [to_decode], shared = [decoder, fast, watch, request])]
    fn decode(cx: decode::Context) {
        let decode::SharedResources { mut decoder, mut fast, mut watch, mut request, .. } = cx.shared;
        while let Some(byte) = cx.local.to_decode.dequeue() {
            if let Some(result) = decoder.lock(|decoder| decoder.push(byte))
                && deliver(result, &mut fast, &mut watch, &mut request)
            {
                rtic::pend(SERVE);
            }
        }
    }

    /// Tells the host, unasked, what the servo has done.
    #[task(binds = EXTI1, priority = 4, shared = [reports, line])]
    fn report(cx: report::Context) {
        let report::SharedResources { mut reports, mut line, .. } = cx.shared;
        if let Some(fault) = reports.lock(|reports| reports.fault.take()) {
            defmt::warn!("motors stopped at tick {=u64}: {}", fault.tick, fault.cause);
            line.lock(|line| line.try_send(&FromBoard::Fault(fault)));
        }
        if let Some(outputs) = reports.lock(|reports| reports.outputs.take()) {
            line.lock(|line| line.try_send(&FromBoard::Outputs(outputs)));
        }
        rtic::pend(Interrupt::USART1);
    }

    /// Obstacle avoidance, or a training step.
    #[task(binds = EXTI2, priority = 3, shared = [avoidance, slow, fast, watch])]
    fn avoid(cx: avoid::Context) {
        let avoid::SharedResources { mut avoidance, mut slow, fast, watch, .. } = cx.shared;
        let Some(job) = avoidance.lock(Option::take) else { return };
        let (speeds, is_trained) = slow.lock(|slow| (slow.avoid(&job), slow.deliberation.map().is_trained()));
        (fast, watch).lock(|fast, watch| {
            if job.latched.now < fast.tick {
                fast.take_command(&job, speeds, is_trained);
            }
            watch.avoidance.done(This::micros());
        });
    }

    /// Target reaching.
    #[task(binds = EXTI3, priority = 2, shared = [target, slow, fast, watch])]
    fn reach(cx: reach::Context) {
        let reach::SharedResources { mut target, mut slow, fast, watch, .. } = cx.shared;
        let Some(job) = target.lock(Option::take) else { return };
        let (speeds, is_trained) = slow.lock(|slow| (slow.reach(&job), slow.deliberation.map().is_trained()));
        (fast, watch).lock(|fast, watch| {
            if job.latched.now < fast.tick {
                fast.take_command(&job, speeds, is_trained);
            }
            watch.target.done(This::micros());
        });
    }

    /// Answers requests; in lockstep this is where ticks are computed.
    #[task(
        binds = EXTI4,
        priority = 1,
        local = [session, sink, is_announced: bool = false],
        shared = [request, fast, slow, watch, decoder, line]
    )]
    fn serve(cx: serve::Context) {
        let serve::LocalResources { session, sink, is_announced, .. } = cx.local;
        let serve::SharedResources { mut request, fast, slow, watch, decoder, mut line, .. } = cx.shared;
        let mut access = Locked { fast, slow, watch, decoder };
        if !*is_announced {
            *is_announced = true;
            sink.send(&mut line, &[DELIMITER]);
            sink.send(&mut line, session.announce(&mut access));
        }
        while let Some(frame) = request.lock(Option::take) {
            let is_hello = matches!(frame.message, FromHost::Hello(_));
            if is_hello {
                // The tasks must not work on a controller that begins anew.
                access.watch.lock(|watch| watch.is_real_time = false);
            }
            let reply = session.serve(&mut access, &frame);
            sink.send(&mut line, reply);
            if is_hello {
                let is_real_time = session.time_base() == TimeBase::RealTime;
                defmt::info!("session, real time: {=bool}", is_real_time);
                motors::stop();
                if is_real_time {
                    access.watch.lock(Watch::begin_real_time);
                }
            }
        }
    }

    /// Reads the FIFO where the link is one; otherwise there is nothing to do.
    #[idle(local = [input], shared = [decoder, fast, watch, request])]
    fn idle(cx: idle::Context) -> ! {
        let idle::SharedResources { mut decoder, mut fast, mut watch, mut request, .. } = cx.shared;
        let Some(input) = cx.local.input else {
            loop {
                // Not a wait for interrupts: QEMU 7.2 loses every second SysTick in one.
                cortex_m::asm::nop();
            }
        };
        loop {
            let mut buffer = [0; FRAME_BYTES_MAX];
            let bytes = input.read(&mut buffer);
            if bytes.is_empty() {
                defmt::info!("the host has closed the link");
                emulator::end(true);
            }
            for &byte in bytes {
                if let Some(result) = decoder.lock(|decoder| decoder.push(byte))
                    && deliver(result, &mut fast, &mut watch, &mut request)
                {
                    rtic::pend(SERVE);
                }
            }
        }
    }

    fn scalar_name() -> &'static str {
        <Real as controller_core::scalar::Scalar>::NAME
    }
}
