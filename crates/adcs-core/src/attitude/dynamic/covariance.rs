//! The covariance of N triples of states, kept as 3 × 3 blocks.
//!
//! Every state of the filter comes in threes (an axis each), so that its matrices are made of 3 × 3
//! blocks most of which are zero or the identity. What is zero is not multiplied:
//!
//! | step | equation | what is saved |
//! |---|---|---|
//! | [`Covariance::propagate`] | P⁺ = Φ P Φᵀ | only the first two triples (attitude, rate) move |
//! | [`Covariance::absorb`] | Joseph, one scalar after the other | hᵀ has one or two triples |
//!
//! A triple whose block is switched off has zero rows and columns and is passed over, so that a state
//! that does not fly costs memory alone.
//!
//! Source: Bierman (1977), §II.5, for the scalar Joseph update as two corrections of rank one.

use nalgebra::{Cholesky, ComplexField, Matrix3, RealField, SMatrix, Vector3, convert};

use super::block::{Block, Blocks, COUNT};

/// One block for each triple.
pub(crate) type Triples<T> = [Matrix3<T>; COUNT];

/// A symmetric matrix of [`COUNT`] × [`COUNT`] blocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Covariance<T: RealField + Copy> {
    rows: [Triples<T>; COUNT],
    flying: [bool; COUNT],
}

/// How the two moving triples follow from all triples in one step: rows of Φ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Transition<T: RealField + Copy> {
    /// Attitude after from every triple before; `None` where Φ is zero.
    pub(crate) attitude: [Option<Matrix3<T>>; COUNT],
    /// Rate after from every triple before.
    pub(crate) rate: [Option<Matrix3<T>>; COUNT],
}

/// One scalar measurement, linearised at the estimate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<T: RealField + Copy> {
    /// What a small change of each triple does to the measurement; `None` where nothing.
    pub(crate) h: [Option<Vector3<T>>; COUNT],
    /// Measured minus expected.
    pub(crate) innovation: T,
    /// Variance of the measurement's noise.
    pub(crate) variance: T,
}

/// One vector for each triple.
pub(crate) type Step<T> = [Vector3<T>; COUNT];

impl<T: RealField + Copy> Row<T> {
    /// A measurement that sees these triples alone.
    pub(crate) fn new<const M: usize>(
        h: [(Block, Vector3<T>); M],
        innovation: T,
        variance: T,
    ) -> Self {
        let mut row = Self { h: [None; COUNT], innovation, variance };
        for (block, of_block) in h {
            if let Some(slot) = row.h.get_mut(block as usize) {
                *slot = Some(of_block);
            }
        }
        row
    }

    fn dot(&self, x: &Step<T>) -> T {
        let terms = self.h.iter().zip(x).filter_map(|(h, x)| h.map(|h| h.dot(x)));
        terms.fold(T::zero(), |sum, term| sum + term)
    }
}

impl<T: RealField + Copy> Covariance<T> {
    /// Nothing is uncertain, and these triples fly.
    pub(crate) fn zeros(blocks: Blocks) -> Self {
        Self { rows: [[Matrix3::zeros(); COUNT]; COUNT], flying: blocks.flying() }
    }

    /// The block of two triples.
    pub(crate) fn block(&self, row: Block, column: Block) -> Matrix3<T> {
        let found = self.rows.get(row as usize).and_then(|row| row.get(column as usize));
        found.copied().unwrap_or_else(Matrix3::zeros)
    }

    /// Sets a block and its mirror image.
    pub(crate) fn set(&mut self, row: Block, column: Block, block: &Matrix3<T>) {
        let mut put = |row: Block, column: Block, block: Matrix3<T>| {
            if let Some(slot) =
                self.rows.get_mut(row as usize).and_then(|row| row.get_mut(column as usize))
            {
                *slot = block;
            }
        };
        put(column, row, block.transpose());
        put(row, column, *block);
    }

    /// Adds to the block of one triple.
    pub(crate) fn add(&mut self, block: Block, more: &Matrix3<T>) {
        self.set(block, block, &(self.block(block, block) + more));
    }

    /// Variances of a triple.
    pub(crate) fn variance(&self, block: Block) -> Vector3<T> {
        self.block(block, block).diagonal()
    }

    /// P⁺ = Φ P Φᵀ, where `transition` moves attitude and rate and the others stay.
    pub(crate) fn propagate(&mut self, transition: &Transition<T>) {
        let attitude = self.times(&transition.attitude);
        let rate = self.times(&transition.rate);
        let corner = |left: &Triples<T>, right: &[Option<Matrix3<T>>; COUNT]| {
            let terms =
                left.iter().zip(right).filter_map(|(x, phi)| phi.map(|phi| x * phi.transpose()));
            terms.fold(Matrix3::zeros(), |sum, term| sum + term)
        };
        let half: T = convert(0.5);
        let symmetric = |m: Matrix3<T>| (m + m.transpose()) * half;
        let of_attitude = symmetric(corner(&attitude, &transition.attitude));
        let mixed = corner(&attitude, &transition.rate);
        let of_rate = symmetric(corner(&rate, &transition.rate));

        for (block, (of_attitude, of_rate)) in
            Block::ALL.into_iter().zip(attitude.iter().zip(&rate))
        {
            self.set(Block::Attitude, block, of_attitude);
            self.set(Block::Rate, block, of_rate);
        }
        self.set(Block::Attitude, Block::Attitude, &of_attitude);
        self.set(Block::Attitude, Block::Rate, &mixed);
        self.set(Block::Rate, Block::Rate, &of_rate);
    }

    /// A triple decays by `factor`.
    pub(crate) fn scale(&mut self, block: Block, factor: T) {
        for row in &mut self.rows {
            if let Some(slot) = row.get_mut(block as usize) {
                *slot *= factor;
            }
        }
        if let Some(row) = self.rows.get_mut(block as usize) {
            row.iter_mut().for_each(|slot| *slot *= factor);
        }
    }

    /// One row of Φ P.
    fn times(&self, phi: &[Option<Matrix3<T>>; COUNT]) -> Triples<T> {
        let mut sum = [Matrix3::zeros(); COUNT];
        for (phi, row) in phi.iter().zip(&self.rows) {
            let Some(phi) = phi else { continue };
            for ((sum, p), flies) in sum.iter_mut().zip(row).zip(self.flying) {
                if flies {
                    *sum += phi * p;
                }
            }
        }
        sum
    }

    /// P h.
    fn times_row(&self, row: &Row<T>) -> Step<T> {
        let mut all = [Vector3::zeros(); COUNT];
        for ((sum, blocks), flies) in all.iter_mut().zip(&self.rows).zip(self.flying) {
            if flies {
                let terms = blocks.iter().zip(&row.h).filter_map(|(p, h)| h.map(|h| p * h));
                *sum = terms.fold(Vector3::zeros(), |sum, term| sum + term);
            }
        }
        all
    }

    /// Absorbs one measurement; `step` is what earlier rows of the same instant have already added to
    /// the states, and takes what this one adds. Returns the squared innovation over its variance.
    ///
    /// `None`, and nothing changes, when the covariance gives the measurement a negative or no
    /// variance, or a number is not finite.
    pub(crate) fn absorb(&mut self, row: &Row<T>, step: &mut Step<T>) -> Option<T> {
        let ph = self.times_row(row);
        let innovation_variance = row.dot(&ph) + row.variance;
        let residual = row.innovation - row.dot(step);
        // Also refuses NaN.
        let sound = innovation_variance >= row.variance && row.variance > T::zero();
        if !(sound && innovation_variance.is_finite() && residual.is_finite()) {
            return None;
        }
        let gain = ph.map(|ph| ph / innovation_variance);
        for (step, gain) in step.iter_mut().zip(&gain) {
            *step += gain * residual;
        }
        // (I − k hᵀ) P, then times (I − k hᵀ)ᵀ, plus r k kᵀ.
        self.add_outer(&gain.map(|gain| -gain), &ph);
        let again = self.times_row(row);
        let mut rest = gain.map(|gain| gain * row.variance);
        for (rest, again) in rest.iter_mut().zip(&again) {
            *rest -= again;
        }
        self.add_outer(&rest, &gain);
        self.symmetrise();
        Some(residual * residual / innovation_variance)
    }

    /// P + x yᵀ.
    fn add_outer(&mut self, x: &Step<T>, y: &Step<T>) {
        for ((row, x), flies) in self.rows.iter_mut().zip(x).zip(self.flying) {
            if !flies {
                continue;
            }
            for ((block, y), flies) in row.iter_mut().zip(y).zip(self.flying) {
                if flies {
                    *block += x * y.transpose();
                }
            }
        }
    }

    /// P = (P + Pᵀ) / 2.
    fn symmetrise(&mut self) {
        let half: T = convert(0.5);
        let flying = self.flying;
        let flying = || Block::ALL.into_iter().zip(flying).filter_map(|(b, f)| f.then_some(b));
        for row in flying() {
            for column in flying().filter(|column| *column as usize <= row as usize) {
                let mean = (self.block(row, column) + self.block(column, row).transpose()) * half;
                self.set(row, column, &mean);
            }
        }
    }

    /// Whether all states that fly have a Cholesky factor: what the variances alone do not show.
    pub(crate) fn is_positive(&self) -> bool {
        const STATES: usize = 3 * COUNT;
        let mut whole = SMatrix::<T, STATES, STATES>::zeros();
        for row in Block::ALL {
            for column in Block::ALL {
                let (r, c) = (3 * row as usize, 3 * column as usize);
                whole.fixed_view_mut::<3, 3>(r, c).copy_from(&self.block(row, column));
            }
        }
        // A state that is switched off has neither variance nor covariance.
        let absent = whole.diagonal().map(|v| if v == T::zero() { T::one() } else { T::zero() });
        whole.set_diagonal(&(whole.diagonal() + absent));
        Cholesky::new(whole).is_some()
    }

    /// Whether every number is finite and no variance negative.
    pub(crate) fn is_sound(&self) -> bool {
        let finite =
            self.rows.iter().flatten().flat_map(Matrix3::iter).all(ComplexField::is_finite);
        finite && Block::ALL.into_iter().all(|block| self.variance(block).min() >= T::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{SMatrix, SVector};

    const STATES: usize = 3 * COUNT;
    type Dense<T> = SMatrix<T, STATES, STATES>;
    type DenseVector<T> = SVector<T, STATES>;

    /// Rounding of products of 30 × 30 numbers of order ten.
    const ROUNDING: f64 = 1e-13;

    fn dense<T: RealField + Copy>(covariance: &Covariance<T>) -> Dense<T> {
        Dense::from_fn(|i, j| covariance.rows[i / 3][j / 3][(i % 3, j % 3)])
    }

    fn dense_row<T: RealField + Copy>(row: &Row<T>) -> DenseVector<T> {
        DenseVector::from_fn(|i, _| row.h[i / 3].map_or(T::zero(), |h| h[i % 3]))
    }

    fn dense_step<T: RealField + Copy>(step: &Step<T>) -> DenseVector<T> {
        DenseVector::from_fn(|i, _| step[i / 3][i % 3])
    }

    fn of(dense: &Dense<f64>) -> Covariance<f64> {
        let mut covariance = Covariance::zeros(Blocks::ALL);
        for row in Block::ALL {
            for column in Block::ALL {
                let corner = (3 * row as usize, 3 * column as usize);
                let block: Matrix3<f64> = dense.fixed_view::<3, 3>(corner.0, corner.1).into();
                covariance.set(row, column, &block);
            }
        }
        covariance
    }

    fn prior() -> Covariance<f64> {
        let root = Dense::from_fn(|i, j| libm::sin((7 * i + 3 * j * j) as f64));
        of(&(root * root.transpose() + Dense::identity() * 0.1))
    }

    fn nothing() -> Step<f64> {
        [Vector3::zeros(); COUNT]
    }

    /// A gyro's three axes.
    fn gyro_rows() -> [Row<f64>; 3] {
        [(Vector3::x(), 0.4), (Vector3::y(), -0.3), (Vector3::z(), 0.1)].map(
            |(axis, innovation)| {
                Row::new([(Block::Rate, axis), (Block::Bias, axis)], innovation, 0.02)
            },
        )
    }

    #[test]
    fn propagation_is_phi_p_phi_transposed() {
        let block = |seed: f64| Some(Matrix3::from_fn(|i, j| libm::cos(seed + (5 * i + j) as f64)));
        // As it flies: the bias is not in it, and a triple that is off is not either.
        let transition = Transition {
            attitude: [
                block(0.1),
                block(0.2),
                None,
                block(0.3),
                block(0.4),
                block(0.5),
                None,
                block(0.6),
                block(0.7),
                None,
            ],
            rate: [
                block(1.1),
                block(1.2),
                None,
                block(1.3),
                block(1.4),
                block(1.5),
                None,
                block(1.6),
                block(1.7),
                None,
            ],
        };
        let mut phi = Dense::identity();
        for (row, blocks) in [transition.attitude, transition.rate].iter().enumerate() {
            for (column, block) in blocks.iter().enumerate() {
                let block = block.unwrap_or_else(Matrix3::zeros);
                phi.fixed_view_mut::<3, 3>(3 * row, 3 * column).copy_from(&block);
            }
        }
        let mut covariance = prior();
        covariance.propagate(&transition);
        let expected = phi * dense(&prior()) * phi.transpose();
        let found = dense(&covariance);
        assert!((found - expected).norm() < ROUNDING * expected.norm());
        assert_eq!(found, found.transpose());
    }

    #[test]
    fn scalars_one_by_one_are_the_vector_update_of_the_whole_matrix() {
        let (mut covariance, mut step) = (prior(), nothing());
        let rows = gyro_rows();
        let nis: f64 = rows.iter().map(|row| covariance.absorb(row, &mut step).unwrap()).sum();

        let h = SMatrix::<f64, 3, STATES>::from_fn(|i, j| dense_row(&rows[i])[j]);
        let p = dense(&prior());
        let innovation = Vector3::from(rows.map(|row| row.innovation));
        let s = h * p * h.transpose() + Matrix3::from_diagonal_element(0.02);
        let inverse = s.try_inverse().unwrap();
        let gain = p * h.transpose() * inverse;
        let expected = (Dense::identity() - gain * h) * p;
        assert!((dense(&covariance) - expected).norm() < ROUNDING * p.norm());
        assert!((dense_step(&step) - gain * innovation).norm() < ROUNDING);
        assert!((nis - innovation.dot(&(inverse * innovation))).abs() < ROUNDING);
    }

    #[test]
    fn what_cannot_be_a_measurement_is_refused_and_changes_nothing() {
        let row = Row::new([(Block::Attitude, Vector3::x())], 0.1, 0.01);
        let refuses = |covariance: Covariance<f64>, row: Row<f64>| {
            let (mut after, mut step) = (covariance, nothing());
            let refused = after.absorb(&row, &mut step).is_none();
            refused && step == nothing() && after.rows[1] == covariance.rows[1]
        };
        assert!(!refuses(prior(), row));
        assert!(refuses(of(&-dense(&prior())), row));
        for innovation in [f64::NAN, f64::INFINITY] {
            assert!(refuses(prior(), Row { innovation, ..row }));
        }
        for variance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(refuses(prior(), Row { variance, ..row }));
        }
        for h in [f64::NAN, f64::INFINITY] {
            assert!(refuses(prior(), Row::new([(Block::Rate, Vector3::y() * h)], 0.1, 0.01)));
        }
    }

    #[test]
    fn a_measurement_a_hundred_thousand_times_better_leaves_its_own_variance_in_f32() {
        // The short form P − k hᵀ P would leave 1e-6 of rounding here.
        const VARIANCE: f32 = 1e-4;
        let along = Vector3::new(0.6, 0.48, 0.64);
        for h in [[(Block::Attitude, along)], [(Block::Bias, Vector3::x())]] {
            let mut covariance = Covariance::zeros(Blocks::ALL);
            for block in Block::ALL {
                covariance.add(block, &(Matrix3::identity() * 10.0));
            }
            // Rounding of hᵀ P h beside variances of 10 is a hundredth of it.
            for times in 1..=20 {
                let row = Row::new(h, 0.0, VARIANCE);
                covariance.absorb(&row, &mut [Vector3::zeros(); COUNT]).unwrap();
                let left = row.dot(&covariance.times_row(&row));
                assert!(times > 1 || (left - VARIANCE).abs() < 0.02 * VARIANCE, "{left}");
                assert!(dense(&covariance).cholesky().is_some(), "{times}");
            }
        }
    }

    #[test]
    fn a_triple_that_decays_takes_its_covariances_along() {
        let mut covariance = prior();
        covariance.scale(Block::Torque, 0.9);
        let mut decay = Dense::identity();
        decay.fixed_view_mut::<3, 3>(18, 18).fill_diagonal(0.9);
        let expected = decay * dense(&prior()) * decay;
        assert!((dense(&covariance) - expected).norm() < ROUNDING * expected.norm());
    }

    #[test]
    fn what_is_added_to_a_triple_is_added_to_it_alone() {
        let mut covariance = prior();
        covariance.add(Block::Dipole, &(Matrix3::identity() * 0.25));
        let mut more = Dense::zeros();
        more.fixed_view_mut::<3, 3>(9, 9).fill_diagonal(0.25);
        assert_eq!(dense(&covariance), dense(&prior()) + more);
    }

    #[test]
    fn what_is_no_covariance_is_seen() {
        assert!(prior().is_sound());
        for bad in [f64::NAN, f64::INFINITY, -100.0] {
            let mut covariance = prior();
            covariance.add(Block::Products, &Matrix3::from_diagonal_element(bad));
            assert!(!covariance.is_sound());
        }
        let mut mixed = prior();
        mixed.set(Block::Rate, Block::Dipole, &Matrix3::from_element(f64::NAN));
        assert!(!mixed.is_sound());
    }
}
