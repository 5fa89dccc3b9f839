//! Single precision as a compiler may write it: a product may be fused with the sum behind it, which rounds once in place
//! of twice. GCC does so for a Cortex-M4F unless told otherwise. A bound holds for every way.

/// The product of a·b + c·d that is fused with the sum, if one is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blend {
    /// Neither.
    Apart,
    /// a·b.
    First,
    /// c·d.
    Second,
}

/// What is fused in a routine that interpolates, and multiplies and adds once more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fused {
    /// In the interpolation.
    pub blend: Blend,
    /// The other product.
    pub other: bool,
}

impl Fused {
    /// Every way to compile it.
    pub const ALL: [Fused; 6] = [
        Fused { blend: Blend::Apart, other: false },
        Fused { blend: Blend::Apart, other: true },
        Fused { blend: Blend::First, other: false },
        Fused { blend: Blend::First, other: true },
        Fused { blend: Blend::Second, other: false },
        Fused { blend: Blend::Second, other: true },
    ];

    /// a·b + c·d.
    pub fn blend(self, [a, b]: [f32; 2], [c, d]: [f32; 2]) -> f32 {
        match self.blend {
            Blend::Apart => a * b + c * d,
            Blend::First => a.mul_add(b, c * d),
            Blend::Second => c.mul_add(d, a * b),
        }
    }

    /// a·b + c, the other product.
    pub fn other(self, [a, b]: [f32; 2], c: f32) -> f32 {
        if self.other { a.mul_add(b, c) } else { a * b + c }
    }
}
