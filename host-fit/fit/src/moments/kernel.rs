//! Pass over the data: half-products of a few hundred rows at a time, then small matrix products with their sums in
//! vector registers.

use std::ops::Range;

use aligned_vec::{AVec, avec};
use pulp::{Arch, Simd, WithSimd};

use super::layout::{Layout, Tile, TileShape};

/// Rows per cache block. Twelve half-products (ten lags, degree 2) of 384 rows are 38 kB: they stay in a
/// 48 kB first-level cache while every tile passes over them.
const BLOCK_ROWS: usize = 384;

/// Cache blocks between two checks for cancellation: with two thousand candidates they take a third of a second.
const BLOCKS_AT_ONCE: usize = 8;

/// f64 lanes of the widest vector `pulp` knows (AVX-512), and f64 per cache line.
const MAX_LANES: usize = 8;

/// Returns the tile that fits this machine's vector registers: its sums, one left value each, and a right value.
pub(super) fn tile_shape() -> TileShape {
    struct Registers;
    impl WithSimd for Registers {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::REGISTER_COUNT
        }
    }
    if Arch::new().dispatch(Registers) >= 32 {
        TileShape { left: 4, right: 6 } // 24 + 4 + 1 registers
    } else {
        TileShape { left: 3, right: 4 } // 12 + 3 + 1
    }
}

/// Buffers of a pass, aligned to cache lines: the half-products of one block of rows, and the running sums.
pub(super) struct Workspace {
    /// Half-products, one after the other, `stride` apart. Within each, `head` values lie before the block's
    /// first row.
    half_products: AVec<f64>,
    head: usize,
    block_rows: usize,
    stride: usize,
    /// For each sum of each tile, one partial sum per vector lane.
    lane_sums: AVec<f64>,
}

impl Workspace {
    pub(super) fn new(layout: &Layout) -> Self {
        let head = layout.max_lag.next_multiple_of(MAX_LANES);
        // the rows before a block are computed again for it: keep them a small part
        let block_rows = BLOCK_ROWS.max(4 * head);
        // one cache line more than needed, or columns a multiple of 4096 bytes apart would share cache sets
        let stride = head + block_rows + MAX_LANES;
        let half_products = avec![0.0; layout.halves.len() * stride];
        let lane_sums = avec![0.0; layout.tile_sums() * MAX_LANES];
        Self { half_products, head, block_rows, stride, lane_sums }
    }

    /// Returns the size in bytes.
    pub(super) fn bytes(&self) -> usize {
        (self.half_products.len() + self.lane_sums.len()) * size_of::<f64>()
    }

    /// Adds the sums over `rows` of every shape at shift 0.
    pub(super) fn add(&mut self, layout: &Layout, signals: &[&[f64]], rows: Range<usize>) {
        let arch = Arch::new();
        for start in rows.clone().step_by(BLOCKS_AT_ONCE * self.block_rows) {
            fos_data::interrupt::check();
            let rows = start..rows.end.min(start + BLOCKS_AT_ONCE * self.block_rows);
            arch.dispatch(Pass { layout, signals, rows, workspace: self });
        }
    }

    /// Returns the sums so far, in the order of the tiles.
    pub(super) fn sums(&self) -> Vec<f64> {
        self.lane_sums.chunks_exact(MAX_LANES).map(|lanes| lanes.iter().sum()).collect()
    }
}

struct Pass<'a> {
    layout: &'a Layout,
    signals: &'a [&'a [f64]],
    rows: Range<usize>,
    workspace: &'a mut Workspace,
}

impl WithSimd for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { layout, signals, rows, workspace } = self;
        let Workspace { half_products, head, block_rows, stride, lane_sums } = workspace;
        for start in rows.clone().step_by(*block_rows) {
            let count = (*block_rows).min(rows.end - start);
            let padded = count.next_multiple_of(MAX_LANES);
            for (half, column) in layout.halves.iter().zip(half_products.chunks_exact_mut(*stride)) {
                // a right half is read up to N₀ minus its own span before the block, never further
                let before = layout.max_lag - half.max_lag();
                half.fill(signals, start - before..start + count, &mut column[*head - before..*head + count]);
                column[*head + count..*head + padded].fill(0.0);
            }
            let column = |half: &usize, shift: usize| {
                let first = half * *stride + *head - shift;
                S::as_simd_f64s(&half_products[first..first + padded]).0
            };
            for tile in &layout.tiles {
                // the lanes of one sum are adjacent for any vector length: a sum owns MAX_LANES places
                let sums = &mut lane_sums[tile.first_sum * MAX_LANES..][..tile.len() * MAX_LANES];
                add_tile(simd, tile, column, sums);
            }
        }
    }
}

/// Adds one block's sums of a tile, with the kernel for its size.
#[inline(always)]
fn add_tile<'a, S: Simd>(
    simd: S,
    tile: &Tile,
    column: impl Fn(&usize, usize) -> &'a [S::f64s] + Copy,
    sums: &mut [f64],
) {
    macro_rules! by_size {
        ($(($left:literal: $($right:literal)*))*) => {
            match (tile.left.len(), tile.right.len()) {
                $($(($left, $right) => {
                    let left: [_; $left] = core::array::from_fn(|i| column(&tile.left[i], 0));
                    let right: [_; $right] = core::array::from_fn(|j| column(&tile.right[j], tile.shift));
                    inner_products::<S, $left, $right>(simd, left, right, sums);
                })*)*
                (left, right) => unreachable!("no kernel for a tile of {left} by {right}"),
            }
        };
    }
    by_size!((1: 1 2 3 4 5 6)(2: 1 2 3 4 5 6)(3: 1 2 3 4 5 6)(4: 1 2 3 4 5 6));
}

/// sums(i, j) += Σ left_i·right_j, lane by lane; every loaded right vector feeds L multiply-adds.
#[inline(always)]
fn inner_products<S: Simd, const L: usize, const R: usize>(
    simd: S,
    left: [&[S::f64s]; L],
    right: [&[S::f64s]; R],
    sums: &mut [f64],
) {
    let vectors = left[0].len();
    let left = left.map(|column| &column[..vectors]);
    let right = right.map(|column| &column[..vectors]);
    let mut block = [[simd.splat_f64s(0.0); R]; L];
    for k in 0..vectors {
        let l: [S::f64s; L] = core::array::from_fn(|i| left[i][k]);
        for j in 0..R {
            let r = right[j][k];
            for i in 0..L {
                block[i][j] = simd.mul_add_e_f64s(l[i], r, block[i][j]);
            }
        }
    }
    let places = sums.chunks_exact_mut(MAX_LANES);
    for (place, sum) in places.zip(block.as_flattened()) {
        let lanes = &mut S::as_mut_simd_f64s(place).0[0];
        *lanes = simd.add_f64s(*lanes, *sum);
    }
}
