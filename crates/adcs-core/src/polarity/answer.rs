//! What the estimated answer to the torquers says about them: how they are wired, or that some are dead.
//!
//! `response` estimates P, what the torquers make of a dipole that they are told, as any matrix. Of what
//! it can be one knows more: one of the 48 signed permutations, or the identity with a column of zeros where
//! a torquer obeys and does nothing; one of the three does, or what they share, and all. What speaks for one
//! of these 52 is its posterior density over its prior one,
//!
//! log L = −½ (P − P̂)ᵀ Σ⁻¹ (P − P̂) + ½ |P|² / σ₀²
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | P̂, Σ | `towards`, `inverse` | estimate and its covariance, 0.05² added for scale and misalignment of torquers that are wired well |
//! | σ₀ | `WIRING_PRIOR` | of each entry before the first measurement; \|P\|² is 3 for a wiring, 0 to 2 with dead ones |
//! | C | `work` | ∫ (B × ω) mᵀ dt, of late |
//!
//! The mean odds of all wrong wirings against the right one are, while nothing is wrong, a martingale: that
//! they ever rise above a has a probability of 1/a (Ville's inequality); and so are those of the four sets
//! of dead ones. While the torquers are only to take energy out, wirings alone count under which their work would have
//! been useless or harmful, tr(Pᵀ C) against tr C, and of the dead ones only all: what is dead does no harm, and
//! one torquer that is left takes energy out.
//!
//! Source: Ville (1939) for the inequality.

use nalgebra::{Matrix3, SMatrix, SVector};

use super::response::WIRING_PRIOR;
use super::turning::LogSum;
use crate::frames::SignedPermutation;

/// What torquers that are wired well may do beside P, each entry.
const WIRING_SLACK: f32 = 0.05;
/// What takes out less than this part of what the right wiring does is harmful, or useless.
const USELESS: f32 = 0.25;
/// Wrong wirings, and sets of dead torquers.
const WRONG: f32 = SignedPermutation::COUNT as f32 - 1.0;
const DEAD: f32 = Answer::DEAD.len() as f32;

/// What torquers make of what they are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    /// They are wired so.
    Wired(SignedPermutation),
    /// Those along these axes of Body do nothing, the others what they should.
    Dead([bool; 3]),
}

impl Answer {
    const RIGHT: Self = Self::Wired(SignedPermutation::IDENTITY);

    const DEAD: [[bool; 3]; 4] =
        [[true, false, false], [false, true, false], [false, false, true], [true; 3]];

    fn all() -> impl Iterator<Item = Self> {
        SignedPermutation::all().map(Self::Wired).chain(Self::DEAD.map(Self::Dead))
    }

    fn matrix(self) -> Matrix3<f32> {
        match self {
            Self::Wired(wiring) => wiring.matrix(),
            Self::Dead(dead) => {
                Matrix3::from_diagonal(&dead.map(|dead| if dead { 0.0 } else { 1.0 }).into())
            }
        }
    }
}

/// How far the torquers' answer is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponseEvidence {
    /// What explains the rates best.
    pub(super) best: Answer,
    /// Natural logarithm of its odds against the second best.
    pub(super) lead: f32,
    /// How far the estimate is from it, (P − P̂)ᵀ Σ⁻¹ (P − P̂): nine in the mean where it is true.
    pub(super) misfit: f32,
    /// Natural logarithm of the mean odds of all wrong wirings against the right one, those that do not
    /// count being impossible.
    pub(super) wrong: f32,
    /// The same of dead torquers.
    pub(super) dead: f32,
    /// Log-likelihood of the right wiring and of the reversed one; for comparing filters that were fed
    /// differently.
    pub(super) right: f32,
    /// See `right`.
    pub(super) reversed: f32,
}

/// The estimate of P, for asking how likely an answer is.
pub(super) struct Answers {
    inverse: SMatrix<f32, 9, 9>,
    towards: SVector<f32, 9>,
    middle: f32,
    determinant: f32,
}

impl Answers {
    /// Of an estimate of the nine numbers, column by column, and its covariance.
    pub(super) fn new(wiring: SVector<f32, 9>, covariance: SMatrix<f32, 9, 9>) -> Option<Self> {
        let slack = SMatrix::<f32, 9, 9>::from_diagonal_element(WIRING_SLACK * WIRING_SLACK);
        let factor = (covariance + slack).cholesky()?;
        let inverse = factor.inverse();
        let towards = inverse * wiring;
        let middle = wiring.dot(&towards);
        Some(Self { inverse, towards, middle, determinant: factor.determinant() })
    }

    /// (P − P̂)ᵀ Σ⁻¹ (P − P̂), multiplied out: of the nine entries of P three at most are not zero.
    fn misfit(&self, answer: &Matrix3<f32>) -> f32 {
        let entries = || answer.iter().enumerate().filter(|(_, sign)| **sign != 0.0);
        let along = |at: usize| self.towards.get(at).copied().unwrap_or(0.0);
        let both = |at: (usize, usize)| self.inverse.get(at).copied().unwrap_or(0.0);
        let linear: f32 = entries().map(|(i, sign)| sign * along(i)).sum();
        let square: f32 =
            entries().map(|(i, a)| entries().map(|(j, b)| a * b * both((i, j))).sum::<f32>()).sum();
        square - 2.0 * linear + self.middle
    }

    /// What speaks for each answer, `log_likelihood` being that of all measurements under any P; with `work`
    /// only what would have been useless or harmful counts as wrong.
    pub(super) fn evidence(
        &self,
        log_likelihood: f32,
        work: Option<&Matrix3<f32>>,
    ) -> Option<ResponseEvidence> {
        let prior = |p: &Matrix3<f32>| 0.5 * p.norm_squared() / (WIRING_PRIOR * WIRING_PRIOR);
        let likelihood = |p: &Matrix3<f32>| prior(p) - 0.5 * self.misfit(p);
        let right = likelihood(&Answer::RIGHT.matrix());
        let (mut best, mut misfit) = (Answer::RIGHT, f32::INFINITY);
        let (mut most, mut second) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        let (mut wrong, mut dead) = (LogSum::default(), LogSum::default());
        for it in Answer::all() {
            let p = it.matrix();
            let found = likelihood(&p);
            let counts = work.is_none_or(|work| p.dot(work) > USELESS * work.trace());
            match it {
                Answer::Wired(SignedPermutation::IDENTITY) => {}
                Answer::Wired(_) if counts => wrong.add(found),
                Answer::Dead(set) if counts && (work.is_none() || set == [true; 3]) => {
                    dead.add(found);
                }
                Answer::Wired(_) | Answer::Dead(_) => {}
            }
            if found > most {
                (best, misfit, most, second) = (it, 2.0 * (prior(&p) - found), found, most);
            } else if found > second {
                second = found;
            }
        }
        // p(y | P) = p(P | y) p(y) / p(P).
        let marginal = log_likelihood - libm::logf(self.determinant) * 0.5;
        let reversed = likelihood(&Answer::Wired(SignedPermutation::REVERSED).matrix());
        let found = ResponseEvidence {
            best,
            lead: most - second,
            misfit,
            wrong: wrong.mean_over(WRONG) - right,
            dead: dead.mean_over(DEAD) - right,
            right: marginal + right,
            reversed: marginal + reversed,
        };
        let ResponseEvidence { lead, wrong, dead, right, reversed, .. } = found;
        let numbers = [lead, misfit, wrong, dead, right, reversed];
        numbers.iter().all(|it| it.is_finite()).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of an estimate at `p` with this σ of each entry.
    fn evidence(p: Matrix3<f32>, sigma: f32, work: Option<&Matrix3<f32>>) -> ResponseEvidence {
        let estimate = SVector::<f32, 9>::from_iterator(p.iter().copied());
        let covariance = SMatrix::<f32, 9, 9>::from_diagonal_element(sigma * sigma);
        Answers::new(estimate, covariance).unwrap().evidence(0.0, work).unwrap()
    }

    #[test]
    fn before_anything_is_known_no_answer_is_likelier_than_another() {
        /// What the slack of 0.05 takes from the prior, natural logarithm.
        const SLACK: f32 = 0.02;
        let nothing_known = evidence(Matrix3::zeros(), WIRING_PRIOR, None);
        let ResponseEvidence { wrong, dead, lead, .. } = nothing_known;
        assert!([wrong, dead, lead].iter().all(|it| it.abs() < SLACK), "{nothing_known:?}");
    }

    #[test]
    fn what_is_well_known_is_named_and_what_lies_between_is_not_explained() {
        /// 99.9 % of χ² with nine degrees of freedom.
        const EXPLAINED: f32 = 27.9;
        const SIGMA: f32 = 0.1;
        for answer in Answer::all() {
            let found = evidence(answer.matrix(), SIGMA, None);
            assert_eq!(found.best, answer);
            assert!(found.misfit < 0.1 && found.lead > 10.0, "{found:?}");
        }
        let turned = SignedPermutation::new(1).unwrap().matrix();
        let between = (Matrix3::identity() * 0.25) + turned * 0.75;
        assert!(evidence(between, 0.05, None).misfit > EXPLAINED);
    }

    #[test]
    fn in_a_despin_all_dead_torquers_count_and_one_does_not() {
        // Each torquer takes as much energy out.
        let work = -Matrix3::identity();
        for dead in Answer::DEAD {
            let matrix = Answer::Dead(dead).matrix();
            let found = evidence(matrix, 0.1, Some(&work));
            assert_eq!(found.dead > 10.0, dead == [true; 3], "{found:?}");
            assert!(evidence(matrix, 0.1, None).dead > 10.0);
        }
    }
}
