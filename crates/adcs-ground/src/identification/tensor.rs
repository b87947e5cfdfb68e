//! An inertia tensor on the command line.

use std::str::FromStr;

use adcs_sim::rigid_body::Inertia;

/// Tensor about the centre of mass, Body: `xx,yy,zz` or `xx,yy,zz,xy,xz,yz`, kg·m². Products stand as in
/// the tensor, with their negative sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tensor([[f64; 3]; 3]);

impl Tensor {
    /// Row by row, kg·m².
    pub fn rows(&self) -> [[f64; 3]; 3] {
        self.0
    }
}

impl FromStr for Tensor {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |part: &str| {
            part.trim().parse::<f64>().map_err(|_| format!("'{}' is not a number", part.trim()))
        };
        let numbers = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
        let (xx, yy, zz, xy, xz, yz) = match numbers[..] {
            [xx, yy, zz] => (xx, yy, zz, 0.0, 0.0, 0.0),
            [xx, yy, zz, xy, xz, yz] => (xx, yy, zz, xy, xz, yz),
            _ => return Err(format!("{} numbers; it takes three or six", numbers.len())),
        };
        let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        Inertia::new(rows).map_err(|error| error.to_string())?;
        Ok(Self(rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_or_six_numbers_of_a_body_are_a_tensor() {
        let six: Tensor = "0.05184, 0.05416,0.05978,0.00058,-0.00077,0.00069".parse().unwrap();
        assert_eq!(six.rows()[2], [-0.00077, 0.00069, 0.05978]);
        assert_eq!("1,1,1".parse::<Tensor>().unwrap().rows()[1], [0.0, 1.0, 0.0]);
        for wrong in ["", "1,1", "1,1,x", "1,1,3", "1,1,-1", "1,1,nan"] {
            assert!(wrong.parse::<Tensor>().is_err(), "{wrong}");
        }
    }
}
