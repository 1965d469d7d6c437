//! Command lines equivalent to the actions in the browser or in a report.

use fos_data::escaping::quoted;
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_diagnose::refine::Logs;
use fos_diagnose::study::Refinement;
use fos_fit::fit::{FitOptions, Train};
use serde_json::json;

/// Options of `fit` for `settings`, those with a default value omitted.
pub fn fit_options(settings: &FitOptions) -> String {
    let default = FitOptions::default();
    let text = |name: &str, value: String, is_default: bool| match is_default {
        true => String::new(),
        false => format!(" --{name} {}", quoted(&value)),
    };
    let number = |name: &str, value: Option<f64>| match value {
        Some(value) if value != 0.0 => format!(" --{name}={value:?}"),
        _ => String::new(),
    };
    let serialised = |value: serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let memory: Vec<String> = settings.memory_s.iter().map(f64::to_string).collect();
    let memory = if memory.is_empty() { "none".to_owned() } else { memory.join(",") };
    let denoising = settings.denoising.map_or_else(String::new, |denoising| denoising.to_string());
    let train = match settings.train {
        Train::Share(share) => format!("{}%", 100.0 * share),
        Train::Seconds(seconds) => format!("{seconds}s"),
    };
    let mut line = [
        text("method", settings.method.to_string(), settings.method == default.method),
        text("denoise", denoising, settings.denoising.is_none()),
        text("search", serialised(json!(settings.search)), settings.search == default.search),
        text("max-lag", settings.max_lag.to_string(), settings.max_lag == default.max_lag),
        text("degree", settings.degree.to_string(), settings.degree == default.degree),
        text("memory", memory, settings.memory_s == default.memory_s),
        text("input-lags", settings.input_lags.to_string(), settings.input_lags == default.input_lags),
        text("max-terms", settings.max_terms.to_string(), settings.max_terms == default.max_terms),
        text("stop", serialised(json!(settings.stop)), settings.stop == default.stop),
        text("train", train, settings.train == default.train),
        number("offset", settings.offset),
        number("scale", settings.scale),
        number("full-scale", Some(settings.full_scale)),
    ]
    .concat();
    line.extend(settings.inputs.iter().map(|input| text("input", input.to_string(), false)));
    line.extend(settings.physical.iter().map(|input| text("physical", input.to_string(), false)));
    if settings.fitted_on != default.fitted_on {
        line += " --factory-corrected";
    }
    line
}

/// Command lines that repeat an analysis of these logs: a fit to `fitted` with `settings`, and the diagnosis or refinement
/// of each axis.
pub fn command_lines<'a>(
    fitted: &[Source],
    settings: &FitOptions,
    logs: &Logs,
    axes: impl IntoIterator<Item = (&'a str, Option<&'a Refinement>)>,
) -> Vec<String> {
    let path = |log: &Recording| quoted(&log.paths());
    let LoadOptions { columns, rate_hz, format, topic, strict: _, keep_moved } = &logs.read;
    let maps: String = columns.specs().iter().map(|map| format!(" --map {}", quoted(map))).collect();
    let rate = rate_hz.map_or_else(String::new, |rate| format!(" --rate {rate}"));
    let moved = if *keep_moved { " --keep-moved" } else { "" };
    let format = format.map_or_else(String::new, |format| format!(" --format {}", format.id()));
    let topic = topic.as_ref().map_or_else(String::new, |topic| format!(" --topic {}", quoted(topic)));
    let read = format!("{maps}{format}{topic}{rate}{moved}");
    let fitted: Vec<String> = fitted.iter().map(|source| quoted(&source.path)).collect();
    let field = path(&logs.log);
    let reference =
        logs.reference.as_ref().map_or_else(String::new, |log| format!(" --reference {}", path(log)));
    let evaluated =
        logs.evaluation.as_ref().map_or_else(String::new, |log| format!(" --evaluate-on {}", path(log)));
    let mut lines = vec![
        format!("fos fit {} --axis all{}{read} -o unit.json", fitted.join(" "), fit_options(settings)),
        format!("fos compare unit.json {field}{read} --figures figures"),
    ];
    for (column, refinement) in axes {
        let on = format!("--axis {} --from {field}{reference}{evaluated}{read}", quoted(column));
        lines.push(format!("fos diagnose unit.json {on}"));
        for added in refinement.into_iter().flat_map(Refinement::added) {
            lines.push(format!("fos add unit.json {} {on}", quoted(&added.effect.id)));
        }
    }
    let last = logs.evaluation.as_ref().map_or(field, path);
    lines.push("fos export unit.json --image unit.fosm --rust model.rs --c model.h".to_owned());
    lines.push(format!("fos replay unit.fosm {last}{read}"));
    lines
}
