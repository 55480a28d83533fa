//! What an unknown word probably stands for: the same name in other letters, the word of another robot or language,
//! a slip of the finger, in this order.

use crate::habits;

/// Longest names that are compared, in characters: nobody mistypes longer ones.
const CHARS_MAX: usize = 64;
/// Most names that are compared with one.
const CANDIDATES_MAX: usize = 4096;
/// Cost of a wrong, missing or additional letter, or of two that changed places.
const SLIP: usize = 2;
/// Cost of a letter that looks like the right one.
const LOOKALIKE: usize = 1;

/// How well a candidate fits; less is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fit {
    /// Other case or other underscores.
    Letters,
    /// The word that people bring from elsewhere.
    Habit,
    /// Cost of the slips, letters of the name that are not a common beginning, difference of the lengths.
    Spelling(usize, usize, usize),
}

/// The candidate that was probably meant by `name`, if one is likelier than every other. Long names, and those of a
/// crowd beyond the first few thousand, are not looked at.
pub fn nearest(name: &str, candidates: impl Iterator<Item = impl AsRef<str>>) -> Option<String> {
    let letters: Vec<char> = name.chars().take(CHARS_MAX + 1).map(lower).collect();
    let limit = match letters.len() {
        0 | 1 | CHARS_MAX.. => 0,
        2 => LOOKALIKE,
        3..=6 => SLIP,
        7..=9 => 2 * SLIP,
        _ => 3 * SLIP,
    };
    if letters.is_empty() || letters.len() > CHARS_MAX {
        return None;
    }
    let habit = habits::usual_name(name);
    let mut best: Option<(Fit, String)> = None;
    let mut is_tie = false;
    for candidate in candidates.take(CANDIDATES_MAX) {
        let candidate = candidate.as_ref();
        if candidate == name || candidate.len() > 4 * (CHARS_MAX + limit) {
            continue;
        }
        let Some(fit) = fit(&letters, candidate, habit, limit) else {
            continue;
        };
        match &best {
            Some((least, text)) if fit > *least || *text == candidate => {}
            Some((least, _)) if fit == *least => is_tie = true,
            _ => {
                best = Some((fit, candidate.to_owned()));
                is_tie = false;
            }
        }
    }
    // A button that puts the wrong one of two motions into a program is worse than none.
    best.filter(|_| !is_tie).map(|(_, text)| text)
}

fn fit(name: &[char], candidate: &str, habit: Option<&str>, limit: usize) -> Option<Fit> {
    let other: Vec<char> = candidate
        .chars()
        .take(name.len() + limit + 4)
        .map(lower)
        .collect();
    let plain =
        |letters: &[char]| -> Vec<char> { letters.iter().copied().filter(|c| *c != '_').collect() };
    if name.len() > 1 && other.len().abs_diff(name.len()) < 4 && plain(name) == plain(&other) {
        return Some(Fit::Letters);
    }
    if habit == Some(candidate) {
        return Some(Fit::Habit);
    }
    let cost = distance(name, &other, limit)?;
    let alike = name.iter().zip(&other).take_while(|(a, b)| a == b).count();
    Some(Fit::Spelling(
        cost,
        name.len() - alike,
        other.len().abs_diff(name.len()),
    ))
}

fn lower(c: char) -> char {
    c.to_lowercase().next().unwrap_or(c)
}

/// Letters that are taken for each other when read.
fn look_alike(a: char, b: char) -> bool {
    const GROUPS: [&str; 5] = ["il1|", "o0", "s5", "b8", "z2"];
    GROUPS
        .iter()
        .any(|group| group.contains(a) && group.contains(b))
}

/// Edit distance with transpositions of neighbours counted as one (optimal string alignment); None if it is above
/// `limit`. Three rows of the table are kept.
fn distance(a: &[char], b: &[char], limit: usize) -> Option<usize> {
    if a.len().abs_diff(b.len()) * SLIP > limit {
        return None;
    }
    let first = (0..=b.len()).map(|length| length * SLIP);
    let (mut before, mut last) = (vec![0; b.len() + 1], first.collect::<Vec<usize>>());
    let mut row = vec![0; b.len() + 1];
    for i in 1..=a.len() {
        row[0] = i * SLIP;
        for j in 1..=b.len() {
            let (from, to) = (a[i - 1], b[j - 1]);
            let change = match () {
                () if from == to => 0,
                () if look_alike(from, to) => LOOKALIKE,
                () => SLIP,
            };
            row[j] = (last[j - 1] + change)
                .min(last[j] + SLIP)
                .min(row[j - 1] + SLIP);
            let swapped = i > 1 && j > 1 && from == b[j - 2] && a[i - 2] == to;
            if swapped {
                row[j] = row[j].min(before[j - 2] + SLIP);
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

    /// Functions of the robot, and Python's, that are taken for each other.
    const NAMES: &[&str] = &[
        "False",
        "None",
        "True",
        "d2r",
        "end_force_mode",
        "end_freedrive_mode",
        "force_mode",
        "freedrive_mode",
        "get_actual_joint_positions",
        "get_actual_joint_speeds",
        "get_actual_tcp_pose",
        "get_actual_tcp_speed",
        "get_forward_kin",
        "get_inverse_kin",
        "get_standard_analog_in",
        "get_standard_analog_out",
        "get_standard_digital_in",
        "get_standard_digital_out",
        "get_target_tcp_pose",
        "get_tcp_force",
        "get_tool_digital",
        "halt",
        "join_thread",
        "movec",
        "movej",
        "movel",
        "movep",
        "popup",
        "pose_trans",
        "print",
        "r2d",
        "range",
        "servoj",
        "set_payload",
        "set_standard_analog_out",
        "set_standard_digital_out",
        "set_tcp",
        "set_tool_digital",
        "sleep",
        "socket_open",
        "socket_read_string",
        "socket_send_string",
        "speedj",
        "speedl",
        "start_thread",
        "stop_thread",
        "stopj",
        "stopl",
        "sync",
        "textmsg",
        "to_str",
        "zero_ftsensor",
    ];

    fn check(pairs: &[(&str, &str)]) {
        assert!(pairs.len() >= 20, "{}", pairs.len());
        for (written, meant) in pairs {
            let found = nearest(written, NAMES.iter());
            assert_eq!(found.as_deref(), Some(*meant), "{written}");
        }
    }

    #[test]
    fn other_case_and_underscores_come_first() {
        check(&[
            ("moveJ", "movej"),
            ("MoveJ", "movej"),
            ("MOVEJ", "movej"),
            ("moveL", "movel"),
            ("MoveL", "movel"),
            ("moveC", "movec"),
            ("moveP", "movep"),
            ("move_j", "movej"),
            ("move_l", "movel"),
            ("speedJ", "speedj"),
            ("speedL", "speedl"),
            ("servoJ", "servoj"),
            ("stopL", "stopl"),
            ("true", "True"),
            ("TRUE", "True"),
            ("false", "False"),
            ("none", "None"),
            ("Sleep", "sleep"),
            ("setTcp", "set_tcp"),
            ("getActualTcpPose", "get_actual_tcp_pose"),
            ("Textmsg", "textmsg"),
            ("startThread", "start_thread"),
            ("zero_ft_sensor", "zero_ftsensor"),
        ]);
    }

    #[test]
    fn words_of_other_robots_and_languages_come_next() {
        check(&[
            ("set_digital_out", "set_standard_digital_out"),
            ("get_digital_in", "get_standard_digital_in"),
            ("get_digital_out", "get_standard_digital_out"),
            ("set_analog_out", "set_standard_analog_out"),
            ("get_analog_in", "get_standard_analog_in"),
            ("textmessage", "textmsg"),
            ("wait", "sleep"),
            ("delay", "sleep"),
            ("null", "None"),
            ("nil", "None"),
            ("printf", "print"),
            ("echo", "print"),
            ("deg2rad", "d2r"),
            ("rad2deg", "r2d"),
            ("get_tcp_pose", "get_actual_tcp_pose"),
            ("get_joint_positions", "get_actual_joint_positions"),
            ("inverse_kinematics", "get_inverse_kin"),
            ("forward_kinematics", "get_forward_kin"),
            ("move_lin", "movel"),
            ("ptp", "movej"),
            ("teach_mode", "freedrive_mode"),
            ("run_thread", "start_thread"),
            ("exit", "halt"),
            ("socket_read_line", "socket_read_string"),
            ("setDigitalOut", "set_standard_digital_out"),
            ("getDigitalIn", "get_standard_digital_in"),
            ("getTcpPose", "get_actual_tcp_pose"),
            ("MovePTP", "movej"),
            ("get_inverse_kinematics", "get_inverse_kin"),
            ("getForwardKinematics", "get_forward_kin"),
            ("pose_transform", "pose_trans"),
        ]);
    }

    #[test]
    fn words_of_other_robots_stand_for_functions_that_are_there() {
        for (written, meant) in [
            ("print_msg", "print"),
            ("TPWrite", "textmsg"),
            ("clock", "controller_timestamp"),
            ("get_time", "controller_timestamp"),
            ("ClkRead", "controller_timestamp"),
            ("rand", "random"),
            ("zero_ft", "zero_ftsensor"),
            ("get_flange_pose", "get_actual_tool_flange_pose"),
            ("CJointT", "get_actual_joint_positions"),
            ("Offs", "pose_add"),
            ("RelTool", "pose_trans"),
            ("SLIN", "movel"),
            ("inverse_pose", "pose_inv"),
            ("conveyor_pulse_decode", "encoder_enable_pulse_decode"),
            ("read_input_bit_register", "read_input_boolean_register"),
            ("rtde_set_watchdog", "rtsi_set_watchdog"),
            ("substring", "str_sub"),
            ("arctan2", "atan2"),
            ("power_off", "powerdown"),
        ] {
            let names = [meant, "movej", "sleep", "set_payload"];
            let found = nearest(written, names.iter());
            assert_eq!(found.as_deref(), Some(meant), "{written}");
            // A program's own name of this spelling is not unknown; where nothing does the same, nothing is said.
            assert_eq!(nearest(written, ["set_payload"].iter()), None, "{written}");
        }
    }

    #[test]
    fn slips_of_the_finger_come_last() {
        check(&[
            ("mvoej", "movej"),
            ("moevj", "movej"),
            ("movvej", "movej"),
            ("mvel", "movel"),
            ("move1", "movel"),
            ("moveI", "movel"),
            ("texmsg", "textmsg"),
            ("textmgs", "textmsg"),
            ("tetxmsg", "textmsg"),
            ("slepe", "sleep"),
            ("slee", "sleep"),
            ("pritn", "print"),
            ("prnt", "print"),
            ("set_tpc", "set_tcp"),
            ("set_paylod", "set_payload"),
            ("get_actaul_joint_position", "get_actual_joint_positions"),
            ("get_inverse_kim", "get_inverse_kin"),
            ("pose_tran", "pose_trans"),
            ("freedive_mode", "freedrive_mode"),
            ("ragne", "range"),
            ("Ture", "True"),
            ("set_standart_digital_out", "set_standard_digital_out"),
        ]);
    }

    #[test]
    fn nothing_is_said_where_it_could_be_either() {
        for written in ["movex", "speedx", "move", "x", "gripper", "widget_in"] {
            assert_eq!(nearest(written, NAMES.iter()), None, "{written}");
        }
        // Another motion than the one that was meant is worse than none.
        let with_moveml = || NAMES.iter().chain(&["moveml"]);
        for written in ["moveto", "move_to", "movefj"] {
            let found = nearest(written, with_moveml());
            assert_ne!(found.as_deref(), Some("moveml"), "{written}");
        }
        // What the program does not have is not proposed.
        assert_eq!(nearest("wait", ["wart"].iter()).as_deref(), Some("wart"));
        assert_eq!(nearest("null", ["movej"].iter()), None);
        assert_eq!(nearest("pl", ["p1", "q"].iter()).as_deref(), Some("p1"));
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
        assert_eq!(nearest("naem1234", crowd).as_deref(), Some("name1234"));
        assert!(task_memory::live_bytes() - before < 100_000);
    }
}
