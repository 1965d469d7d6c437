//! Sums that a pool needs, and their division into small matrix products.
//!
//! 1. Every Gram entry is the average of a product of two candidates (or of a candidate and the target).
//!    As a (shape, shift) pair, many entries share one shape: with ten output lags and degree 2, 2,279
//!    products have 297 shapes.
//! 2. Each shape is left(n)·right(n − c), a product of two half-products. For one shift c, the shapes with that shift
//!    are entries of a matrix product LᵀR over the rows, L holding left halves, R right halves c samples late. It is cut
//!    into tiles that keep their sums in registers; unneeded tiles are omitted.

use ahash::AHashMap;

use super::product::Product;
use crate::candidates::Candidates;

/// Sums of a pool, and the order in which a pass over the data forms them.
#[derive(Debug)]
pub(super) struct Layout {
    /// Number of candidates.
    pub(super) size: usize,
    /// Distinct products, as (shape, shift): all shifts of one shape are adjacent, ascending.
    pub(super) products: Vec<(Product, usize)>,
    /// Index into `products` of every average a Gram matrix holds; see [`product`](Self::product).
    places: Vec<usize>,
    /// Distinct shapes, each with its run of `products` and the index of its sum.
    pub(super) shapes: Vec<Shape>,
    /// Distinct half-products.
    pub(super) halves: Vec<Product>,
    pub(super) tiles: Vec<Tile>,
    /// Largest lag in any product: N₀.
    pub(super) max_lag: usize,
}

/// An average over the rows; candidates by their index in the pool.
#[derive(Debug, Clone, Copy)]
pub(super) enum Average {
    /// ⟨y⟩
    Target,
    /// ⟨y²⟩
    TargetSquare,
    /// ⟨p_i⟩
    Mean(usize),
    /// ⟨y p_i⟩
    WithTarget(usize),
    /// ⟨p_i p_j⟩
    Pair(usize, usize),
}

/// All products that are shifted copies of one.
#[derive(Debug)]
pub(super) struct Shape {
    pub(super) product: Product,
    /// Copies: `products[first..end]`, shifts ascending.
    pub(super) first: usize,
    pub(super) end: usize,
    /// Index of its sum among the sums of all tiles.
    pub(super) sum: usize,
}

/// Sums over rows of left(n)·right(n − shift) for every left and right half listed.
#[derive(Debug)]
pub(super) struct Tile {
    pub(super) shift: usize,
    /// Indices into the half-products.
    pub(super) left: Vec<usize>,
    pub(super) right: Vec<usize>,
    /// Index of the tile's first sum; sums are stored left half by left half.
    pub(super) first_sum: usize,
}

impl Tile {
    pub(super) fn len(&self) -> usize {
        self.left.len() * self.right.len()
    }
}

/// Largest number of left and right halves in a tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileShape {
    pub(super) left: usize,
    pub(super) right: usize,
}

impl Layout {
    /// Forms the products of every pair of candidates, of every candidate with the target and the constant.
    pub(super) fn new(pool: &Candidates, tile_shape: TileShape) -> Self {
        let monomials = pool.monomials();
        let target = [fos_core::y(0)];
        // in the order of `place_of`
        let mut averages = vec![Product::of(&target, &[]), Product::of(&target, &target)];
        for (i, p) in monomials.iter().enumerate() {
            averages.push(Product::of(p, &[]));
            averages.push(Product::of(p, &target));
            averages.extend(monomials[..=i].iter().map(|q| Product::of(p, q)));
        }
        let mut numbers: AHashMap<Product, usize> = AHashMap::new();
        let mut shapes: Vec<Shape> = Vec::new();
        let mut placed: Vec<(usize, usize)> = Vec::with_capacity(averages.len());
        for product in averages {
            let (shape, shift) = product.normalised();
            let number = *numbers.entry(shape).or_insert_with(|| {
                shapes.push(Shape { product: shape, first: 0, end: 0, sum: 0 });
                shapes.len() - 1
            });
            placed.push((number, shift));
        }
        // a table of shapes against shifts instead of a sort, which would be half the cost of a layout
        let shifts = Shifts::of(pool);
        let mut index = vec![0; shapes.len() * shifts.len()];
        for (shape, shift) in &placed {
            index[shape * shifts.len() + shifts.rank[*shift]] = 1;
        }
        let mut products = Vec::new();
        for (shape, row) in shapes.iter_mut().zip(index.chunks_exact_mut(shifts.len())) {
            shape.first = products.len();
            for (place, shift) in row.iter_mut().zip(&shifts.ascending).filter(|(place, _)| **place == 1) {
                *place = products.len();
                products.push((shape.product, *shift));
            }
            shape.end = products.len();
        }
        let place = |(shape, shift): &(usize, usize)| index[shape * shifts.len() + shifts.rank[*shift]];
        let places = placed.iter().map(place).collect();
        let (halves, tiles) = tile(&mut shapes, tile_shape);
        Self { size: pool.len(), products, places, shapes, halves, tiles, max_lag: pool.max_lag() }
    }

    /// Returns the index of the product of an average.
    pub(super) fn product(&self, average: Average) -> usize {
        let candidate_offset = |i: usize| 2 + 2 * i + i * (i + 1) / 2;
        self.places[match average {
            Average::Target => 0,
            Average::TargetSquare => 1,
            Average::Mean(i) => candidate_offset(i),
            Average::WithTarget(i) => candidate_offset(i) + 1,
            Average::Pair(i, j) => candidate_offset(i.max(j)) + 2 + i.min(j),
        }]
    }

    /// Returns the number of sums that the tiles form; at least one per shape.
    pub(super) fn tile_sums(&self) -> usize {
        self.tiles.last().map_or(0, |tile| tile.first_sum + tile.len())
    }
}

/// Possible shifts of a product: the lags of the pool's factors, and none.
struct Shifts {
    ascending: Vec<usize>,
    /// Index of each shift.
    rank: Vec<usize>,
}

impl Shifts {
    fn of(pool: &Candidates) -> Self {
        let mut ascending = vec![0];
        ascending.extend(pool.factors().map(|factor| usize::from(factor.lag)));
        ascending.sort_unstable();
        ascending.dedup();
        let mut rank = vec![0; pool.max_lag() + 1];
        ascending.iter().enumerate().for_each(|(place, shift)| rank[*shift] = place);
        Self { ascending, rank }
    }

    fn len(&self) -> usize {
        self.ascending.len()
    }
}

/// Groups the shapes into tiles and stores in each shape the index of its sum.
///
/// Left halves that need the same right halves are adjacent, so that tiles are full.
fn tile(shapes: &mut [Shape], most: TileShape) -> (Vec<Product>, Vec<Tile>) {
    let split: Vec<_> = shapes.iter().map(|shape| shape.product.halves()).collect();
    let mut halves: Vec<Product> = split.iter().flat_map(|(left, right, _)| [*left, *right]).collect();
    halves.sort_unstable();
    halves.dedup();
    let index = |half: &Product| halves.binary_search(half).expect("every half was listed");

    /// A needed entry of LᵀR.
    #[derive(PartialEq, Eq, PartialOrd, Ord)]
    struct Entry {
        shift: usize,
        left: usize,
        right: usize,
        shape: usize,
    }
    let entry = |(shape, (left, right, shift)): (usize, &(Product, Product, usize))| Entry {
        shift: *shift,
        left: index(left),
        right: index(right),
        shape,
    };
    let mut entries: Vec<Entry> = split.iter().enumerate().map(entry).collect();
    entries.sort_unstable();

    let mut tiles: Vec<Tile> = Vec::new();
    for same_shift in entries.chunk_by(|a, b| a.shift == b.shift) {
        let mut rows: Vec<&[Entry]> = same_shift.chunk_by(|a, b| a.left == b.left).collect();
        rows.sort_by(|a, b| a.iter().map(|e| e.right).cmp(b.iter().map(|e| e.right)));
        for rows in balanced_chunks(&rows, most.left) {
            let mut columns: Vec<usize> = rows.iter().flat_map(|row| row.iter().map(|e| e.right)).collect();
            columns.sort_unstable();
            columns.dedup();
            for right in balanced_chunks(&columns, most.right) {
                let first_sum = tiles.last().map_or(0, |tile| tile.first_sum + tile.len());
                for (i, row) in rows.iter().enumerate() {
                    for entry in row.iter() {
                        if let Ok(j) = right.binary_search(&entry.right) {
                            shapes[entry.shape].sum = first_sum + i * right.len() + j;
                        }
                    }
                }
                let left = rows.iter().map(|row| row[0].left).collect();
                tiles.push(Tile { shift: same_shift[0].shift, left, right: right.to_vec(), first_sum });
            }
        }
    }
    (halves, tiles)
}

/// Cuts a list into the fewest pieces of at most `most`, of nearly equal length.
fn balanced_chunks<T>(list: &[T], most: usize) -> impl Iterator<Item = &[T]> {
    let pieces = list.len().div_ceil(most);
    list.chunks(list.len().div_ceil(pieces.max(1)).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: TileShape = TileShape { left: 4, right: 6 };

    #[test]
    fn ten_lags_of_degree_two_share_297_sums() {
        let pool = Candidates::builder().output(1..=10, 2).build().unwrap();
        let layout = Layout::new(&pool, TILE);
        let by_order = |order| layout.shapes.iter().filter(|s| s.product.degree() == order).count();
        assert_eq!([1, 2, 3, 4].map(by_order), [1, 11, 65, 220]);
        assert_eq!(layout.halves.len(), 12, "the constant, y(n), and y(n)·y(n-d) for d = 0 to 9");
        let waste = layout.tile_sums() as f64 / layout.shapes.len() as f64;
        assert!(waste < 1.2, "tiles form {waste} times the sums needed");
    }

    #[test]
    fn tiles_form_the_products_of_their_shapes() {
        let pool = Candidates::builder()
            .output(1..=3, 3)
            .input(0, 0..=4, 2)
            .input(2, 7..=7, 1)
            .cross_products(3)
            .build()
            .unwrap();
        let layout = Layout::new(&pool, TILE);
        for shape in &layout.shapes {
            let within = |tile: &&Tile| (tile.first_sum..tile.first_sum + tile.len()).contains(&shape.sum);
            let tile = layout.tiles.iter().find(within).expect("a tile forms it");
            let (i, j) = (
                (shape.sum - tile.first_sum) / tile.right.len(),
                (shape.sum - tile.first_sum) % tile.right.len(),
            );
            let formed = (layout.halves[tile.left[i]], layout.halves[tile.right[j]], tile.shift);
            assert_eq!(formed, shape.product.halves());
        }
    }
}
