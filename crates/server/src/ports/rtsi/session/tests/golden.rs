//! The bytes of every packet that the controller sends, and of those it is sent for them.
//!
//! Lines `>` are what a client sends, `<` what comes back, all in hexadecimal but for the letter of the packet. Checked
//! with Python's struct module against the protocol page when they were made.

use core::fmt::Write as _;

use kinematics::{JointPositions, Payload};
use motion_api::Registers;

use super::*;

/// A sample in which no two values are alike, with every type of variable in it.
fn rich_sample() -> Sample {
    let mut sample = sample();
    let registers = Registers::default();
    registers.output.set_boolean(64, true);
    registers.output.set_integer(47, -2);
    registers.output.set_float(0, 0.5);
    sample.registers = registers.images();
    sample.state.cycle = 3125;
    sample.state.time = 12.5;
    sample.state.actual_q = JointPositions([1.0, -1.5, 2.0, -2.5, 3.0, -3.5]);
    sample.state.payload = Payload {
        mass: 1.25,
        cog: [0.25, 0.5, -0.75].into(),
        ..Payload::default()
    };
    sample.state.digital_out = 0x0102_0304;
    sample
}

struct Script {
    rig: Rig,
    page: String,
}

impl Script {
    fn new(controller: &Arc<Fake>, owners: &Owners, client: u64) -> Self {
        Self {
            rig: connect(controller, owners, client, 64 * 1024),
            page: String::new(),
        }
    }

    fn write(&mut self, mark: char, letter: u8, payload: &[u8]) {
        let bytes: Vec<String> = payload.iter().map(|b| format!("{b:02x}")).collect();
        let length = payload.len() + 3;
        let letter = char::from(letter);
        let line = format!("{mark} {length:04x} {letter} {}", bytes.join(" "));
        writeln!(self.page, "{}", line.trim_end()).unwrap();
    }

    async fn receive(&mut self) {
        let (letter, payload) = self.rig.receive().await;
        self.write('<', letter, &payload);
    }

    async fn say(&mut self, letter: u8, payload: &[u8]) {
        self.write('>', letter, payload);
        self.rig.send(letter, payload).await;
    }

    async fn ask(&mut self, letter: u8, payload: &[u8]) {
        self.say(letter, payload).await;
        self.receive().await;
    }
}

fn outputs(frequency: f64, names: &str) -> Vec<u8> {
    [&frequency.to_be_bytes()[..], names.as_bytes()].concat()
}

#[tokio::test(start_paused = true)]
async fn every_packet_has_its_bytes() {
    let (controller, owners) = (Fake::new(), Owners::default());
    let mut script = Script::new(&controller, &owners, 1);
    script.ask(packet_type::PROTOCOL, &[0, 2]).await;
    script.ask(packet_type::PROTOCOL, &[0, 1]).await;
    script.ask(packet_type::VERSION, &[]).await;
    script
        .ask(
            packet_type::INPUTS,
            b"external_force_torque,speed_slider_mask",
        )
        .await;
    let every_type = "output_bit_register64,tool_digital0_mode,actual_digital_output_bits,robot_mode,timestamp,\
                      payload_cog,actual_joint_positions,joint_mode,output_int_register47,output_double_register0";
    script
        .ask(packet_type::OUTPUTS, &outputs(250.0, every_type))
        .await;
    script.ask(packet_type::OUTPUTS, &outputs(62.5, "")).await;
    script.ask(packet_type::START, &[]).await;
    let _ = controller.samples.send(Arc::new(rich_sample()));
    script.receive().await;
    script.receive().await;
    script.ask(packet_type::PAUSE, &[]).await;
    script.ask(packet_type::DATA, &[1, 0]).await;
    script.ask(packet_type::DATA, &[7]).await;
    script.ask(packet_type::DATA, &[]).await;
    script.ask(packet_type::OUTPUTS, &[0]).await;
    script.say(packet_type::TEXT, b"\x02hi\x03app\x03").await;
    script.ask(packet_type::TEXT, b"hi").await;
    script.ask(b'?', b"").await;

    let mut other = Script::new(&controller, &owners, 2);
    other
        .ask(
            packet_type::INPUTS,
            b"input_int_register0,speed_slider_mask",
        )
        .await;
    other.ask(packet_type::INPUTS, b"timestamp").await;
    other
        .ask(
            packet_type::OUTPUTS,
            &outputs(250.0, "timestamp,speed_slider_mask,nonsense"),
        )
        .await;
    other.ask(packet_type::START, &[]).await;
    insta::assert_snapshot!(format!("{}\nanother client\n{}", script.page, other.page));
}
