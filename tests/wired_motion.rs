//! Inputs that motion listens to, through the real binary: pulses of an encoder, and pairs that switch safety planes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

mod common;

use common::printed_in_cell as printed;

/// Configurable outputs 0 and 1 drive the two high-speed inputs.
const CHANNELS: &str = r#"
[[wire]]
from = "configurable_digital_out[0]"
to = "configurable_digital_in[0]"
[[wire]]
from = "configurable_digital_out[1]"
to = "configurable_digital_in[1]"
"#;

#[test]
fn pulses_on_wired_inputs_are_counted_as_the_decoder_says() {
    let out = printed(
        r#"
def p():
    # one turn of the two channels: A, then B, as a belt that runs forwards gives them
    def turn(forwards):
        order = [[0, True], [1, True], [0, False], [1, False]]
        if not forwards:
            order = [[1, True], [0, True], [1, False], [0, False]]
        end
        for edge in order:
            set_configurable_digital_out(edge[0], edge[1])
            sync()
            sync()
        end
    end
    counts = []
    for kind in [[1, 16, 17], [1, 17, 16], [2, 16, 0], [3, 16, 0], [4, 17, 0]]:
        encoder_enable_pulse_decode(0, kind[0], kind[1], kind[2])
        sync()
        before = encoder_get_tick_count(0)
        for i in range(5):
            turn(True)
        end
        middle = encoder_get_tick_count(0)
        for i in range(3):
            turn(False)
        end
        counts.append([middle - before, encoder_get_tick_count(0) - middle])
    end
    for count in counts:
        print(count)
    end
end
"#,
        CHANNELS,
    );
    // Four edges a turn count in quadrature, with the direction; one channel has two edges and knows no direction.
    assert_eq!(
        out,
        "[20.0, -12.0]\n[-20.0, 12.0]\n[10.0, 6.0]\n[5.0, 3.0]\n[5.0, 3.0]\n"
    );
}

#[test]
fn the_arm_follows_a_belt_that_only_pulses_tell_of() {
    // 125 edges a second of 1000 a metre: 0.125 m/s.
    let out = printed(
        r#"
def p():
    def belt():
        order = [[0, True], [1, True], [0, False], [1, False]]
        i = 0
        while True:
            set_configurable_digital_out(order[i % 4][0], order[i % 4][1])
            i = i + 1
            sync()
            sync()
        end
    end
    encoder_enable_pulse_decode(1, 1, 16, 17)
    b = start_thread(belt, ())
    sleep(0.5)
    y = get_target_tcp_pose()[1]
    t = encoder_get_tick_count(1)
    track_conveyor_linear([0, 1, 0, 0, 0, 0], 1000.0, encoder_index=1)
    sleep(1.5)
    belt_way = (encoder_get_tick_count(1) - t) / 1000
    way = get_target_tcp_pose()[1] - y
    print(belt_way > 0.15, abs(way - belt_way) < 0.003)
    stop_conveyor_tracking()
    stop_thread(b)
end
"#,
        CHANNELS,
    );
    assert_eq!(out, "True True\n");
}

#[test]
fn a_plane_of_a_pair_counts_while_both_of_its_inputs_are_high() {
    let cell = r#"
[[safety_plane]]
name = "door"
point = [0, 0, 0.3]
normal = [0, 0, 1]
ci_pair = 1

[[input]]
at = 2
set = "configurable_digital_in[2]"
value = true

[[input]]
at = 4
set = "configurable_digital_in[3]"
value = true

[[input]]
at = 8
set = "configurable_digital_in[2]"
value = false
"#;
    let out = printed(
        r#"
def attempt(p):
    inside = is_within_safety_limits(p)
    try:
        movel(p, v=0.5)
        print(inside, "reached")
    except RuntimeError as e:
        print(inside, e)
    end
end
def p():
    up = get_target_tcp_pose()
    low = list(up)
    low[2] = 0.25
    print(is_within_safety_limits(low, ciPair=[0, 1, 0, 0]), is_within_safety_limits(low, ciPair=[1, 0, 1, 1]))
    attempt(low)
    movel(up, v=0.5)
    # one input alone is not the pair
    while not get_configurable_digital_in(2):
        sync()
    end
    attempt(low)
    movel(up, v=0.5)
    while not get_configurable_digital_in(3):
        sync()
    end
    attempt(low)
    print(is_within_safety_limits(low, ciPair=[0, 0, 0, 0]))
    while get_configurable_digital_in(2):
        sync()
    end
    attempt(low)
end
p()
"#,
        cell,
    );
    assert_eq!(
        out,
        "False True\nTrue reached\nTrue reached\n\
         False movel(): the target lies 0.0500 m behind safety plane 1 of the cell\nTrue\nTrue reached\n"
    );
}
