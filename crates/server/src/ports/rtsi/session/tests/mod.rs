//! Conversations as the SDK holds them, over an in-memory stream.

mod golden;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use motion_api::RingFull;
use parking_lot::Mutex;
use proptest::prelude::*;
use tokio::io::{DuplexStream, duplex};
use tokio::sync::broadcast;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::super::inputs::Change;
use super::super::outputs::tests::sample;
use super::*;
use crate::ports::description::RobotDescription;

struct Fake {
    description: RobotDescription,
    samples: broadcast::Sender<Arc<Sample>>,
    applied: Mutex<Vec<(ClientId, Vec<Change>, usize)>>,
    /// There is no room for changes.
    busy: AtomicBool,
}

impl RtsiBackend for Fake {
    fn description(&self) -> &RobotDescription {
        &self.description
    }
    fn samples(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.samples.subscribe()
    }
    fn sample(&self) -> Sample {
        sample()
    }
    fn apply(
        &self,
        client: ClientId,
        changes: &[Change],
        written: &[InputVariable],
    ) -> Result<u64, RingFull> {
        if self.busy.load(Ordering::Relaxed) {
            return Err(RingFull { capacity: 512 });
        }
        self.applied
            .lock()
            .push((client, changes.to_vec(), written.len()));
        Ok(110)
    }
}

impl Fake {
    fn new() -> Arc<Self> {
        Arc::new(Self {
            description: RobotDescription::cs66(),
            samples: broadcast::Sender::new(64),
            applied: Mutex::default(),
            busy: AtomicBool::new(false),
        })
    }

    /// Lets one cycle pass.
    async fn cycle(&self, number: u64) {
        self.send(number);
        settle().await;
    }

    fn send(&self, number: u64) {
        let mut sample = sample();
        sample.state.cycle = number;
        sample.state.time = number as f64 * 0.004;
        let _ = self.samples.send(Arc::new(sample));
    }
}

async fn settle() {
    for _ in 0..20 {
        tokio::task::yield_now().await;
    }
}

struct Rig {
    client: DuplexStream,
    session: JoinHandle<io::Result<()>>,
}

fn connect(controller: &Arc<Fake>, owners: &Owners, client: u64, room: usize) -> Rig {
    let (stream, server) = duplex(room);
    let (controller, owners) = (controller.clone(), owners.clone());
    let session =
        tokio::spawn(async move { serve(server, ClientId(client), &*controller, &owners).await });
    Rig {
        client: stream,
        session,
    }
}

impl Rig {
    async fn send(&mut self, letter: u8, payload: &[u8]) {
        let mut bytes = Vec::new();
        append_packet(&mut bytes, letter, |out| out.extend(payload));
        self.client.write_all(&bytes).await.unwrap();
        settle().await;
    }

    async fn receive(&mut self) -> (u8, Vec<u8>) {
        let mut head = [0; 3];
        self.client.read_exact(&mut head).await.unwrap();
        let length = usize::from(u16::from_be_bytes([head[0], head[1]]));
        let mut payload = vec![0; length - 3];
        self.client.read_exact(&mut payload).await.unwrap();
        (head[2], payload)
    }

    async fn ask(&mut self, letter: u8, payload: &[u8]) -> Vec<u8> {
        self.send(letter, payload).await;
        let (answer, payload) = self.receive().await;
        assert_eq!(answer, letter, "{payload:?}");
        payload
    }

    /// Id and types of a recipe.
    async fn outputs(&mut self, frequency: f64, names: &str) -> (u8, String) {
        let payload = [&frequency.to_be_bytes()[..], names.as_bytes()].concat();
        recipe(&self.ask(packet_type::OUTPUTS, &payload).await)
    }

    async fn inputs(&mut self, names: &str) -> (u8, String) {
        recipe(&self.ask(packet_type::INPUTS, names.as_bytes()).await)
    }

    async fn text(&mut self) -> String {
        let (letter, payload) = self.receive().await;
        assert_eq!(letter, packet_type::TEXT);
        String::from_utf8(payload[1..].to_vec()).unwrap()
    }

    async fn nothing(&mut self) {
        assert!(
            timeout(Duration::from_millis(100), self.receive())
                .await
                .is_err()
        );
    }
}

fn recipe(payload: &[u8]) -> (u8, String) {
    (
        payload[0],
        String::from_utf8(payload[1..].to_vec()).unwrap(),
    )
}

fn is(id: u8, kinds: &str) -> (u8, String) {
    (id, kinds.to_owned())
}

#[tokio::test]
async fn the_handshake_of_the_page_goes_byte_for_byte() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    let conversation: [(&[u8], &[u8]); 5] = [
        (b"\x00\x05V\x00\x01", b"\x00\x04V\x01"),
        (
            b"\x00\x03v",
            b"\x00\x13v\x00\x00\x00\x02\x00\x00\x00\x0f\x00\x00\x00\x00\x00\x00\x00\x00",
        ),
        (
            b"\x00\x37Istandard_digital_output_mask,standard_digital_output",
            b"\x00\x11I\x01UINT16,UINT16",
        ),
        (
            b"\x00\x1fO\x40\x6f\x40\x00\x00\x00\x00\x00timestamp,robot_mode",
            b"\x00\x10O\x02DOUBLE,INT32",
        ),
        (b"\x00\x03S", b"\x00\x04S\x01"),
    ];
    for (request, reply) in conversation {
        rig.client.write_all(request).await.unwrap();
        let mut answer = vec![0; reply.len()];
        rig.client.read_exact(&mut answer).await.unwrap();
        assert_eq!(answer, reply);
    }
    settle().await;
    controller.cycle(3125).await;
    let mut package = [0; 16];
    rig.client.read_exact(&mut package).await.unwrap();
    assert_eq!(
        package,
        *b"\x00\x10U\x02\x40\x29\x00\x00\x00\x00\x00\x00\x00\x00\x00\x07"
    );
    rig.send(packet_type::DATA, &[1, 0, 1, 0, 1]).await;
    assert_eq!(
        *controller.applied.lock(),
        [(
            ClientId(1),
            vec![Change::StandardDigitalOut { mask: 1, levels: 1 }],
            2
        )]
    );
    assert_eq!(rig.ask(packet_type::PAUSE, &[]).await, [1]);
}

#[tokio::test(start_paused = true)]
async fn recipes_are_sent_each_at_its_own_rate_and_none_while_paused() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 64 * 1024);
    assert_eq!(rig.outputs(125.0, "timestamp").await, is(1, "DOUBLE"));
    assert_eq!(
        rig.outputs(f64::NAN, "timestamp,timestamp,").await,
        is(2, "DOUBLE,DOUBLE")
    );
    assert_eq!(rig.outputs(62.5, "").await, is(3, ""));
    controller.cycle(99).await;
    rig.nothing().await;
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    let mut ids = Vec::new();
    for cycle in 100..108 {
        controller.cycle(cycle).await;
        let mut in_cycle = Vec::new();
        while let Ok((letter, payload)) = timeout(Duration::from_millis(1), rig.receive()).await {
            assert_eq!(letter, packet_type::DATA);
            in_cycle.push(payload[0]);
        }
        ids.push(in_cycle);
    }
    let all: Vec<&[u8]> = vec![
        &[1, 2, 3],
        &[2],
        &[1, 2],
        &[2],
        &[1, 2, 3],
        &[2],
        &[1, 2],
        &[2],
    ];
    assert_eq!(ids, all);
    assert_eq!(rig.ask(packet_type::PAUSE, &[]).await, [1]);
    controller.cycle(108).await;
    rig.nothing().await;
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    controller.cycle(109).await;
    assert_eq!(rig.receive().await.1[0], 1, "at once after the start");
}

#[tokio::test(start_paused = true)]
async fn cycles_that_come_in_one_go_are_all_sent() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 64);
    assert_eq!(rig.outputs(125.0, "timestamp").await, is(1, "DOUBLE"));
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    controller.cycle(100).await;
    for number in 101..160 {
        controller.send(number);
    }
    for number in (100..160).step_by(2) {
        let (_, payload) = rig.receive().await;
        let time = f64::from_be_bytes(*payload[1..].first_chunk().unwrap());
        assert_eq!(time, f64::from(number) * 0.004);
    }
    rig.nothing().await;
}

#[tokio::test(start_paused = true)]
async fn a_lost_cycle_does_not_move_the_ones_after_it() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    rig.outputs(62.5, "timestamp").await;
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    let mut sent = Vec::new();
    for number in (100..130).filter(|n| ![104, 105, 112].contains(n)) {
        controller.cycle(number).await;
        while timeout(Duration::from_millis(1), rig.receive())
            .await
            .is_ok()
        {
            sent.push(number);
        }
    }
    assert_eq!(sent, [100, 106, 108, 113, 116, 120, 124, 128]);
}

#[tokio::test(start_paused = true)]
async fn data_never_stops_for_a_second_while_started_even_if_no_cycle_comes() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    rig.outputs(250.0, "timestamp").await;
    rig.outputs(0.1, "timestamp").await;
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    let start = Instant::now();
    for repetition in 1..=4 {
        assert_eq!(rig.receive().await.1[0], 1);
        assert_eq!(rig.receive().await.1[0], 2);
        assert_eq!(start.elapsed().as_millis(), 500 * repetition);
        // Whatever the client says meanwhile.
        rig.send(packet_type::TEXT, b"\x02hi\x03app\x03").await;
    }
    assert_eq!(rig.ask(packet_type::PAUSE, &[]).await, [1]);
    rig.nothing().await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    rig.nothing().await;
}

#[tokio::test(start_paused = true)]
async fn a_rate_close_to_zero_sends_once_and_no_more() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 64 * 1024);
    assert_eq!(rig.outputs(1e-300, "timestamp").await, is(1, "DOUBLE"));
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    controller.cycle(100).await;
    assert_eq!(rig.receive().await.1[0], 1);
    controller.cycle(101).await;
    rig.nothing().await;
}

#[test]
fn a_rate_is_a_whole_number_of_cycles() {
    for (frequency, step, cycles) in [
        (250.0, 0.004, 1),
        (125.0, 0.004, 2),
        (62.5, 0.004, 4),
        (100.0, 0.004, 3),
        (250.0, 0.001, 4),
        (250.0, 0.008, 1),
        (1e-300, 0.004, u64::MAX),
    ] {
        assert_eq!(
            cycles_between(frequency, step),
            cycles,
            "{frequency} Hz, {step} s"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn unknown_names_are_not_found_and_keep_the_connection_from_starting() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    assert_eq!(
        rig.outputs(250.0, "timestamp,nonsense,speed_slider_mask")
            .await,
        is(1, "DOUBLE,NOT_FOUND,NOT_FOUND")
    );
    assert_eq!(
        rig.inputs("timestamp,input_int_register0").await,
        is(2, "NOT_FOUND,INT32")
    );
    assert_eq!(rig.ask(packet_type::START, &[]).await, [0]);
    controller.cycle(1).await;
    rig.nothing().await;
}

#[tokio::test(start_paused = true)]
async fn values_wait_for_room_and_are_left_out_with_a_word_when_there_is_none() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    assert_eq!(rig.inputs("input_int_register0").await, is(1, "INT32"));
    let applied = || controller.applied.lock().len();
    controller.busy.store(true, Ordering::Relaxed);
    rig.send(packet_type::DATA, &[1, 0, 0, 0, 7]).await;
    tokio::time::sleep(ROOM_WITHIN / 2).await;
    assert_eq!(applied(), 0);
    controller.busy.store(false, Ordering::Relaxed);
    tokio::time::sleep(2 * LOOK_AGAIN).await;
    assert_eq!(applied(), 1);
    controller.busy.store(true, Ordering::Relaxed);
    rig.send(packet_type::DATA, &[1, 0, 0, 0, 8]).await;
    assert!(
        rig.text()
            .await
            .contains("a data package was left out: 512 commands wait")
    );
    assert_eq!(applied(), 1);
}

#[tokio::test(start_paused = true)]
async fn an_input_has_one_writer_and_a_reconnect_is_waited_for() {
    let (controller, owners) = (Fake::new(), Owners::default());
    let mut first = connect(&controller, &owners, 1, 4096);
    assert_eq!(first.inputs("input_int_register0").await, is(1, "INT32"));
    let mut second = connect(&controller, &owners, 2, 4096);
    assert_eq!(
        second
            .inputs("input_int_register1,input_int_register0")
            .await,
        is(1, "INT32,IN_USE")
    );
    assert_eq!(
        first.inputs("input_int_register0").await,
        is(2, "INT32"),
        "twice by its owner"
    );
    // Closed and opened again in the same moment.
    let mut third = connect(&controller, &owners, 3, 4096);
    third
        .send(packet_type::INPUTS, b"input_int_register0")
        .await;
    drop(first);
    assert_eq!(recipe(&third.receive().await.1), is(1, "INT32"));
}

#[tokio::test(start_paused = true)]
async fn inputs_are_applied_while_paused_and_wrong_packages_are_told() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    rig.inputs("speed_slider_mask,speed_slider_fraction").await;
    let values = [&[1][..], &1_u32.to_be_bytes(), &0.5_f64.to_be_bytes()].concat();
    rig.send(packet_type::DATA, &values).await;
    assert_eq!(
        *controller.applied.lock(),
        [(ClientId(1), vec![Change::SpeedFraction(0.5)], 2)]
    );
    for (payload, text) in [
        (&[9, 0][..], "there is no input recipe 9"),
        (&[1, 0], "input recipe 1 has 12 bytes of values, not 1"),
        (&[], "a data package begins with the id of its recipe"),
    ] {
        rig.send(packet_type::DATA, payload).await;
        assert_eq!(rig.text().await, text);
    }
    rig.send(packet_type::TEXT, b"\x05hi").await;
    let sentence = "a text message is two texts with their lengths and a level";
    assert_eq!(rig.text().await, sentence);
    rig.send(b'?', &[]).await;
    assert_eq!(rig.text().await, "packets of type 63 are not known");
    assert_eq!(rig.ask(packet_type::PROTOCOL, &[0, 2]).await, [0]);
    assert_eq!(rig.ask(packet_type::PROTOCOL, &[0, 1]).await, [1]);
    assert_eq!(controller.applied.lock().len(), 1);
}

#[tokio::test(start_paused = true)]
async fn what_was_written_before_the_start_is_in_the_first_package() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    rig.outputs(250.0, "timestamp").await;
    rig.inputs("input_int_register0").await;
    rig.send(packet_type::DATA, &[2, 0, 0, 0, 7]).await;
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    for number in 100..112 {
        controller.cycle(number).await;
    }
    for number in [110, 111] {
        let (_, payload) = rig.receive().await;
        let time = f64::from_be_bytes(*payload[1..].first_chunk().unwrap());
        assert_eq!(time, f64::from(number) * 0.004);
    }
    // While data flows, writing holds nothing up.
    rig.send(packet_type::DATA, &[2, 0, 0, 0, 8]).await;
    controller.cycle(112).await;
    assert_eq!(rig.receive().await.1[0], 1);
}

#[tokio::test(start_paused = true)]
async fn a_slow_reader_loses_packages_but_no_replies() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 64);
    rig.outputs(250.0, "actual_joint_positions").await;
    assert_eq!(rig.ask(packet_type::START, &[]).await, [1]);
    for cycle in 1..2000 {
        controller.cycle(cycle).await;
    }
    rig.client.write_all(b"\x00\x03P").await.unwrap();
    settle().await;
    let mut packages = 0;
    loop {
        let (letter, payload) = rig.receive().await;
        if letter == packet_type::PAUSE {
            break;
        }
        assert_eq!(payload.len(), 49);
        packages += 1;
    }
    let most = DATA_BYTES_MAX / 52 + 3;
    assert!(packages <= most, "{packages} packages");
    rig.nothing().await;
}

#[tokio::test(start_paused = true)]
async fn recipes_have_limits() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 256 * 1024);
    let long = "timestamp,".repeat(RECIPE_VARIABLES_MAX + 1);
    assert_eq!(rig.outputs(250.0, &long).await, is(0, "NOT_FOUND"));
    assert_eq!(
        rig.text().await,
        "more than 1024 variables in a recipe are not possible"
    );
    for id in 1..=254 {
        assert_eq!(rig.outputs(250.0, "robot_mode").await, is(id, "INT32"));
    }
    assert_eq!(rig.outputs(250.0, "robot_mode").await, is(0, "NOT_FOUND"));
    assert_eq!(rig.text().await, "more than 254 recipes are not possible");
}

#[tokio::test]
async fn what_is_not_rtsi_ends_the_connection() {
    let controller = Fake::new();
    let mut rig = connect(&controller, &Owners::default(), 1, 4096);
    rig.client.write_all(&[0, 1, 2]).await.unwrap();
    let error = rig.session.await.unwrap().unwrap_err();
    assert_eq!(error.to_string(), "a packet of 1 bytes; the shortest has 3");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]
    #[test]
    fn any_packets_leave_the_session_alive(
        packets in proptest::collection::vec(
            (prop_oneof![Just(b'V'), Just(b'O'), Just(b'I'), Just(b'S'), Just(b'P'), Just(b'U'), Just(b'M'),
                any::<u8>()],
             proptest::collection::vec(prop_oneof![2 => 0u8..4, 1 => any::<u8>(), 1 => Just(b',')], 0..30)),
            0..20),
    ) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
        runtime.block_on(async {
            let controller = Fake::new();
            let mut rig = connect(&controller, &Owners::default(), 1, 1 << 20);
            for (letter, payload) in &packets {
                rig.send(*letter, payload).await;
            }
            controller.cycle(1).await;
            rig.send(packet_type::VERSION, &[]).await;
            loop {
                let (letter, payload) = rig.receive().await;
                assert!(!payload.is_empty(), "a packet without payload");
                if letter == packet_type::VERSION { break; }
            }
        });
    }
}
