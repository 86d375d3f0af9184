//! Arithmetic on a vector register, written like arithmetic on numbers.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// One register of numbers, each of another problem. All functions must be inlined into a [`pulp::WithSimd`] of `S`.
///
/// Closures, also those of `map` and `from_fn`, are compiled without the registers' instructions: formulas in lanes are written with
/// loops and functions that are always inlined.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: pulp::Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: pulp::Simd> Lanes<S> {
    /// Registers that eight numbers fill.
    pub const VECTORS: usize = 8 / S::F64_LANES;

    /// The same number everywhere.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, value: simd.splat_f64s(value) }
    }

    /// The numbers of register `vector` of eight.
    #[inline(always)]
    pub fn load(simd: S, from: &[f64; 8], vector: usize) -> Self {
        Self { simd, value: S::as_simd_f64s(from).0[vector] }
    }

    #[inline(always)]
    pub fn store(self, to: &mut [f64; 8], vector: usize) {
        S::as_mut_simd_f64s(to).0[vector] = self.value;
    }

    /// self · factor + sum, rounded once.
    #[inline(always)]
    pub fn times_plus(self, factor: Self, sum: Self) -> Self {
        Self { value: self.simd.mul_add_f64s(self.value, factor.value, sum.value), ..self }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { value: self.simd.sqrt_f64s(self.value), ..self }
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { value: self.simd.abs_f64s(self.value), ..self }
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { value: self.simd.max_f64s(self.value, other.value), ..self }
    }

    /// self where `sign` is not negative, −self elsewhere.
    #[inline(always)]
    pub fn negated_where_negative(self, sign: Self) -> Self {
        let mask = self.simd.less_than_f64s(sign.value, self.simd.splat_f64s(0.0));
        Self { value: self.simd.select_f64s(mask, (-self).value, self.value), ..self }
    }

    /// The largest of the numbers.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        self.simd.reduce_max_f64s(self.value)
    }
}

impl<S: pulp::Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { value: self.simd.add_f64s(self.value, other.value), ..self }
    }
}

impl<S: pulp::Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { value: self.simd.sub_f64s(self.value, other.value), ..self }
    }
}

impl<S: pulp::Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { value: self.simd.mul_f64s(self.value, other.value), ..self }
    }
}

impl<S: pulp::Simd> Div for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self { value: self.simd.div_f64s(self.value, other.value), ..self }
    }
}

impl<S: pulp::Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: self.simd.neg_f64s(self.value), ..self }
    }
}
