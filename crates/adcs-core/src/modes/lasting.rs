//! For how long things have been so.

/// For how long something has been so without a break, s.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Held(f32);

impl Held {
    /// Whether it has now been so for `for_s`.
    pub fn step(&mut self, dt_s: f32, is_so: bool, for_s: f32) -> bool {
        self.0 = if is_so { self.0 + dt_s } else { 0.0 };
        is_so && self.0 >= for_s
    }
}

/// For how long a sensor has been silent, or the torquers have refused, s.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Silence {
    is_silent: bool,
    pub for_s: f32,
}

impl Silence {
    /// Takes in whether it speaks; `None` leaves the last word standing.
    pub fn step(&mut self, dt_s: f32, speaks: Option<bool>) {
        self.is_silent = speaks.map_or(self.is_silent, |speaks| !speaks);
        self.for_s = if self.is_silent { self.for_s + dt_s } else { 0.0 };
    }
}
