//! Command fusion: `c = β c_p + (1 − β) c_o` (P1 Eq. 10), the first paper's way to join two modules.
//!
//! A sum of two commands, each best for its module, need be good for neither: that is what cooperative EKMs improve
//! on, and why it is kept here beside them.

use crate::kohonen::features::Command;
use crate::scalar::Scalar;

/// Joins the command for the target with the command away from obstacles; `beta` within 0..=1.
#[must_use]
pub fn fuse<S: Scalar>(beta: S, target: Command<S>, avoidance: Command<S>) -> Command<S> {
    let rest = S::ONE - beta;
    Command {
        left: beta * target.left + rest * avoidance.left,
        right: beta * target.right + rest * avoidance.right,
    }
    .scaled_to_limit()
}

#[cfg(test)]
mod tests {
    use super::fuse;
    use crate::kohonen::features::Command;
    use crate::scalar::{Fixed, Scalar};

    fn check<S: Scalar>() {
        let command = |left, right| Command { left: S::from_f32(left), right: S::from_f32(right) };
        let fused = fuse(S::from_f32(0.75), command(1.0, 0.5), command(-1.0, 0.5));
        assert_eq!(fused, command(0.5, 0.5));
        assert!(fuse(S::HALF, command(9.0, 3.0), command(9.0, 3.0)).is_realisable());
    }

    #[test]
    fn is_the_weighted_sum() {
        check::<f32>();
        check::<Fixed>();
    }
}
