//! The sequence of checkpoints: reach each, stop at the last, take replacements under way.
//!
//! Checkpoints are numbered from 0 since the last [`Checkpoints::replace_all`]; a number stays valid when earlier ones
//! have been reached, so that a planner can say "replace number 1" while the robot is on its way (P1 Fig. 9).

use heapless::Deque;

use crate::scalar::Scalar;
use crate::units::{Point, Pose};

/// A list of checkpoints that does not fit, or a number that names none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum CheckpointError {
    /// More checkpoints than the fixed capacity holds; nothing was changed.
    TooMany {
        /// How many were to be held.
        count: u16,
        /// How many can be.
        capacity: u16,
    },
    /// The number is of a checkpoint already reached, or of none; nothing was changed.
    NotAhead {
        /// The number asked for.
        number: u16,
        /// The numbers still ahead, from …
        first: u16,
        /// … up to, not including, this.
        end: u16,
    },
    /// A coordinate is not a number or beyond ±2000 m; nothing was changed.
    OutOfRange {
        /// Position in the list given.
        position: u16,
    },
}

impl core::fmt::Display for CheckpointError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooMany { count, capacity } => {
                write!(
                    f,
                    "{count} checkpoints do not fit: the controller holds {capacity}; send them in parts"
                )
            }
            Self::NotAhead { number, first, end } => {
                write!(f, "checkpoint {number} is not ahead: numbers {first}..{end} are")
            }
            Self::OutOfRange { position } => {
                write!(
                    f,
                    "checkpoint at position {position} has a coordinate that is no number within ±2000 m"
                )
            }
        }
    }
}

impl core::error::Error for CheckpointError {}

/// What happened at a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Reached {
    /// Its number.
    pub number: u16,
    /// It was the last: the robot stops here.
    pub is_goal: bool,
}

/// When a checkpoint counts as reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckpointParameters<S> {
    /// Distance to a checkpoint on the way (m).
    pub tolerance_m: S,
    /// Distance to the goal (m).
    pub goal_tolerance_m: S,
    /// At the goal the robot's centre may be no faster than this (m/s), or it would roll on.
    pub goal_speed_mps: S,
}

/// The checkpoints ahead, at most `CAPACITY`.
#[derive(Clone, Debug)]
pub struct Checkpoints<S, const CAPACITY: usize> {
    ahead: Deque<Point<S>, CAPACITY>,
    reached: u16,
}

impl<S, const CAPACITY: usize> Default for Checkpoints<S, CAPACITY> {
    fn default() -> Self {
        Self { ahead: Deque::new(), reached: 0 }
    }
}

/// For reports: more than 65,535 is told as that.
fn saturated(count: usize) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX)
}

fn check<S: Scalar>(points: &[Point<S>]) -> Result<(), CheckpointError> {
    let valid = |x: S| x >= -S::LIMIT && x <= S::LIMIT;
    match points.iter().position(|point| !(valid(point.x_m) && valid(point.y_m))) {
        Some(position) => Err(CheckpointError::OutOfRange { position: saturated(position) }),
        None => Ok(()),
    }
}

impl<S: Scalar, const CAPACITY: usize> Checkpoints<S, CAPACITY> {
    /// Takes a new list; numbering starts at 0 again. An empty list stops the robot.
    ///
    /// # Errors
    /// [`CheckpointError`] where the list is too long or holds what is no place; then the old list stays.
    pub fn replace_all(&mut self, points: &[Point<S>]) -> Result<(), CheckpointError> {
        check(points)?;
        if points.len() > CAPACITY {
            return Err(Self::too_many(points.len()));
        }
        self.ahead.clear();
        self.reached = 0;
        self.extend(points);
        Ok(())
    }

    /// Adds checkpoints behind the last.
    ///
    /// # Errors
    /// [`CheckpointError`] where they do not fit or are no places; then nothing is added.
    pub fn append(&mut self, points: &[Point<S>]) -> Result<(), CheckpointError> {
        check(points)?;
        let count = self.ahead.len() + points.len();
        if count > CAPACITY {
            return Err(Self::too_many(count));
        }
        self.extend(points);
        Ok(())
    }

    fn too_many(count: usize) -> CheckpointError {
        CheckpointError::TooMany { count: saturated(count), capacity: saturated(CAPACITY) }
    }

    fn extend(&mut self, points: &[Point<S>]) {
        for &point in points {
            // The callers have checked that there is room.
            let _ = self.ahead.push_back(point);
        }
    }

    /// Moves one checkpoint that is still ahead.
    ///
    /// # Errors
    /// [`CheckpointError`] where the number is not ahead or the point is no place; then nothing is changed.
    pub fn replace(&mut self, number: usize, point: Point<S>) -> Result<(), CheckpointError> {
        check(&[point])?;
        let first = usize::from(self.reached);
        let end = first + self.ahead.len();
        let place = number.checked_sub(first).and_then(|position| self.ahead.iter_mut().nth(position));
        let (number, end) = (saturated(number), saturated(end));
        let place = place.ok_or(CheckpointError::NotAhead { number, first: self.reached, end })?;
        *place = point;
        Ok(())
    }

    /// Forgets all checkpoints: the robot stops.
    pub fn clear(&mut self) {
        self.ahead.clear();
    }

    /// The checkpoint that the robot is on its way to.
    #[must_use]
    pub fn current(&self) -> Option<Point<S>> {
        self.ahead.front().copied()
    }

    /// How many are still ahead.
    #[must_use]
    pub fn remaining(&self) -> usize {
        self.ahead.len()
    }

    /// Removes the current checkpoint where the robot is near enough and, at the goal, slow enough to stop there.
    ///
    /// The pose is asked for only where the speed does not settle it.
    pub fn arrive(
        &mut self,
        p: &CheckpointParameters<S>,
        here: impl FnOnce() -> Pose<S>,
        speed_mps: S,
    ) -> Option<Reached> {
        let current = self.current()?;
        let is_goal = self.ahead.len() == 1;
        if is_goal && speed_mps > p.goal_speed_mps {
            return None;
        }
        let tolerance = if is_goal { p.goal_tolerance_m } else { p.tolerance_m };
        let here = here();
        // Every millisecond: spare the root while it is farther than the tolerance along an axis.
        if (current.x_m - here.x_m).abs() >= tolerance || (current.y_m - here.y_m).abs() >= tolerance {
            return None;
        }
        if here.position().distance_to(current) >= tolerance {
            return None;
        }
        self.ahead.pop_front();
        let number = self.reached;
        self.reached = self.reached.saturating_add(1);
        Some(Reached { number, is_goal })
    }
}

#[cfg(test)]
mod tests {
    use super::{CheckpointError, CheckpointParameters, Checkpoints, Reached};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Pose};

    fn at<S: Scalar>(x: f32, y: f32) -> Pose<S> {
        Pose { x_m: S::from_f32(x), y_m: S::from_f32(y), heading_rad: S::ZERO }
    }

    fn check<S: Scalar>() {
        let p = CheckpointParameters {
            tolerance_m: S::from_f32(0.005),
            goal_tolerance_m: S::from_f32(0.002),
            goal_speed_mps: S::from_f32(0.01),
        };
        let mut points = Checkpoints::<S, 3>::default();
        points.replace_all(&[Point::from_metres(0.1, 0.0), Point::from_metres(0.2, 0.0)]).unwrap();
        assert_eq!(points.arrive(&p, || at(0.0, 0.0), S::ZERO), None);
        assert_eq!(points.arrive(&p, || at(0.097, 0.0), S::ONE), Some(Reached { number: 0, is_goal: false }));
        points.replace(1, Point::from_metres(0.3, 0.1)).unwrap();
        assert_eq!(
            points.replace(0, Point::from_metres(0.0, 0.0)),
            Err(CheckpointError::NotAhead { number: 0, first: 1, end: 2 })
        );
        assert_eq!(points.arrive(&p, || at(0.297, 0.1), S::ZERO), None, "the goal is stricter");
        assert_eq!(points.arrive(&p, || at(0.299, 0.1), S::ONE), None, "too fast to stop here");
        assert_eq!(points.arrive(&p, || at(0.299, 0.1), S::ZERO), Some(Reached { number: 1, is_goal: true }));
        assert_eq!(points.current(), None);
        assert_eq!(
            points.append(&[Point::default(); 4]),
            Err(CheckpointError::TooMany { count: 4, capacity: 3 })
        );
    }

    #[test]
    fn checkpoints_are_reached_in_order_and_replaced_under_way() {
        check::<f32>();
        check::<Fixed>();
    }

    #[test]
    fn what_is_no_place_is_refused() {
        let mut points = Checkpoints::<f32, 3>::default();
        points.replace_all(&[Point::from_metres(1.0, 1.0)]).unwrap();
        let bad = [Point::from_metres(0.0, 0.0), Point { x_m: f32::NAN, y_m: 0.0 }];
        assert_eq!(points.replace_all(&bad), Err(CheckpointError::OutOfRange { position: 1 }));
        assert_eq!(points.remaining(), 1, "the old list stays");
    }
}
