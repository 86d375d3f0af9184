//! What this machine can do at most: floating-point operations and copied bytes per second on one thread.

use std::hint::black_box;

use super::measure::{digits, measure};

/// The machine, as measured in this run.
pub struct Machine {
    processor: String,
    threads: usize,
    compiler: String,
    lanes: usize,
    /// Floating-point operations per second on one thread.
    pub peak: f64,
}

impl Machine {
    pub fn measure() -> Self {
        let rounds = 100_000;
        let lanes = pulp::Arch::new().dispatch(Lanes);
        let fastest = measure(30, || pulp::Arch::new().dispatch(MultiplyAdds { rounds })).low;
        Self {
            processor: processor_name(),
            threads: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            compiler: compiler_version(),
            lanes,
            peak: (2 * CHAINS * lanes * rounds) as f64 / fastest,
        }
    }

    /// Seconds that `flops` operations and `bytes` moved take at least.
    pub fn floor(&self, flops: f64, bytes: f64) -> f64 {
        let moving = if bytes > 0.0 { bytes / copy_rate(bytes) } else { 0.0 };
        moving.max(flops / self.peak)
    }

    pub fn section(&self) -> String {
        format!(
            "## Machine\n\n{}, {} threads, vectors of {} bits in our kernels; {}. Measured in this run on one thread: {} Gflop/s in \
             independent multiply-adds on registers, {} GB/s (read and written) copying 100 MB, {} GB/s copying 200 kB.\n",
            self.processor,
            self.threads,
            64 * self.lanes,
            self.compiler,
            digits(self.peak / 1e9),
            digits(copy_rate(2e8) / 1e9),
            digits(copy_rate(4e5) / 1e9),
        )
    }
}

/// Bytes read and written per second by copying half of `bytes` to the other half.
pub fn copy_rate(bytes: f64) -> f64 {
    let half = (bytes / 16.0).ceil().max(1.0) as usize;
    let source = vec![1.0f64; half];
    let mut target = vec![0.0f64; half];
    let fastest = measure(20, || black_box(&mut target).copy_from_slice(black_box(&source))).low;
    (16 * half) as f64 / fastest
}

/// Independent chains of multiply-adds, enough to hide their latency.
const CHAINS: usize = 10;

struct MultiplyAdds {
    rounds: usize,
}

impl pulp::WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> f64 {
        let (factor, term) = (simd.splat_f64s(black_box(0.999)), simd.splat_f64s(black_box(1e-3)));
        let mut sums = [term; CHAINS];
        for _ in 0..self.rounds {
            for sum in &mut sums {
                *sum = simd.mul_add_f64s(*sum, factor, term);
            }
        }
        sums.iter().map(|sum| simd.reduce_sum_f64s(*sum)).sum()
    }
}

struct Lanes;

impl pulp::WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

fn processor_name() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

fn compiler_version() -> String {
    let output = std::process::Command::new("rustc").arg("--version").output();
    output.ok().and_then(|o| String::from_utf8(o.stdout).ok()).map_or("rustc".to_owned(), |s| s.trim().to_owned())
}
