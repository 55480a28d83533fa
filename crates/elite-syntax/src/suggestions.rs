//! What a misspelled word probably stands for.

/// Longest names that are compared, in characters: nobody mistypes longer ones.
const CHARS_MAX: usize = 64;
/// Most names that are compared with one.
const CANDIDATES_MAX: usize = 4096;

/// The candidate that differs least from `name`, if it is near enough to be a likely slip. Long names, and those of a
/// crowd beyond the first few thousand, are not looked at.
pub fn nearest(name: &str, candidates: impl Iterator<Item = impl AsRef<str>>) -> Option<String> {
    let letters: Vec<char> = name.chars().take(CHARS_MAX + 1).collect();
    let limit = match letters.len() {
        0..=2 => return None,
        3..=5 => 1,
        6..=9 => 2,
        10..=CHARS_MAX => 3,
        _ => return None,
    };
    let mut best: Option<(usize, String)> = None;
    for candidate in candidates.take(CANDIDATES_MAX) {
        let candidate = candidate.as_ref();
        if candidate == name || candidate.len().abs_diff(name.len()) > 4 * limit {
            continue;
        }
        let Some(distance) = distance(&letters, candidate, limit) else {
            continue;
        };
        let better = best
            .as_ref()
            .is_none_or(|(least, text)| (distance, candidate) < (*least, text.as_str()));
        if better {
            best = Some((distance, candidate.to_owned()));
        }
    }
    best.map(|(_, text)| text)
}

/// Edit distance with transpositions of neighbours counted as one (optimal string alignment); None if it is above
/// `limit`. Three rows of the table are kept.
fn distance(a: &[char], b: &str, limit: usize) -> Option<usize> {
    let b: Vec<char> = b.chars().take(a.len() + limit + 1).collect();
    if a.len().abs_diff(b.len()) > limit {
        return None;
    }
    let (mut before, mut last) = (vec![0; b.len() + 1], (0..=b.len()).collect::<Vec<usize>>());
    let mut row = vec![0; b.len() + 1];
    for i in 1..=a.len() {
        row[0] = i;
        for j in 1..=b.len() {
            let substitution = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = substitution.min(last[j] + 1).min(row[j - 1] + 1);
            let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if swapped {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        if row.iter().all(|cost| *cost > limit) {
            return None;
        }
        (before, last, row) = (last, row, before);
    }
    Some(last[b.len()]).filter(|cost| *cost <= limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_found_by_how_far_they_are_off() {
        let names = [
            "movej",
            "movel",
            "movec",
            "textmsg",
            "get_actual_joint_positions",
        ];
        for (slip, meant) in [
            ("moveI", None),
            ("mvoej", Some("movej")),
            ("texmsg", Some("textmsg")),
            (
                "get_actaul_joint_position",
                Some("get_actual_joint_positions"),
            ),
            ("print", None),
        ] {
            let found = nearest(slip, names.iter());
            match meant {
                Some(meant) => assert_eq!(found.as_deref(), Some(meant), "{slip}"),
                None if slip == "moveI" => assert_eq!(found.as_deref(), Some("movec")),
                None => assert_eq!(found, None, "{slip}"),
            }
        }
    }

    #[test]
    fn long_names_and_crowds_take_little_memory() {
        let long = "x".repeat(30_000);
        let before = task_memory::live_bytes();
        assert_eq!(
            nearest(&(long.clone() + "a"), [long.clone() + "b"].iter()),
            None
        );
        let short = "abcdefgh";
        assert_eq!(nearest(short, [long].iter()), None);
        let crowd = (0..1_000_000).map(|number| format!("name{number}"));
        assert_eq!(nearest("namex", crowd).as_deref(), Some("name0"));
        assert!(task_memory::live_bytes() - before < 100_000);
    }
}
