//! What simulated chips need from the simulated world.

/// Which of the board's converters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Converter {
    /// That of magnetometer and gyros.
    Main,
    /// One of those of the Sun sensors, 0 to 2.
    Sun(u8),
}

/// The world at the pins: voltages into the converter, drive out of the H-bridges.
pub trait Plant {
    /// The voltage at input `channel` (0 to 7) of `converter` in this instant, V, noise included.
    /// Called exactly once a conversion, so that noise is drawn in the order in which the flight
    /// software reads.
    fn pin_volts(&mut self, converter: Converter, channel: u8) -> f64;

    /// Brings the mean voltage across the winding of torquer `axis` (0, 1, 2) to the fraction
    /// `drive` (−1 to 1) of the supply. Called whenever a pin of that bridge is
    /// told its level, also when `drive` stays the same.
    fn set_winding(&mut self, axis: usize, drive: f64);

    /// Whether the chips have their supply. The converter must not be talked to without it; the
    /// bridges take their inputs (SLVSBA4 §7.3.3) but drive nothing. A world that cuts the supply
    /// stops the windings' currents itself.
    fn powered(&self) -> bool {
        true
    }
}
