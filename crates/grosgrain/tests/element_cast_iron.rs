//! Periodic homogenisation of a tomogram of cast iron, 100³ voxels, against published figures.

mod periodic;

use std::path::Path;

use grosgrain::material::IsotropicMaterial;
use periodic::PeriodicCell;

const GRAPHITE: u8 = 87;
const IRON: u8 = 182;

fn material_of() -> Vec<u8> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/cast_iron/ggg40_100.raw");
    let voxels = std::fs::read(file).unwrap();
    assert_eq!(voxels.len(), 1_000_000);
    assert!(voxels.iter().all(|v| [GRAPHITE, IRON].contains(v)));
    voxels.iter().map(|v| u8::from(*v == IRON)).collect()
}

/// Hashin–Shtrikman bounds of the bulk and the shear modulus: [K⁻, K⁺, G⁻, G⁺]; phase 1 is the stiffer.
fn hashin_shtrikman(soft: IsotropicMaterial, stiff: IsotropicMaterial, share_stiff: f64) -> [f64; 4] {
    let bulk = |m: IsotropicMaterial| m.lame().0 + 2.0 / 3.0 * m.lame().1;
    let bound = |matrix: IsotropicMaterial, other: IsotropicMaterial, share: f64| {
        let (k, g) = (bulk(matrix), matrix.lame().1);
        let (dk, dg) = (bulk(other) - k, other.lame().1 - g);
        let stiffness = 3.0 * k + 4.0 * g;
        let k_bound = k + share / (1.0 / dk + 3.0 * (1.0 - share) / stiffness);
        let g_bound = g + share / (1.0 / dg + 6.0 * (1.0 - share) * (k + 2.0 * g) / (5.0 * g * stiffness));
        (k_bound, g_bound)
    };
    let (lower, upper) = (bound(soft, stiff, share_stiff), bound(stiff, soft, 1.0 - share_stiff));
    [lower.0, upper.0, lower.1, upper.1]
}

#[test]
fn the_effective_stiffness_of_cast_iron_is_the_published_one_and_lies_within_the_bounds() {
    let material_of = material_of();
    let share_iron = material_of.iter().map(|m| f64::from(*m)).sum::<f64>() / 1e6;
    let graphite = IsotropicMaterial::new(39.7, 0.2225).unwrap();
    let iron = IsotropicMaterial::new(210.0, 0.3).unwrap();
    let cell = PeriodicCell::new([100; 3], [1.0; 3], material_of, vec![graphite.tensor(), iron.tensor()]);
    // The mean stress is linear in the displacement: 1e-6 of the largest entry is below half of the last digit given.
    let c = cell.effective_stiffness(1e-6);
    // chfem's figures for the unit strain yy, GPa, each with an error of half its last digit.
    for (name, found, published) in [("C12", c[0][1], 94.196), ("C22", c[1][1], 233.161), ("C23", c[2][1], 92.879)] {
        assert!((found - published).abs() < 5.5e-4, "{name} = {found:.4} GPa, published {published}");
    }
    let bounds = hashin_shtrikman(graphite, iron, share_iron);
    for (found, printed) in bounds.iter().zip([120.996, 142.270, 62.943, 69.677]) {
        assert!((found - printed).abs() < 1e-3, "bounds {bounds:?}");
    }
    // The bounds hold for statistically isotropic bodies; the isotropic part of the stiffness is compared.
    let trace: f64 = (0..3).map(|i| c[i][i]).sum();
    let off = c[0][1] + c[1][2] + c[0][2];
    let shear: f64 = (3..6).map(|i| c[i][i]).sum();
    let (bulk, rigidity) = ((trace + 2.0 * off) / 9.0, (trace - off + 3.0 * shear) / 15.0);
    assert!((bounds[0]..=bounds[1]).contains(&bulk), "K = {bulk:.3} GPa, bounds {bounds:.3?}");
    assert!((bounds[2]..=bounds[3]).contains(&rigidity), "G = {rigidity:.3} GPa, bounds {bounds:.3?}");
}
