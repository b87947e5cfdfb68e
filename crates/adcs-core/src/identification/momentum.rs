//! Residual dipole, inertia ratios and torquer gains from the balance of angular momentum.
//!
//! J ω + ∫ ω × J ω dt = h₀ + ∫ (G m + M) × B dt
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | J | `inertia` | tensor, Body; as told, or with five unknowns that leave its trace alone |
//! | h₀ | | momentum at the start of a segment: not asked for, and taken out |
//! | M | [`MomentumFit::dipole`] | residual dipole, A·m² |
//! | G | [`MomentumFit::gains`] | what the torquers make of a commanded dipole: one, when they do as they are told |
//!
//! It is eq. (2) of the paper, integrated: no difference is taken, so that a reading's noise counts once
//! and in full length against all that happened since the segment began. All of it is multiplied by J⁻¹, and
//! the residuals are rates: where they are as small as the gyros' noise, the model explains the record.
//!
//! A segment should be long enough for the body to turn in the field, and short enough for what the balance
//! does not know (gyro bias and the tensor's error through ω × J ω, drag, gravity gradient) to stay below the noise.
//!
//! Only products of J, M and G with each other show: M and G are in proportion to the trace of J as it is told.

use nalgebra::{Matrix3, RealField, SMatrix, Vector3};

use super::field_track::{FieldTrack, Tracked};
use super::least_squares::Centred;
use super::{
    IdentificationError, Inertia, Normal, Recorded, Solution, number, of_unit_dipoles, shown,
};

/// Unknowns of [`MomentumFit::ratios`]: M, then the tensor's xx − zz, yy − zz parts and its products.
pub const RATIO_UNKNOWNS: usize = 8;
/// Unknowns of [`MomentumFit::gains`]: M, then G column by column.
pub const GAIN_UNKNOWNS: usize = 12;

/// What is unknown beside M.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beside {
    Nothing,
    Tensor,
    Gains,
}

/// Sums over a record.
#[derive(Debug, Clone, Copy)]
pub struct MomentumFit<T: RealField + Copy, const N: usize> {
    inertia: Inertia<T>,
    beside: Beside,
    segment_s: T,
    track: FieldTrack<T>,
    segment: Option<Segment<T, N>>,
    normal: Normal<T, N>,
}

/// Integrals since a segment began.
#[derive(Debug, Clone, Copy)]
struct Segment<T: RealField + Copy, const N: usize> {
    age_s: T,
    last: Tracked<T>,
    last_field: Vector3<T>,
    /// ∫ ω × J ω dt, for the tensor as told and for its five changes.
    turning: Vector3<T>,
    turnings: [Vector3<T>; 5],
    /// ∫ B dt
    field: Vector3<T>,
    /// ∫ m × B dt, and ∫ B m_j dt.
    driven: Vector3<T>,
    drives: [Vector3<T>; 3],
    sums: Centred<T, N>,
}

impl<T: RealField + Copy> MomentumFit<T, 3> {
    /// For M alone.
    ///
    /// # Errors
    /// [`IdentificationError`]: a tensor or a length of segments that is none.
    pub fn dipole(inertia_kg_m2: [[T; 3]; 3], segment_s: T) -> Result<Self, IdentificationError> {
        Self::new(inertia_kg_m2, segment_s, Beside::Nothing)
    }
}

impl<T: RealField + Copy> MomentumFit<T, RATIO_UNKNOWNS> {
    /// For M and the ratios of the tensor, its trace being as told: the unknowns 3 to 7 are what is to be
    /// added to xx, to yy (and subtracted from zz), to xy, xz and yz, kg·m².
    ///
    /// # Errors
    /// [`IdentificationError`]: a tensor or a length of segments that is none.
    pub fn ratios(inertia_kg_m2: [[T; 3]; 3], segment_s: T) -> Result<Self, IdentificationError> {
        Self::new(inertia_kg_m2, segment_s, Beside::Tensor)
    }

    /// The tensor that a solution means, row by row.
    pub fn tensor(&self, solution: &Solution<T, RATIO_UNKNOWNS>) -> [[T; 3]; 3] {
        let changes = solution.x.iter().skip(3).zip(tensor_changes::<T>());
        let sum = changes.fold(self.inertia.tensor, |sum, (&amount, change)| sum + change * amount);
        sum.into()
    }
}

impl<T: RealField + Copy> MomentumFit<T, GAIN_UNKNOWNS> {
    /// For M and G: the unknowns 3 to 11 are G's columns.
    ///
    /// # Errors
    /// [`IdentificationError`]: a tensor or a length of segments that is none.
    pub fn gains(inertia_kg_m2: [[T; 3]; 3], segment_s: T) -> Result<Self, IdentificationError> {
        Self::new(inertia_kg_m2, segment_s, Beside::Gains)
    }
}

/// Changes of a tensor that leave its trace alone.
fn tensor_changes<T: RealField + Copy>() -> [Matrix3<T>; 5] {
    let (o, i) = (T::zero(), T::one());
    [
        Matrix3::new(i, o, o, o, o, o, o, o, -i),
        Matrix3::new(o, o, o, o, i, o, o, o, -i),
        Matrix3::new(o, i, o, i, o, o, o, o, o),
        Matrix3::new(o, o, i, o, o, o, i, o, o),
        Matrix3::new(o, o, o, o, o, i, o, i, o),
    ]
}

impl<T: RealField + Copy, const N: usize> MomentumFit<T, N> {
    fn new(
        inertia_kg_m2: [[T; 3]; 3],
        segment_s: T,
        beside: Beside,
    ) -> Result<Self, IdentificationError> {
        let usable = segment_s.is_finite() && segment_s > T::zero();
        if !usable {
            return Err(IdentificationError::Interval { found: shown(segment_s) });
        }
        Ok(Self {
            inertia: Inertia::new(inertia_kg_m2)?,
            beside,
            segment_s,
            track: FieldTrack::default(),
            segment: None,
            normal: Normal::default(),
        })
    }

    /// Takes in an instant. Where the record is interrupted, or no field is known, a segment ends.
    pub fn add(&mut self, recorded: &Recorded<T>) {
        let tracked = self.track.advance(recorded);
        let known = tracked.and_then(|tracked| Some((tracked, tracked.field?)));
        let Some((tracked, field)) = known else {
            self.end_segment();
            return;
        };
        match self.segment.as_mut() {
            Some(segment) => segment.advance(&self.inertia, recorded, tracked, field),
            None => self.segment = Some(Segment::begin(tracked, field)),
        }
        if let Some(segment) = self.segment.as_mut() {
            segment.balance(&self.inertia, self.beside);
            if segment.age_s >= self.segment_s {
                self.end_segment();
                self.segment = Some(Segment::begin(tracked, field));
            }
        }
    }

    fn end_segment(&mut self) {
        if let Some(segment) = self.segment.take() {
            self.normal.add_centred(&segment.sums);
        }
    }

    /// The unknowns, M first.
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, N>, IdentificationError> {
        let mut all = *self;
        all.end_segment();
        all.normal.solve()
    }
}

impl<T: RealField + Copy, const N: usize> Segment<T, N> {
    fn begin(tracked: Tracked<T>, field: Vector3<T>) -> Self {
        Self {
            age_s: T::zero(),
            last: tracked,
            last_field: field,
            turning: Vector3::zeros(),
            turnings: [Vector3::zeros(); 5],
            field: Vector3::zeros(),
            driven: Vector3::zeros(),
            drives: [Vector3::zeros(); 3],
            sums: Centred::default(),
        }
    }

    /// Carries the integrals on by the trapezoidal rule.
    fn advance(
        &mut self,
        inertia: &Inertia<T>,
        recorded: &Recorded<T>,
        tracked: Tracked<T>,
        field: Vector3<T>,
    ) {
        let (dt, half) = (recorded.dt_s, recorded.dt_s * number(0.5));
        let (before, now) = (self.last.rate, tracked.rate);
        let mean = |tensor: &Matrix3<T>| {
            (before.cross(&(tensor * before)) + now.cross(&(tensor * now))) * half
        };
        self.turning += mean(&inertia.tensor);
        for (turning, change) in self.turnings.iter_mut().zip(tensor_changes::<T>()) {
            *turning += mean(&change);
        }
        let area = (self.last_field + field) * half;
        let dipole = Vector3::from(recorded.dipole_am2);
        self.field += area;
        self.driven += dipole.cross(&area);
        for (drive, dipole) in self.drives.iter_mut().zip(dipole.iter()) {
            *drive += area * *dipole;
        }
        self.age_s += dt;
        (self.last, self.last_field) = (tracked, field);
    }

    /// Adds the balance at this instant: a x = y with a constant of its own.
    fn balance(&mut self, inertia: &Inertia<T>, beside: Beside) {
        let inverse = &inertia.inverse;
        let rate = self.last.rate;
        // J⁻¹ (J ω + ∫ ω × J ω dt − ∫ m × B dt)
        let mut y = rate + inverse * self.turning;
        let mut columns = [Vector3::zeros(); GAIN_UNKNOWNS];
        let of_dipole = inverse * of_unit_dipoles(&self.field);
        for (column, value) in columns.iter_mut().zip(of_dipole.column_iter()) {
            *column = value.into();
        }
        let others = columns.iter_mut().skip(3);
        match beside {
            Beside::Nothing => y -= inverse * self.driven,
            Beside::Tensor => {
                y -= inverse * self.driven;
                let changes = self.turnings.iter().zip(tensor_changes::<T>());
                for (column, (turning, change)) in others.zip(changes) {
                    *column = -(inverse * (change * rate + turning));
                }
            }
            Beside::Gains => {
                let drives = self.drives.iter().map(|drive| inverse * of_unit_dipoles(drive));
                let of_gains = drives
                    .flat_map(|drive| [0, 1, 2].map(|axis| Vector3::from(drive.column(axis))));
                for (column, value) in others.zip(of_gains) {
                    *column = value;
                }
            }
        }
        let mut a = SMatrix::<T, 3, N>::zeros();
        for (mut to, from) in a.column_iter_mut().zip(columns) {
            to.copy_from(&from);
        }
        self.sums.add(&a, &y);
    }
}
