//! What comes over the network and serial lines: the codecs of every port and field bus.

mod conversation;
mod dashboard;
mod debugger;
mod foxglove;
mod http;
mod http_inputs;
mod interpreter;
mod modbus_rtu;
mod modbus_server;
mod opening;
mod primary;
mod query;
mod ros2;
mod rtsi;
mod script_socket;
mod xmlrpc;

use super::{Target, as_they_are, files_of};

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "ros2_link",
        about: "the link to the process of the ROS 2 node: messages, and trajectories within the limits",
        check: ros2::judge,
        render_input: as_they_are,
        seeds: ros2::seeds,
        words: &[
            b"shoulder_pan_joint\0",
            b"\x06\0\0\0",
            b"\xff\xff\xff\xff",
            b"\0\0\0\0\0\0\xf8\x7f",
            b"\0\0\0\0\0\0\xf0\x7f",
        ],
        bytes_max: 2000,
    },
    Target {
        name: "primary",
        about: "port 30001: programs framed the same in any pieces, bounded",
        check: primary::judge,
        render_input: as_they_are,
        seeds: || {
            let mut seeds = files_of(&["tests/scripts", "examples"], ".script");
            seeds.push(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n".to_vec());
            seeds.push(b"stop task\nsec a():\n  x = 1\nend\ndef b():\n  y = 2\nend\n".to_vec());
            seeds
        },
        words: &[
            b"\n",
            b"end\n",
            b"def f():\n",
            b"sec s():\n",
            b"  x = 1\n",
            b"\r\n",
            b"\0",
            b"stop task\n",
            b"POST ",
        ],
        bytes_max: 1000,
    },
    Target {
        name: "interpreter",
        about: "port 30020: statements and commands in any pieces, replies of one line",
        check: interpreter::judge,
        render_input: as_they_are,
        seeds: || {
            let mut seeds = files_of(&["tests/transcripts"], ".txt");
            seeds.push(
                b"clear_interpreter()\nskipbuffer\nx = 1\nstatelastexecuted\nabort\n".to_vec(),
            );
            seeds
        },
        words: &[
            b"\n",
            b"clear_interpreter()",
            b"skipbuffer",
            b"abort",
            b"end_interpreter()",
            b"\xff",
            b"def f():",
            b"GET ",
        ],
        bytes_max: 400,
    },
    Target {
        name: "query",
        about: "port 40011: questions read the same in any pieces, answers of one line",
        check: query::judge,
        render_input: as_they_are,
        seeds: || {
            let lines: [&[u8]; 3] = [
                b"req 1 get_actual_joint_positions()\nreq 2 get_inverse_kin([0,0,0,0,0,0])\r\n",
                b"req 5get_inverse_kin(x)\n req 18446744073709551615 a\nreq -1 b\n",
                b"req x y\nrequest 1 z\nreq 7 set_tcp([0, 0, 0.1, 0, 0, 0])\nreq 8",
            ];
            lines.map(<[u8]>::to_vec).to_vec()
        },
        words: &[
            b"req ",
            b"1",
            b" ",
            b"\n",
            b"\r",
            b"\t",
            b"_",
            b"[",
            b"]",
            b"\xc3\xa4",
        ],
        bytes_max: 300,
    },
    Target {
        name: "dashboard",
        about: "port 29999: every line has one reply that fits the SDK's read",
        check: dashboard::judge,
        render_input: as_they_are,
        seeds: || {
            let lines: [&[u8]; 4] = [
                b"help\nrobotMode\nplay\npause -p\nstop\n",
                b"loadTask a.task\nloadConfiguration b\ngetTaskPath\nspeed -v 50\n",
                b"popup -s hello\nlog a text\nunlockProtectiveStop\n",
                b"echo x\nstatus\nsafety -m\nversion\nquit\n",
            ];
            lines.map(<[u8]>::to_vec).to_vec()
        },
        words: &[
            b"-h",
            b"help ",
            b"-s ",
            b"\n",
            b"\r",
            b"\x1b[2J",
            b"task",
            b"load",
            b"..",
            b"\xc3\xa4",
        ],
        bytes_max: 300,
    },
    Target {
        name: "debugger",
        about: "the debugger: sessions of any messages, every answer is one",
        check: debugger::judge,
        render_input: as_they_are,
        seeds: debugger::seeds,
        words: &[
            b"Content-Length: 2\r\n\r\n{}",
            b"\r\n\r\n",
            b"\"arguments\":",
            b"\"command\":\"next\"",
            b"\"threadId\":",
            b"-1",
            b"99999999999",
            b"null",
            b"[]",
        ],
        bytes_max: 3000,
    },
    Target {
        name: "rtsi",
        about: "port 30004: packets, recipes and values of every type",
        check: rtsi::judge,
        render_input: as_they_are,
        seeds: || {
            let packet = |letter: u8, payload: &[u8]| {
                let length = u16::try_from(payload.len() + 3).unwrap_or(u16::MAX);
                [&length.to_be_bytes()[..], &[letter], payload].concat()
            };
            let recipe = b"speed_slider_mask,speed_slider_fraction,standard_digital_output_mask,input_int_register_24";
            vec![
                packet(b'V', &[0, 1]),
                packet(b'I', recipe),
                [packet(b'I', recipe), packet(b'U', &[1; 64])].concat(),
                packet(
                    b'O',
                    b"\x40\x5f\x40\0\0\0\0\0timestamp,actual_joint_positions,robot_mode",
                ),
                packet(b'M', b"\x05hello\x06source\x02"),
                packet(b'S', b""),
            ]
        },
        words: &[
            b"timestamp",
            b"input_double_register_47",
            b",",
            b"target_joint_positions",
            b"\x7f\xf8\0\0\0\0\0\0",
        ],
        bytes_max: 600,
    },
    Target {
        name: "opening",
        about: "first bytes on a port that speaks no HTTP: browsers stay out, nobody else loses a byte",
        check: opening::judge,
        render_input: as_they_are,
        seeds: || {
            let starts: [&[u8]; 7] = [
                b"GET / HTTP/1.1\r\nHost: x\r\n\r\n",
                b"\r\n post\t/x HTTP/1.0\r\n\r\n",
                b"propfind host:443 http/1.1\r\n",
                b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
                b"def move():\n  get = 1\nend\n",
                b"\0\x0aI\0a,b,c",
                b"\x16\x03\0\0\0\x06\x01\x03\0\0\0\x08",
            ];
            starts.map(<[u8]>::to_vec).to_vec()
        },
        words: &[
            b"GET ",
            b"get ",
            b"link ",
            b" / ",
            b"HTTP/",
            b"\r\n",
            b"\t",
            b"\x16\x03",
            b"HEAD",
            b"-",
            b"OPTIONS",
        ],
        bytes_max: 400,
    },
    Target {
        name: "http",
        about: "whole connections to the http port: only who calls this machine by its name gets in",
        check: http::judge,
        render_input: as_they_are,
        seeds: || {
            let requests: [&[u8]; 6] = [
                b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\nGET /metrics HTTP/1.1\r\nHost: 127.0.0.1:8080\r\n\
                  \r\n",
                b"GET http://evil.example/panel HTTP/1.1\r\nHost: evil.example\r\nOrigin: http://evil.example\r\n\r\n",
                b"GET /api/io HTTP/1.0\r\n\r\n",
                b"POST /api/inputs HTTP/1.1\r\nHost: [::1]:80\r\nContent-Type: application/json\r\n\
                  Content-Length: 13\r\n\r\n{\"DI0\": true}",
                b"POST /api/inputs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
                  Origin: http://localhost\r\nTransfer-Encoding: chunked\r\n\r\n6\r\n{\"DI0\"\r\n7\r\n: true}\r\n\
                  0\r\n\r\n",
                b"OPTIONS * HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nConnection: close\r\n\r\n",
            ];
            requests.map(<[u8]>::to_vec).to_vec()
        },
        words: &[
            b"\r\n",
            b"Host: ",
            b"localhost",
            b"evil.example",
            b"127.0.0.1",
            b"[::1]",
            b"@",
            b"%",
            b"Origin: null\r\n",
            b"Transfer-Encoding: chunked\r\n",
            b"Content-Length: 0\r\n",
            b"HTTP/1.1",
            b"HTTP/1.0",
            b"HTTP/2.0",
            b"/api/inputs",
            b"/healthz",
            b"..",
            b"ffffffff\r\n",
            b"application/json",
        ],
        bytes_max: 1500,
    },
    Target {
        name: "foxglove",
        about: "whole connections to the Foxglove port: handshakes, frames, messages; nothing is left of who is gone",
        check: foxglove::judge,
        render_input: as_they_are,
        seeds: || {
            let mut whole = foxglove::handshake();
            whole.extend(b"\x81\x8e\0\0\0\0{\"op\":\"other\"}\x89\x80\0\0\0\0\x01\x80\0\0\0\0\x88\x80\0\0\0\0");
            vec![
                whole,
                foxglove::handshake(),
                br#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":1},{"id":8,"channelId":6}]}
{"op":"unsubscribe","subscriptionIds":[7,8,100]}
{"op":"advertise","channels":[]}"#
                    .to_vec(),
            ]
        },
        words: &[
            b"\n",
            b"{",
            b"}",
            b"[",
            b"]",
            b"\"id\":",
            b"4294967295",
            b"-1",
            b"null",
            b"\"op\":\"subscribe\"",
            b"\x81\xff",
            b"\x82\xfe",
            b"\x01\x80\0\0\0\0",
            b"\x80\x80\0\0\0\0",
            b"Sec-WebSocket-",
            b"foxglove.websocket.v1",
            b"Host: evil.example\r\n",
            b"\xff",
        ],
        bytes_max: 1500,
    },
    Target {
        name: "http_inputs",
        about: "bodies of POST /api/inputs",
        check: http_inputs::judge,
        render_input: as_they_are,
        seeds: || {
            vec![
                br#"{"standard_digital_inputs": {"0": true, "7": false}, "analog": {"0": 4.5}}"#.to_vec(),
                concat!(
                    r#"{"DI0": true, "AI1": 0.5, "#,
                    r#""registers": {"int": {"3": -7}, "bool": {"64": true}, "double": {"1": 1e300}}}"#
                )
                .into(),
            ]
        },
        words: &[
            b"{", b"}", b"[", b"\"", b":", b",", b"null", b"1e999", b"-0", b"\"DI0\"", b"\\u0000",
            b"\xff",
        ],
        bytes_max: 800,
    },
    Target {
        name: "modbus_server",
        about: "the controller's own Modbus server: every message has an answer that is a message",
        check: modbus_server::judge,
        render_input: as_they_are,
        seeds: || {
            let frame = |pdu: &[u8]| [&[0, 1, 0, 0, 0, pdu.len() as u8 + 1, 1], pdu].concat();
            [
                &[1, 0, 0, 0, 8][..],
                &[3, 0, 0, 0, 125],
                &[5, 0, 1, 0xff, 0],
                &[6, 4, 0, 1, 2],
                &[15, 0, 0, 0, 9, 2, 1, 1],
                &[16, 0, 0, 0, 2, 4, 1, 2, 3, 4],
                &[23, 1, 0, 0, 1, 1, 0, 0, 1, 2, 1, 1],
                &[4, 0, 63, 0, 48],
                &[16, 0, 2, 0, 2, 4, 0, 3, 0, 100],
                &[6, 0, 17, 0, 50],
                &[22, 1, 0, 0, 0xf2, 0, 0x25],
                &[15, 0, 32, 0, 24, 3, 1, 1, 1],
            ]
            .map(frame)
            .to_vec()
        },
        words: &[],
        bytes_max: 600,
    },
    Target {
        name: "modbus_rtu",
        about: "what a serial line carries while a reply is waited for, and PDUs of replies",
        check: modbus_rtu::judge,
        render_input: as_they_are,
        seeds: || {
            vec![
                vec![1, 0, 2, 0, 1, 3, 4, 0, 1, 0, 2],
                vec![1, 8, 2, 0, 1, 5, 0, 7, 0xff, 0],
                vec![1, 0, 2, 0, 1, 0x83, 2],
            ]
        },
        words: &[],
        bytes_max: 300,
    },
    Target {
        name: "script_socket",
        about: "what a peer of a script's socket sends: numbers and texts, the same in any pieces",
        check: script_socket::judge,
        render_input: as_they_are,
        seeds: || {
            vec![
                b"\x07\x00\x03(1, 2.5, -3e4)\r\n(4,5,6)".to_vec(),
                b"\x02\x09\x06<hello>\r\n<<text>".to_vec(),
            ]
        },
        words: &[
            b"(", b")", b",", b"nan", b"1e999", b"-", b"\r\n", b"<", b">", b"GET ",
        ],
        bytes_max: 400,
    },
    Target {
        name: "xmlrpc",
        about: "answers of an XML-RPC server; what came in can go out",
        check: xmlrpc::judge,
        render_input: as_they_are,
        seeds: || {
            let value = |value: &str| {
                format!("<?xml version='1.0'?><methodResponse><params><param><value>{value}</value></param></params>\
                         </methodResponse>").into_bytes()
            };
            vec![
                value("<int>5</int>"),
                value("<array><data><value><double>1.5</double></value><value>text</value></data></array>"),
                value("<struct><member><name>a</name><value><boolean>1</boolean></value></member></struct>"),
                value("<base64>aGVsbG8=</base64>"),
                b"<methodResponse><fault><value><struct><member><name>faultCode</name><value><int>4</int></value>\
                 </member><member><name>faultString</name><value><string>no</string></value></member></struct></value>\
                 </fault></methodResponse>".to_vec(),
            ]
        },
        words: &[
            b"<value>",
            b"</value>",
            b"<array><data>",
            b"<struct>",
            b"<i4>",
            b"<nil/>",
            b"&lt;",
            b"&#x0;",
            b"<![CDATA[",
            b"<!ENTITY a 'b'>",
            b"<!--",
        ],
        bytes_max: 1200,
    },
];
