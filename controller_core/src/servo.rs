//! Homeostatic control: every millisecond, wheel speeds are held by encoder feedback.
//!
//! Per wheel, in this order: the commanded speed becomes a reference under the acceleration limit; the way the
//! reference has run is compared with the way the encoder has counted (the **lag**); and
//!
//! ```text
//! drive = feedforward · reference + proportional · (reference − measured) + integral · lag
//! ```
//!
//! The integral of the speed error *is* the lag, and kept in encoder counts it is exact: at 12 counts per millimetre
//! one count per millisecond would be a speed of 83 mm/s, so a differentiated speed alone is too coarse to integrate.
//! Anti-windup: the lag is bounded, and stands still while the drive is saturated in its direction. A wheel that is
//! driven but hardly turns for `stall_ms` is reported as stalled, for `stall_hold_ms`: the motors rest before they
//! try again.
//!
//! *Open in the papers*, which name the module (P1, section 2.1) and leave its law to the robot.

use crate::scalar::Scalar;
use crate::units::{EncoderCounts, WheelDrive, WheelSpeeds};

/// Milliseconds of one servo tick.
pub const TICK_MS: u16 = 1;

/// The numbers of the servo; see [`crate::config::ServoConfig`] for units and reasons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoParameters<S> {
    /// Largest change of the reference in one tick (m/s).
    pub acceleration_per_tick_mps: S,
    /// Counts that a wheel at 1 m/s makes in one tick.
    pub counts_per_tick_per_mps: S,
    /// Speed of one count per tick (m/s).
    pub mps_per_count_per_tick: S,
    /// Drive per m/s of reference.
    pub feedforward: S,
    /// Drive per m/s of error.
    pub proportional: S,
    /// Drive per count of lag.
    pub integral: S,
    /// Bound of the lag (counts).
    pub lag_limit: S,
    /// Share of the difference that the measured speed takes over in one tick.
    pub speed_filter: S,
    /// References below this never stall (m/s).
    pub stall_reference_mps: S,
    /// A wheel that turns slower than this share of its reference does not follow it.
    pub stall_share: S,
    /// How long it may not follow (ms).
    pub stall_ms: u16,
    /// How long a stall is reported (ms).
    pub stall_hold_ms: u16,
}

/// The state of one wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wheel<S> {
    reference_mps: S,
    measured_mps: S,
    lag: S,
    stalled_ms: u16,
}

impl<S: Scalar> Wheel<S> {
    // On a host only, see `controller::tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn step(&mut self, p: &ServoParameters<S>, target_mps: S, counted: i32) -> S {
        let change = target_mps - self.reference_mps;
        self.reference_mps += change.clamp(-p.acceleration_per_tick_mps, p.acceleration_per_tick_mps);

        let counted = S::from_i32(counted);
        self.measured_mps += (counted * p.mps_per_count_per_tick - self.measured_mps) * p.speed_filter;

        let expected = self.reference_mps * p.counts_per_tick_per_mps;
        let lag = (self.lag + expected - counted).clamp(-p.lag_limit, p.lag_limit);
        let open_loop = p.feedforward * self.reference_mps
            + p.proportional * (self.reference_mps - self.measured_mps)
            + p.integral * lag;
        let drive = open_loop.clamp(-S::ONE, S::ONE);
        let saturated = open_loop > S::ONE || open_loop < -S::ONE;
        let winds_up = saturated && lag.abs() > self.lag.abs();
        if !winds_up {
            self.lag = lag;
        }
        self.watch_for_stall(p);
        drive
    }

    fn watch_for_stall(&mut self, p: &ServoParameters<S>) {
        let asked = self.reference_mps.abs();
        let follows = self.measured_mps.abs() >= asked * p.stall_share;
        if asked < p.stall_reference_mps || follows {
            self.stalled_ms = 0;
        } else {
            self.stalled_ms = self.stalled_ms.saturating_add(TICK_MS);
        }
    }
}

/// The state of both wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Servo<S> {
    left: Wheel<S>,
    right: Wheel<S>,
    /// Rest of the time for which a stall is reported.
    stall_hold_ms: u16,
}

impl<S: Scalar> Servo<S> {
    /// One tick: the commanded speeds and the counts since the last tick give the motors' drive.
    // On a host only, see `controller::tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn step(
        &mut self,
        p: &ServoParameters<S>,
        command: WheelSpeeds<S>,
        counted: EncoderCounts,
    ) -> WheelDrive<S> {
        let drive = WheelDrive {
            left: self.left.step(p, command.left_mps, counted.left),
            right: self.right.step(p, command.right_mps, counted.right),
        };
        if self.left.stalled_ms.max(self.right.stalled_ms) >= p.stall_ms {
            self.stall_hold_ms = p.stall_hold_ms;
        } else {
            self.stall_hold_ms = self.stall_hold_ms.saturating_sub(TICK_MS);
        }
        drive
    }

    /// A wheel has not followed its reference for `stall_ms`, less than `stall_hold_ms` ago.
    #[must_use]
    pub fn is_stalled(&self) -> bool {
        self.stall_hold_ms > 0
    }

    /// The speeds that the servo holds now, under the acceleration limit.
    #[must_use]
    pub fn reference(&self) -> WheelSpeeds<S> {
        WheelSpeeds { left_mps: self.left.reference_mps, right_mps: self.right.reference_mps }
    }

    /// The wheel speeds as measured, low-pass filtered.
    #[must_use]
    pub fn measured(&self) -> WheelSpeeds<S> {
        WheelSpeeds { left_mps: self.left.measured_mps, right_mps: self.right.measured_mps }
    }

    /// Forgets references and errors, as after the motors were cut; the next reference starts from rest. A stall
    /// stays reported for its time.
    pub fn reset(&mut self) {
        self.left = Wheel::default();
        self.right = Wheel::default();
    }
}
