//! From the values of a volume to a Young modulus per voxel.

use super::{Cell, Label, Lattice, Volume, VoxelGrid};

/// How the values of a volume become moduli.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModulusLaw {
    /// The values are Young's moduli \[Pa\]; zero means void.
    Direct,
    /// E = coefficient · ρ^exponent \[Pa\] with ρ \[g/cm³\] from the CT number; ρ ≤ 0 means void.
    Power {
        /// Modulus at 1 g/cm³ \[Pa\].
        coefficient: f64,
        /// Exponent.
        exponent: f64,
        /// Density from the CT number.
        density: DensityLaw,
    },
}

/// Density from the CT number: ρ = slope · HU + intercept, in g/cm³ (1 g/cm³ = 1000 kg/m³).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensityLaw {
    /// Density per Hounsfield unit \[g/cm³\].
    pub slope: f64,
    /// Density at CT number 0 (water) \[g/cm³\].
    pub intercept: f64,
}

/// Moduli and densities of voxels, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct ModulusField {
    /// Number of voxels along x, y, z.
    pub cells: [usize; 3],
    /// Young's modulus \[Pa\]; 0 in voids.
    pub young: Vec<f64>,
    /// Density \[kg/m³\], where the law gives one; 0 in voids.
    pub density: Option<Vec<f64>>,
    /// Which voxels are void.
    pub void: Vec<bool>,
}

/// Why moduli cannot be had from a volume.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModulusError {
    /// The volume holds fewer or more values than voxels.
    #[error("the volume holds {found} values for {cells:?} voxels")]
    Length {
        /// Number of values.
        found: usize,
        /// Voxels along x, y, z.
        cells: [usize; 3],
    },
    /// A parameter of the law makes no sense.
    #[error("the modulus law's {name} is {value}; it must be {expected}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// A voxel's value gives no modulus.
    #[error("voxel ({}, {}, {}) has the value {value}, which gives {result}; {hint}", at[0], at[1], at[2])]
    Value {
        /// The voxel.
        at: [usize; 3],
        /// Its value.
        value: f64,
        /// What the law made of it.
        result: String,
        /// What to do.
        hint: &'static str,
    },
}

impl ModulusLaw {
    /// The modulus \[Pa\] and, where the law gives one, the density \[kg/m³\] of every voxel.
    ///
    /// Where `floor` is given, moduli of solid voxels below it are raised to it \[Pa\].
    ///
    /// # Errors
    /// Parameters out of range; a voxel whose value is not finite, is a negative modulus, or overflows.
    pub fn apply(&self, volume: &Volume, floor: Option<f64>) -> Result<ModulusField, ModulusError> {
        self.validate(floor)?;
        let lattice = Lattice::new(volume.cells);
        if volume.values.len() != lattice.cell_count() {
            return Err(ModulusError::Length { found: volume.values.len(), cells: volume.cells });
        }
        let voxels: Result<Vec<(f64, f64)>, ModulusError> = (volume.values.iter().enumerate())
            .map(|(c, &value)| self.voxel(value).map_err(|fault| fault.at(lattice.cell_position(Cell(c)), value)))
            .collect();
        let (mut young, density): (Vec<f64>, Vec<f64>) = voxels?.into_iter().unzip();
        let void: Vec<bool> = young.iter().map(|e| *e == 0.0).collect();
        let floor = floor.unwrap_or(0.0);
        young.iter_mut().filter(|e| **e > 0.0).for_each(|e| *e = e.max(floor));
        let density = matches!(self, Self::Power { .. }).then_some(density);
        Ok(ModulusField { cells: volume.cells, young, density, void })
    }

    /// Modulus \[Pa\] and density \[kg/m³\] of one value; zeros for a void.
    fn voxel(&self, value: f64) -> Result<(f64, f64), Fault> {
        if !value.is_finite() {
            return Err(Fault("no modulus".into(), "every value must be finite"));
        }
        match *self {
            Self::Direct if value < 0.0 => {
                Err(Fault("a negative modulus".into(), "moduli in pascals must be positive, or 0 for a void"))
            }
            Self::Direct => Ok((value, 0.0)),
            Self::Power { coefficient, exponent, density } => {
                let rho = density.slope * value + density.intercept;
                if rho <= 0.0 {
                    return Ok((0.0, 0.0));
                }
                let young = coefficient * rho.powf(exponent);
                match young.is_finite() && young > 0.0 {
                    true => Ok((young, 1000.0 * rho)),
                    false => Err(Fault(format!("a modulus of {young} Pa"), "check the law's parameters")),
                }
            }
        }
    }

    fn validate(&self, floor: Option<f64>) -> Result<(), ModulusError> {
        let positive = |name, value: f64| check(name, value, "positive and finite", value.is_finite() && value > 0.0);
        let finite = |name, value: f64| check(name, value, "finite", value.is_finite());
        floor.map_or(Ok(()), |floor| positive("floor", floor))?;
        let Self::Power { coefficient, exponent, density } = *self else { return Ok(()) };
        positive("coefficient", coefficient)?;
        finite("exponent", exponent)?;
        finite("density slope", density.slope)?;
        finite("density intercept", density.intercept)
    }
}

fn check(name: &'static str, value: f64, expected: &'static str, good: bool) -> Result<(), ModulusError> {
    if good { Ok(()) } else { Err(ModulusError::Parameter { name, value, expected }) }
}

/// What a value led to, and what to do about it.
struct Fault(String, &'static str);

impl Fault {
    fn at(self, at: [usize; 3], value: f64) -> ModulusError {
        ModulusError::Value { at, value, result: self.0, hint: self.1 }
    }
}

impl ModulusField {
    /// The body with these moduli and densities, the same label everywhere; `spacing` is the edge lengths of a voxel \[m\].
    pub fn into_grid(self, spacing: [f64; 3], label: Label) -> VoxelGrid {
        let lattice = Lattice::new(self.cells);
        VoxelGrid {
            lattice,
            spacing,
            origin: [0.0; 3],
            labels: vec![label; lattice.cell_count()],
            void: self.void,
            young: Some(self.young),
            density: self.density,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(values: &[f64]) -> Volume {
        let values = values.to_vec();
        Volume { cells: [values.len(), 1, 1], spacing: None, voxel_to_world: None, values, integral: false }
    }

    const BONE: ModulusLaw =
        ModulusLaw::Power { coefficient: 6.85e9, exponent: 1.49, density: DensityLaw { slope: 1e-3, intercept: 1.0 } };

    #[test]
    fn the_power_law_gives_pascals_and_kilograms_per_cubic_metre() {
        let field = BONE.apply(&volume(&[0.0, 1000.0, -1000.0, -1200.0]), None).unwrap();
        assert_eq!(field.void, [false, false, true, true]);
        let young = [6.85e9, 6.85e9 * (1.49 * 2f64.ln()).exp(), 0.0, 0.0];
        for (found, expected) in field.young.iter().zip(young) {
            // Two roundings of each of exp, ln and powf.
            assert!((found - expected).abs() <= 1e-14 * expected, "{found} Pa instead of {expected} Pa");
        }
        assert_eq!(field.density, Some(vec![1000.0, 2000.0, 0.0, 0.0]));
        let grid = field.into_grid([1e-3; 3], Label(4));
        assert_eq!(grid.validate(), Ok(()));
        assert_eq!(grid.labels, [Label(4); 4]);
    }

    #[test]
    fn the_floor_raises_solid_voxels_only() {
        let field = BONE.apply(&volume(&[-999.0, 0.0, -1000.0]), Some(1e6)).unwrap();
        assert_eq!(field.young, [1e6, 6.85e9, 0.0]);
        assert_eq!(field.void, [false, false, true]);
    }

    #[test]
    fn moduli_read_directly_keep_their_values_and_zero_is_void() {
        let field = ModulusLaw::Direct.apply(&volume(&[2.5e6, 0.0]), None).unwrap();
        assert_eq!((field.young, field.void, field.density), (vec![2.5e6, 0.0], vec![false, true], None));
    }

    #[test]
    fn values_and_parameters_without_a_modulus_are_refused() {
        let power = |coefficient, exponent| ModulusLaw::Power {
            coefficient,
            exponent,
            density: DensityLaw { slope: 1.0, intercept: 0.0 },
        };
        for (law, values, floor, part) in [
            (ModulusLaw::Direct, [1.0, -5.0], None, "voxel (1, 0, 0) has the value -5, which gives a negative modulus"),
            (ModulusLaw::Direct, [f64::NAN, 1.0], None, "voxel (0, 0, 0) has the value NaN"),
            (power(1.0, 1e3), [1.0, 1e9], None, "a modulus of inf Pa"),
            (power(-1.0, 1.0), [1.0, 1.0], None, "coefficient is -1"),
            (power(1.0, f64::NAN), [1.0, 1.0], None, "exponent is NaN"),
            (ModulusLaw::Direct, [1.0, 1.0], Some(0.0), "floor is 0"),
        ] {
            let message = law.apply(&volume(&values), floor).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
