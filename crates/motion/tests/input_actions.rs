//! Inputs that set something off (manual 5.27 to 5.30).
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::common;

use common::{Bench, ideal};
use motion_api::{DigitalBank, InputAction, IoChange, MotionMode, SettingCommand};

fn level(bench: &Bench, level: bool) {
    let change = IoChange::digital_in(DigitalBank::Configurable, 4, level);
    bench.send(SettingCommand::SetIo(change));
}

fn tick(bench: &mut Bench, cycles: usize) -> MotionMode {
    for _ in 0..cycles {
        bench.tick();
    }
    bench.states.last().unwrap().motion_mode
}

#[test]
fn the_arm_is_led_by_hand_while_an_input_with_that_action_is_high() {
    let mut bench = Bench::new(ideal("cs66"));
    level(&bench, true);
    assert_eq!(tick(&mut bench, 3), MotionMode::Idle);
    let bit = DigitalBank::Configurable.bit(4);
    let action = InputAction::Freedrive;
    bench.send(SettingCommand::SetIo(IoChange::DigitalInAction {
        bit,
        action,
    }));
    assert_eq!(tick(&mut bench, 3), MotionMode::Freedrive);
    let wrench = [0.0, 20.0, 0.0, 0.0, 0.0, 0.0];
    bench.push(wrench);
    let before = bench.states.last().unwrap().actual_tcp_pose.xyz[1];
    tick(&mut bench, 100);
    let moved = bench.states.last().unwrap().actual_tcp_pose.xyz[1] - before;
    assert!(moved > 0.01, "{moved}");
    level(&bench, false);
    assert_eq!(tick(&mut bench, 300), MotionMode::Idle);
    assert!(bench.states.last().unwrap().target_qd.max_abs() == 0.0);
    // Again, and the end through the action.
    level(&bench, true);
    assert_eq!(tick(&mut bench, 3), MotionMode::Freedrive);
    bench.send(SettingCommand::SetIo(IoChange::InputActionsToDefault));
    assert_eq!(tick(&mut bench, 300), MotionMode::Idle);
    assert!(bench.stops.is_empty());
}
