//! The metrics of all robots as one page: each sample with the label `robot`, each family once.

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Families of samples in the order in which they were first seen.
#[derive(Default)]
pub(super) struct MergedMetrics {
    order: Vec<String>,
    families: BTreeMap<String, MetricFamily>,
}

#[derive(Default)]
struct MetricFamily {
    head: String,
    samples: String,
}

impl MergedMetrics {
    /// Adds the page of a robot; lines that are none are left out.
    pub(super) fn add(&mut self, robot: &str, page: &str) {
        let mut family = String::new();
        for line in page.lines() {
            let mut words = line.split_ascii_whitespace();
            if let Some(rest) = line.strip_prefix("# ") {
                let Some(name) = rest.split_ascii_whitespace().nth(1) else {
                    continue;
                };
                let is_new = family != name;
                family = name.to_owned();
                let entry = self.family(name);
                // Every robot says the same of it; the first has said it.
                if entry.samples.is_empty() && (is_new || !entry.head.contains(line)) {
                    let _ = writeln!(entry.head, "{line}");
                }
            } else if let (Some(sample), Some(_)) = (words.next(), words.next()) {
                let name = sample.split('{').next().unwrap_or(sample);
                // `x_bucket`, `x_sum` and `x_count` belong to the family that was opened.
                let owner = match !family.is_empty() && name.starts_with(family.as_str()) {
                    true => family.clone(),
                    false => name.to_owned(),
                };
                let line = labelled(line, name, robot);
                let _ = writeln!(self.family(&owner).samples, "{line}");
            }
        }
    }

    /// A sample of the fleet's own.
    pub(super) fn sample(
        &mut self,
        (name, kind, help): (&str, &str, &str),
        robot: &str,
        value: u64,
    ) {
        let entry = self.family(name);
        if entry.head.is_empty() {
            entry.head = format!("# HELP {name} {help}\n# TYPE {name} {kind}\n");
        }
        let _ = writeln!(entry.samples, "{name}{{robot=\"{robot}\"}} {value}");
    }

    fn family(&mut self, name: &str) -> &mut MetricFamily {
        if !self.families.contains_key(name) {
            self.order.push(name.to_owned());
        }
        self.families.entry(name.to_owned()).or_default()
    }

    /// The page.
    pub(super) fn text(&self) -> String {
        let families = self.order.iter().filter_map(|name| self.families.get(name));
        families
            .map(|family| format!("{}{}", family.head, family.samples))
            .collect()
    }
}

/// `name{a="b"} 1` with the label of the robot; names of robots need no escape.
fn labelled(line: &str, name: &str, robot: &str) -> String {
    let rest = line.get(name.len()..).unwrap_or_default();
    match rest.strip_prefix('{') {
        Some(labels) if labels.starts_with('}') => format!("{name}{{robot=\"{robot}\"{labels}"),
        Some(labels) => format!("{name}{{robot=\"{robot}\",{labels}"),
        None => format!("{name}{{robot=\"{robot}\"}}{rest}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_stand_once_with_the_samples_of_all_robots() {
        let page = "# HELP a_total What.\n# TYPE a_total counter\na_total 1\na_total{port=\"x\"} 2\n\
                    # HELP b Time.\n# TYPE b histogram\nb_bucket{le=\"1\"} 3\nb_sum 4\nb_count 5\nc{} 6\n\n";
        let mut merged = MergedMetrics::default();
        merged.add("left", page);
        merged.add("right", page);
        merged.sample(("up", "gauge", "Runs."), "left", 1);
        assert_eq!(
            merged.text(),
            "# HELP a_total What.\n# TYPE a_total counter\n\
             a_total{robot=\"left\"} 1\na_total{robot=\"left\",port=\"x\"} 2\n\
             a_total{robot=\"right\"} 1\na_total{robot=\"right\",port=\"x\"} 2\n\
             # HELP b Time.\n# TYPE b histogram\n\
             b_bucket{robot=\"left\",le=\"1\"} 3\nb_sum{robot=\"left\"} 4\nb_count{robot=\"left\"} 5\n\
             b_bucket{robot=\"right\",le=\"1\"} 3\nb_sum{robot=\"right\"} 4\nb_count{robot=\"right\"} 5\n\
             c{robot=\"left\"} 6\nc{robot=\"right\"} 6\n\
             # HELP up Runs.\n# TYPE up gauge\nup{robot=\"left\"} 1\n"
        );
    }
}
