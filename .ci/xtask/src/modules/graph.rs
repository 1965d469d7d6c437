//! Graph of dependencies between files, and its cycles.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;

use super::source::{Defined, File, Sources};

/// Files, and the names that each takes from others.
pub(crate) struct Graph<'a> {
    files: DiGraph<&'a File, BTreeSet<String>>,
}

impl<'a> Graph<'a> {
    /// Resolves every reference.
    pub(crate) fn of(sources: &'a Sources) -> Self {
        let mut taken: BTreeMap<(usize, usize), BTreeSet<String>> = BTreeMap::new();
        for reference in &sources.references {
            let (file, found) = (sources.modules[reference.module].file, sources.follow(reference));
            for defined in found.defined {
                if let Defined::Item(other) = defined
                    && other != file
                {
                    taken.entry((file, other)).or_default().insert(found.name.clone());
                }
            }
        }
        let mut files = DiGraph::new();
        let nodes: Vec<NodeIndex> = sources.files.iter().map(|file| files.add_node(file)).collect();
        for ((from, to), names) in taken {
            files.add_edge(nodes[from], nodes[to], names);
        }
        Self { files }
    }

    pub(crate) fn files(&self) -> usize {
        self.files.node_count()
    }

    pub(crate) fn count(&self) -> usize {
        self.files.edge_count()
    }

    fn arrow(&self, from: NodeIndex, to: NodeIndex, names: &BTreeSet<String>) -> String {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        format!("{} -> {}: {}", self.files[from].path, self.files[to].path, names.join(", "))
    }

    /// Every edge on its own line, sorted.
    pub(crate) fn arrows(&self) -> String {
        let arrow = |edge: petgraph::graph::EdgeReference<BTreeSet<String>>| {
            self.arrow(edge.source(), edge.target(), edge.weight()) + "\n"
        };
        let lines: BTreeSet<String> = self.files.edge_references().map(arrow).collect();
        lines.into_iter().collect()
    }

    /// Cycles, each with its files and the names of each edge.
    pub(crate) fn circles(&self) -> Vec<String> {
        let mut circles: Vec<String> = tarjan_scc(&self.files)
            .iter()
            .filter(|part| part.len() > 1)
            .map(|part| self.circle(part))
            .collect();
        circles.sort();
        circles
    }

    fn circle(&self, part: &[NodeIndex]) -> String {
        let names: BTreeSet<&str> = part.iter().map(|&file| self.files[file].path.as_str()).collect();
        let mut ties = BTreeSet::new();
        for edge in
            part.iter().flat_map(|&file| self.files.edges(file)).filter(|edge| part.contains(&edge.target()))
        {
            ties.insert(self.arrow(edge.source(), edge.target(), edge.weight()));
        }
        let names: Vec<&str> = names.into_iter().collect();
        let mut text = format!("a circle of {} files: {}", names.len(), names.join(", "));
        for tie in ties {
            let _ = write!(text, "\n  {tie}");
        }
        text
    }

    /// Graph for Graphviz, with a cluster for each package.
    pub(crate) fn dot(&self) -> String {
        let mut packages: BTreeMap<&str, Vec<NodeIndex>> = BTreeMap::new();
        for file in self.files.node_indices() {
            packages.entry(&self.files[file].package).or_default().push(file);
        }
        let mut text = String::from("digraph {\n  rankdir = LR\n  node [shape = box]\n");
        for (package, files) in packages {
            let _ = writeln!(text, "  subgraph \"cluster_{package}\" {{\n    label = \"{package}\"");
            for file in files {
                let _ = writeln!(text, "    \"{}\"", self.files[file].path);
            }
            text += "  }\n";
        }
        for edge in self.files.edge_references() {
            let _ = writeln!(
                text,
                "  \"{}\" -> \"{}\"",
                self.files[edge.source()].path,
                self.files[edge.target()].path
            );
        }
        text + "}\n"
    }
}
