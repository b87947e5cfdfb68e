//! Six Sun sensors, one Sun: which faces see it, and where it is.
//!
//! Each face that has light must pass three questions before it counts:
//!
//! 1. *Is it as bright as the Sun would be there?* A pinhole lets I_full · cos θ through of a Sun
//!    θ off the axis. The sunlit Earth gives at most 0.21 of I_full within ±55 deg (0.55 over
//!    unbroken cloud), the Sun at the edge of the cone 0.57 of it: what is too faint for its place
//!    is the Earth, a Sun half set, or a fault; what is too bright is a fault.
//! 2. *Is it where it is expected?* Asked when somebody has an attitude and its uncertainty.
//! 3. *Do the faces agree?* Up to three see the Sun at once.
//!
//! Those that pass are averaged with weights 1/σ²: the errors of different faces are independent
//! and alike about every axis across the line of sight, so that this is the estimate of maximum
//! likelihood, of variance 1/Σ(1/σ²).
//!
//! A face that sees the Sun and the Earth together shows the centre of gravity of both. Its excess
//! of light tells how much is foreign: with q = I / (I_full cos θ) a part f = 1 − 1/q of the light
//! pulls the spot by f times the distance between Sun and Earth-light. Far off the axis some pull
//! goes unnoticed, because it moves the spot to where less, or more, light is expected: dq/dθ is
//! tan θ. Unless the Earth is known not to be in view, both are put into σ:
//!
//! σ² = σ₀² + (f · [`PULL_RAD`])² + (tan θ · [`UNNOTICED_RAD`])²
//!
//! Angles between directions are taken as chords, which are smaller by 1 % at 0.5 rad.

mod parameters;
mod sighting;
#[cfg(test)]
mod tests;

use crate::frames::{Body, Vector};
use crate::reading::{MissingReason, Reading};
use crate::sensing::sun_face::{Spot, SunFace};

pub use parameters::{CUBE_XYZW, FACES, SunFacesError, SunFacesParameters};
pub use sighting::{EarthDisc, Expected, FaceVerdict, SunDirection, SunPrediction, SunSighting};

/// What the spot is pulled by for a unit of excess light, and what goes unnoticed for a unit of
/// tan θ: root mean squares about one axis, rad. From 40,000 sightings of the simulator, with an
/// Earth of albedo 0.3, in any attitude 615 km above the lit and the dark side; a test of `adcs-sim`
/// holds σ against the errors there.
pub const PULL_RAD: f32 = 0.5;
/// See [`PULL_RAD`].
pub const UNNOTICED_RAD: f32 = 0.0105;

/// The six faces with their parameters checked.
#[derive(Debug, Clone, Copy)]
pub struct SunFaces {
    faces: [SunFace; FACES],
    sigma_rad: f32,
    faintest: f32,
    brightest: f32,
    gate: f32,
}

/// A face that may see the Sun.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    direction: Vector<Body>,
    variance_rad2: f32,
    /// The share of it that foreign light makes.
    pull_rad2: f32,
    light: f32,
    /// Whether its face is known to have the Earth in view.
    earth: bool,
}

impl Candidate {
    /// Whether two directions with these variances about each axis can be one.
    fn agrees(&self, other: Vector<Body>, variance_rad2: f32, gate: f32) -> bool {
        let chord = self.direction - other;
        chord.dot(&chord) <= gate * gate * (self.variance_rad2 + variance_rad2)
    }
}

type Candidates = [Option<Candidate>; FACES];

impl SunFaces {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`SunFacesError`] with the face and the value; the previous parameters should stay in force.
    pub fn new(parameters: &SunFacesParameters) -> Result<Self, SunFacesError> {
        let p = parameters;
        let face = |face: u8, parameters| {
            SunFace::new(parameters).map_err(|error| SunFacesError::Face { face, error })
        };
        let [a, b, c, d, e, f] = &p.faces;
        let faces = [face(0, a)?, face(1, b)?, face(2, c)?, face(3, d)?, face(4, e)?, face(5, f)?];
        if !(p.sigma_rad > 0.0 && p.sigma_rad < 1.0) {
            return Err(SunFacesError::Sigma { found_rad: p.sigma_rad });
        }
        if !(0.0..=1.0).contains(&p.faintest) {
            return Err(SunFacesError::Faintest { found: p.faintest });
        }
        if !(p.brightest > 1.0 && p.brightest.is_finite()) {
            return Err(SunFacesError::Brightest { found: p.brightest });
        }
        if !(p.gate > 0.0 && p.gate.is_finite()) {
            return Err(SunFacesError::Gate { found: p.gate });
        }
        let &SunFacesParameters { sigma_rad, faintest, brightest, gate, .. } = p;
        Ok(Self { faces, sigma_rad, faintest, brightest, gate })
    }

    /// Where the Sun is by the currents `[X1, X2, Y1, Y2]` (A) of each face.
    pub fn sight(&self, currents: &[Reading<[f32; 4]>; FACES], expected: &Expected) -> SunSighting {
        let mut verdicts = [FaceVerdict::Dark; FACES];
        let mut candidates: Candidates = [None; FACES];
        for (((face, &currents), verdict), slot) in
            self.faces.iter().zip(currents).zip(&mut verdicts).zip(&mut candidates)
        {
            let candidate = face
                .spot(currents)
                .and_then(|spot| self.as_bright_as_the_sun(face, &spot, expected))
                .and_then(|candidate| self.as_predicted(candidate, expected.sun));
            match candidate {
                Ok(candidate) => *slot = Some(candidate),
                Err(why) => *verdict = why,
            }
        }
        let sun = match self.spokesman(&candidates, expected.sun) {
            None => Reading::Missing(without_candidates(&verdicts)),
            Some(Err(reason)) => Reading::Missing(reason),
            Some(Ok(spokesman)) => self.mean(&candidates, spokesman, &mut verdicts),
        };
        for (verdict, candidate) in verdicts.iter_mut().zip(&candidates) {
            if candidate.is_some() && *verdict != FaceVerdict::Used {
                *verdict = FaceVerdict::Disagrees;
            }
        }
        SunSighting { sun, faces: verdicts }
    }

    /// Question 1, and the variance that follows from the answer.
    fn as_bright_as_the_sun(
        &self,
        face: &SunFace,
        spot: &Spot,
        expected: &Expected,
    ) -> Result<Candidate, FaceVerdict> {
        // The spot has light and a cosine above zero.
        let q = spot.light / (spot.cos_off_axis * expected.irradiance);
        if q > self.brightest {
            return Err(FaceVerdict::Bright);
        }
        let earth = expected.earth.is_some_and(|earth| in_view(face, &earth));
        let bright_enough = q >= self.faintest;
        if !bright_enough {
            return Err(if earth { FaceVerdict::Earth } else { FaceVerdict::Faint });
        }
        let earth_excluded = expected.earth.is_some() && !earth;
        let pull_rad2 = if earth_excluded { 0.0 } else { pull_rad2(q, spot.cos_off_axis) };
        Ok(Candidate {
            direction: spot.direction.vector(),
            variance_rad2: self.sigma_rad * self.sigma_rad + pull_rad2,
            pull_rad2,
            light: spot.light,
            earth,
        })
    }

    /// Question 2.
    fn as_predicted(
        &self,
        candidate: Candidate,
        prediction: Option<SunPrediction>,
    ) -> Result<Candidate, FaceVerdict> {
        let Some(SunPrediction { direction, sigma_rad }) = prediction else {
            return Ok(candidate);
        };
        let agrees = candidate.agrees(direction.vector(), sigma_rad * sigma_rad, self.gate);
        if agrees { Ok(candidate) } else { Err(FaceVerdict::Unpredicted) }
    }

    /// Question 3: the candidate with which the others must agree; `None` without any.
    ///
    /// With a prediction it is the one nearest to that. Without, the one that most others agree
    /// with, of equals one that does not look towards the Earth, of these the brightest; and if any
    /// other does not agree, then it must have a majority, or all who do not must look towards the
    /// Earth and it must not.
    fn spokesman(
        &self,
        candidates: &Candidates,
        prediction: Option<SunPrediction>,
    ) -> Option<Result<Candidate, MissingReason>> {
        let present = || candidates.iter().flatten();
        if let Some(SunPrediction { direction, .. }) = prediction {
            let distance = |c: &Candidate| (c.direction - direction.vector()).norm();
            return present().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied().map(Ok);
        }
        let agreeing = |with: &Candidate| present().filter(|other| self.agree(with, other)).count();
        let best = *present().max_by(|a, b| {
            let order = agreeing(a).cmp(&agreeing(b));
            order.then(b.earth.cmp(&a.earth)).then(a.light.total_cmp(&b.light))
        })?;
        let explained =
            || !best.earth && present().all(|other| self.agree(&best, other) || other.earth);
        let settled = 2 * agreeing(&best) > present().count() || explained();
        Some(if settled { Ok(best) } else { Err(MissingReason::Disagree) })
    }

    fn agree(&self, a: &Candidate, b: &Candidate) -> bool {
        a.agrees(b.direction, b.variance_rad2, self.gate)
    }

    /// The weighted mean of all that agree with the spokesman, who are marked as used.
    fn mean(
        &self,
        candidates: &Candidates,
        spokesman: Candidate,
        verdicts: &mut [FaceVerdict; FACES],
    ) -> Reading<SunDirection> {
        let mut sum = Vector::<Body>::zero();
        let (mut weight, mut pull) = (0.0, 0.0);
        for (verdict, candidate) in verdicts.iter_mut().zip(candidates) {
            if let Some(candidate) = candidate.filter(|other| self.agree(&spokesman, other)) {
                // The variance is at least σ₀², which is positive.
                sum = sum + candidate.direction * (1.0 / candidate.variance_rad2);
                weight += 1.0 / candidate.variance_rad2;
                pull += candidate.pull_rad2 / (candidate.variance_rad2 * candidate.variance_rad2);
                *verdict = FaceVerdict::Used;
            }
        }
        let Some(direction) = sum.direction() else {
            return Reading::Missing(MissingReason::NotFinite);
        };
        let worst_residual_rad = verdicts
            .iter()
            .zip(candidates)
            .filter(|(verdict, _)| **verdict == FaceVerdict::Used)
            .filter_map(|(_, candidate)| *candidate)
            .map(|candidate| (candidate.direction - direction.vector()).norm())
            .fold(0.0, f32::max);
        let sigma_rad = 1.0 / libm::sqrtf(weight);
        let pull_rad = libm::sqrtf(pull) / weight;
        Reading::Fresh(SunDirection { direction, sigma_rad, pull_rad, worst_residual_rad })
    }
}

/// Variance about each axis of what foreign light does to a spot of relative brightness `q`.
fn pull_rad2(q: f32, cos_off_axis: f32) -> f32 {
    let excess = (1.0 - 1.0 / q).max(0.0);
    let tan_2 = 1.0 / (cos_off_axis * cos_off_axis) - 1.0;
    excess * excess * (PULL_RAD * PULL_RAD) + tan_2 * (UNNOTICED_RAD * UNNOTICED_RAD)
}

/// Whether any of the Earth is within the face's cone.
fn in_view(face: &SunFace, earth: &EarthDisc) -> bool {
    let reach_rad = (face.half_cone_rad() + earth.radius_rad).min(core::f32::consts::PI);
    face.boresight().vector().dot(&earth.nadir.vector()) > libm::cosf(reach_rad)
}

/// Why there is no Sun when no face sees it: the strongest of the reasons of the faces.
fn without_candidates(verdicts: &[FaceVerdict; FACES]) -> MissingReason {
    let any = |wanted: FaceVerdict| verdicts.contains(&wanted);
    let missing = verdicts.iter().find_map(|verdict| match verdict {
        FaceVerdict::Missing(reason) => Some(*reason),
        _ => None,
    });
    if any(FaceVerdict::Unpredicted) {
        return MissingReason::Unpredicted;
    }
    // A face that says nothing may be the one that is lit.
    missing.unwrap_or(if verdicts.iter().all(|verdict| *verdict == FaceVerdict::Dark) {
        MissingReason::Dark
    } else {
        MissingReason::NotTheSun
    })
}
