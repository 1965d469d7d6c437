//! `cargo xtask corpus CONTROL FOLDER`: selects inputs for the repository from a merge by libFuzzer.
//!
//! CONTROL is the file written by `-merge_control_file` in a merge with `-set_cover_merge=1 -use_counters=0`. Inputs
//! are selected greedily: each time the one that reaches most new edges, the smaller one of two, as long as those are
//! at least [`WORTH`]. The selection is stable: applied to its own result it selects all of it. The inputs are copied
//! into FOLDER and replace its content.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::Path;

/// Smallest number of new edges that justifies an input; most inputs reach one or two that no other does.
const WORTH: usize = 8;

/// An executed input.
#[derive(Debug, PartialEq)]
struct Input {
    path: String,
    /// Size, bytes.
    size: u64,
    edges: BTreeSet<u64>,
}

/// Inputs of a control file: their number, that of the first folder, their paths; then for each `STARTED index size`
/// and `FT index edge…`. (`COV` lists only edges that no earlier input reached.)
fn inputs(control: &str) -> Result<Vec<Input>, Box<dyn Error>> {
    let mut lines = control.lines();
    let count: usize = lines.next().ok_or("an empty control file")?.trim().parse()?;
    let mut inputs: Vec<Input> = lines
        .by_ref()
        .skip(1)
        .take(count)
        .map(|path| Input { path: path.to_owned(), size: 0, edges: BTreeSet::new() })
        .collect();
    for line in lines {
        let mut words = line.split_whitespace();
        let what = words.next().unwrap_or_default();
        let numbers: Vec<u64> = words.map(str::parse).collect::<Result<_, _>>()?;
        if let [index, rest @ ..] = &numbers[..]
            && let Some(input) = inputs.get_mut(usize::try_from(*index)?)
        {
            match (what, rest) {
                ("STARTED", [size]) => input.size = *size,
                ("FT", edges) => input.edges.extend(edges),
                _ => {}
            }
        }
    }
    Ok(inputs)
}

/// Selects the inputs to keep.
fn taken(mut inputs: Vec<Input>) -> Vec<Input> {
    let (mut reached, mut taken) = (BTreeSet::new(), Vec::new());
    loop {
        let news = |input: &Input| input.edges.difference(&reached).count();
        let best = (0..inputs.len()).max_by_key(|&at| (news(&inputs[at]), Reverse(inputs[at].size)));
        let Some(best) = best.filter(|&at| news(&inputs[at]) >= WORTH) else { return taken };
        let input = inputs.swap_remove(best);
        reached.extend(&input.edges);
        taken.push(input);
    }
}

pub(crate) fn run(control: &str, folder: &Path) -> Result<(), Box<dyn Error>> {
    let inputs = inputs(&fs::read_to_string(control)?)?;
    let (before, taken) = (inputs.len(), taken(inputs));
    if taken.is_empty() {
        return Err(format!("{control}: no input reaches anything").into());
    }
    let beside = folder.with_extension("new");
    fs::create_dir_all(&beside)?;
    for input in &taken {
        let name = Path::new(&input.path).file_name().ok_or("an input without a name")?;
        fs::copy(&input.path, beside.join(name))?;
    }
    fs::remove_dir_all(folder)?;
    fs::rename(&beside, folder)?;
    let bytes: u64 = taken.iter().map(|input| input.size).sum();
    println!("{}: {} of {before} inputs, {bytes} bytes", folder.display(), taken.len());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(path: &str, size: u64, edges: impl IntoIterator<Item = u64>) -> Input {
        Input { path: path.to_owned(), size, edges: edges.into_iter().collect() }
    }

    #[test]
    fn parses_control_file() {
        let control = "2\n0\nc/a\nc/b\nSTARTED 0 12\nFT 0 1 2\nCOV 0 7 9\nSTARTED 1 30\nFT 1 3\nCOV 1\n";
        assert_eq!(inputs(control).unwrap(), [input("c/a", 12, [1, 2]), input("c/b", 30, [3])]);
    }

    #[test]
    fn selects_smallest_inputs_with_most_new_edges() {
        let all = || {
            vec![
                input("large", 90, 0..60),
                input("small", 10, 0..60),
                input("rest", 50, 50..95),
                input("few", 1, 91..99),
            ]
        };
        let paths = |inputs: Vec<Input>| inputs.into_iter().map(|input| input.path).collect::<Vec<_>>();
        assert_eq!(paths(taken(all())), ["small", "rest"]);
        assert_eq!(paths(taken(taken(all()))), ["small", "rest"]);
    }
}
