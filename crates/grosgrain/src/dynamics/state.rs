//! The motion of a body.

/// Motion of the nodes of a body, three numbers each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Displacement \[m\].
    pub displacement: Vec<f64>,
    /// Velocity \[m/s\].
    pub velocity: Vec<f64>,
}

impl State {
    /// Rest, for this many nodes.
    pub fn rest(nodes: usize) -> Self {
        Self { displacement: vec![0.0; 3 * nodes], velocity: vec![0.0; 3 * nodes] }
    }

    /// ½ Σ m ‖v‖² \[J\].
    pub fn kinetic_energy(&self, mass: &[f64]) -> f64 {
        self.velocity.chunks_exact(3).zip(mass).map(|(v, m)| 0.5 * m * v.iter().map(|v| v * v).sum::<f64>()).sum()
    }

    /// Momentum Σ m v \[N s\], and angular momentum Σ m (X + u) × v \[N m s\] about the origin, of nodes at `rest_position` X.
    pub fn momenta(&self, mass: &[f64], rest_position: impl Fn(usize) -> [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let (mut linear, mut angular) = ([0.0; 3], [0.0; 3]);
        for (n, m) in mass.iter().enumerate().filter(|(_, m)| **m > 0.0) {
            let (rest, at) = (rest_position(n), 3 * n);
            let x: [f64; 3] = std::array::from_fn(|r| rest[r] + self.displacement[at + r]);
            let v: [f64; 3] = std::array::from_fn(|r| self.velocity[at + r]);
            let spin = crate::linalg::matrix3::cross(&x, &v);
            for r in 0..3 {
                linear[r] += m * v[r];
                angular[r] += m * spin[r];
            }
        }
        (linear, angular)
    }
}
