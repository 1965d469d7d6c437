//! Requests and answers. Every answer is JSON, in the same form as that of `--json` on the command line.

use fos_data::column::Column;
use std::convert::Infallible;
use std::sync::Arc;

use axum::Json;
use axum::body::Body;
use axum::extract::{FromRequestParts, Path, Query, State};
use axum::http::request::Parts;
use axum::http::{StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;
use tokio_stream::wrappers::WatchStream;
use tokio_stream::{Stream, StreamExt};

use super::folders::Listed;
use super::series::{Joined, Rows, Series, ViewKind, series as series_of};
use super::study::Study;
use super::task::{LogFiles, Open};
use super::view::{Entry, Page};
use super::workspace::Workspace;
use fos_data::file::{FileError, TemporarySibling};
use fos_data::recording::{ColumnMap, LoadOptions, Preview, preview as preview_of};
use fos_data::text::capitalised;
use fos_device_io::replay::Summary;
use fos_diagnose::effects::Effect;
use fos_export::{Refusal, c_source, image, rust_source};
use fos_figures::compare::View;
use fos_figures::curves::{AgainstChannel, AxisCurves};
use fos_figures::noise::allan_of_noise;
use fos_figures::units::{ShownUnit, Units};
use fos_figures::{Figure, svg};
use fos_fit::evaluate::UnaidedError;
use fos_fit::model::UnitModel;
use fos_fit::noise::AxisNoise;
use fos_report::certificate::{self, Certificate, Outcome, Stated};
use fos_report::{Report, ReportAxis, html, markdown};

/// Largest size of a dropped file, bytes: a day of six axes at 200 Hz as text.
const LARGEST_FILE: u64 = 4 << 30;

/// Error answer: status and message.
pub(super) struct Refused(StatusCode, String);

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        (self.0, Json(json!({ "error": self.1 }))).into_response()
    }
}

pub(super) type Answer<T> = Result<Json<T>, Refused>;

pub(super) fn not_found(what: String) -> Refused {
    Refused(StatusCode::NOT_FOUND, what)
}

pub(super) fn forbidden(what: String) -> Refused {
    Refused(StatusCode::FORBIDDEN, what)
}

fn not_now(what: String) -> Refused {
    Refused(StatusCode::CONFLICT, what)
}

pub(super) fn wrong(what: impl ToString) -> Refused {
    Refused(StatusCode::UNPROCESSABLE_ENTITY, what.to_string())
}

/// Runs slow work on a thread for blocking work, so that other requests do not wait.
pub(super) async fn in_background<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Refused> + Send + 'static,
) -> Result<T, Refused> {
    let failed = |_| {
        Refused(StatusCode::INTERNAL_SERVER_ERROR, "an error in this program\nhelp: please report it".into())
    };
    tokio::task::spawn_blocking(work).await.map_err(failed)?
}

/// Answers with the result of slow work.
pub(super) async fn answer<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Refused> + Send + 'static,
) -> Answer<T> {
    in_background(work).await.map(Json)
}

/// The study of the number in the path.
pub(super) struct OfId(Arc<Study>);

impl FromRequestParts<Arc<Workspace>> for OfId {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, workspace: &Arc<Workspace>) -> Result<Self, Response> {
        let id = Path::<u64>::from_request_parts(parts, workspace).await;
        let Path(id) = id.map_err(IntoResponse::into_response)?;
        workspace.study(id).map(Self).map_err(|what| not_found(what).into_response())
    }
}

pub(super) async fn studies(State(workspace): State<Arc<Workspace>>) -> Json<Vec<Entry>> {
    Json(workspace.entries())
}

/// Request for a new study: the example, or logs.
#[derive(Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[cfg_attr(test, ts(optional_fields = nullable))]
#[serde(deny_unknown_fields)]
pub(super) struct Wanted {
    #[serde(default)]
    #[cfg_attr(test, ts(as = "Option<_>", optional))]
    example: bool,
    log: Option<String>,
    reference: Option<String>,
    evaluation: Option<String>,
    #[serde(default)]
    #[cfg_attr(test, ts(as = "Option<_>", optional))]
    columns: Vec<String>,
    rate_hz: Option<f64>,
}

pub(super) async fn open(
    State(workspace): State<Arc<Workspace>>,
    Json(wanted): Json<Wanted>,
) -> Answer<Value> {
    let open = match wanted.example {
        true => Open::Example(workspace.folders.example()),
        false => Open::Logs(wanted.files(&workspace, LoadOptions::default())?),
    };
    Ok(Json(json!({ "id": workspace.open(open).map_err(not_now)? })))
}

impl Wanted {
    /// Returns the logs if they may be read; their columns and rate replace those of `read`.
    fn files(self, workspace: &Workspace, read: LoadOptions) -> Result<LogFiles, Refused> {
        let Self { log, reference, evaluation, columns, rate_hz, .. } = self;
        let log = log.ok_or_else(|| wrong("which log? \"log\" is missing"))?;
        for path in [Some(&log), reference.as_ref(), evaluation.as_ref()].into_iter().flatten() {
            workspace.folders.permitted(path).map_err(forbidden)?;
        }
        let columns = ColumnMap::from_specs(columns).map_err(wrong)?;
        Ok(LogFiles { log, reference, evaluation, read: LoadOptions { columns, rate_hz, ..read } })
    }
}

/// Reads a study's logs again, with other columns or in other roles.
pub(super) async fn read_again(
    State(workspace): State<Arc<Workspace>>,
    Path(id): Path<u64>,
    Json(wanted): Json<Wanted>,
) -> Answer<Value> {
    let study = workspace.study(id).map_err(not_found)?;
    let before = study.files().map_or_else(LoadOptions::default, |files| files.read);
    study.read_again(wanted.files(&workspace, before)?);
    Ok(Json(json!({ "id": id })))
}

pub(super) async fn close(State(workspace): State<Arc<Workspace>>, Path(id): Path<u64>) -> Answer<Value> {
    workspace.close(id).map_err(not_found)?;
    Ok(Json(json!({})))
}

pub(super) async fn state(OfId(study): OfId) -> Answer<Page> {
    answer(move || Ok(study.page())).await
}

pub(super) async fn events(
    OfId(study): OfId,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Refused> {
    let status_events = WatchStream::new(study.status_events());
    let events = status_events.map(|status| {
        Ok(Event::default().json_data(&status).unwrap_or_else(|_| Event::default().comment("unreadable")))
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::default()))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AxisWanted {
    axis: String,
}

pub(super) async fn look_at(OfId(study): OfId, Json(wanted): Json<AxisWanted>) -> Answer<Value> {
    study.look_at(&wanted.axis).map_err(wrong)?;
    Ok(Json(json!({})))
}

pub(super) async fn cancel(OfId(study): OfId) -> Answer<Value> {
    study.stop();
    Ok(Json(json!({})))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Addition {
    axis: String,
    effect: String,
}

pub(super) async fn add(
    State(workspace): State<Arc<Workspace>>,
    OfId(study): OfId,
    Json(addition): Json<Addition>,
) -> Answer<Value> {
    workspace.library.get(&addition.effect).map_err(wrong)?;
    study.add(&addition.axis, &addition.effect).map_err(not_now)?;
    Ok(Json(json!({})))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Undoing {
    axis: String,
    keep: usize,
}

pub(super) async fn undo(OfId(study): OfId, Json(undoing): Json<Undoing>) -> Answer<Value> {
    study.undo(&undoing.axis, undoing.keep).map_err(not_now)?;
    Ok(Json(json!({})))
}

/// Treatment of the rows with detected motion.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Motion {
    /// True to use them like any other rows.
    keep: bool,
}

pub(super) async fn keep_moved(OfId(study): OfId, Json(motion): Json<Motion>) -> Answer<Value> {
    study.keep_moved(motion.keep).map_err(not_now)?;
    Ok(Json(json!({})))
}

/// Window of a time series.
#[derive(Deserialize)]
pub(super) struct Window {
    axis: String,
    view: ViewKind,
    from: f64,
    to: f64,
    width: usize,
    /// Length of the means of the slow view, s.
    #[serde(default = "one_second")]
    mean_s: f64,
}

fn one_second() -> f64 {
    1.0
}

#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct AxisSeries {
    axis: String,
    unit: &'static str,
    #[serde(flatten)]
    series: Series,
}

pub(super) async fn series(OfId(study): OfId, Query(window): Query<Window>) -> Answer<AxisSeries> {
    if !(window.from.is_finite() && window.to > window.from && window.mean_s > 0.0) {
        return Err(wrong("\"from\" and \"to\" do not make a window"));
    }
    answer(move || {
        let read = study.read().map_err(not_now)?;
        let axis = study.axis(&window.axis).map_err(wrong)?;
        let log = &read.logs.log;
        let reference = log.channel(&Column::named(&window.axis).reference()).ok();
        let rows = Rows {
            recording: log,
            measured: &log.channel(&window.axis).map_err(wrong)?.values,
            reference: reference.map(|channel| channel.values.as_slice()),
            trace: axis.examination.as_ref().map(|found| (&found.trace, &found.trace.axes[0])),
            before: axis.before.as_ref().map(|found| (&found.trace, &found.trace.axes[0])),
        };
        let joined = Joined { kind: window.view, mean_s: window.mean_s };
        let series = series_of(rows, joined, window.from, window.to, window.width);
        Ok(AxisSeries { unit: Column::named(&window.axis).unit().label(), axis: window.axis, series })
    })
    .await
}

/// Axis, and a stretch of it from `from` to `to`, s; the whole log without them.
#[derive(Deserialize)]
pub(super) struct Stretch {
    axis: String,
    from: Option<f64>,
    to: Option<f64>,
}

/// Figure with the name by which the page finds it: `residual`, `against:temp_c`.
#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct NamedFigure {
    name: String,
    figure: Figure,
}

pub(super) async fn figures(OfId(study): OfId, Query(stretch): Query<Stretch>) -> Answer<Vec<NamedFigure>> {
    answer(move || drawn(&study, &stretch)).await
}

fn drawn(study: &Study, stretch: &Stretch) -> Result<Vec<NamedFigure>, Refused> {
    let read = study.read().map_err(not_now)?;
    let axis = study.axis(&stretch.axis).map_err(wrong)?;
    let found =
        axis.examination.ok_or_else(|| not_now("there is no model yet\nhelp: wait a moment".to_owned()))?;
    let log = &read.logs.log;
    let rows = stretch.from.zip(stretch.to).map(|(from, to)| {
        let inside = |time: &f64| (from..=to).contains(time);
        let first = log.time_s.iter().position(inside).unwrap_or(0);
        let last = log.time_s.iter().rposition(inside).map_or(first, |last| last + 1);
        first..last
    });
    let part = rows.as_ref().map(|rows| found.trace.within(rows.clone()));
    let trace = part.as_ref().unwrap_or(&found.trace);
    if trace.stretches.iter().all(|stretch| stretch.len() < SHORTEST) {
        return Err(wrong(
            "the stretch is too short for anything but the samples themselves\nhelp: take a longer one",
        ));
    }
    let curves = part.as_ref().map(|part| AxisCurves::of(&found.comparison, part, 0, log));
    let curves = curves.as_ref().unwrap_or(&found.curves);
    let view = View { axis: &found.comparison, curves, moved: &read.summaries.log.moved };
    let mut figures = vec![("residual".to_owned(), view.residual())];
    let against = AgainstChannel::every_channel(&found.comparison, &found.trace, 0, log, rows.as_ref());
    figures.extend(against.into_iter().map(|one| (format!("against:{}", one.channel), view.against(one))));
    figures.extend(view.spectrum().map(|figure| ("spectrum".to_owned(), figure)));
    figures.extend(view.autocorrelation().map(|figure| ("autocorrelation".to_owned(), figure)));
    figures.push(("allan".to_owned(), view.allan()));
    if rows.is_none() {
        figures.extend(view.dependence().map(|figure| ("dependence".to_owned(), figure)));
    }
    Ok(figures.into_iter().map(|(name, figure)| NamedFigure { name, figure }).collect())
}

/// Axis whose noise is requested, and units of N, B and K in the legend.
#[derive(Deserialize)]
pub(super) struct NoiseOf {
    axis: String,
    #[serde(default)]
    units: Units,
}

/// Draws the Allan deviation with N, B and K like `fos noise`; none where the log is too short.
pub(super) async fn noise(OfId(study): OfId, Query(of): Query<NoiseOf>) -> Answer<Option<Figure>> {
    answer(move || {
        let Some(noise) = study.noise(&of.axis).map_err(not_now)? else { return Ok(None) };
        let units = |axis: &AxisNoise| ShownUnit::of_noise(&axis.column, of.units);
        let label = capitalised(Column::named(&of.axis).label());
        Ok(Some(allan_of_noise(&label, &[noise], units)))
    })
    .await
}

/// Heading and position errors of all six axes together without aiding, before the models and with them.
pub(super) async fn strapdown(OfId(study): OfId) -> Answer<Vec<[UnaidedError; 2]>> {
    answer(move || {
        let file = study.whole_file().map_err(not_now)?;
        study.strapdown(&file).map_err(wrong)
    })
    .await
}

/// Draws a figure of the page as SVG.
pub(super) async fn draw(Json(figure): Json<Figure>) -> Result<Response, Refused> {
    let drawn = in_background(move || svg(&figure).map_err(wrong)).await?;
    Ok(([(header::CONTENT_TYPE, "image/svg+xml")], drawn).into_response())
}

/// Smallest number of samples of a stretch for statistics.
const SHORTEST: usize = 64;

pub(super) async fn export(
    State(workspace): State<Arc<Workspace>>,
    Path((id, format)): Path<(u64, String)>,
) -> Result<Response, Refused> {
    let study = workspace.study(id).map_err(not_found)?;
    in_background(move || exported(&study, &format)).await
}

/// Returns the certificate of a calibration by hand from the log to explain.
pub(super) async fn certificate(OfId(study): OfId) -> Result<Response, Refused> {
    let page = in_background(move || {
        let read = study.read().map_err(not_now)?;
        let none = || {
            not_found(
                "the log has too few orientations for a calibration\nhelp: record 12 or more, 3 s each"
                    .to_owned(),
            )
        };
        let found = Outcome::Hand(Box::new(read.calibration.clone().ok_or_else(none)?));
        certificate::html(&Certificate::of(Stated::default(), &read.logs.log, found)).map_err(wrong)
    });
    Ok(attached("certificate.html", page.await?.into_bytes()))
}

fn exported(study: &Study, format: &str) -> Result<Response, Refused> {
    let file = study.whole_file().map_err(not_now)?;
    let provenance = file.provenance();
    let (name, content) = match format {
        "image" => ("unit.fosm", image(&file.model, "", &provenance).map_err(wrong)?),
        "rust" => ("model.rs", rust_source(&file.model, &provenance).into_bytes()),
        "c" => ("model.h", c_source(&file.model, "model", "", &provenance).map_err(wrong)?.into_bytes()),
        "study" => ("unit.json", file.to_bytes()),
        "report.html" => ("report.html", html(&report(study, &file)?).map_err(wrong)?.into_bytes()),
        "report.md" => ("report.md", markdown(&report(study, &file)?).map_err(wrong)?.into_bytes()),
        _ => {
            return Err(not_found(format!(
                "there is no {format:?}; there are image, rust, c, study, report.html, report.md"
            )));
        }
    };
    Ok(attached(name, content))
}

/// A file to be saved.
fn attached(name: &str, content: Vec<u8>) -> Response {
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{name}\"")),
    ];
    (headers, Body::from(content)).into_response()
}

/// Returns the report on the axes that have been examined.
fn report(study: &Study, file: &fos_diagnose::study::Study) -> Result<Report, Refused> {
    let read = study.read().map_err(not_now)?;
    let known = read.axes.iter().filter_map(|column| study.axis(column).ok());
    let axes = known.filter_map(|axis| {
        let found = axis.examination?;
        let moved = &read.summaries.log.moved;
        let view = View { axis: &found.comparison, curves: &found.curves, moved };
        Some(ReportAxis { section: axis.section, figures: view.all() })
    });
    let strapdown = study.strapdown(file).map_err(wrong)?;
    Ok(Report::put_together(file, axes.collect(), strapdown, &read.logs, read.summaries.clone()))
}

/// Acceptance of the exported model by the hubs.
#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Hubs {
    /// Refusal of a hub and its remedy, in the words of the command line; none if all hubs accept the model.
    pub(super) refusal: Option<String>,
}

impl Hubs {
    pub(super) fn of(model: &UnitModel) -> Self {
        Self { refusal: Refusal::of(model).map(|refusal| refusal.to_string()) }
    }
}

pub(super) async fn hubs(OfId(study): OfId) -> Answer<Hubs> {
    answer(move || Ok(Hubs::of(&study.whole_file().map_err(not_now)?.model))).await
}

/// Result of running the exported image over the evaluation log, or over the log to explain if there is none.
#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Replayed {
    /// Path of the log.
    log: String,
    summary: Summary,
    /// Command line with the same result.
    command: String,
    /// Size of the image, bytes.
    bytes: usize,
}

pub(super) async fn replay(OfId(study): OfId) -> Answer<Replayed> {
    answer(move || {
        let read = study.read().map_err(not_now)?;
        let file = study.whole_file().map_err(not_now)?;
        let bytes = image(&file.model, "", &file.provenance()).map_err(wrong)?;
        let length = bytes.len();
        let summary = study.replay(bytes).map_err(wrong)?;
        let log = read.logs.evaluation.as_ref().unwrap_or(&read.logs.log);
        let command = format!("fos replay unit.fosm {}", fos_data::escaping::quoted(&log.paths()));
        Ok(Replayed { log: log.paths(), summary, command, bytes: length })
    })
    .await
}

pub(super) async fn logs(State(workspace): State<Arc<Workspace>>) -> Answer<Vec<Listed>> {
    answer(move || Ok(workspace.folders.logs())).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Previewed {
    path: String,
    /// Entries of a column map that the user chose.
    #[serde(default)]
    columns: Vec<String>,
}

pub(super) async fn preview(
    State(workspace): State<Arc<Workspace>>,
    Json(wanted): Json<Previewed>,
) -> Answer<Preview> {
    let path = workspace.folders.permitted(&wanted.path).map_err(forbidden)?;
    let map = ColumnMap::from_specs(wanted.columns).map_err(wrong)?;
    answer(move || preview_of(&path, &map).map_err(wrong)).await
}

pub(super) async fn effects(State(workspace): State<Arc<Workspace>>) -> Json<Vec<Effect>> {
    Json(workspace.library.effects().to_vec())
}

#[derive(Deserialize)]
pub(super) struct Named {
    name: String,
}

/// Streams a dropped file into a temporary file next to its destination; only a complete file is moved there.
pub(super) async fn upload(
    State(workspace): State<Arc<Workspace>>,
    Query(named): Query<Named>,
    body: Body,
) -> Answer<Value> {
    let mut places = workspace.folders.for_upload(&named.name).map_err(wrong)?.peekable();
    let path = places.peek().cloned().unwrap_or_default();
    let failed = |error: std::io::Error| {
        let error = FileError::writing(&path)(error);
        Refused(StatusCode::INTERNAL_SERVER_ERROR, error.to_string())
    };
    let arriving = TemporarySibling::of(&path).map_err(failed)?;
    let mut file = tokio::fs::File::from_std(arriving.file().try_clone().map_err(failed)?);
    let (mut stream, mut bytes) = (body.into_data_stream(), 0_u64);
    while let Some(piece) = stream.next().await {
        let piece = piece.map_err(|error| wrong(format!("the file did not arrive whole: {error}")))?;
        bytes += piece.len() as u64;
        if bytes > LARGEST_FILE {
            return Err(Refused(
                StatusCode::PAYLOAD_TOO_LARGE,
                "the file is larger than 4 GiB\nhelp: open it by its path, in a folder that `fos serve` was given".into(),
            ));
        }
        file.write_all(&piece).await.map_err(failed)?;
    }
    file.flush().await.map_err(failed)?;
    let path = in_background(move || Ok(arriving.put_as_new(places))).await?.map_err(failed)?;
    Ok(Json(json!({ "path": path.display().to_string() })))
}
