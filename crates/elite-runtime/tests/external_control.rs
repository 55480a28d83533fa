//! A program in the shape of the vendor's external-control script, retyped in our own words: everything inside one
//! function that `end` closes, tabs, a class derived from `queue.Queue` with zero-argument `super()`, a condition on
//! the queue's own mutex, a lock around the motion, script threads that are stopped and joined, and a reverse socket on
//! which a program on a PC sends packets of eight integers.
//!
//! The robot's socket and motion functions are stand-ins inside the program, so that the test is about the language.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set itself up should stop"
)]

use crate::common;

use std::io::{Read, Write};
use std::net::TcpListener;

use common::{Standing, run};
use elite_runtime::TaskEnd;

const SCRIPT: &str = r#"def externalControl():
	import threading
	import time
	import queue
	import os
	import signal
	import socket
	import struct

	global control_mode
	global steptime
	global moves

	ZOOM = 1000000
	MODE_STOPPED = -2
	MODE_UNINITIALIZED = -1
	MODE_IDLE = 0
	MODE_SERVOJ = 1
	MODE_SERVOJ_QUEUE = 8
	QUEUE_SIZE = 3
	QUEUE_TIMEOUT = 0.2

	MOTION_MUTEX = threading.Lock()
	control_mode = MODE_UNINITIALIZED
	steptime = get_steptime()
	moves = []
	open_sockets = {}

	"""stand-ins for the controller's own functions"""
	def socket_open(ip, port, name):
		try:
			open_sockets[name] = socket.create_connection((ip, port), 2)
		except OSError as e:
			textmsg("cannot connect: ", str(e))
			return False
		return True

	def socket_close(name):
		open_sockets.pop(name).close()

	def socket_read_binary_integer(count, name, timeout = 2):
		connection = open_sockets[name]
		connection.settimeout(timeout if timeout > 0 else None)
		data = b""
		try:
			while len(data) < 4 * count:
				part = connection.recv(4 * count - len(data))
				if part == b"":
					break
				data += part
		except socket.timeout:
			pass
		got = len(data) // 4
		values = list(struct.unpack(">{}i".format(got), data[:4 * got]))
		return [got] + values + [-1] * (count - got)

	def socket_send_int(value, name):
		open_sockets[name].sendall(struct.pack(">i", value))

	def servoj(q, t = 0.004, lookahead_time = 0.1, gain = 300):
		moves.append(("servoj", q[0], t))
		sync()

	def stopj(a):
		moves.append(("stopj", a))

	class PointQueue(queue.Queue):
		def __init__(self):
			super().__init__()
			self.changed = threading.Condition(self.mutex)

		def put(self, item):
			super().put(item)
			with self.mutex:
				self.changed.notify_all()

		def get(self):
			item = super().get()
			with self.mutex:
				self.changed.notify_all()
			return item

		def newest(self):
			with self.mutex:
				if self._qsize() > 0:
					return self.queue[-1]
				return None

		def wait_until(self, count, timeout = None):
			with self.mutex:
				while self._qsize() < count:
					if not self.changed.wait(timeout):
						return False
				return True

	points = PointQueue()
	target = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
	has_target = False

	def scaled(packet):
		joints = []
		for value in packet[2:8]:
			joints.append(value / ZOOM)
		return joints

	def set_target(joints):
		nonlocal target
		nonlocal has_target
		with MOTION_MUTEX:
			target = joints
			has_target = True

	def servo_thread():
		while control_mode in (MODE_SERVOJ,):
			with MOTION_MUTEX:
				joints = target if has_target else None
			if joints is None:
				sync()
			else:
				servoj(joints, t = steptime, lookahead_time = 0.1, gain = 300)

	def queue_thread():
		textmsg("queue thread waits")
		if not points.wait_until(QUEUE_SIZE, QUEUE_TIMEOUT):
			textmsg("queue was not filled in time")
		while True:
			joints = points.get()
			with MOTION_MUTEX:
				servoj(joints, t = steptime)

	def killOthers():
		try:
			result = subprocess.run(["ps"], stdout = subprocess.PIPE)
			for line in result.stdout.splitlines():
				os.kill(int(line.split(None, 1)[0]), signal.SIGTERM)
		except Exception as e:
			textmsg("not possible: ", str(e))

	def start_motion(mode):
		if mode == MODE_SERVOJ:
			return start_thread(servo_thread, ())
		elif mode == MODE_SERVOJ_QUEUE:
			return start_thread(queue_thread, ())
		return 0

	motion_thread = 0
	if socket_open("127.0.0.1", PORT, "reverse_socket"):
		textmsg("connected")
	timeout = 0
	count = 0

	while control_mode > MODE_STOPPED:
		packet = socket_read_binary_integer(8, "reverse_socket", timeout)
		if packet[0] != 8:
			textmsg("timed out: {} of {}".format(packet[0], 8))
			control_mode = MODE_STOPPED
		else:
			timeout = packet[1] / 1000
			if packet[8] != control_mode:
				stop_thread(motion_thread)
				join_thread(motion_thread)
				stopj(8.0)
				control_mode = packet[8]
				motion_thread = start_motion(control_mode)
			if control_mode == MODE_SERVOJ:
				set_target(scaled(packet))
			elif control_mode == MODE_SERVOJ_QUEUE:
				points.put(scaled(packet))
			count += 1

	stop_thread(motion_thread)
	join_thread(motion_thread)
	stopj(8.0)
	socket_send_int(count, "reverse_socket")
	socket_close("reverse_socket")
	print(MOTION_MUTEX.locked(), points.mutex.locked(), points.newest())
	print(count, control_mode)
	seen = []
	for move in moves:
		name = move[0] if move[0] == "stopj" else round(move[1], 3)
		if not seen or seen[-1] != name:
			seen.append(name)
	print(seen)
end"#;

/// One packet: timeout in ms, six joints, mode.
fn packet(timeout_ms: i32, first_joint: f64, mode: i32) -> Vec<u8> {
    let joint = (first_joint * 1e6) as i32;
    let words = [timeout_ms, joint, 0, 0, 0, 0, 0, mode];
    words.iter().flat_map(|word| word.to_be_bytes()).collect()
}

fn drive(packets: Vec<(Vec<u8>, u64)>, wait_for_count: bool) -> (common::Ran, Option<i32>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let pc = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        for (packet, pause_ms) in packets {
            // In two parts: TCP may cut anywhere.
            stream.write_all(&packet[..13]).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(pause_ms));
            stream.write_all(&packet[13..]).unwrap();
        }
        if !wait_for_count {
            return None;
        }
        let mut count = [0; 4];
        stream.read_exact(&mut count).unwrap();
        Some(i32::from_be_bytes(count))
    });
    let ran = run(
        &Standing::default(),
        &SCRIPT.replace("PORT", &port.to_string()),
    );
    (ran, pc.join().unwrap())
}

#[test]
fn an_external_control_program_follows_modes_and_leaves_when_it_is_told() {
    let packets = vec![
        (packet(1000, 0.0, 0), 5),
        (packet(1000, 0.1, 1), 30),
        (packet(1000, 0.2, 1), 30),
        (packet(1000, 0.0, 0), 30),
        (packet(1000, 0.3, 8), 5),
        (packet(1000, 0.4, 8), 5),
        (packet(1000, 0.5, 8), 5),
        (packet(1000, 0.0, 0), 100),
        (packet(1000, 0.0, -2), 5),
    ];
    let (ran, count) = drive(packets, true);
    assert_eq!((&ran.end, ran.error.as_str()), (&TaskEnd::Finished, ""));
    assert_eq!(
        ran.printed,
        "False False None\n9 -2\n['stopj', 0.1, 0.2, 'stopj', 0.3, 0.4, 0.5, 'stopj']\n"
    );
    assert_eq!(count, Some(9));
    assert_eq!(ran.log, ["connected", "queue thread waits"]);
}

#[test]
fn an_external_control_program_ends_when_its_pc_falls_silent() {
    let (ran, _) = drive(vec![(packet(50, 0.1, 1), 5), (packet(50, 0.2, 1), 5)], true);
    assert_eq!((&ran.end, ran.error.as_str()), (&TaskEnd::Finished, ""));
    assert_eq!(ran.log, ["connected", "timed out: 0 of 8"]);
    assert!(
        ran.printed.starts_with("False False None\n2 -2\n"),
        "{}",
        ran.printed
    );
}
