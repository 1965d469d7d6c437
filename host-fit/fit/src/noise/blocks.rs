//! A recording reduced to means over blocks of equal length, in which slow effects are searched for.

use std::ops::Range;

use fos_data::pose;
use fos_data::recording::{Recording, runs};

use crate::signal::centred;

/// Approximate number of blocks of a recording.
const WANTED: f64 = 600.0;

/// Shortest block, s.
const SHORTEST_S: f64 = 0.5;

/// Least share of known samples in a block.
const KNOWN_SHARE: f64 = 0.25;

/// Share of recorded time below which a log counts as bursts: blocks then lie within bursts.
const RECORDED_SHARE: f64 = 0.5;

/// Largest number of single-burst blocks, as a multiple of the wanted number.
const MAX_SINGLE_BURSTS: f64 = 2.0;

/// Least number of blocks in a rest with its own level: a single block determines its level and nothing else.
const LEAST_A_REST: f64 = 2.0;

/// Least noise of a block, relative to the mean of all.
const LEAST_NOISE: f64 = 1e-3;

/// Blocks of a recording with enough known samples. They lie on the grid of ticks, so that gaps keep their length. In a
/// log of bursts (5 s of every 300 s) they are bursts or equal parts of them, at their true distances; if there are too
/// many bursts, several form one block.
#[derive(Debug, Clone)]
pub struct Blocks {
    /// Length of a block, s.
    pub length_s: f64,
    /// Sample period, s.
    pub period_s: f64,
    /// Shortest time constant of flicker noise, s; faster noise counts as white. It is the same for all blocks up to
    /// 9 s long, so that noise levels can be transferred between block lengths.
    pub flicker_from_s: f64,
    /// Blocks, in order of time.
    pub blocks: Vec<Block>,
    /// Blocks, from the second on, at which an unknown new level begins: gravity may have turned under an
    /// accelerometer. Whitening eliminates these levels.
    restarts: Vec<usize>,
    /// Rows that are used; one flag per row of the recording.
    known: Vec<bool>,
}

/// Running computation of block means.
#[derive(Debug)]
pub struct Averaging<'b> {
    blocks: &'b Blocks,
    row: usize,
    /// Sum over the used values of the current block.
    sum: f64,
    /// Means of the completed blocks.
    pub means: Vec<f64>,
}

impl Averaging<'_> {
    /// Adds the values of the next rows.
    pub fn extend(&mut self, values: &[f64]) {
        let first = self.row;
        self.row += values.len();
        while let Some(block) = self.blocks.blocks.get(self.means.len()) {
            let rows = block.rows.start.max(first)..block.rows.end.min(self.row);
            if !rows.is_empty() {
                let known = &self.blocks.known[rows.clone()];
                for (value, known) in values[rows.start - first..rows.end - first].iter().zip(known) {
                    if *known {
                        self.sum += value;
                    }
                }
            }
            if self.row < block.rows.end {
                return;
            }
            self.means.push(self.sum / block.count as f64);
            self.sum = 0.0;
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Position on the grid: its middle is (index + ½)·length after the first sample.
    pub index: u64,
    /// Rows of the block.
    pub rows: Range<usize>,
    /// Number of used rows in it.
    pub count: usize,
    /// Variance of its fast noise relative to that of the log; 1 unless the log was shaken.
    pub noise: f64,
}

/// Returns the block length that suits a recording, s: about 600 blocks.
pub fn length_for(recording: &Recording) -> f64 {
    let (ticks, period_s) = (ticks(recording), recording.rate.period_s);
    let Some(burst) = burst_rows(recording) else {
        return (ticks as f64 * period_s / WANTED).max(SHORTEST_S);
    };
    let length_s = (recording.n_rows() as f64 * period_s / WANTED).max(SHORTEST_S);
    let burst_s = burst as f64 * period_s;
    match length_s < MAX_SINGLE_BURSTS * burst_s {
        true => burst_s / (burst_s / length_s).round().max(1.0),
        false => (ticks as f64 * period_s / WANTED).max(SHORTEST_S),
    }
}

/// Returns the block length for a recording in which each burst may have its own level, s.
pub fn length_with_levels_for(recording: &Recording) -> f64 {
    let length_s = length_for(recording);
    match burst_rows(recording) {
        Some(rows) => length_s.min(rows as f64 * recording.rate.period_s / LEAST_A_REST),
        None => length_s,
    }
}

/// Number of samples on the grid, from the first to the last.
fn ticks(recording: &Recording) -> u64 {
    recording.segments.last().map_or(0, |last| last.tick + last.rows.len() as u64)
}

/// Returns the rows of a usual burst if the recording consists of bursts: half of all rows lie in shorter ones.
fn burst_rows(recording: &Recording) -> Option<usize> {
    if recording.n_rows() as f64 >= RECORDED_SHARE * ticks(recording) as f64 {
        return None;
    }
    // samples lost within a burst, fewer than a segment, do not end it
    let longest_loss = (recording.n_rows() / recording.segments.len().max(1)) as u64;
    let mut bursts: Vec<usize> = Vec::new();
    for segment in &recording.segments {
        match bursts.last_mut() {
            Some(burst) if segment.missing_before < longest_loss => *burst += segment.rows.len(),
            _ => bursts.push(segment.rows.len()),
        }
    }
    bursts.sort_unstable();
    let mut shorter = 0;
    bursts.into_iter().find(|rows| {
        shorter += rows;
        2 * shorter >= recording.n_rows()
    })
}

/// Power of three below a third of a block, at least 1.
fn flicker_from_s(length_s: f64) -> f64 {
    3.0_f64.powf((length_s / 3.0).max(1.0).log(3.0).floor())
}

impl Blocks {
    /// Forms blocks of `length_s` from the rows that `known` marks, one flag per row.
    pub fn new(recording: &Recording, length_s: f64, known: Vec<bool>) -> Self {
        let period_s = recording.rate.period_s;
        let ticks = (length_s / period_s).round().max(1.0) as u64;
        let burst = burst_rows(recording);
        let within_bursts = burst.is_some_and(|rows| ticks as f64 <= MAX_SINGLE_BURSTS * rows as f64);
        let full = match burst {
            Some(rows) if within_bursts => rows.min(ticks as usize) as f64,
            Some(_) => ticks as f64 * recording.n_rows() as f64 / self::ticks(recording) as f64,
            None => ticks as f64,
        };
        let mut blocks: Vec<Block> = Vec::new();
        // tick at which the count of blocks starts, and the first block
        let (mut origin, mut first) = (0, 0);
        for segment in &recording.segments {
            if within_bursts && segment.missing_before >= ticks {
                let next = blocks.last().map_or(0, |last| last.index + 1);
                (origin, first) = (segment.tick, next.max(segment.tick / ticks));
            }
            for row in segment.rows.clone() {
                let index = first + (segment.tick - origin + (row - segment.rows.start) as u64) / ticks;
                let counts = usize::from(known[row]);
                match blocks.last_mut() {
                    Some(last) if last.index == index => {
                        last.rows.end = row + 1;
                        last.count += counts;
                    }
                    _ => blocks.push(Block { index, rows: row..row + 1, count: counts, noise: 1.0 }),
                }
            }
        }
        blocks.retain(|block| block.count as f64 >= KNOWN_SHARE * full);
        let length_s = ticks as f64 * period_s;
        Self {
            length_s,
            period_s,
            flicker_from_s: flicker_from_s(length_s),
            blocks,
            restarts: Vec::new(),
            known,
        }
    }

    /// Forms blocks with an unknown new level from each of the rows `turns` on. A block has one level: the one after
    /// the turn.
    pub fn with_levels(recording: &Recording, length_s: f64, mut known: Vec<bool>, turns: &[usize]) -> Self {
        let blocks = Self::new(recording, length_s, known.clone());
        let mut later = turns;
        for block in &blocks.blocks {
            later = &later[later.partition_point(|turn| *turn < block.rows.start)..];
            let inside = later.partition_point(|turn| *turn < block.rows.end);
            if let Some(turn) = later[..inside].last() {
                known[block.rows.start..*turn].fill(false);
            }
        }
        let mut blocks = if turns.is_empty() { blocks } else { Self::new(recording, length_s, known) };
        let first_after = |turn: &usize| blocks.blocks.partition_point(|block| block.rows.end <= *turn);
        let mut restarts: Vec<usize> = turns.iter().map(first_after).collect();
        restarts.retain(|start| (1..blocks.len()).contains(start));
        restarts.dedup();
        blocks.restarts = restarts;
        blocks
    }

    /// Returns the blocks, from the second on, at which an unknown new level begins.
    pub fn restarts(&self) -> &[usize] {
        &self.restarts
    }

    /// Number of blocks beyond those that only determine a level.
    pub fn beyond_levels(&self) -> usize {
        self.len() - self.restarts.len()
    }

    /// Returns `values`, one per block, for the blocks in `within`, each about the mean of its level.
    pub fn about_levels(&self, values: &[f64], within: Range<usize>) -> Vec<f64> {
        let levels = pose::levels_between(&self.restarts, within);
        levels.into_iter().flat_map(|level| centred(values[level].to_vec())).collect()
    }

    /// Sets the noise of each block from the changes of `error`, one value per row, between adjacent samples:
    /// intermittent shaking changes the noise of the means.
    pub fn with_noise_of(mut self, error: &[f64]) -> Self {
        let variance = |block: &Block| {
            let known = block.rows.clone().filter(|row| self.known[*row]);
            let rows: Vec<usize> = known.collect();
            let changes = rows.windows(2).map(|pair| (error[pair[1]] - error[pair[0]]).powi(2));
            changes.sum::<f64>() / rows.len().max(1) as f64
        };
        let variances: Vec<f64> = self.blocks.iter().map(variance).collect();
        let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
        for (block, variance) in self.blocks.iter_mut().zip(variances) {
            block.noise = (variance / mean).max(LEAST_NOISE);
        }
        self
    }

    /// Number of blocks with enough data.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Returns true if there is no block.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Returns the used rows, one flag per row.
    pub fn known(&self) -> &[bool] {
        &self.known
    }

    /// Returns the means of `column`, one value per row of the recording, over the used rows.
    pub fn means(&self, column: &[f64]) -> Vec<f64> {
        self.means_of(|row| [column[row]]).into_iter().map(|[mean]| mean).collect()
    }

    /// Returns the means of several columns at once; `of` returns their values for each used row, in order.
    pub fn means_of<const N: usize>(&self, mut of: impl FnMut(usize) -> [f64; N]) -> Vec<[f64; N]> {
        let mean = |block: &Block| {
            let mut sums = [0.0; N];
            for row in block.rows.clone() {
                if self.known[row] {
                    sums.iter_mut().zip(of(row)).for_each(|(sum, value)| *sum += value);
                }
            }
            sums.map(|sum| sum / block.count as f64)
        };
        self.blocks.iter().map(mean).collect()
    }

    /// Starts a computation of means from values given in the order of the rows.
    pub fn averaging(&self) -> Averaging<'_> {
        Averaging { blocks: self, row: 0, sum: 0.0, means: Vec::with_capacity(self.blocks.len()) }
    }

    /// Returns the runs of used rows within `rows`, each with its block, in order.
    pub fn used_runs(&self, rows: Range<usize>) -> impl Iterator<Item = (usize, Range<usize>)> {
        let first = self.blocks.partition_point(|block| block.rows.end <= rows.start);
        let within = self.blocks[first..].iter().take_while(move |block| block.rows.start < rows.end);
        within.enumerate().flat_map(move |(place, block)| {
            let within = block.rows.start.max(rows.start)..block.rows.end.min(rows.end);
            let used = match block.count == block.rows.len() {
                true => vec![within],
                false => runs(within, |row| self.known[row]),
            };
            used.into_iter().map(move |run| (first + place, run))
        })
    }

    /// Returns the middle of a block, s after the first sample.
    pub fn middle_s(&self, block: usize) -> f64 {
        (self.blocks[block].index as f64 + 0.5) * self.length_s
    }

    /// Number of used samples in all blocks.
    pub fn samples(&self) -> usize {
        self.blocks.iter().map(|block| block.count).sum()
    }
}
