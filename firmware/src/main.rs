//! The application: tasks, what they share, and who may interrupt whom. The same for both boards.
//!
//! | task | priority | released | deadline | when it is missed |
//! | --- | --- | --- | --- | --- |
//! | [`usart`](app::usart) | 6 | by each byte of the link | the next byte | the frame is damaged, and asked for again |
//! | [`servo`](app::servo) | 5 | each millisecond | the next millisecond | counted; motors rest for a second |
//! | [`decode`](app::decode) | 5 | by bytes received | none | the ring runs over: as a damaged frame |
//! | [`report`](app::report) | 5 | by the servo | its next release | the newer report replaces the older |
//! | [`avoid`](app::avoid) | 3 | each 128 ms, or training step | its next release | counted, left out; motors rest |
//! | [`reach`](app::reach) | 2 | each 256 ms | its next release | likewise |
//! | [`serve`](app::serve) | 3 | by a request | none | the next request is dropped and counted |
//! | [`idle`](app::idle) | 0 | | | |
//!
//! Decoding and reporting share the servo's priority, so that their stack frames do not add up on the board with 8 KiB;
//! the servo may start late by the time that one frame takes. For the same reason requests are served at the priority
//! of avoidance, which waits for the longest of them no longer than a fifth of its period.
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
    use core::mem::MaybeUninit;

    use controller_core::reflex::Latched;
    use cortex_m::peripheral::SCB;
    use cortex_m::peripheral::syst::SystClkSource;
    use firmware::board::{Board, Real, This, pac::Interrupt};
    use firmware::controller::{Fast, Slow, put_fast, put_session, put_slow};
    use firmware::drivers;
    use firmware::drivers::motors::{self, Motors};
    use firmware::drivers::stopwatch;
    use firmware::drivers::usart::Usart;
    use firmware::drivers::watchdog::Watchdog;
    use firmware::emulator::{self, Emulator, Fifos, Input};
    use firmware::log;
    use firmware::slot::{Filler, Slot, Taker};
    use firmware::watch::Watch;
    use heapless::spsc::{Consumer, Producer, Queue};
    use protocol::endpoint::{Identity, Job, Session};
    use protocol::frame::{DELIMITER, Decoder};
    use protocol::message::{FromBoard, FromHost, TimeBase};
    use rtic::Mutex;

    use crate::fault::{epoch, halt};
    use crate::link::{Line, Locked, Reports, Request, Sink, deliver};

    /// Bytes between the USART and who decodes them: more than come while the servo computes.
    const RECEIVED_BYTES: usize = 32;
    /// Bytes between who sends and the USART: a report has room, longer frames are sent in parts.
    const TO_SEND_BYTES: usize = 64;

    /// Bytes that are decoded before the servo gets its turn: at most one frame's end is among them.
    const BYTES_AT_ONCE: usize = 8;

    /// Bytes that one trap fetches from the FIFO: any frame without a scan.
    const READ_BYTES: usize = 64;

    /// Interrupts that the hardware leaves free, each the release of a task.
    const DECODE: Interrupt = Interrupt::EXTI0;
    const REPORT: Interrupt = Interrupt::EXTI1;
    const AVOID: Interrupt = Interrupt::EXTI2;
    const REACH: Interrupt = Interrupt::EXTI3;
    const SERVE: Interrupt = Interrupt::EXTI4;

    #[shared]
    struct Shared {
        fast: &'static mut Fast,
        slow: &'static mut Slow,
        watch: Watch,
        decoder: &'static mut Decoder<FromHost>,
        /// For the request to answer next.
        request: Filler<Request>,
        reports: Reports,
        line: Line,
    }

    #[local]
    struct Local {
        usart: Usart,
        received: Producer<'static, u8>,
        to_decode: Consumer<'static, u8>,
        to_send: Consumer<'static, u8>,
        real_time: RealTime,
        watchdog: Watchdog,
        avoidance: Taker<Job<Real>>,
        target: Taker<Latched<Real>>,
        requested: Taker<Request>,
        session: &'static mut Session,
        sink: Sink,
        input: Option<Input>,
    }

    // What is large is made where it stays.
    #[init(local = [
        fast: MaybeUninit<Fast> = MaybeUninit::uninit(),
        slow: MaybeUninit<Slow> = MaybeUninit::uninit(),
        session_place: MaybeUninit<Session> = MaybeUninit::uninit(),
        decoder: Decoder<FromHost> = Decoder::new(),
        request_slot: Slot<Request> = Slot::with(Request::BLANK),
        avoidance_slot: Slot<Job<Real>> = Slot::new(),
        target_slot: Slot<Latched<Real>> = Slot::new(),
        ring_in: Queue<u8, RECEIVED_BYTES> = Queue::new(),
        ring_out: Queue<u8, TO_SEND_BYTES> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let clocks = This::start_clocks(&cx.device);
        This::route_pins(&cx.device);
        This::start_stopwatch(&cx.device, &clocks);
        let fifos = if clocks.is_emulated() { open_emulator() } else { None };
        let build_id = env!("EKM_BUILD_ID");
        defmt::info!("{=str} ({=str}) build {=str}", This::ID.name(), scalar_name(), build_id);
        defmt::info!("{}", clocks);

        let Ok(slow) = put_slow(cx.local.slow) else {
            defmt::error!("the default parameters do not fit the number type of this board");
            halt();
        };
        let fast = put_fast(cx.local.fast, slow);
        let session = put_session(cx.local.session_place, Identity { board: This::ID, build_id }, epoch());

        let (request, requested) = cx.local.request_slot.split();
        let (for_avoidance, avoidance) = cx.local.avoidance_slot.split();
        let (for_target, target) = cx.local.target_slot.split();
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
                decoder: cx.local.decoder,
                request,
                reports: Reports::default(),
                line: Line::new(ring_out),
            },
            Local {
                usart: Usart::start(cx.device.USART1, &clocks),
                received,
                to_decode,
                to_send,
                real_time: RealTime {
                    motors: Motors::start(cx.device.TIM3, &clocks),
                    for_avoidance,
                    for_target,
                },
                avoidance,
                target,
                requested,
                watchdog: Watchdog::new(cx.device.IWDG),
                session,
                sink,
                input,
            },
        )
    }

    /// Bytes in, bytes out.
    ///
    /// While the ring is full this task is masked. On silicon the next byte is then lost, and its frame with it; an
    /// emulator, whose bytes come as fast as they are taken, waits.
    #[task(binds = USART1, priority = 6, local = [usart, received, to_send])]
    fn usart(cx: usart::Context) {
        let usart::LocalResources { usart, received, to_send, .. } = cx.local;
        if received.ready()
            && let Some(byte) = usart.receive()
        {
            let _ = received.enqueue(byte);
            rtic::pend(DECODE);
        }
        if !received.ready() {
            drivers::usart::pause();
        }
        while usart.has_room() {
            let Some(byte) = to_send.dequeue() else { break };
            usart.send(byte);
        }
        usart.notify_room(to_send.ready());
    }

    /// A millisecond has passed.
    #[task(binds = SysTick, priority = 5, local = [real_time, watchdog], shared = [fast, watch, reports])]
    fn servo(cx: servo::Context) {
        stopwatch::count();
        let servo::LocalResources { real_time, watchdog, .. } = cx.local;
        let servo::SharedResources { fast, watch, reports, .. } = cx.shared;
        (fast, watch, reports).lock(|fast, watch, reports| {
            if watch.is_real_time {
                watchdog.start();
                real_time.millisecond(fast, watch, reports);
            }
            if watch.all_in_time() {
                watchdog.feed();
            }
        });
    }

    /// What the servo drives and whom it releases.
    pub struct RealTime {
        motors: Motors,
        for_avoidance: Filler<Job<Real>>,
        for_target: Filler<Latched<Real>>,
    }

    impl RealTime {
        /// Kept out of [`servo`], whose stack frame is there in lockstep too.
        #[inline(never)]
        fn millisecond(&mut self, fast: &mut Fast, watch: &mut Watch, reports: &mut Reports) {
            let now_us = This::micros();
            watch.servo_begins(now_us, fast.readings_age_ms());
            let (missed, is_new) = watch.missed_recently();
            if is_new {
                defmt::warn!("a deadline was missed at tick {=u64}", fast.tick);
            }
            fast.reflex.supervision.deadline_missed = missed;
            let (outputs, work) = fast.tick();
            if outputs.stopped.is_some() {
                motors::stop();
            } else {
                self.motors.drive(outputs.wheel_drive);
            }
            reports.put(&outputs);
            if reports.has_fault() || outputs.tick.is_multiple_of(This::REPORT_MS) {
                rtic::pend(REPORT);
            }
            if let Some(work) = work {
                if work.avoids && watch.avoidance.release(now_us) {
                    self.for_avoidance.put(fast.job(work));
                    rtic::pend(AVOID);
                }
                if work.reaches && watch.target.release(now_us) {
                    self.for_target.put(fast.latch(work));
                    rtic::pend(REACH);
                }
            }
            watch.servo_ends(This::micros(), SCB::is_pendst_pending());
        }
    }

    /// Bytes to frames; what cannot wait is done at once, the rest is left to [`serve`].
    #[task(binds = EXTI0, priority = 5, local = [to_decode], shared = [decoder, fast, watch, request])]
    fn decode(cx: decode::Context) {
        let decode::SharedResources { mut decoder, mut fast, mut watch, mut request, .. } = cx.shared;
        for _ in 0..BYTES_AT_ONCE {
            let Some(byte) = cx.local.to_decode.dequeue() else { break };
            decode_byte(byte, &mut decoder, &mut fast, &mut watch, &mut request);
        }
        if cx.local.to_decode.ready() {
            // After the servo, if that is due.
            rtic::pend(DECODE);
        }
        drivers::usart::resume();
    }

    /// Tells the host, unasked, what the servo has done.
    #[task(binds = EXTI1, priority = 5, shared = [reports, line])]
    fn report(cx: report::Context) {
        let report::SharedResources { mut reports, mut line, .. } = cx.shared;
        while let Some(report) = &reports.lock(Reports::next) {
            if let FromBoard::Fault(fault) = report {
                defmt::warn!("motors stopped at tick {=u64}: {}", fault.tick, fault.cause);
            }
            line.lock(|line| line.try_send(report));
        }
        rtic::pend(Interrupt::USART1);
    }

    /// Obstacle avoidance, or a training step.
    #[task(binds = EXTI2, priority = 3, local = [avoidance], shared = [slow, fast, watch])]
    fn avoid(cx: avoid::Context) {
        let avoid::SharedResources { mut slow, fast, watch, .. } = cx.shared;
        let decided = cx
            .local
            .avoidance
            .take(|job| slow.lock(|slow| (job.latched.now, slow.avoid(job), slow.is_trained())));
        (fast, watch).lock(|fast, watch| {
            if let Some((now, speeds, is_trained)) = decided {
                fast.take_command(now, speeds, is_trained);
            }
            watch.avoidance.done(This::micros());
        });
    }

    /// Target reaching.
    #[task(binds = EXTI3, priority = 2, local = [target], shared = [slow, fast, watch])]
    fn reach(cx: reach::Context) {
        let reach::SharedResources { mut slow, fast, watch, .. } = cx.shared;
        let decided = cx
            .local
            .target
            .take(|latched| slow.lock(|slow| (latched.now, slow.reach(latched), slow.is_trained())));
        (fast, watch).lock(|fast, watch| {
            if let Some((now, speeds, is_trained)) = decided {
                fast.take_command(now, speeds, is_trained);
            }
            watch.target.done(This::micros());
        });
    }

    /// Answers requests; in lockstep this is where ticks are computed.
    #[task(
        binds = EXTI4,
        priority = 3,
        local = [requested, session, sink, is_announced: bool = false],
        shared = [fast, slow, watch, decoder, line]
    )]
    fn serve(cx: serve::Context) {
        let serve::LocalResources { requested, session, sink, is_announced, .. } = cx.local;
        let serve::SharedResources { fast, slow, watch, decoder, mut line, .. } = cx.shared;
        let mut access = Locked { fast, slow, watch, decoder };
        if !*is_announced {
            *is_announced = true;
            sink.send(&mut line, &[DELIMITER]);
            sink.send(&mut line, session.announce(&mut access));
        }
        let served = requested.take(|request| {
            // By reference: a second copy of the message would lie under the whole computation of a tick.
            let read = &request.read();
            let Ok(message) = read else {
                access.decoder.lock(|decoder| decoder.count_as_bad());
                return None;
            };
            let is_hello = matches!(message, FromHost::Hello(_));
            if is_hello {
                // The tasks must not work on a controller that begins anew.
                access.watch.lock(|watch| watch.is_real_time = false);
            }
            Some((is_hello, session.serve_message(&mut access, request.sequence, message)))
        });
        // Only now, with the slot free again: the host answers at once.
        let Some((is_hello, reply)) = served.flatten() else { return };
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
        read_fifo(input, &mut decoder, &mut fast, &mut watch, &mut request)
    }

    /// Reads frames until the host has gone away. Kept out of [`idle`], whose stack frame is there all the time.
    #[inline(never)]
    fn read_fifo(
        input: &mut Input,
        decoder: &mut impl Mutex<T = &'static mut Decoder<FromHost>>,
        fast: &mut impl Mutex<T = &'static mut Fast>,
        watch: &mut impl Mutex<T = Watch>,
        request: &mut impl Mutex<T = Filler<Request>>,
    ) -> ! {
        loop {
            let mut buffer = [0; READ_BYTES];
            let bytes = input.read(&mut buffer);
            if bytes.is_empty() {
                defmt::info!("the host has closed the link");
                emulator::end(true);
            }
            for &byte in bytes {
                decode_byte(byte, decoder, fast, watch, request);
            }
        }
    }

    fn decode_byte(
        byte: u8,
        decoder: &mut impl Mutex<T = &'static mut Decoder<FromHost>>,
        fast: &mut impl Mutex<T = &'static mut Fast>,
        watch: &mut impl Mutex<T = Watch>,
        request: &mut impl Mutex<T = Filler<Request>>,
    ) {
        let is_request = decoder.lock(|decoder| match decoder.push_raw(byte)? {
            Ok(raw) => {
                let delivered = deliver(&raw, fast, watch, request);
                if delivered.is_err() {
                    decoder.count_as_bad();
                }
                delivered.ok()
            }
            Err(_) => {
                defmt::debug!("damaged frame");
                None
            }
        });
        if is_request == Some(true) {
            rtic::pend(SERVE);
        }
    }

    /// The log, and the link over FIFOs where the host wants it.
    #[inline(never)]
    fn open_emulator() -> Option<Fifos> {
        let emulator = Emulator::open();
        if let Some(file) = emulator.log {
            log::to_file(file);
        }
        emulator.fifos
    }

    fn scalar_name() -> &'static str {
        <Real as controller_core::scalar::Scalar>::NAME
    }
}
