//! Loads a recording: recognises the format, reads the table, assigns channels to the columns.

use crate::column::AXES;
use std::path::Path;
use std::sync::Arc;

use super::channel::Channel;
use super::column_map::ColumnMap;
use super::error::RecordingError;
use super::format::{self, Extent, Meaning, Opened};
use super::grid::{Boundary, Grid, Mark, Segment};
use super::load_options::{LoadOptions, MayHaveRates};
use super::quality::Quality;
use super::rate::RATES_HZ;
use super::rate::{self, Rate, Stamps};
use super::source::Source;
use super::table::{Column, Skipped, Table, check_names};
use super::unusable::refuse_unusable;
use super::{
    ClockProblem, Recording, Stream, clock_check, failed_reads, gaps, interleaved, own_rate, streams,
};
use crate::closest::closest;
use crate::unit::Unit;

/// Largest share of rows with a repeated timestamp for which full repeats count as copies; above it the clock of the log
/// is coarse, and equal rows are equal measurements.
const MAX_COPIES: f64 = 0.1;

/// Number and share of steps back that a clock may have if it was set back; timestamps with more of them are out of the
/// order of time.
const FEW_BACKS: u64 = 3;
const MAX_BACKS: f64 = 0.02;

/// Relative difference from which a measured rate contradicts the stated one, which then replaces it: the oscillators of
/// parts are off by up to five percent (MPU-6000, product specification, 6.6), and nobody states three digits.
const SAME_RATE: f64 = 0.07;

/// Reads a log in any known format ([`KNOWN_FORMATS`](super::KNOWN_FORMATS)), recognised by its content.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Recording, RecordingError> {
    let path = path.as_ref();
    let (opened, mut source) = format::open(path, options, Extent::Whole)?;
    match opened {
        Opened::Table(mut table) => {
            let mut meaning = format::meaning(path, &table, options)?;
            meaning.unwrap_clock(&mut table);
            if let Some(undecided) = meaning.undecided.take() {
                return Err(undecided);
            }
            source.read_as.clone_from(&meaning.read_as);
            match meaning.streams(&table) {
                Some(streams) => {
                    refuse_unusable(path, &table, options.strict)?;
                    check_map(path, &table, &meaning.map)?;
                    // the map is applied already: the streams have the names of channels
                    let followed = LoadOptions { columns: ColumnMap::default(), ..options.clone() };
                    let mut recording = Recording::from_streams(source, streams, &followed)?;
                    let of_table = table.quality;
                    recording.quality.rows_in_file = of_table.rows_in_file;
                    recording.quality.rows_unusable = of_table.rows_unusable;
                    recording.quality.first_unusable = of_table.first_unusable;
                    Ok(recording)
                }
                None => assemble(source, *table, &meaning, options, MayHaveRates::Yes),
            }
        }
        Opened::Streams(streams, read_as) => {
            source.read_as = Some(read_as);
            Recording::from_streams(source, streams, options)
        }
    }
}

/// Columns at the begin of a log, and their meaning.
pub(super) fn begin(path: &Path) -> Result<(Table, Meaning), RecordingError> {
    let options = LoadOptions::default();
    let (opened, _) = format::open(path, &options, Extent::Begin)?;
    match opened {
        Opened::Table(mut table) => {
            refuse_unusable(path, &table, false)?;
            let meaning = format::meaning(path, &table, &options)?;
            meaning.unwrap_clock(&mut table);
            Ok((*table, meaning))
        }
        Opened::Streams(streams, read_as) => {
            let mut table = Table::default();
            let joined = streams::join(path, streams)?.columns.into_iter();
            table.columns.extend(joined.map(|(name, values)| Column { name, values }));
            Ok((table, Meaning { read_as: Some(read_as), ..Meaning::default() }))
        }
    }
}

impl Recording {
    /// Builds a recording from columns in memory, of one length and named as in a log: `t_s`, `gx_rads`, `still`, ….
    pub fn from_columns(
        source: Source,
        columns: Vec<(String, Vec<f64>)>,
        options: &LoadOptions,
    ) -> Result<Recording, RecordingError> {
        Self::of_columns(source, columns, options, MayHaveRates::Yes)
    }

    /// The same for columns of one rate or of several.
    pub(super) fn of_columns(
        source: Source,
        columns: Vec<(String, Vec<f64>)>,
        options: &LoadOptions,
        rates: MayHaveRates,
    ) -> Result<Recording, RecordingError> {
        let expected = columns.first().map_or(0, |(_, values)| values.len());
        if let Some((name, values)) = columns.iter().find(|(_, values)| values.len() != expected) {
            return Err(RecordingError::Lengths { name: name.clone(), expected, found: values.len() });
        }
        let mut table = Table::default();
        table.quality.rows_in_file = expected as u64;
        for (name, values) in columns {
            match options.columns.ignores(&name) {
                true => table.ignored.push(name),
                false => table.columns.push(Column { name, values }),
            }
        }
        check_names(Path::new(&source.path), &table.names())?;
        for i in 0..table.columns.len() {
            table.note_missing_cells(i, 0);
        }
        assemble(source, table, &Meaning::of_user(options), options, rates)
    }
}

/// Assigns channels to the columns of a table and builds the recording.
fn assemble(
    source: Source,
    mut table: Table,
    meaning: &Meaning,
    options: &LoadOptions,
    rates: MayHaveRates,
) -> Result<Recording, RecordingError> {
    let path = Path::new(&source.path).to_owned();
    let map = &meaning.map;
    if let Some(rate_hz) = options.rate_hz.filter(|hz| !RATES_HZ.contains(hz)) {
        return Err(RecordingError::BadRate { rate_hz });
    }
    check_map(&path, &table, map)?;

    let time = table.index_of(map.column_of("t_s"));
    match time {
        Some(time) => table.drop_rows_without_time(time),
        None if options.rate_hz.is_none() => {
            let available = table.names();
            let alike = ["time", "timestamp", "t_ms", "t"].iter().find_map(|name| {
                closest(name, available.iter().map(String::as_str).filter(|name| name.contains('t')))
            });
            let closest = alike.map(str::to_owned);
            let perhaps = meaning.perhaps.clone();
            return Err(RecordingError::NoTime { path, closest, available, perhaps });
        }
        None => {}
    }
    refuse_unusable(&path, &table, options.strict)?;
    if let Some(time) = time {
        drop_copies(&mut table, time, map);
    }
    let n_rows = table.n_rows();
    if n_rows < 2 {
        return Err(RecordingError::TooFewRows { path, rows: n_rows });
    }

    let to_s = map.mappings().iter().find(|mapping| mapping.target == "t_s");
    let to_s = to_s.map_or(1.0, |mapping| mapping.conversion.scale);
    let rounded = time.and_then(|time| clock_check::rounded(&table.columns[time].values));
    let rounded_to_s = rounded.map(|step| step * to_s.abs());
    let Table { columns, skipped, mut quality, .. } = table;
    quality.perhaps.clone_from(&meaning.perhaps);
    quality.assumed_map.clone_from(&meaning.assumed_map);
    let mut channels = name_channels(columns, map);
    quality.failed_reads = channels.iter_mut().filter_map(failed_reads::take_out).collect();
    channels.retain(|channel| !quality.failed_reads.iter().any(|reads| reads.covers_column(&channel.name)));
    exclude_empty_axes(&path, &mut channels, &mut quality, n_rows, &options.columns)?;
    if rates == MayHaveRates::Yes
        && let Some(streams) = streams_of(&channels, n_rows, options)
    {
        let options = LoadOptions { rate_hz: None, columns: ColumnMap::default(), ..options.clone() };
        let mut recording = Recording::from_streams(source, streams, &options)?;
        recording.quality = Quality {
            stamps_repeated: recording.quality.stamps_repeated,
            clock_back: recording.quality.clock_back,
            gaps: recording.quality.gaps,
            samples_missing: recording.quality.samples_missing,
            clock: recording.quality.clock,
            pauses: recording.quality.pauses,
            paused_s: recording.quality.paused_s,
            ..quality
        };
        return Ok(recording);
    }
    let mut take = |name: &str| {
        let index = channels.iter().position(|channel| channel.name == name)?;
        // not shared yet, so nothing is copied
        Some(Arc::unwrap_or_clone(channels.remove(index).values))
    };
    let stamps = take("t_s");
    // a missing cell does not count as still
    let still = take("still").map(|cells| cells.into_iter().map(|cell| cell > 0.5).collect());
    let marks = find_marks(take("segment").as_deref().unwrap_or_default(), &skipped);

    let column = || map.column_of("t_s").to_owned();
    let by_order = |rate_hz: f64| without_stamps(n_rows, rate_hz, &marks);
    let (time_s, grid, rate) = match (stamps, options.rate_hz) {
        (Some(time_s), nominal_hz) => match measured(&path, column(), time_s, nominal_hz, &marks) {
            Ok((time_s, grid, rate)) => {
                let (segments, period_s) = (&grid.segments, rate.period_s);
                quality.clock = clock_check::problems(
                    map.column_of("t_s"),
                    &time_s,
                    rounded_to_s,
                    segments,
                    period_s,
                    &channels,
                );
                let is_other = |rate_hz: &f64| (rate.true_hz / rate_hz - 1.0).abs() > SAME_RATE;
                let no_time = quality.clock.iter().any(ClockProblem::discredits_stamps);
                match nominal_hz.filter(|rate_hz| is_other(rate_hz) || no_time) {
                    Some(rate_hz) => {
                        let stamped_hz = Some(rate.true_hz);
                        quality.clock =
                            vec![ClockProblem::Overridden { column: column(), stamped_hz, rate_hz }];
                        without_stamps(n_rows, rate_hz, &marks_of(&grid))
                    }
                    None => (time_s, grid, rate),
                }
            }
            Err(error) => {
                let rate_hz = nominal_hz.ok_or(error)?;
                quality.clock =
                    vec![ClockProblem::Overridden { column: column(), stamped_hz: None, rate_hz }];
                by_order(rate_hz)
            }
        },
        (None, rate_hz) => by_order(rate_hz.unwrap_or(1.0)),
    };
    if rate.stamps != Stamps::Absent && is_interleaved(&time_s, &channels) {
        return Err(RecordingError::TwoDevices { path });
    }
    quality.stamps_repeated = time_s.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64;
    quality.clock_back = grid.clock_back;
    let (pauses, others): (Vec<&Segment>, Vec<&Segment>) =
        grid.segments.iter().partition(|segment| segment.boundary == Boundary::Pause);
    quality.gaps = others.iter().filter(|segment| segment.missing_before > 0).count() as u64;
    quality.samples_missing = others.iter().map(|segment| segment.missing_before).sum();
    quality.pauses = pauses.len() as u64;
    quality.paused_s = pauses.iter().map(|segment| segment.missing_before as f64 * rate.period_s).sum();
    Ok(Recording {
        sources: vec![source],
        time_s,
        channels,
        segments: grid.segments,
        rate,
        still,
        turns: Vec::new(),
        keeps_moved: options.keep_moved,
        quality,
        alignment: None,
        detected: Default::default(),
    })
}

/// Boundaries of a grid, for rows that count in their order; empty if the timestamps leave gaps everywhere.
fn marks_of(grid: &Grid) -> Vec<Mark> {
    let rows = grid.segments.last().map_or(0, |last| last.rows.end);
    let is_few = grid.segments.len() * 20 <= rows;
    let inner =
        grid.segments.iter().skip(1).filter(|segment| is_few || segment.boundary == Boundary::SegmentColumn);
    inner
        .map(|segment| Mark {
            row: segment.rows.start,
            boundary: segment.boundary,
            missing: segment.missing_before,
        })
        .collect()
}

/// Timestamps with the grid and the rate computed from them.
fn measured(
    path: &Path,
    column: String,
    time_s: Vec<f64>,
    nominal_hz: Option<f64>,
    marks: &[Mark],
) -> Result<(Vec<f64>, Grid, Rate), RecordingError> {
    let path = path.to_owned();
    let Some((grid, rate)) = measure(&time_s, nominal_hz, marks) else {
        return Err(RecordingError::NoClock { path, column });
    };
    if !RATES_HZ.contains(&rate.true_hz) {
        return Err(RecordingError::NoSuchClock { path, column, period_s: rate.period_s });
    }
    let (backs, rows) = (grid.clock_back, time_s.len());
    if backs > FEW_BACKS && backs as f64 > MAX_BACKS * rows as f64 {
        return Err(RecordingError::OutOfOrder { path, column, backs, rows });
    }
    Ok((time_s, grid, rate))
}

/// Streams that a table was merged from, if an axis has a separate rate.
fn streams_of(channels: &[Channel], n_rows: usize, options: &LoadOptions) -> Option<Vec<Stream>> {
    let (time, others): (Vec<&Channel>, Vec<&Channel>) =
        channels.iter().partition(|channel| channel.name == "t_s");
    let time_s = match (time.first(), options.rate_hz) {
        (Some(time), _) => time.values.to_vec(),
        (None, Some(rate_hz)) => (0..n_rows).map(|row| row as f64 / rate_hz).collect(),
        (None, None) => return None,
    };
    own_rate::streams(&time_s, &others)
}

/// Rejects a map that reads or ignores columns that the log does not have.
fn check_map(path: &Path, table: &Table, map: &ColumnMap) -> Result<(), RecordingError> {
    let mapped = map.mappings().iter().map(|mapping| &mapping.column);
    let mapped = mapped.filter(|column| table.index_of(column).is_none());
    let is_there =
        |column: &String| table.ignored.contains(column) || table.quality.text_columns.contains(column);
    match mapped.chain(map.ignored().iter().filter(|column| !is_there(column))).next() {
        None => Ok(()),
        Some(column) => {
            let mut available = table.names();
            available.extend(table.ignored.iter().cloned());
            available.extend(table.quality.text_columns.iter().cloned());
            let closest = closest(column, available.iter().map(String::as_str)).map(str::to_owned);
            Err(RecordingError::UnknownColumn {
                path: path.to_owned(),
                column: column.clone(),
                closest,
                available,
            })
        }
    }
}

/// Drops rows that repeat the sample before them: the same timestamp, and the same values in all inertial channels (in
/// all channels, if there are none of those). A sender that holds the last sample may still update a slow channel.
fn drop_copies(table: &mut Table, time: usize, map: &ColumnMap) {
    let stamps = &table.columns[time].values;
    let repeats = |row: usize| row > 0 && stamps[row] == stamps[row - 1];
    let n_repeats = (0..stamps.len()).filter(|&row| repeats(row)).count();
    if n_repeats == 0 || n_repeats as f64 > MAX_COPIES * stamps.len() as f64 {
        return;
    }
    let is_inertial = |column: &&Column| AXES.iter().any(|axis| map.column_of(axis) == column.name);
    let mut compared: Vec<&Column> = table.columns.iter().filter(is_inertial).collect();
    if compared.is_empty() {
        compared = table.columns.iter().collect();
    }
    let equal = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
    let keep: Vec<bool> = (0..stamps.len())
        .map(|row| {
            let same = |column: &&Column| equal(column.values[row], column.values[row - 1]);
            !(repeats(row) && compared.iter().all(same))
        })
        .collect();
    table.quality.rows_repeated = keep.iter().filter(|&&keep| !keep).count() as u64;
    // skipped rows are located by row: count the remaining ones
    let mut kept = 0;
    let mut skipped = table.skipped.iter_mut().peekable();
    for (row, &keep) in keep.iter().enumerate() {
        if let Some(found) = skipped.next_if(|found| found.before_row == row) {
            found.before_row = kept;
        }
        kept += usize::from(keep);
    }
    skipped.for_each(|found| found.before_row = kept);
    table.keep_rows(&keep);
}

/// Converts columns to channels in SI units, in the order of the file; a column that is mapped twice appears twice.
fn name_channels(columns: Vec<Column>, map: &ColumnMap) -> Vec<Channel> {
    let mut channels = Vec::with_capacity(columns.len());
    for Column { name, values } in columns {
        let mappings: Vec<_> = map.mappings().iter().filter(|mapping| mapping.column == name).collect();
        let Some((last, others)) = mappings.split_last() else {
            // a mapped channel replaces a column of its name
            if map.column_of(&name) == name {
                channels.push(Channel { unit: Unit::of_column(&name), name, values: values.into() });
            }
            continue;
        };
        let mut add = |mapping: &super::column_map::Mapping, mut values: Vec<f64>| {
            mapping.conversion.apply(&mut values);
            channels.push(Channel {
                name: mapping.target.clone(),
                unit: mapping.unit,
                values: values.into(),
            });
        };
        others.iter().for_each(|mapping| add(mapping, values.clone()));
        add(last, values);
    }
    channels
}

/// Returns true if rows of two devices alternate.
fn is_interleaved(time_s: &[f64], channels: &[Channel]) -> bool {
    let axes = channels.iter().filter(|channel| AXES.contains(&channel.name.as_str()));
    interleaved::interleaved(time_s, &axes.map(|channel| &channel.values[..]).collect::<Vec<_>>())
}

/// Excludes axes without a single number, so that the others can be used. One that the user mapped is an error.
fn exclude_empty_axes(
    path: &Path,
    channels: &mut Vec<Channel>,
    quality: &mut Quality,
    rows: usize,
    given: &ColumnMap,
) -> Result<(), RecordingError> {
    let is_empty = |channel: &Channel| channel.values.iter().all(|value| !value.is_finite());
    let is_axis = |channel: &&Channel| AXES.contains(&channel.name.as_str());
    let empty = channels.iter().filter(is_axis).filter(|channel| is_empty(channel));
    quality.empty_axes = empty.map(|channel| channel.name.clone()).collect();
    let named = quality.empty_axes.iter().find(|axis| given.mappings().iter().any(|m| m.target == **axis));
    if let Some(name) = named {
        return Err(RecordingError::NoValues { path: path.display().to_string(), name: name.clone(), rows });
    }
    channels.retain(|channel| !quality.empty_axes.contains(&channel.name));
    Ok(())
}

/// Boundaries known without timestamps: changes of the label (an empty one is no change), skipped rows.
fn find_marks(labels: &[f64], skipped: &[Skipped]) -> Vec<Mark> {
    let mut marks: Vec<Mark> = skipped
        .iter()
        .filter(|found| found.before_row > 0)
        .map(|found| Mark { row: found.before_row, boundary: Boundary::Gap, missing: found.rows })
        .collect();
    let mut current = f64::NAN;
    for (row, &label) in labels.iter().enumerate().filter(|(_, label)| !label.is_nan()) {
        if !current.is_nan() && label != current {
            marks.push(Mark { row, boundary: Boundary::SegmentColumn, missing: 0 });
        }
        current = label;
    }
    marks.sort_by_key(|mark| mark.row);
    marks.dedup_by(|later, kept| {
        let same = later.row == kept.row;
        if same {
            kept.missing += later.missing;
            kept.boundary = Boundary::SegmentColumn;
        }
        same
    });
    marks
}

/// Rate and segments from timestamps. The period is needed to count missing samples, and their number to measure the
/// period: two passes.
fn measure(time_s: &[f64], nominal_hz: Option<f64>, marks: &[Mark]) -> Option<(Grid, Rate)> {
    let mut look = rate::first_look(time_s, nominal_hz)?;
    let marks = with_pauses(marks, &look.after_pauses);
    let mut grid = gaps::find(time_s, &look, &marks);
    if let Some(period_s) = rate::slope(time_s, &grid) {
        look.period_s = period_s;
        grid = gaps::find(time_s, &look, &marks);
    }
    let period_s = rate::slope(time_s, &grid).unwrap_or(look.period_s);
    let jitter_s = rate::jitter(time_s, &grid, period_s);
    let stamps = rate::classify_timestamps(look.stamps, jitter_s, period_s);
    Some((
        grid.with_pauses(period_s),
        Rate { nominal_hz, true_hz: 1.0 / period_s, period_s, jitter_s, stamps },
    ))
}

/// Merges known boundaries with pauses; an unusable row next to a pause does not change it.
fn with_pauses(marks: &[Mark], after_pauses: &[usize]) -> Vec<Mark> {
    let mut all = marks.to_vec();
    for row in after_pauses {
        match all.binary_search_by_key(row, |mark| mark.row) {
            Ok(at) if all[at].boundary == Boundary::Gap => all[at].boundary = Boundary::Pause,
            Ok(_) => {}
            Err(at) => all.insert(at, Mark { row: *row, boundary: Boundary::Pause, missing: 0 }),
        }
    }
    all
}

/// Time, rate and segments of a log without timestamps: row over rate, and known boundaries.
fn without_stamps(n_rows: usize, rate_hz: f64, marks: &[Mark]) -> (Vec<f64>, Grid, Rate) {
    let mut segments =
        vec![Segment { rows: 0..n_rows, tick: 0, missing_before: 0, boundary: Boundary::Start }];
    let mut missing = 0;
    for mark in marks {
        missing += mark.missing;
        if let Some(last) = segments.last_mut() {
            last.rows.end = mark.row;
        }
        segments.push(Segment {
            rows: mark.row..n_rows,
            tick: mark.row as u64 + missing,
            missing_before: mark.missing,
            boundary: mark.boundary,
        });
    }
    let grid = Grid { segments, clock_back: 0 };
    let period_s = 1.0 / rate_hz;
    let time_s = grid.ticks().into_iter().map(|tick| tick as f64 * period_s).collect();
    let rate =
        Rate { nominal_hz: Some(rate_hz), true_hz: rate_hz, period_s, jitter_s: 0.0, stamps: Stamps::Absent };
    (time_s, grid, rate)
}
