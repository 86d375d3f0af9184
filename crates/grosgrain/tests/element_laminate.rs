//! Effective stiffness of periodic laminates against the closed form.
//!
//! Layers normal to z, perfectly bonded: the strains xx, yy, xy and the stresses zz, yz, xz are the same in all layers, so with c = λ + 2μ and ⟨·⟩ the
//! volume mean C33 = ⟨1/c⟩⁻¹, C13 = C33 ⟨λ/c⟩, C11 = ⟨4μ(λ+μ)/c⟩ + C33 ⟨λ/c⟩², C12 = ⟨2μλ/c⟩ + C33 ⟨λ/c⟩²,
//! C44 = ⟨1/μ⟩⁻¹, C66 = ⟨μ⟩. The displacement is piecewise linear in z, so trilinear hexahedra are exact.

mod periodic;

use grosgrain::material::IsotropicMaterial;
use periodic::PeriodicCell;

/// C11, C12, C13, C33, C44, C66 of layers with these materials and volume fractions.
fn closed_form(layers: &[(IsotropicMaterial, f64)]) -> [f64; 6] {
    let mean = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        layers.iter().map(|(material, share)| share * f(material.lame().0, material.lame().1)).sum()
    };
    let c33 = 1.0 / mean(&|l, m| 1.0 / (l + 2.0 * m));
    let ratio = mean(&|l, m| l / (l + 2.0 * m));
    [
        mean(&|l, m| 4.0 * m * (l + m) / (l + 2.0 * m)) + c33 * ratio * ratio,
        mean(&|l, m| 2.0 * m * l / (l + 2.0 * m)) + c33 * ratio * ratio,
        c33 * ratio,
        c33,
        1.0 / mean(&|_, m| 1.0 / m),
        mean(&|_, m| m),
    ]
}

/// Layers one, two, … cells thick in turn normal to `axis`, non-cubic cells.
fn effective(materials: &[IsotropicMaterial], layer_of: &[u8], axis: usize) -> [[f64; 6]; 6] {
    let mut cells = [2, 3, 2];
    cells[axis] = layer_of.len();
    let count = cells.iter().product::<usize>();
    let along = |n: usize| [n % cells[0], n / cells[0] % cells[1], n / (cells[0] * cells[1])][axis];
    let material_of = (0..count).map(|n| layer_of[along(n)]).collect();
    let tensors = materials.iter().map(|m| m.tensor()).collect();
    PeriodicCell::new(cells, [1.0, 0.5, 2.0], material_of, tensors).effective_stiffness(1e-13)
}

/// C11, C12, C13, C33, C44, C66 of layers normal to `axis`, and the largest entry that must vanish or repeat another.
fn constants(c: &[[f64; 6]; 6], axis: usize) -> ([f64; 6], f64) {
    let (z, x, y) = (axis, (axis + 1) % 3, (axis + 2) % 3);
    let found = [c[x][x], c[x][y], c[x][z], c[z][z], c[3 + x][3 + x], c[3 + z][3 + z]];
    let repeated = [c[y][y] - found[0], c[y][z] - found[2], c[3 + y][3 + y] - found[4]];
    let coupling = (0..36).map(|n| (n / 6, n % 6)).filter(|(i, j)| i != j && (*i > 2 || *j > 2));
    let worst = coupling.map(|(i, j)| c[i][j]).chain(repeated).fold(0.0f64, |m, v| m.max(v.abs()));
    (found, worst)
}

#[test]
fn the_effective_stiffness_of_laminates_is_the_closed_form() {
    let material = |young, poisson| IsotropicMaterial::new(young, poisson).unwrap();
    // Reference numbers of the two half-and-half laminates, to all digits printed: C11, C12, C13, C33, C44, C66.
    let cases = [
        (10.0, [6.835097303, 3.352338682, 0.614544213, 0.751109594, 0.068282690, 1.741379310]),
        (100.0, [63.265950351, 28.748708971, 0.620069586, 0.757862827, 0.068896621, 17.258620690]),
    ];
    for (stiff, printed) in cases {
        let phases = [material(stiff, 0.45), material(0.1, 0.45)];
        let exact = closed_form(&[(phases[0], 0.5), (phases[1], 0.5)]);
        for i in 0..6 {
            assert!((exact[i] - printed[i]).abs() < 1e-9, "the closed form gives {}, not {}", exact[i], printed[i]);
        }
        for axis in 0..3 {
            let (found, rest) = constants(&effective(&phases, &[0, 0, 1, 1], axis), axis);
            for i in 0..6 {
                let error = (found[i] / exact[i] - 1.0).abs();
                assert!(error < 1e-8, "E {stiff}, axis {axis}, constant {i}: {} against {}", found[i], exact[i]);
            }
            assert!(rest < 1e-8 * exact[0], "E {stiff}, axis {axis}: {rest:.1e} should vanish");
        }
    }
}

#[test]
fn three_layers_of_different_thickness_and_poisson_ratio_follow_the_closed_form() {
    let phases = [(1.0, 0.1), (30.0, 0.49), (1e3, 0.3)].map(|(e, nu)| IsotropicMaterial::new(e, nu).unwrap());
    let exact = closed_form(&[(phases[0], 0.5), (phases[1], 1.0 / 6.0), (phases[2], 1.0 / 3.0)]);
    let (found, rest) = constants(&effective(&phases, &[0, 0, 1, 2, 0, 2], 2), 2);
    for i in 0..6 {
        let error = (found[i] / exact[i] - 1.0).abs();
        assert!(error < 1e-8, "constant {i}: {} against {}", found[i], exact[i]);
    }
    assert!(rest < 1e-8 * exact[0], "{rest:.1e} should vanish");
}
