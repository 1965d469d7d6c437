//! Command lines equivalent to the actions in the browser or in a report.

use crate::escaping::quoted;
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_diagnose::refine::Logs;
use fos_diagnose::study::Refinement;

/// Command lines that repeat an analysis of these logs: a fit to `fitted`, and the diagnosis or refinement of each axis.
pub(crate) fn command_lines<'a>(
    fitted: &[Source],
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
        format!("fos fit {} --axis all{read} -o unit.json", fitted.join(" ")),
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
