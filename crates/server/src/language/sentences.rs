//! Sentences of commands in Chinese, in the order of the English ones. A test holds them against the source.

/// Refusals, findings and results.
pub(super) const SENTENCES: &[(&str, &str)] = &[
    ("# Translation of {}", "# {0} 的翻译"),
    ("## {}", "## {0~}"),
    (
        "$INSUNITS {} is no unit that is driven",
        "$INSUNITS {0} 不是可用的单位",
    ),
    ("'{}' alone is no statement", "单独的 '{0}' 不是语句"),
    (
        "'{}' is no group code of a DXF file",
        "'{0}' 不是 DXF 文件的组码",
    ),
    ("'{}' is no number", "'{0}' 不是数"),
    ("'{}' is not understood", "不理解 '{0}'"),
    (
        "--clock: time is always simulated here",
        "--clock：这里时间总是仿真的",
    ),
    (
        "--from {} s is later than --to {} s: nothing lies between",
        "--from {0} s 晚于 --to {1} s：其间没有内容",
    ),
    (
        "--keep {}-{}: the last line of {} is {}",
        "--keep {0}-{1}：{2} 的最后一行是第 {3} 行",
    ),
    (
        "--layer is for drawings (.dxf): other files have no layers",
        "--layer 用于图纸（.dxf）：其他文件没有图层",
    ),
    (
        "--local and --control {} contradict each other: leave one of them out",
        "--local 与 --control {0} 相矛盾：请去掉其中一个",
    ),
    (
        "--log-dir: no log files are written",
        "--log-dir：这里不写日志文件",
    ),
    (
        "--payload {} kg is more than the {} kg that {} is rated for",
        "--payload {0} kg 超过 {2} 的额定负载 {1} kg",
    ),
    (
        "--plant: the arm is always ideal here, so that the path is measured",
        "--plant：这里机械臂总是理想的，以便测量路径",
    ),
    (
        "--record: nothing is recorded; run --record does",
        "--record：这里不作记录；请用 run --record",
    ),
    (
        "--ros-peers names {} machines, allowed are 1 to {}",
        "--ros-peers 给出了 {0} 台机器，允许 1 到 {1} 台",
    ),
    (
        "--ros2-profile makes a bag of one recording: leave --record-rotate out",
        "--ros2-profile 由一个记录生成 bag：请去掉 --record-rotate",
    ),
    (
        "--ros2-profile writes a bag beside the recording: give --record FILE as well",
        "--ros2-profile 在记录旁写入 bag：请同时给出 --record 文件",
    ),
    ("--ros2: {}", "--ros2：{0~}"),
    ("--set {}: {}", "--set {0}：{1~}"),
    (
        "--set: the file is a secondary program, which has no globals of its own",
        "--set：该文件是次级程序，没有自己的全局变量",
    ),
    (
        "--units is for tables (.csv): G-code and drawings say their unit themselves",
        "--units 用于表格（.csv）：G 代码和图纸自带单位",
    ),
    ("1 core may be used", "可用 1 个核心"),
    ("1 to {} Hz are allowed", "允许 1 到 {0} Hz"),
    (": {} line {}", "：{0} 第 {1} 行"),
    (
        ":log takes how many lines, as :log 100",
        ":log 后面是行数，如 :log 100",
    ),
    (":{} takes nothing behind it", ":{0} 后面不能有内容"),
    ("Everything has a counterpart.", "全部都有对应。"),
    (
        "NAME=VALUE is needed, as speed=0.25",
        "需要 NAME=VALUE，如 speed=0.25",
    ),
    ("Open a shell on", "打开交互会话，连接"),
    ("POLYLINE is a mesh: left out", "POLYLINE 是网格：已略去"),
    (
        "POLYLINE lies in a tilted plane: left out",
        "POLYLINE 位于倾斜平面内：已略去",
    ),
    ("Send {} to", "把 {0} 发送到"),
    (
        "Statements are carried out at once. :help lists the shell's own orders, :quit ends.",
        "语句立即执行。:help 列出本程序的命令，:quit 退出。",
    ),
    (
        "TimeoutError: no simulated time passed for {} s: the program computes without waiting",
        "TimeoutError: {0} s 内没有仿真时间经过：程序只计算不等待",
    ),
    (
        "TimeoutError: the program had not ended after {} s",
        "TimeoutError: 程序在 {0} s 后没有结束",
    ),
    ("URScript has no character '{}'", "URScript 没有字符 '{0}'"),
    (
        "[[actuator]] \"{}\": the physics engine refused its joint",
        "[[actuator]] \"{0}\"：物理引擎拒绝了它的关节",
    ),
    (
        "[[part]] \"{}\": pose overlaps \"{}\" by {} m, allowed: poses in which parts do not overlap",
        "[[part]] \"{0}\"：位姿与 \"{1}\" 重叠 {2} m，只允许工件不重叠的位姿",
    ),
    (
        "[[{}]] \"{}\": {} is {}, allowed: an input that nothing else drives (\"{}\" drives it)",
        "[[{0}]] \"{1}\"：{2} 为 {3}，应为没有其他驱动的输入（\"{4}\" 在驱动它）",
    ),
    (
        "[[{}]] \"{}\": {} is {}, allowed: {}",
        "[[{0}]] \"{1}\"：{2} 为 {3}，允许：{4~}",
    ),
    (
        "[[{}]] \"{}\": {} names \"{}\", allowed: the name of {}",
        "[[{0}]] \"{1}\"：{2} 指向 \"{3}\"，允许{4~}的名称",
    ),
    (
        "[[{}]]: name is \"{}\", allowed: names that nothing else has ([[{}]] has it)",
        "[[{0}]]：名称为 \"{1}\"，不允许重名（[[{2}]] 已用此名称）",
    ),
    (
        "[[{}]]: {} entries, allowed: up to {}",
        "[[{0}]]：有 {1} 项，最多允许 {2} 项",
    ),
    (
        "`bind` is {}; an IP address is needed",
        "`bind` 为 {0}；需要 IP 地址",
    ),
    (
        "`eliteserver plan` finds a way around; what may touch is named by [[touch]] in the cell file",
        "`eliteserver plan` 可求绕行的路径；允许接触的物体在单元文件的 [[touch]] 中给出",
    ),
    ("`http-port` is {}; {}", "`http-port` 为 {0}；{1~}"),
    (
        "`record` in [defaults] can only be \"off\": without it every robot records into a folder of its own",
        "[defaults] 中的 `record` 只能是 \"off\"：不写时每个机器人记录到自己的文件夹",
    ),
    (
        "`size` is a length in m or a list of lengths",
        "`size` 是以 m 为单位的长度或长度的列表",
    ),
    ("`trust-host` has {}; {}", "`trust-host` 中有 {0}；{1~}"),
    (
        "`trust-host` is {}; a list of names is needed",
        "`trust-host` 为 {0}；需要名称列表",
    ),
    (
        "`value` is true, false or a number",
        "`value` 是 true、false 或数",
    ),
    (
        "`{}` belongs to a robot, not to [defaults]",
        "`{0}` 属于单个机器人，不属于 [defaults]",
    ),
    (
        "`{}` has no number: it is `{}`",
        "`{0}` 没有序号：应为 `{1}`",
    ),
    ("`{}` is given twice", "`{0}` 给出了两次"),
    (
        "`{}` is no input or output; names are like standard_digital_in[0], configurable_digital_out[7], tool_digital_in[0], standard_analog_out[1], tool_analog_in, input_float_register[0]",
        "`{0}` 不是输入或输出；名称如 standard_digital_in[0]、configurable_digital_out[7]、tool_digital_in[0]、standard_analog_out[1]、tool_analog_in、input_float_register[0]",
    ),
    (
        "`{}` needs a number from 0 to {}, as in {}[0]",
        "`{0}` 需要 0 到 {1} 的序号，如 {2}[0]",
    ),
    (
        "a GLB has a head of 12 bytes; there are {}",
        "GLB 的文件头为 12 字节；这里只有 {0} 字节",
    ),
    ("a POLYLINE has no SEQEND", "POLYLINE 没有 SEQEND"),
    (
        "a [[serial]] has this line already",
        "已有 [[serial]] 使用此串口",
    ),
    ("a beam has from and until", "光束有 from 和 until"),
    (
        "a belt that carries has pose, size and direction, a turntable center and radius",
        "运送工件的皮带有 pose、size 和 direction，转台有 center 和 radius",
    ),
    ("a block has at most {} KiB", "一个块最多 {0} KiB"),
    ("a box needs x, y, z", "长方体需要 x、y、z"),
    (
        "a bus is needed: \"tool\", \"masterboard\" or \"tcp:PORT\"",
        "需要总线：\"tool\"、\"masterboard\" 或 \"tcp:端口\"",
    ),
    ("a chunk cannot be unpacked: {}", "无法解压块：{0~}"),
    ("a chunk ends within a record", "块在记录项中间结束"),
    ("a chunk has no header", "块没有头部"),
    (
        "a chunk holds a record of kind {}, which has no place in a chunk",
        "块中有类型 {0} 的记录项，它不应在块中",
    ),
    (
        "a chunk is longer than the file",
        "有一个数据块超出文件末尾",
    ),
    (
        "a chunk says that it has {} bytes and has {}",
        "块声明有 {0} 字节，实际有 {1}",
    ),
    (
        "a collision shape of the URDF link `{}` {}",
        "URDF 连杆 `{0}` 的碰撞形状{1~}",
    ),
    ("a condition cannot start threads", "条件不能启动线程"),
    (
        "a conveyor is linear, with direction and ticks_per_meter, or circular, with center and ticks_per_revolution",
        "传送带为直线型（direction 和 ticks_per_meter）或圆周型（center 和 ticks_per_revolution）",
    ),
    (
        "a conveyor that carries needs one",
        "运送工件的传送带需要给出它",
    ),
    (
        "a conveyor turns an encoder, or carries parts",
        "传送带应带动编码器或运送工件",
    ),
    (
        "a corner is at ({}, {}, {}); allowed are finite numbers",
        "顶点位于 ({0}, {1}, {2})；只允许有限的数",
    ),
    ("a cycle of the recording: {}", "记录中的一个周期：{0~}"),
    ("a cylinder needs radius, length", "圆柱需要半径和长度"),
    (
        "a device or pty path or tcp:host:port is needed",
        "需要设备或 pty 的路径，或 tcp:host:port",
    ),
    ("a direction is needed", "需要一个方向"),
    ("a distance has pose and range", "测距有 pose 和 range"),
    (
        "a face has more than {} corners, the most that is allowed",
        "一个面的顶点超过 {0} 个，即允许的上限",
    ),
    (
        "a face has {} corners; allowed are 3 to {}",
        "一个面有 {0} 个顶点；允许 3 至 {1} 个",
    ),
    (
        "a face names point {}; before this line there are {} points, from 1 or, backwards, from -1",
        "一个面引用点 {0}；此行之前有 {1} 个点，从 1 起编号，倒数则从 -1 起",
    ),
    ("a fault of the controller: {}", "控制器的缺陷：{0}"),
    (
        "a feed of {}: allowed is more than 0",
        "进给为 {0}：必须大于 0",
    ),
    ("a floor", "地面"),
    ("a function has one pair of inputs", "一个功能只有一对输入"),
    (
        "a gripper with protocol has no points",
        "带 protocol 的夹爪没有输入输出点",
    ),
    (
        "a line of more than 64 KiB is no statement",
        "超过 64 KiB 的一行不是语句",
    ),
    (
        "a linear one has axis and stroke",
        "直线型有 axis 和 stroke",
    ),
    ("a list of {} is needed", "需要{0~}的列表"),
    (
        "a mass from 0 to 1000 kg is needed, then perhaps the centre of gravity in m, up to 10, as in 2.5 or 2.5,0,0,0.08, then perhaps six numbers of inertia in kg m²",
        "需要 0 到 1000 kg 的质量，之后可给出重心（m，不超过 10），如 2.5 或 2.5,0,0,0.08，再之后可给出六个惯量（kg m²）",
    ),
    (
        "a mesh has the size of its file; scale changes it",
        "网格的大小取自其文件；用 scale 改变",
    ),
    (
        "a mesh needs a file: .stl, .obj, .gltf or .glb, beside the cell file or in a folder there",
        "网格需要文件：.stl、.obj、.gltf 或 .glb，与单元文件同在一处或在其下的文件夹中",
    ),
    (
        "a message is of channel {}, which is not declared",
        "消息属于未声明的通道 {0}",
    ),
    ("a message of the bag: {}", "bag 的消息：{0~}"),
    (
        "a metadata record has {} bytes; at most {} are read",
        "元数据项有 {0} 字节；最多读取 {1} 字节",
    ),
    ("a name as \"cs66\" is needed", "需要如 \"cs66\" 的名称"),
    ("a number >= 0 is needed", "需要不小于 0 的数"),
    ("a number is needed", "需要一个数"),
    ("a number of rad is needed", "需要以 rad 为单位的数"),
    (
        "a number of seconds above 0 is needed, at most 1e9",
        "需要大于 0、不超过 1e9 的秒数",
    ),
    (
        "a packet of {} bytes; the shortest has {}",
        "{0} 字节的数据包；最短为 {1} 字节",
    ),
    (
        "a path was found, but driven it does not keep the margin",
        "找到了路径，但执行时不能保持间隙",
    ),
    (
        "a path was found, but driven it does not keep the margin{}; a smaller --margin may help",
        "找到了路径，但执行时不能保持间隙{0~}；减小 --margin 也许有用",
    ),
    (
        "a path was found, but the controller does not drive it: {}",
        "找到了路径，但控制器不执行它：{0~}",
    ),
    (
        "a pause of {} s: allowed are 0 to 3600",
        "暂停 {0} s：允许 0 到 3600",
    ),
    ("a plane has no size", "平面没有尺寸"),
    (
        "a point is at ({}, {}, {}) times {}; allowed are finite numbers",
        "点位于 ({0}, {1}, {2})，再乘以 {3}；只允许有限的数",
    ),
    ("a point with levels is needed", "需要一个数字点"),
    (
        "a pose has six numbers, and this one {}",
        "位姿有六个数，而这里有 {0} 个",
    ),
    ("a presence has pose and size", "存在检测有 pose 和 size"),
    ("a primitive has no POSITION", "有一个图元没有 POSITION"),
    (
        "a primitive has {} corners, which are no whole triangles",
        "有一个图元有 {0} 个顶点，凑不成完整的三角形",
    ),
    (
        "a program is running; stop it first, or let it run to its end",
        "程序正在运行；请先停止它，或让它运行到结束",
    ),
    (
        "a program runs on the robot at {}; the shell would take its place. Stop it first",
        "机器人 {0} 上正在运行程序，交互会话会取代它。请先停止该程序",
    ),
    (
        "a radius of {} m: allowed is more than 0",
        "半径为 {0} m：必须大于 0",
    ),
    (
        "a record is longer than the chunk it is in",
        "记录项比所在的块长",
    ),
    ("a record is not what its kind says", "记录项与其类型不符"),
    (
        "a record of kind {} ends within one of its texts",
        "类型 {0} 的记录项在文本中间结束",
    ),
    (
        "a rotary one has axis, point and angle",
        "旋转型有 axis、point 和 angle",
    ),
    (
        "a schema or a channel has {} bytes; at most {} are read",
        "结构定义或通道有 {0} 字节；最多读取 {1} 字节",
    ),
    ("a sphere needs its radius", "球需要半径"),
    (
        "a spline has neither control points nor two fit points that differ",
        "样条曲线既没有控制点，也没有两个不同的拟合点",
    ),
    (
        "a spline of degree {} with {} control points has {} knots, and this one {}",
        "{0} 次、{1} 个控制点的样条曲线有 {2} 个节点，而此曲线有 {3} 个",
    ),
    (
        "a spline of degree {}: allowed are 1 to {}",
        "样条曲线的次数为 {0}：允许 1 到 {1}",
    ),
    (
        "a table with a, d, alpha and optionally theta is needed",
        "需要含有 a、d、alpha 和可选 theta 的表",
    ),
    (
        "a text like \"#3a7f00\" is needed",
        "需要如 \"#3a7f00\" 的文本",
    ),
    (
        "a text of 1 to {} characters in one line is needed",
        "需要一行 1 到 {0} 个字符的文本",
    ),
    (
        "a text over several lines cannot stand in a block: the port takes one line",
        "多行文本不能放在块中：端口只接收一行",
    ),
    (
        "a text that is not checked is sent as it is; leave --no-check out",
        "不检查的文本按原样发送；请去掉 --no-check",
    ),
    (
        "a text, a number or a list of them is needed",
        "需要文本、数或它们的列表",
    ),
    ("a tool on the flange", "法兰上的工具"),
    (
        "a value is an expression such as 0.25, [1, 2] or \"text\", the quotes included",
        "值是表达式，如 0.25、[1, 2] 或 \"text\"（包括引号）",
    ),
    (
        "a weight of a spline is not above 0",
        "样条曲线有不大于 0 的权重",
    ),
    (
        "a {} has {} bytes; at most {} are read at once",
        "{0} 有 {1} 字节；一次最多读取 {2} 字节",
    ),
    (
        "about {} records and {} bytes of messages wait unwritten, {} messages were dropped, and what comes last in the file may be incomplete",
        "约有 {0} 条记录和 {1} 字节的消息尚未写入，丢弃了 {2} 条消息，文件末尾的内容可能不完整",
    ),
    (
        "all {} points are reached at least {} mm from everything, {} rad from the ends of the joints' ranges, in {} s from first to last",
        "全部 {0} 个点都可到达，与所有物体至少相距 {1} mm，距关节范围的边界 {2} rad，从第一点到最后一点 {3} s",
    ),
    (
        "all {} points are reached {} rad from the ends of the joints' ranges, in {} s from first to last",
        "全部 {0} 个点都可到达，距关节范围的边界 {1} rad，从第一点到最后一点 {2} s",
    ),
    (
        "allow it: LimitMEMLOCK=infinity in a systemd unit, 'USER - memlock unlimited' in /etc/security/limits.conf, or --ulimit memlock=-1 of a container",
        "请允许：systemd 单元中 LimitMEMLOCK=infinity，/etc/security/limits.conf 中 'USER - memlock unlimited'，或容器的 --ulimit memlock=-1",
    ),
    (
        "allow it: LimitRTPRIO=99 in a systemd unit, 'USER - rtprio 99' in /etc/security/limits.conf, or --cap-add SYS_NICE of a container",
        "请允许：systemd 单元中 LimitRTPRIO=99，/etc/security/limits.conf 中 'USER - rtprio 99'，或容器的 --cap-add SYS_NICE",
    ),
    (
        "allowed are \"tool\", \"masterboard\" and \"tcp:PORT\" with a port from 1 to 65535",
        "允许 \"tool\"、\"masterboard\" 和 \"tcp:端口\"，端口为 1 到 65535",
    ),
    ("allowed are -{} to {}", "允许 -{0} 到 {1}"),
    ("allowed are 0 and 1", "允许 0 和 1"),
    ("allowed are 0 to 3", "允许 0 到 3"),
    ("allowed are 0 to {}", "允许 0 到 {0}"),
    ("allowed are 0 to {} s", "允许 0 到 {0} s"),
    (
        "allowed are 0.1 to 1000 messages a second",
        "允许每秒 0.1 到 1000 条消息",
    ),
    ("allowed are 1 to 123", "允许 1 到 123"),
    ("allowed are 1 to 247", "允许 1 到 247"),
    ("allowed are 1 to {}", "允许 1 至 {0}"),
    (
        "allowed are a host name or an IP address, without a port",
        "允许主机名或 IP 地址，不带端口",
    ),
    (
        "allowed are a line from 1, or the first and the last one, as in 12-30",
        "允许从 1 数起的行号，或首行和末行，如 12-30",
    ),
    (
        "allowed are a port from 1 to 65535, 0 for any free port, and off",
        "允许 1 到 65535 的端口、0（任一空闲端口）和 off",
    ),
    (
        "allowed are box, cylinder, sphere and mesh",
        "允许 box、cylinder、sphere 和 mesh",
    ),
    ("allowed are en and zh", "允许 en 和 zh"),
    (
        "allowed are factors from 0.001 to 1000",
        "允许 0.001 到 1000 的系数",
    ),
    (
        "allowed are fastdds and cyclonedds",
        "允许 fastdds 和 cyclonedds",
    ),
    (
        "allowed are fs, fs=DIR, process, env, net and net=played",
        "允许 fs、fs=DIR、process、env、net 和 net=played",
    ),
    (
        "allowed are numbers above 0, up to 1000{}",
        "允许大于 0、不超过 1000{0} 的数",
    ),
    (
        "allowed are numbers from 0.01 to 100; 1 is as recorded",
        "允许 0.01 到 100 的数；1 为记录时的速度",
    ),
    ("allowed are numbers from 0.05 to 1", "允许 0.05 到 1 的数"),
    (
        "allowed are numbers from {} to {} {}",
        "允许 {0} 到 {1} {2} 的数",
    ),
    (
        "allowed are off and the path of a file to write",
        "允许 off 和要写的文件的路径",
    ),
    (
        "allowed are realtime and virtual",
        "允许 realtime 和 virtual",
    ),
    (
        "allowed are remote, local and mixed",
        "允许 remote、local 和 mixed",
    ),
    (
        "allowed are rigid, rapier and ideal",
        "允许 rigid、rapier 和 ideal",
    ),
    (
        "allowed are seconds above 0, up to {}",
        "允许大于 0、不超过 {0} 秒",
    ),
    ("allowed are seconds from 0 to 86400", "允许 0 到 86400 秒"),
    (
        "allowed are sizes from 1 MB and times from 1 s to a year, as in 500MB, 2GB, 90s, 30min or 8h",
        "允许 1 MB 以上的大小和 1 s 到一年的时间，如 500MB、2GB、90s、30min 或 8h",
    ),
    (
        "allowed are sizes from 1 MB, as in 500MB, 20GB or 4GiB",
        "允许 1 MB 以上的大小，如 500MB、20GB 或 4GiB",
    ),
    ("allowed are text and json", "允许 text 和 json"),
    ("allowed are true and false", "允许 true 和 false"),
    (
        "allowed are whole milliseconds from 1 to 8",
        "允许 1 到 8 的整毫秒数",
    ),
    ("allowed are whole numbers from 0", "允许不小于 0 的整数"),
    (
        "allowed are whole numbers from 0 to 65535",
        "允许 0 到 65535 的整数",
    ),
    (
        "allowed are {} or the path of a URDF file (with a `/` in it, or ending in .urdf)",
        "允许 {0} 或 URDF 文件的路径（含有 `/`，或以 .urdf 结尾）",
    ),
    ("allowed is an IP address", "允许 IP 地址"),
    ("an analog input is needed", "需要一个模拟输入"),
    ("an analog output is needed", "需要一个模拟输出"),
    (
        "an answer of {}() is longer than {} bytes",
        "{0}() 的一个回答超过 {1} 字节",
    ),
    (
        "an arc needs a centre (I, J, K) or a radius (R)",
        "圆弧需要圆心（I、J、K）或半径（R）",
    ),
    (
        "an arc of radius {} mm cannot be driven",
        "半径 {0} mm 的圆弧无法执行",
    ),
    (
        "an arc of radius {} mm cannot reach a point {} mm away",
        "半径 {0} mm 的圆弧到不了 {1} mm 外的点",
    ),
    (
        "an arc with R must end somewhere else",
        "用 R 的圆弧，终点必须不同于起点",
    ),
    ("an array of at most {} elements", "最多 {0} 个元素的数组"),
    ("an ellipse without a plane", "椭圆没有平面"),
    ("an ellipse without a size", "椭圆没有尺寸"),
    ("an input is needed", "需要一个输入"),
    (
        "an input takes one wire, this one has wire {}",
        "一个输入只接一条线，此输入已有接线 {0}",
    ),
    ("an input with levels is needed", "需要一个数字输入"),
    ("an item has one index, or two", "元素有一个或两个下标"),
    (
        "an output close or open is needed",
        "需要输出 close 或 open",
    ),
    ("an output is needed", "需要一个输出"),
    ("and {} more", "还有 {0} 项"),
    ("at most {} of them are simulated", "最多仿真 {0} 个"),
    ("at {}:{}:{}", "位于 {0}:{1}:{2}"),
    (
        "blocks and brackets lie more than {} deep",
        "块和括号嵌套超过 {0} 层",
    ),
    (
        "boot with clocksource=tsc tsc=reliable where the processor has an invariant counter",
        "处理器有恒定计数器时，以 clocksource=tsc tsc=reliable 启动系统",
    ),
    (
        "break takes a line, the name of a function, or 'when' and a condition of the arm",
        "break 后面是行号、函数名，或 'when' 和机械臂的条件",
    ),
    (
        "cannot create the recording {}: {}",
        "无法创建记录 {0}：{1}",
    ),
    (
        "cannot open port {} for the grippers of the cell file: {}",
        "无法为单元文件的夹爪打开端口 {0}：{1~}",
    ),
    ("cannot read the bag {}: {}", "无法读取 bag {0}：{1~}"),
    (
        "cannot read the calibration file {}: {}",
        "无法读取标定文件 {0}：{1~}",
    ),
    (
        "cannot read the cell file {}: {}",
        "无法读取单元文件 {0}：{1~}",
    ),
    (
        "cannot read the configuration file {}: {}",
        "无法读取配置文件 {0}：{1~}",
    ),
    (
        "cannot read the fleet {}: {}",
        "无法读取机器人组文件 {0}：{1~}",
    ),
    ("cannot read the model {}: {}", "无法读取型号 {0}：{1~}"),
    ("cannot read the points {}: {}", "无法读取点文件 {0}：{1~}"),
    ("cannot read the script {}: {}", "无法读取脚本 {0}：{1~}"),
    ("cannot read {}: {}", "无法读取 {0}：{1~}"),
    ("cannot record: {}", "无法记录：{0~}"),
    (
        "cannot remove the old ready file {}: {}",
        "无法删除旧的就绪文件 {0}：{1~}",
    ),
    (
        "cannot remove the ready file {}: {}",
        "无法删除就绪文件 {0}：{1~}",
    ),
    ("cannot start a thread: {}", "无法启动线程：{0~}"),
    (
        "cannot start the recorder's thread: {}",
        "无法启动记录线程：{0}",
    ),
    ("cannot start: {}", "无法启动：{0~}"),
    ("cannot use the model {}: {}", "无法使用型号 {0}：{1~}"),
    ("cannot write the answer: {}", "无法写出回答：{0~}"),
    ("cannot write the bag: {}", "无法写入 bag：{0~}"),
    (
        "cannot write the calibration file {}: {}",
        "无法写入标定文件 {0}：{1~}",
    ),
    ("cannot write the picture {}: {}", "无法写入图片 {0}：{1~}"),
    (
        "cannot write the ready file {}: {}",
        "无法写入就绪文件 {0}：{1~}",
    ),
    (
        "cannot write the recording {}: the disk takes nothing",
        "无法写入记录 {0}：磁盘不接受数据",
    ),
    (
        "cannot write the recording {}: {}",
        "无法写入记录 {0}：{1~}",
    ),
    ("cannot write {}: {}", "无法写入 {0}：{1~}"),
    (
        "choose another place with --record, or --record off",
        "用 --record 选择其他位置，或用 --record off",
    ),
    (
        "choose one from 1024 on with {}, or allow it: AmbientCapabilities=CAP_NET_BIND_SERVICE",
        "用 {0} 选择 1024 以上的端口，或允许：AmbientCapabilities=CAP_NET_BIND_SERVICE",
    ),
    (
        "ci_pair is {}, it must be 0 to 3 (CI0/1, CI2/3, CI4/5, CI6/7)",
        "ci_pair 为 {0}，应为 0 到 3（CI0/1、CI2/3、CI4/5、CI6/7）",
    ),
    (
        "clearance() needs the arm and its cell, which are not known here",
        "clearance() 需要机械臂及其单元，这里不知道",
    ),
    (
        "command {} cannot be given again: {}",
        "命令 {0} 不能再次发出：{1~}",
    ),
    (
        "command {} is missing in the recording, command {} comes in its place",
        "记录中缺少命令 {0}，其位置上是命令 {1}",
    ),
    (
        "command {}, a moveml, cannot be given again: {}",
        "命令 {0}（moveml）不能再次发出：{1~}",
    ),
    ("command: none", "命令：无"),
    ("command: {} {}", "命令：{0} {1}"),
    (
        "command: {} {} ({} line {})",
        "命令：{0} {1}（{2} 第 {3} 行）",
    ),
    ("commands: {}{}", "命令：{0}{1}"),
    ("connected again", "已重新连接"),
    ("copies need their distances", "copies 需要间距"),
    (
        "cpupower frequency-set -g performance: a core that has slowed down wakes up late",
        "cpupower frequency-set -g performance：降频的核心唤醒较晚",
    ),
    ("cups need their radius, m", "吸盘需要半径，m"),
    (
        "cycle time {} s before, {} s after: {} % shorter (simulated runs: {})",
        "节拍由 {0} s 变为 {1} s：缩短 {2} %（仿真运行 {3} 次）",
    ),
    (
        "cycle {}: the motion generator {} is not known to this version",
        "周期 {0}：此版本不认识运动生成器 {1}",
    ),
    (
        "cycle {}: {} has {} elements, it needs {}",
        "周期 {0}：{1} 有 {2} 个元素，需要 {3} 个",
    ),
    ("cycles: {}", "周期：{0}"),
    (
        "defaults must be a table, [defaults]",
        "defaults 应为表 [defaults]",
    ),
    (
        "delete takes the number that break shows",
        "delete 后面是 break 显示的编号",
    ),
    ("different: {} of {} cycles", "不同：{1} 个周期中的 {0} 个"),
    ("discarded: {}", "已丢弃：{0}"),
    ("drop the statements that wait", "丢弃等待中的语句"),
    ("duration: {} s", "时长：{0} s"),
    ("either at or when is needed", "需要 at 或 when 之一"),
    ("either every or when is needed", "需要 every 或 when 之一"),
    (
        "either mass or density is needed",
        "需要 mass 或 density 之一",
    ),
    (
        "end it ('ss -ltnp sport = :{}' names it), or choose another with {}",
        "结束该程序（'ss -ltnp sport = :{0}' 可查），或用 {1} 选择其他端口",
    ),
    (
        "end, once everything before is done (Ctrl-D as well)",
        "前面的语句都完成后退出（也可按 Ctrl-D）",
    ),
    ("ending: complete", "结尾：完整"),
    (
        "ending: cut, the recorder was killed or is still writing; readable up to {} s, the last complete chunk",
        "结尾：不完整，记录程序被中止或仍在写入；可读到 {0} s，即最后一个完整的块",
    ),
    (
        "ending: damaged ({}); readable up to {} s, the last chunk before that",
        "结尾：损坏（{0~}）；可读到 {1} s，即此前的最后一个块",
    ),
    ("errors: {}", "错误：{0}"),
    (
        "every obstacle needs a name of its own",
        "每个障碍物需要各自的名称",
    ),
    (
        "every plane needs a name of its own",
        "每个平面需要各自的名称",
    ),
    (
        "every robot is a table, [[robot]]",
        "每个机器人应为表 [[robot]]",
    ),
    (
        "every way to bring the TCP to {} needs a joint beyond its range",
        "使 TCP 到达 {0} 的每种方式都会有关节超出范围",
    ),
    ("finite numbers are needed", "需要有限的数"),
    (
        "first difference at cycle {} ({} s): {}",
        "首个差异在周期 {0}（{1} s）：{2~}",
    ),
    (
        "first difference at cycle {}: {} (recorded and rerun)",
        "首个差异在周期 {0}：{1~}（记录与重新运行）",
    ),
    (
        "first difference of the programs: {}",
        "程序的首个差异：{0~}",
    ),
    (
        "first s     last s   times    spent s   line",
        "首次 s     末次 s    次数     用时 s     行",
    ),
    (
        "first s     last s   times    spent s   node",
        "首次 s     末次 s    次数     用时 s   节点",
    ),
    ("force mode: {}", "力控模式：{0~}"),
    ("found {} where {} is needed", "此处应为 {1}，却是{0~}"),
    (
        "found: 1 time, {} of {} cycles",
        "找到 1 次，{1} 个周期中的 {0} 个",
    ),
    (
        "found: {} times, {} of {} cycles",
        "找到 {0} 次，{2} 个周期中的 {1} 个",
    ),
    (
        "four numbers in m are needed, least and largest x, least and largest y, as in -1,1,-0.5,0.5",
        "需要四个以 m 为单位的数：最小和最大 x、最小和最大 y，如 -1,1,-0.5,0.5",
    ),
    (
        "four or more rests at one point are needed, the data has {}",
        "需要在同一点的四个以上静止段，数据中有 {0} 个",
    ),
    (
        "fs= needs a folder, fs=/data for instance",
        "fs= 需要一个文件夹，例如 fs=/data",
    ),
    (
        "give it two: the control cycle shares the one with every program and every client",
        "请给两个：否则控制周期要与所有程序和客户端共用一个核心",
    ),
    ("goal_in_collision: {}", "终点碰撞：{0~}"),
    (
        "goto takes a cycle or a time: goto 541, goto 2.1 s",
        "goto 后面是周期或时间：goto 541，goto 2.1 s",
    ),
    (
        "gripper {} has this number on the bus already",
        "夹爪 {0} 已在此总线上使用该号码",
    ),
    ("here is {} and not {}", "这里是{0~}，而不是{1~}"),
    (
        "home puts joint {} at {} rad, allowed is {} to {} rad",
        "home 使关节 {0} 位于 {1} rad，允许 {2} 到 {3} rad",
    ),
    (
        "how the robot is, and which statement it is at",
        "机器人的状态，以及执行到哪条语句",
    ),
    ("identical: {} cycles", "相同：{0} 个周期"),
    (
        "identical: {} programs, {} commands",
        "相同：{0} 个程序，{1} 个命令",
    ),
    ("in node {}", "节点 {0}"),
    (
        "indices of triangles must have a bufferView and nothing sparse",
        "三角形的索引必须有 bufferView，且不得有 sparse",
    ),
    (
        "interpreter mode of the robot at {}",
        "机器人 {0} 的解释器模式",
    ),
    (
        "is the address of --bind one of this machine's?",
        "--bind 的地址是本机的吗？",
    ),
    (
        "it calls {}() where {}() was recorded",
        "调用了 {0}()，记录中为 {1}()",
    ),
    ("it can be locked", "可以锁定"),
    ("it cannot be started: {}", "无法启动：{0~}"),
    ("it cannot be waited for: {}", "无法等待其结束：{0~}"),
    ("it does not define {}", "没有定义 {0}"),
    (
        "it ended ({}); its log says why",
        "已结束（{0~}）；原因见其日志",
    ),
    (
        "it gives {} after cycle {}, which took it in the recording",
        "在周期 {1} 之后才发出 {0}，记录中该周期已取走它",
    ),
    (
        "it gives {} where {} of line {} was recorded",
        "发出了 {0}，记录中为第 {2} 行的 {1}",
    ),
    (
        "it gives {} with other arguments than recorded: {}, not {}",
        "发出的 {0} 参数与记录不同：{1}，而不是 {2}",
    ),
    (
        "it gives {}, and nothing more was recorded of it",
        "发出了 {0}，记录中此后没有它的内容",
    ),
    (
        "it goes on where it had ended when it was recorded",
        "记录中已结束，这里却继续运行",
    ),
    (
        "it goes with a surface: pose and size of a belt, radius of a turntable",
        "它需要有表面：皮带的位姿和尺寸，或转台的半径",
    ),
    ("it goes with copies", "它与 copies 一起使用"),
    ("it goes with protocol", "它与 protocol 一起使用"),
    (
        "it goes with shape = \"mesh\"",
        "它只与 shape = \"mesh\" 一起使用",
    ),
    (
        "it has a skin, whose shape depends on bones; allowed are rigid meshes",
        "它有蒙皮，形状随骨骼而变；只允许刚性网格",
    ),
    (
        "it has ended without giving {}, which was recorded",
        "已结束，却没有发出记录中的 {0}",
    ),
    ("it has more than {} values", "值超过 {0} 个"),
    (
        "it has no uri; only the first buffer of a GLB file with a binary chunk may be without",
        "它没有 uri；只有带二进制数据块的 GLB 文件的第一个缓冲区可以没有",
    ),
    (
        "it has not given {}, which was taken in this cycle",
        "没有发出本周期取走的 {0}",
    ),
    (
        "it has the joints of several arms, which begin with {} and {}",
        "含有多台机械臂的关节，名称以 {0} 和 {1} 开头",
    ),
    ("it has too many values", "值太多"),
    (
        "it has {} bytes, a table takes at most {}",
        "有 {0} 字节，表格最多 {1} 字节",
    ),
    (
        "it has {} bytes, at most {} are read",
        "有 {0} 字节，最多读取 {1} 字节",
    ),
    (
        "it has {} joints and {} positions",
        "有 {0} 个关节和 {1} 个位置",
    ),
    (
        "it has {} joints, at most {} are read",
        "有 {0} 个关节，最多读取 {1} 个",
    ),
    (
        "it has {} robots, at most {} are started",
        "其中有 {0} 个机器人，最多启动 {1} 个",
    ),
    (
        "it held {} MB, {} MB are allowed",
        "占用 {0} MB，允许 {1} MB",
    ),
    (
        "it is a folder, a pipe or a device; recordings are files",
        "它是文件夹、管道或设备；记录是文件",
    ),
    ("it is empty", "是空的"),
    ("it is empty or ends at once", "文件为空或刚开始就结束"),
    ("it is larger than {} MiB", "超过 {0} MiB"),
    (
        "it is named, but there are {} accessors",
        "它被引用，但只有 {0} 个 accessor",
    ),
    (
        "it is named, but there are {} nodes",
        "它被引用，但只有 {0} 个节点",
    ),
    (
        "it is no glTF (column {}): {}",
        "不是 glTF（第 {0} 列）：{1~}",
    ),
    (
        "it is no text: its byte {} is not UTF-8",
        "不是文本：第 {0} 个字节不是 UTF-8",
    ),
    ("it is not one expression", "不是单个表达式"),
    (
        "it is reached twice; a node hangs on one other, and never on itself",
        "它被到达两次；一个节点只能挂在另一个节点下，且不能挂在自己下面",
    ),
    (
        "it is the default scene; there are {} scenes",
        "它是默认场景；但只有 {0} 个场景",
    ),
    ("it is too large", "过大"),
    (
        "it lies more than 100 m away: are the units right?",
        "它在 100 m 之外：单位是否正确？",
    ),
    (
        "it names bufferViews[{}]; there are {}",
        "它引用 bufferViews[{0}]；只有 {1} 个",
    ),
    (
        "it names buffers[{}]; there are {}",
        "它引用 buffers[{0}]；只有 {1} 个",
    ),
    (
        "it names meshes[{}]; there are {}",
        "它引用 meshes[{0}]；只有 {1} 个",
    ),
    (
        "it names point {}; there are {} points",
        "它引用点 {0}；只有 {1} 个点",
    ),
    (
        "it requires the extension {}; export it without compression and without extensions of geometry",
        "它需要扩展 {0}；请导出为不压缩、不带几何扩展的文件",
    ),
    (
        "it says which arm was measured, as model = \"cs66\"",
        "它说明测量的是哪种机械臂，如 model = \"cs66\"",
    ),
    (
        "its byteStride is {}; allowed here are {} to 252",
        "它的 byteStride 为 {0}；这里允许 {1} 至 252",
    ),
    (
        "its componentType is {}; allowed are 5120 to 5123, 5125 and 5126",
        "它的 componentType 为 {0}；允许 5120 至 5123、5125 和 5126",
    ),
    (
        "its componentType is {}; allowed for indices are 5121, 5123 and 5125",
        "它的 componentType 为 {0}；索引允许 5121、5123 和 5125",
    ),
    (
        "its count is {}; allowed are at most {}",
        "它的 count 为 {0}；最多允许 {1}",
    ),
    ("its data are no base64: {}", "它的数据不是 base64：{0}"),
    (
        "its data are {}; allowed are data:…;base64,… and names of files beside this one",
        "它的数据为 {0}；允许 data:…;base64,… 以及旁边文件的名称",
    ),
    (
        "its element {} names point {}; there are {}",
        "它的元素 {0} 引用点 {1}；只有 {2} 个点",
    ),
    ("its matrix is no finite one", "它的矩阵含有非有限的数"),
    (
        "its ports did not listen within {} s",
        "其端口在 {0} s 内没有监听",
    ),
    ("its program may go on", "其程序可能仍在运行"),
    (
        "its schemas and channels have more than {} bytes together",
        "其结构定义和通道共超过 {0} 字节",
    ),
    (
        "its sparse entry {} changes element {}; there are {}",
        "它的 sparse 条目 {0} 改动元素 {1}；只有 {2} 个元素",
    ),
    (
        "its syntax is {}, not proto2 or proto3",
        "语法为 {0}，不是 proto2 或 proto3",
    ),
    (
        "its type is {}; here it must be {}",
        "它的 type 为 {0}；这里必须是 {1}",
    ),
    (
        "its uri is {}; allowed are names of files in the folder of this one, without .., and data:…;base64,…",
        "它的 uri 为 {0}；允许此文件所在文件夹中文件的名称（不含 ..），以及 data:…;base64,…",
    ),
    (
        "joint `{}` has no acceleration limit, {} rad/s² is taken",
        "关节 `{0}` 没有加速度限值，采用 {1} rad/s²",
    ),
    (
        "joint {} is at {} rad, allowed are {} to {} rad",
        "关节 {0} 位于 {1} rad，允许 {2} 到 {3} rad",
    ),
    (
        "joint {} would be at {} rad, allowed is {} to {} rad",
        "关节 {0} 将位于 {1} rad，允许 {2} 到 {3} rad",
    ),
    ("joints {} rad", "关节 {0} rad"),
    (
        "keep other load off this machine, set the governor to performance, and for a real cell use a kernel with PREEMPT_RT; a virtual machine is never quite on time",
        "不要在本机上运行其他负载，调频策略设为 performance，真实单元请用带 PREEMPT_RT 的内核；虚拟机总会有些延迟",
    ),
    ("kind = \"{}\" has no such key", "kind = \"{0}\" 没有此键"),
    (
        "limit {} is {} {}, it must be at least {}",
        "限值 {0} 为 {1} {2}，至少应为 {3}",
    ),
    (
        "limit {} is {} {}, it must not be more than the {} {} outside of reduced mode",
        "限值 {0} 为 {1} {2}，不能超过缩减模式之外的 {3} {4}",
    ),
    (
        "limit {} of joint {} is {}, allowed is {} up to the arm's {}",
        "关节 {1} 的限值 {0} 为 {2}，允许 {3} 到机械臂的 {4}",
    ),
    ("limits reached: {}", "到达限值：{0}"),
    (
        "line {}: the path has more than {} steps",
        "第 {0} 行：路径超过 {1} 步",
    ),
    ("line {}: {}", "第 {0} 行：{1~}"),
    ("line {}: {}: {}: {}", "第 {0} 行：{1~}：{2}：{3~}"),
    (
        "link `{}`: the collision mesh {} is not used, only cylinders, spheres, capsules and boxes are",
        "连杆 `{0}`：不使用碰撞网格 {1}，只使用圆柱、球、胶囊和长方体",
    ),
    (
        "link {} of the arm stands in obstacle {} at the start; the two never touch",
        "机械臂的连杆 {0} 在开始时位于障碍物 {1} 之内；两者永不接触",
    ),
    ("list takes the number of a line", "list 后面是行号"),
    (
        "longest cycle: {} µs, latest wake-up: {} µs",
        "最长周期：{0} µs，最大唤醒延迟：{1} µs",
    ),
    (
        "make room, or bound what recordings take with --record-budget and --record-rotate",
        "腾出空间，或用 --record-budget 和 --record-rotate 限制记录的大小",
    ),
    (
        "memory cannot be locked ({}); cycles may be late when memory is short",
        "无法锁定内存（{0~}）；内存不足时周期可能延迟",
    ),
    (
        "message {} of {} cannot be decoded: {}",
        "无法解码 {1} 的第 {0} 条消息：{2~}",
    ),
    (
        "message {} of {} cannot be read: {}",
        "无法读取 {1} 的第 {0} 条消息：{2~}",
    ),
    (
        "message {} of {} in {} cannot be read: {}",
        "无法读取 {2} 中 {1} 的第 {0} 条消息：{3~}",
    ),
    ("messages missing: {}", "缺失的消息：{0}"),
    (
        "metres for a unit of the file are needed, above 0",
        "需要文件单位对应的米数，大于 0",
    ),
    ("missing: {}", "缺失：{0}"),
    (
        "model {}, with the kinematics measured in {}",
        "型号 {0}，运动学参数取自 {1} 的测量",
    ),
    ("model {}: {}", "型号 {0}：{1~}"),
    (
        "more commands than the ring holds were taken in cycle {}",
        "周期 {0} 取走的命令多于环形缓冲区的容量",
    ),
    (
        "more than 0 up to {} N/m, or none for a hard one",
        "大于 0、不超过 {0} N/m；坚硬物体不必给出",
    ),
    (
        "more than {} calls, items and fields in a row",
        "连续的调用、元素和字段超过 {0} 个",
    ),
    ("more than {} operators in a row", "连续的运算符超过 {0} 个"),
    (
        "more than {} primitives are drawn, the most that is allowed",
        "绘制的图元超过 {0} 个，即允许的上限",
    ),
    (
        "names are the columns of --csv /cycle, line, program, command and the names of modes; functions are norm, and part, held, count, fallen of a cell with parts",
        "可用的名称有 --csv /cycle 的各列、line、program、command 和各模式的名称；函数有 norm，以及带工件单元的 part、held、count、fallen",
    ),
    (
        "names: {} is called {}, and nothing of the cell is connected to it",
        "names：{0} 名为 {1}，而单元中没有任何东西与它相连",
    ),
    (
        "no base pose in the area reaches all points with {} mm to spare; from the best one these are not reached: {}",
        "区域内没有基座位姿能以 {0} mm 的间隙到达所有点；最好的位姿到达不了的点：{1}",
    ),
    (
        "no connection to the robot at {}: no answer within {} s",
        "无法连接机器人 {0}：{1} s 内没有应答",
    ),
    (
        "no connection to the robot at {}: {}",
        "无法连接机器人 {0}：{1~}",
    ),
    (
        "no joint positions bring the TCP to {}: it is out of the arm's reach; with another base pose or a longer tool (--tcp) it may not be",
        "没有关节位置能使 TCP 到达 {0}：超出机械臂的到达范围；换一个基座位姿或更长的工具（--tcp）也许可以",
    ),
    (
        "no joint positions inside the limits reach the pose",
        "限位之内没有关节位置能到达该位姿",
    ),
    (
        "no joint positions reach the goal",
        "没有关节位置能到达终点",
    ),
    ("no more lines can be read: {}", "无法继续读取输入：{0~}"),
    ("no path was found", "没有找到路径"),
    ("no path was found in {} tries", "{0} 次尝试中没有找到路径"),
    (
        "no path was found {}; most often in the way were {}; --time gives it longer",
        "{0~}没有找到路径；最常挡路的是{1~}；--time 可给更长时间",
    ),
    (
        "no path was found {}; most often in the way were {}; a position in --via or a smaller --margin may help",
        "{0~}没有找到路径；最常挡路的是{1~}；在 --via 中给出一个位置或减小 --margin 也许有用",
    ),
    (
        "no path was found {}; most often in the way were {}{}",
        "{0~}没有找到路径；最常挡路的是{1~}{2~}",
    ),
    ("no program ran", "没有运行程序"),
    ("no program was started", "没有启动程序"),
    (
        "no simulated time passed for {} s: the program computes without waiting; it was stopped{}",
        "{0} s 内没有仿真时间经过：程序只计算不等待；已停止{1~}",
    ),
    ("no statement begins here or below", "该处及其后没有语句"),
    (
        "no test has {} in its path or name",
        "没有测试的路径或名称包含 {0}",
    ),
    ("no_path: {}", "没有路径：{0~}"),
    ("nobody can be asked: {}", "无法询问任何人：{0~}"),
    (
        "nobody plays {}:{}, and --allow net=played reaches no other machine",
        "没有测试扮演 {0}:{1}，而 --allow net=played 不连接其他机器",
    ),
    (
        "norm() takes a list of numbers, for example norm(tcp_force[0:3])",
        "norm() 的参数是数的列表，例如 norm(tcp_force[0:3])",
    ),
    ("not known: {}", "未知：{0}"),
    (
        "nothing can be gained: the cycle takes {} s (simulated runs: {})",
        "没有可加快之处：节拍为 {0} s（仿真运行 {1} 次）",
    ),
    ("nothing can be written into {}: {}", "无法写入 {0}：{1~}"),
    ("nothing is to be done", "无需处理"),
    ("nothing stands in the cell", "单元中没有任何东西"),
    ("nothing was sent", "没有发送任何内容"),
    ("numbers above 0 are needed", "需要大于 0 的数"),
    ("numbers of at least 0 are needed", "需要不小于 0 的数"),
    (
        "numbers of at most {} N or Nm are needed",
        "需要不超过 {0} N 或 Nm 的数",
    ),
    (
        "one conveyor turns an encoder",
        "一个编码器只由一条传送带带动",
    ),
    ("one value is needed", "需要一个值"),
    ("only in {}: {} cycles", "只在 {0} 中：{1} 个周期"),
    ("out of order: {}", "乱序：{0}"),
    ("out_of_reach: {}", "不可达：{0~}"),
    ("overruns: {}", "超时周期：{0}"),
    ("peak TCP force: {} N", "TCP 力峰值：{0} N"),
    ("peak TCP speed: {} m/s", "TCP 速度峰值：{0} m/s"),
    ("peak joint speeds: {} rad/s", "关节速度峰值：{0} rad/s"),
    ("peak joint torques: {} Nm", "关节力矩峰值：{0} Nm"),
    ("press Enter", "请按回车键"),
    ("print takes an expression", "print 后面是表达式"),
    (
        "program {} at cycle {}, line {}: {}",
        "程序 {0}，周期 {1}，第 {2} 行：{3~}",
    ),
    ("program {} at cycle {}: {}", "程序 {0}，周期 {1}：{2~}"),
    (
        "program {} cannot be repeated from cycle {} on: {}, which is not in the recording",
        "程序 {0} 从第 {1} 周期起不能重复：{2~}，而记录中没有它",
    ),
    (
        "program {}: {}, {} s to {} s",
        "程序 {0}：{1}，{2} s 到 {3} s",
    ),
    (
        "program {}: {}, {} s to {} s, still running",
        "程序 {0}：{1}，{2} s 到 {3} s，仍在运行",
    ),
    ("programs: {}", "程序：{0}"),
    ("protective stop", "保护性停止"),
    ("protective stops: {}", "保护性停止：{0}"),
    (
        "raise the limit on processes (ulimit -u, TasksMax= of a unit)",
        "提高进程数上限（ulimit -u，单元的 TasksMax=）",
    ),
    ("real-time priority is given", "有实时优先级"),
    (
        "record onto another disk (--record): what it does not take in time is left out, and counted",
        "记录到其他磁盘（--record）：磁盘来不及写入的部分会被略去并计数",
    ),
    (
        "recording stopped, the robot goes on: {}",
        "记录已停止，机器人继续运行：{0~}",
    ),
    (
        "recording the {} at {}, controller {}.{}.{}: {} of {} variables at {} Hz into {}",
        "正在记录 {1} 处的 {0}，控制器 {2}.{3}.{4}：{6} 个变量中的 {5} 个，{7} Hz，写入 {8}",
    ),
    ("recording: {}", "记录：{0}"),
    ("robot {} has no `name`", "第 {0} 个机器人没有 `name`"),
    (
        "robot {}: `memory` is {}; {}",
        "机器人 {0}：`memory` 为 {1}；{2~}",
    ),
    (
        "robot {}: `name` is {}; 1 to {} letters, digits, `-` and `_` are allowed",
        "第 {0} 个机器人：`name` 为 {1}；允许 1 到 {2} 个字母、数字、`-` 和 `_`",
    ),
    (
        "robot {}: `{}` is the fleet's to say",
        "机器人 {0}：`{1}` 由机器人组决定",
    ),
    ("robot {}: {}", "机器人 {0}：{1~}"),
    (
        "robot: {}, {} plant, {} clock, step {} ms, seed {}, eliteserver {}",
        "机器人：{0~}，模型 {1}，时钟 {2}，步长 {3} ms，种子 {4}，eliteserver {5}",
    ),
    (
        "ros2 is started by 'eliteserver serve --ros2', with a socket as its standard input ({})",
        "ros2 由 'eliteserver serve --ros2' 启动，标准输入为套接字（{0~}）",
    ),
    (
        "script: {} line {} (thread {})",
        "脚本：{0} 第 {1} 行（线程 {2}）",
    ),
    (
        "script: {} line {}, node {} (thread {})",
        "脚本：{0} 第 {1} 行，节点 {2}（线程 {3}）",
    ),
    ("sent {} to the robot at {}", "已把 {0} 发送到机器人 {1}"),
    (
        "six joint positions in rad are needed, as in 0,-1.57,1.57,-1.57,-1.57,0, or a pose of the TCP in m and rad, all of them up to 1000, as in 'p[0.4,0.1,0.3,3.14,0,0]'",
        "需要六个关节位置（rad），如 0,-1.57,1.57,-1.57,-1.57,0，或 TCP 的位姿（m 和 rad），如 'p[0.4,0.1,0.3,3.14,0,0]'；都不超过 1000",
    ),
    (
        "six joint positions in rad, up to 1000, are needed, separated by commas, as in 0,-1.57,1.57,-1.57,-1.57,0",
        "需要六个不超过 1000 的关节位置（rad），以逗号分隔，如 0,-1.57,1.57,-1.57,-1.57,0",
    ),
    ("something comes nearer than {} mm", "有物体距离小于 {0} mm"),
    ("start_in_collision: {}", "起点碰撞：{0~}"),
    (
        "statements: {} was carried out last, {} accepted last, {} wait",
        "语句：最后执行 {0}，最后接收 {1}，等待 {2} 条",
    ),
    (
        "stop the movej or movel that the arm does",
        "停止机械臂正在执行的 movej 或 movel",
    ),
    (
        "stopping the program on the robot",
        "正在停止机器人上的程序",
    ),
    ("that line is too long", "该行太长"),
    (
        "the ROS 2 domain is {}, allowed are 0 to 232 (--ros-domain, else ROS_DOMAIN_ID)",
        "ROS 2 域为 {0}，允许 0 到 232（--ros-domain，否则 ROS_DOMAIN_ID）",
    ),
    ("the URDF cannot be understood: {}", "无法理解 URDF：{0~}"),
    ("the URDF element <{}> {}", "URDF 元素 <{0}> {1~}"),
    (
        "the URDF has {} revolute joints in a row ({}), exactly six are needed",
        "URDF 中串联的旋转关节有 {0} 个（{1}），需要恰好六个",
    ),
    (
        "the URDF is not well-formed XML near byte {}: {}",
        "URDF 在第 {0} 个字节附近不是合法的 XML：{1~}",
    ),
    (
        "the URDF is {} bytes long, {} are allowed",
        "URDF 有 {0} 字节，允许 {1} 字节",
    ),
    (
        "the URDF joint `{}` is {}; only revolute and fixed joints are supported",
        "URDF 关节 `{0}` 为 {1~}；只支持 revolute 和 fixed 关节",
    ),
    (
        "the URDF joint `{}` names the link `{}`, which does not exist",
        "URDF 关节 `{0}` 指向不存在的连杆 `{1}`",
    ),
    ("the URDF joint `{}` {}", "URDF 关节 `{0}` {1~}"),
    ("the URDF link `{}` has {}", "URDF 连杆 `{0}` 有{1~}"),
    ("the URDF link `{}` {}", "URDF 连杆 `{0}` {1~}"),
    ("the URDF names two {} `{}`", "URDF 中有两个{0~}名为 `{1}`"),
    (
        "the URDF nests elements more than {} deep",
        "URDF 的元素嵌套超过 {0} 层",
    ),
    (
        "the arc begins {} mm from its centre and ends {} mm from it",
        "圆弧起点距圆心 {0} mm，终点距圆心 {1} mm",
    ),
    ("the arm cannot be simulated: {}", "无法仿真机械臂：{0~}"),
    (
        "the arm cannot follow the last {} mm to the target on a line; --approach is shorter or 0",
        "机械臂无法沿直线走完到终点的最后 {0} mm；请缩短 --approach 或设为 0",
    ),
    (
        "the arm does not reach {}, {}, {} m (base frame)",
        "机械臂到不了 {0}、{1}、{2} m（基座坐标系）",
    ),
    ("the arm does not rest at {} s", "机械臂在 {0} s 时没有静止"),
    (
        "the arm of the recording cannot be made: {}",
        "无法构建记录中的机械臂：{0~}",
    ),
    (
        "the arm touches something at the goal",
        "机械臂在终点碰到物体",
    ),
    (
        "the arm touches something at the start",
        "机械臂在起点碰到物体",
    ),
    (
        "the arm touches something at via position {}",
        "机械臂在中间位置 {0} 碰到物体",
    ),
    (
        "the bag {} cannot be written: there is something else in that folder",
        "无法写入 bag {0}：该文件夹中有别的内容",
    ),
    (
        "the bag {} has more than {} files",
        "bag {0} 的文件多于 {1} 个",
    ),
    (
        "the bag {} keeps its messages in {}; only MCAP is read: ros2 bag convert makes it of other bags",
        "bag {0} 的消息保存在 {1} 中；只读取 MCAP：可用 ros2 bag convert 转换其他 bag",
    ),
    ("the bag {}: {}", "bag {0}：{1~}"),
    ("the beginning", "程序开头"),
    (
        "the buffers are longer than {} bytes together, the most that is allowed",
        "各缓冲区合计超过 {0} 字节，即允许的上限",
    ),
    (
        "the calibration file {} is for the model {}, but the model {} is asked for; leave the model out, or give {}",
        "标定文件 {0} 用于型号 {1}，而要求的型号是 {2}；请不给出型号，或给出 {3}",
    ),
    (
        "the calibration in the recording is not usable: {}",
        "记录中的标定不可用：{0~}",
    ),
    ("the cell file: {}", "单元文件：{0~}"),
    (
        "the cell has {} files; a recording takes at most {}",
        "单元有 {0} 个文件；一个记录最多接受 {1} 个",
    ),
    ("the cell of the recording: {}", "记录中的单元：{0~}"),
    (
        "the cell's modbus signal {} cannot be added: {}",
        "无法添加单元的 Modbus 信号 {0}：{1~}",
    ),
    (
        "the cell's {} is of {}; with --allow net=played no device outside this process is reached",
        "单元的{0~}属于 {1}；用 --allow net=played 时不连接此进程之外的设备",
    ),
    (
        "the checksum of a chunk is not that of its content",
        "块的校验和与内容不符",
    ),
    ("the clock was not made", "没有建立时钟"),
    ("the clock was not started", "时钟没有启动"),
    ("the compiled-in font is broken", "内置字体损坏"),
    (
        "the compression {} of a chunk is not known; zstd and lz4 are",
        "块的压缩方式 {0} 未知；可用 zstd 和 lz4",
    ),
    ("the condition cannot be read:", "无法读取条件："),
    ("the condition fails at {} s:", "条件在 {0} s 处失败："),
    (
        "the condition takes too long for one cycle",
        "条件对一个周期来说计算太久",
    ),
    (
        "the connection for data to the robot at {} broke: {}",
        "与 {0} 处机器人的数据连接中断：{1~}",
    ),
    (
        "the connection for statements to the robot at {} broke: {}",
        "与机器人 {0} 的语句连接中断：{1~}",
    ),
    (
        "the connection to the robot at {} broke: {}",
        "与机器人 {0} 的连接中断：{1~}",
    ),
    ("the controller does not offer {}", "控制器不提供 {0}"),
    (
        "the controller does not start like this: {} to mend",
        "控制器这样无法启动：有 {0} 项要处理",
    ),
    (
        "the controller of the recording cannot be made: {}",
        "无法建立记录中的控制器：{0~}",
    ),
    (
        "the controller runs; {} of it could be better",
        "控制器可以运行；有 {0} 项可改善",
    ),
    ("the data breakpoint is {}: {}", "数据断点 {0}：{1~}"),
    ("the debugger has ended", "调试器已结束"),
    (
        "the drawing names no unit: millimetres are assumed",
        "图纸没有给出单位：按毫米处理",
    ),
    (
        "the eight bytes that begin and end an MCAP file are not there",
        "缺少 MCAP 文件首尾的八个字节",
    ),
    ("the encoding {} is not supported", "不支持编码 {0}"),
    ("the end of the file", "文件末尾"),
    ("the end of the program", "程序的结尾"),
    ("the file cannot be read: {}", "无法读取文件：{0~}"),
    (
        "the file has more than {} triangles, the most that is allowed",
        "文件的三角形超过 {0} 个，即允许的上限",
    ),
    (
        "the file has {} bytes; STL is either text that begins with solid, or has at least {} bytes",
        "文件有 {0} 字节；STL 要么是以 solid 开头的文本，要么至少有 {1} 字节",
    ),
    (
        "the file is longer than {} bytes, the most that is allowed here",
        "文件超过 {0} 字节，即此处允许的上限",
    ),
    (
        "the file is outside of the folder; allowed are files within it, named by a relative path",
        "文件在文件夹之外；只允许其中的文件，用相对路径表示",
    ),
    (
        "the file {} of the cell has {} bytes; a recording takes files of at most {}",
        "单元的文件 {0} 有 {1} 字节；一个记录接受的文件最大为 {2} 字节",
    ),
    (
        "the files of the cell have {} bytes together; a recording takes at most {}",
        "单元的文件共有 {0} 字节；一个记录最多接受 {1} 字节",
    ),
    (
        "the first request of a client must be initialize",
        "客户端的第一个请求必须是 initialize",
    ),
    (
        "the flange lies alike in all rests: turn it about two axes by 20 degrees or more between them",
        "各静止段中法兰姿态相同：请在它们之间绕两个轴转动 20 度以上",
    ),
    ("the force in N is needed", "需要力，N"),
    (
        "the head names no columns x, y, z and perhaps rx, ry, rz",
        "表头没有列名 x、y、z 以及可选的 rx、ry、rz",
    ),
    (
        "the hull of the tool has the point {}, at least one point is needed and all must be finite",
        "工具的凸包有点 {0}，至少需要一个点，且必须都是有限值",
    ),
    (
        "the knots of a spline are not in order",
        "样条曲线的节点没有按顺序排列",
    ),
    (
        "the last reports of the robot: errors, alarms; :log 100 for more",
        "机器人最近的报告：错误、报警；:log 100 显示更多",
    ),
    (
        "the measurements do not tell the unknowns {}",
        "测量值不能确定未知量 {0}",
    ),
    ("the middles of the rims are needed", "需要各吸盘口的中心"),
    (
        "the mode of a primitive is {}; allowed is 4, triangles",
        "有一个图元的 mode 为 {0}；只允许 4，即三角形",
    ),
    (
        "the motion does not tell the centre of gravity (mass {} kg): turn the flange about two axes",
        "此运动无法判断重心（质量 {0} kg）：请绕两个轴转动法兰",
    ),
    ("the motion does not tell {}", "此运动无法判断{0~}"),
    (
        "the motion thread gets no FIFO priority {} ({}); cycles may be late under load",
        "运动线程得不到 FIFO 优先级 {0}（{1~}）；有负载时周期可能延迟",
    ),
    (
        "the name leads to no regular file, but for instance to a folder or a device",
        "此名称所指不是普通文件，而是文件夹、设备之类",
    ),
    (
        "the name of a link (shoulder, upper_arm, forearm, wrist_1, wrist_2, wrist_3, base), of the tool, or of something in this cell; * stands for any letters",
        "应为连杆（shoulder、upper_arm、forearm、wrist_1、wrist_2、wrist_3、base）、工具或此单元中物体的名称；* 代表任意字符",
    ),
    (
        "the name of a value is longer than {} bytes",
        "某个值的名称超过 {0} 字节",
    ),
    ("the opening in m is needed", "需要开口宽度，m"),
    (
        "the operating system gives none: {}",
        "操作系统不提供线程：{0~}",
    ),
    (
        "the operating system refused what a fleet needs: {}",
        "操作系统拒绝了机器人组所需的资源：{0~}",
    ),
    (
        "the operating system refused what a run needs: {}",
        "操作系统拒绝了运行所需的资源：{0~}",
    ),
    (
        "the operating system refused what a server needs: {}",
        "操作系统拒绝了服务器所需的资源：{0~}",
    ),
    (
        "the path of a file of the cell has {} bytes; a recording takes paths of 1 to {}",
        "单元中一个文件的路径有 {0} 字节；一个记录接受 1 到 {1} 字节的路径",
    ),
    (
        "the payload has a component that is not a finite number",
        "负载有分量不是有限的数",
    ),
    (
        "the payload inertia [{}] belongs to no rigid body: its principal moments are {} kg m², they must not be negative and none may exceed the sum of the other two",
        "负载惯量 [{0}] 不属于任何刚体：主惯量为 {1} kg m²，不能为负，且任一个不能超过另两个之和",
    ),
    (
        "the payload is too light to tell where it is: {} kg, ± {} kg",
        "负载太轻，无法判断其位置：{0} kg，± {1} kg",
    ),
    (
        "the payload mass is {} kg, it must not be negative",
        "负载质量为 {0} kg，不能为负",
    ),
    ("the picture cannot be drawn: {}", "无法绘制图片：{0~}"),
    ("the picture cannot be encoded: {}", "无法编码图片：{0~}"),
    ("the point is more than 100 m away", "点在 100 m 之外"),
    (
        "the position range of joint {} is {} to {} rad; it must not be empty and must lie within the arm's {} to {} rad",
        "关节 {0} 的位置范围为 {1} 到 {2} rad；不能为空，且必须在机械臂的 {3} 到 {4} rad 之内",
    ),
    (
        "the program cannot be made faster as it is: {}",
        "程序现状无法加快：{0~}",
    ),
    (
        "the program cannot be put into a function, as controllers take it: {}",
        "程序无法放入控制器要求的函数中：{0~}",
    ),
    (
        "the program does not compile{}: {}",
        "程序不能编译{0~}：{1~}",
    ),
    ("the program ended", "程序已结束"),
    ("the program failed{}: {}", "程序失败{0~}：{1~}"),
    ("the program goes on", "程序继续运行"),
    (
        "the program had not ended after {} s of simulated time{}; --timeout gives it longer, and one that repeats itself for ever needs a bound on its repetitions",
        "仿真时间 {0} s 后程序仍未结束{1~}；--timeout 可给更长时间，而无限重复的程序需要限定重复次数",
    ),
    (
        "the program on the robot has ended; a new one begins, with none of its variables",
        "机器人上的程序已结束；将启动新程序，原有变量不再存在",
    ),
    (
        "the program runs into something as it is: {} and {} are {} mm inside each other in line {}, at {} s",
        "程序现状会发生碰撞：{0~}与{1~}重叠 {2} mm，在第 {3} 行，{4} s 时",
    ),
    (
        "the program that enters interpreter mode failed: {}",
        "进入解释器模式的程序失败：{0~}",
    ),
    (
        "the program waits{} for something from outside that does not come; set inputs at their times in the cell file ([[input]]), or give it values with --set",
        "程序{0~}在等待不会到来的外部信号；请在单元文件中按时间设置输入（[[input]]），或用 --set 给出值",
    ),
    ("the program was stopped", "程序已停止"),
    (
        "the program was stopped and has not ended within {} s",
        "程序被停止，但在 {0} s 内没有结束",
    ),
    ("the program was stopped{}", "程序被停止{0~}"),
    (
        "the programs were not run again: {}",
        "没有重新运行程序：{0~}",
    ),
    (
        "the recording cannot be run again in this version: {}",
        "此版本不能重新运行该记录：{0~}",
    ),
    (
        "the recording covers {} s to {} s",
        "记录的范围是 {0} s 到 {1} s",
    ),
    (
        "the recording did not keep up and dropped messages",
        "记录跟不上，丢弃了消息",
    ),
    ("the recording does not hold it", "记录中没有它"),
    (
        "the recording does not say how the controller was started, it cannot be run again",
        "记录没有说明控制器是如何启动的，不能重新运行",
    ),
    (
        "the recording has cycles of {} ms; {}",
        "记录的周期为 {0} ms；{1~}",
    ),
    (
        "the recording has format {}, this version reads up to {}",
        "记录的格式为 {0}，此版本最高读取 {1}",
    ),
    (
        "the recording has more of {} than are run again ({})",
        "记录中的{0~}多于可重新运行的数量（{1}）",
    ),
    ("the recording has no cycles", "记录中没有周期"),
    ("the recording has stopped: {}", "记录已停止：{0~}"),
    (
        "the recording has {} cycles up to cycle {}; at most {} missing ones are run",
        "到第 {1} 周期为止记录有 {0} 个周期；缺少的周期最多补运行 {2} 个",
    ),
    (
        "the recording is not complete: the disk did not take it in time",
        "记录不完整：磁盘没有及时接受数据",
    ),
    ("the recording is not complete: {}", "记录不完整：{0}"),
    (
        "the recording jumps from cycle {} to cycle {}; at most {} missing cycles are run",
        "记录从周期 {0} 跳到周期 {1}；缺少的周期最多补运行 {2} 个",
    ),
    (
        "the recording takes nothing, no time can pass",
        "记录不再接收数据，时间无法前进",
    ),
    ("the recording {} has failed", "记录 {0} 失败"),
    (
        "the recordings have more than {} cycles: use --from and --to",
        "记录超过 {0} 个周期：请用 --from 和 --to",
    ),
    (
        "the recordings hold no force reading (raw_wrench): use --from-torques",
        "记录中没有力读数（raw_wrench）：请用 --from-torques",
    ),
    (
        "the recordings hold no joint positions in this time",
        "这段时间的记录中没有关节位置",
    ),
    (
        "the recordings hold no torques of the joints (actual_torque)",
        "记录中没有关节力矩（actual_torque）",
    ),
    (
        "the recordings hold {} measurements: {} or more are needed",
        "记录中有 {0} 个测量值：需要 {1} 个或更多",
    ),
    (
        "the robot `{}` exists, but its dimensions and masses are not public, so it cannot be simulated; built in are {}",
        "机器人 `{0}` 存在，但其尺寸和质量没有公开，因此不能仿真；内置的有 {1}",
    ),
    (
        "the robot at {} answers {} with something else",
        "{0} 处的机器人对{1~}的应答不符",
    ),
    (
        "the robot at {} does not answer on its port for data ({})",
        "{0} 处的机器人在数据端口上没有应答（{1~}）",
    ),
    (
        "the robot at {} does not answer on its port for statements: {} s",
        "机器人 {0} 的语句端口没有应答：{1} s",
    ),
    (
        "the robot at {} has closed the connection",
        "机器人 {0} 已关闭连接",
    ),
    (
        "the robot at {} has closed the connection for data",
        "{0} 处的机器人关闭了数据连接",
    ),
    (
        "the robot at {} has closed the connection for statements",
        "机器人 {0} 已关闭语句连接",
    ),
    (
        "the robot at {} has not answered the statement, and none waits there",
        "机器人 {0} 没有回应该语句，那里也没有等待的语句",
    ),
    (
        "the robot at {} has not begun the program that enters interpreter mode",
        "机器人 {0} 没有启动进入解释器模式的程序",
    ),
    (
        "the robot at {} is of type {}, which is none of {}",
        "{0} 处的机器人型号为 {1}，不在 {2} 之中",
    ),
    ("the robot at {} refuses {}", "{0} 处的机器人拒绝{1~}"),
    (
        "the robot at {} says nothing any more: no state for {} s",
        "机器人 {0} 不再发送数据：{1} s 没有状态",
    ),
    (
        "the robot at {} sends states without the configuration of its arm",
        "{0} 处的机器人发送的状态没有机械臂配置",
    ),
    (
        "the robot at {} takes no statement: {} s",
        "机器人 {0} 不接收语句：{1} s",
    ),
    (
        "the robot at {} takes nothing: {} s",
        "机器人 {0} 不接收数据：{1} s",
    ),
    (
        "the robot has its TCP {} mm from where these numbers put it: it counts with something that it does not send, such as offsets of its joints",
        "机器人的 TCP 与按这些数计算的位置相差 {0} mm：它还用了没有发送的数据，例如关节零位偏差",
    ),
    (
        "the robot model {} cannot be read: {}",
        "无法读取机器人型号 {0}：{1~}",
    ),
    (
        "the robot still runs its program 3 s after it was told to stop",
        "发出停止命令 3 s 后，机器人仍在运行程序",
    ),
    (
        "the robot's name {} has no address",
        "机器人名称 {0} 没有地址",
    ),
    (
        "the robot's name {} is not known: {}",
        "不认识机器人名称 {0}：{1~}",
    ),
    (
        "the schema of {} cannot be used: {}",
        "无法使用 {0} 的结构定义：{1~}",
    ),
    (
        "the script {} is XML, not a program",
        "脚本 {0} 是 XML，不是程序",
    ),
    (
        "the script {} is larger than the {} MiB allowed",
        "脚本 {0} 超过允许的 {1} MiB",
    ),
    (
        "the script {} is not UTF-8 text (byte {} is not)",
        "脚本 {0} 不是 UTF-8 文本（第 {1} 个字节不是）",
    ),
    (
        "the session with the client cannot begin: {}",
        "与客户端的会话无法开始：{0}",
    ),
    (
        "the session with the client has failed: {}",
        "与客户端的会话失败：{0}",
    ),
    (
        "the shape of a finger is needed: {} for a box",
        "需要手指的形状：箱体用 {0}",
    ),
    ("the shell was ended", "交互会话已结束"),
    (
        "the size of the tool's {} is {}, every number must be finite and positive",
        "工具的 {0} 尺寸为 {1}，每个数都必须是有限的正数",
    ),
    ("the speed in m/s is needed", "需要速度，m/s"),
    (
        "the start configuration has {} = {}, which does not fit",
        "启动配置中 {0} = {1}，不合适",
    ),
    (
        "the step time is {} s, allowed are 0.001 to 0.008 s",
        "步长为 {0} s，允许 0.001 到 0.008 s",
    ),
    (
        "the table with a, d, alpha and optionally theta is needed",
        "需要含有 a、d、alpha 和可选 theta 的表",
    ),
    ("the target is more than 100 m away", "目标在 100 m 之外"),
    ("the tests cannot be run: {}", "无法运行测试：{0~}"),
    (
        "the text has no end: its quote is missing",
        "字符串没有结束：缺少引号",
    ),
    (
        "the three points lie in one line: the third one has to lie beside it",
        "三点在一条直线上：第三点必须在直线之外",
    ),
    (
        "the version of GLB is {}; allowed is 2",
        "GLB 的版本为 {0}；只允许 2",
    ),
    (
        "the version of glTF is {}; allowed is 2.0",
        "glTF 的版本为 {0}；只允许 2.0",
    ),
    (
        "the {} has {} m there, and a measured arm is within {} m of it{}",
        "{0} 在那里为 {1} m，实测的机械臂与它相差不超过 {2} m{3~}",
    ),
    (
        "the {} has {} {} there, and a measured arm is within {} {} of it{}",
        "{0} 在那里为 {1} {2}，实测的机械臂与它相差不超过 {3} {4}{5~}",
    ),
    (
        "the {} of a safety plane is {}, it must be {}",
        "安全平面的 {0} 为 {1}，应为{2~}",
    ),
    (
        "the {} ring holds {} entries, at least {} are needed",
        "{0} 缓冲区有 {1} 项，至少需要 {2} 项",
    ),
    (
        "there are more than {} points, the most that is allowed",
        "点超过 {0} 个，即允许的上限",
    ),
    ("there are too many points", "点过多"),
    (
        "there are {} parts, allowed: up to {}",
        "有 {0} 个工件，最多允许 {1} 个",
    ),
    (
        "there are {} safety planes already, more are not possible",
        "已有 {0} 个安全平面，不能再多",
    ),
    (
        "there is a curve or a curved surface; allowed are faces f of straight edges",
        "这里有曲线或曲面；只允许由直边围成的面 f",
    ),
    ("there is a record of kind 0", "有类型为 0 的记录项"),
    (
        "there is no --cell: only the arm itself is kept from itself, whatever else stands there",
        "没有 --cell：只避免机械臂碰到自身，不论周围有什么",
    ),
    (
        "there is no --cell: only the links and the tool are measured, against each other",
        "没有 --cell：只测量连杆和工具之间的距离",
    ),
    (
        "there is no --cell: the path only keeps the arm from itself",
        "没有 --cell：路径只避免机械臂碰到自身",
    ),
    ("there is no :{}; there are {}", "没有 :{0}；可用的有 {1}"),
    (
        "there is no built-in robot model `{}`; built in are {}, a path of a URDF file works as well",
        "没有内置的机器人型号 `{0}`；内置的有 {1}，也可以给出 URDF 文件的路径",
    ),
    ("there is no chunk JSON", "没有 JSON 数据块"),
    (
        "there is no command {} in this version",
        "此版本没有命令 {0}",
    ),
    (
        "there is no line, polyline, arc, circle, ellipse or spline{}",
        "没有直线、多段线、圆弧、圆、椭圆或样条曲线{0~}",
    ),
    (
        "there is no move (G0 to G3) in it",
        "其中没有运动（G0 到 G3）",
    ),
    (
        "there is no order {}; did you mean {}?",
        "没有命令 {0}；是否想写 {1}？",
    ),
    (
        "there is no order {}; help lists the orders",
        "没有命令 {0}；help 列出所有命令",
    ),
    (
        "there is no plant {}; allowed are {}, {} and {}",
        "没有 plant {0}；允许 {1}、{2} 和 {3}",
    ),
    ("there is no point in it", "其中没有点"),
    ("there is no recording", "没有记录"),
    (
        "there is no robot; each is a table [[robot]]",
        "没有机器人；每个机器人是一个表 [[robot]]",
    ),
    (
        "there is no room for the motion about --home: {}",
        "--home 附近没有运动的空间：{0~}",
    ),
    (
        "there is no script (*.script) below {}",
        "{0} 之内没有脚本（*.script）",
    ),
    ("there is no state at {} s: {}", "{0} s 处没有状态：{1~}"),
    ("there is no such place", "没有这个位置"),
    (
        "there is no test: tests are functions test_… in files test_*.script or *_test.script",
        "没有测试：测试是文件 test_*.script 或 *_test.script 中名为 test_… 的函数",
    ),
    (
        "there is no topic {} in the recording; it has {}",
        "记录中没有主题 {0}；有 {1}",
    ),
    ("there is no {} \"{}\"", "没有 {0} \"{1}\""),
    (
        "there is no {}; break lists what there is",
        "没有 {0}；break 列出已有的停止条件",
    ),
    ("there is none", "没有"),
    (
        "there is nothing called {} in the cell that could be held; there is nothing",
        "单元中没有名为 {0} 的可夹持物体；单元中没有可夹持的物体",
    ),
    (
        "there is nothing called {} in the cell that could be held; there is {}",
        "单元中没有名为 {0} 的可夹持物体；有{1~}",
    ),
    (
        "there is nothing to draw from {} s to {} s: the recording covers {} s to {} s",
        "{0} s 到 {1} s 没有可画的内容：记录的范围是 {2} s 到 {3} s",
    ),
    (
        "there is nothing to draw from {} s to {} s; time goes forward, for a hundred years at most",
        "{0} s 到 {1} s 没有可画的内容；时间只向前，最多一百年",
    ),
    (
        "there is nothing to draw: the recording has no cycles",
        "没有可画的内容：记录中没有周期",
    ),
    ("this cannot be assigned to", "不能对它赋值"),
    (
        "this cell is a text without a folder, so there is no file beside it",
        "此单元只是一段文本，没有文件夹，所以旁边没有文件",
    ),
    (
        "this eliteserver was built without the ROS 2 node; build it with the feature ros2: cargo build --release -p server --features ros2",
        "这个 eliteserver 构建时不含 ROS 2 节点；请带 ros2 特性构建：cargo build --release -p server --features ros2",
    ),
    (
        "this is a binary DXF file: save it as text",
        "这是二进制 DXF 文件：请保存为文本格式",
    ),
    (
        "this is a recording of a robot elsewhere, which has no commands to run again; `compare` tells how far another recording is from it",
        "这是其他机器人的记录，其中没有可重新运行的命令；`compare` 可报告另一记录与它相差多少",
    ),
    (
        "this is part {} of a recording in several files; only the first can be run again",
        "这是多文件记录的第 {0} 部分；只有第一部分可以重新运行",
    ),
    ("this kind needs one", "这一类需要给出它"),
    ("this list", "本列表"),
    ("this pair asks for {} already", "这一对已用于 {0}"),
    ("three finite numbers", "三个有限的数"),
    (
        "three numbers that are not all 0 are needed, as in 0,0,-1",
        "需要三个不全为 0 的数，如 0,0,-1",
    ),
    (
        "two of the points are {} mm apart: 20 mm or more are needed",
        "有两点相距 {0} mm：需要至少 20 mm",
    ),
    (
        "two revolute joints, `{}` and `{}`, move on the same link `{}`: the arm must not branch",
        "两个旋转关节 `{0}` 和 `{1}` 都连在连杆 `{2}` 上：机械臂不能分叉",
    ),
    ("two robots are called {}", "两个机器人都名为 {0}"),
    (
        "two robots have the address {}; each needs one of its own",
        "两个机器人的地址都是 {0}；每个需要自己的地址",
    ),
    (
        "unknown key `{}`; beside [defaults] and [[robot]] there are {}",
        "未知的键 `{0}`；[defaults] 和 [[robot]] 之外有 {1}",
    ),
    (
        "until takes a line or a condition of the arm",
        "until 后面是行号或机械臂的条件",
    ),
    (
        "variables of this session, or :vars NAME NAME",
        "本次会话的变量，或 :vars NAME NAME",
    ),
    ("warning: {}", "警告：{0~}"),
    ("warnings: {}", "警告：{0}"),
    (
        "what came to its programs from outside is not in the recording: it was made by an earlier version",
        "记录中没有外部传给程序的内容：它由较早的版本生成",
    ),
    ("what is {}; allowed are {}", "what 为 {0}；允许 {1}"),
    (
        "what stands before = is no name of a variable",
        "= 之前的不是变量名",
    ),
    (
        "what the robot sends is no arm of its type: {}",
        "机器人发送的数据不是其型号的机械臂：{0~}",
    ),
    ("what {} sends is not RTSI: {}", "{0} 发送的不是 RTSI：{1~}"),
    (
        "what {} sends is not the stream of port 30001: {}",
        "{0} 发送的不是 30001 端口的数据流：{1~}",
    ),
    (
        "what {} sends is not the stream of port 30020: {}",
        "{0} 发送的不是 30020 端口的数据流：{1}",
    ),
    (
        "where it may, the cell file says so: [[touch]], a = {}, b = {}",
        "允许接触时，请在单元文件中写明：[[touch]]，a = {0}，b = {1}",
    ),
    (
        "with alpha[{}] = {} it puts the axis of joint {} {} m aside, and a measured arm is within {} m",
        "与 alpha[{0}] = {1} 一起使关节 {2} 的轴线偏离 {3} m，实测的机械臂不超过 {4} m",
    ),
    (
        "with {} the meshes of the cell have {} triangles together, allowed are {}",
        "加上 {0}，单元的网格共有 {1} 个三角形，允许 {2} 个",
    ),
    (
        "woken {} µs late in the median, {} µs in 99 of 100 cycles, {} µs at most, of {} cycles of {} ms",
        "唤醒延迟：中位数 {0} µs，百分之九十九的周期不超过 {1} µs，最大 {2} µs，共 {3} 个 {4} ms 的周期",
    ),
    (
        "x, y, z in m, up to 10, and Rx, Ry, Rz in rad, up to 1000, are needed, separated by commas, as in 0,0,0.1,0,0,0",
        "需要以逗号分隔的 x、y、z（m，不超过 10）和 Rx、Ry、Rz（rad，不超过 1000），如 0,0,0.1,0,0,0",
    ),
    (
        "{} GB, {} hours of a moving arm",
        "{0} GB，可记录机械臂运动 {1} 小时",
    ),
    (
        "{} and {} are both {}; every service needs a port of its own",
        "{0} 和 {1} 都是 {2}；每个服务需要各自的端口",
    ),
    (
        "{} and {} are only {} mm apart at an end of the path; there the margin of {} mm is not kept",
        "{0~}与{1~}在路径一端只相距 {2} mm；那里不能保持 {3} mm 的间隙",
    ),
    ("{} and {} overlap by {} m", "{0~}与{1~}重叠 {2} m"),
    ("{} are needed", "需要{0~}"),
    ("{} are needed, these are {}", "需要{0~}，这里有 {1} 个"),
    (
        "{} at the goal; what may touch is named by [[touch]] in the cell file",
        "{0~}，在终点；允许接触的物体在单元文件的 [[touch]] 中给出",
    ),
    (
        "{} at the start; what may touch is named by [[touch]] in the cell file",
        "{0~}，在起点；允许接触的物体在单元文件的 [[touch]] 中给出",
    ),
    ("{} at via position {}", "{0~}，在中间位置 {1}"),
    (
        "{} bytes are announced, there are {}",
        "声明有 {0~} 字节，实际有 {1} 字节",
    ),
    (
        "{} bytes are announced; the file has {}",
        "声明有 {0~} 字节；文件有 {1} 字节",
    ),
    (
        "{} bytes from byte {} are announced; buffers[{}] has {}",
        "声明从字节 {1} 起有 {0~} 字节；buffers[{2}] 有 {3} 字节",
    ),
    ("{} bytes, {} are allowed", "{0} 字节，允许 {1} 字节"),
    (
        "{} can be wired to its own kind only",
        "{0} 只能与同类的点相连",
    ),
    (
        "{} columns: a point has x, y, z and perhaps rx, ry, rz",
        "有 {0} 列：一个点有 x、y、z，以及可选的 rx、ry、rz",
    ),
    (
        "{} comes within {} mm of {} {}",
        "{0~}与{2~}相距不到 {1} mm，{3~}",
    ),
    ("{} cores may be used", "可用 {0} 个核心"),
    (
        "{} did not turn far enough (0.2 rad) to tell its friction",
        "{0~}转动不足（0.2 rad），无法判断摩擦",
    ),
    (
        "{} does not compile; nothing was sent",
        "{0} 无法编译；没有发送任何内容",
    ),
    (
        "{} does not say how the controller was started, so there are no frames to write",
        "{0} 没有说明控制器是如何启动的，因此没有可写的坐标系",
    ),
    ("{} does not take {}", "{0} 不接受 {1~}"),
    (
        "{} does not tell its room: {}",
        "无法得知 {0} 的可用空间：{1~}",
    ),
    ("{} does nothing without {}", "没有 {1} 时 {0} 不起作用"),
    (
        "{} elements of {} bytes, {} apart, from byte {} are beyond the {} bytes of bufferViews[{}]",
        "{0~} 个元素，每个 {1} 字节，间隔 {2} 字节，从字节 {3} 起，超出 bufferViews[{5}] 的 {4} 字节",
    ),
    (
        "{} ends in the middle, its writer was killed or is still writing; the answer is about what is there",
        "{0} 在中间结束，写入程序被中止或仍在写入；回答依据已有的内容",
    ),
    ("{} gives `{}` twice", "{0} 两次给出 `{1}`"),
    (
        "{} has a component that is not a finite number",
        "{0} 有分量不是有限的数",
    ),
    (
        "{} has an unknown key `{}`; the keys are {}",
        "{0} 中有未知的键 `{1}`；可用的键为 {2}",
    ),
    (
        "{} has joint states of several robots, and which is meant is not known: {}",
        "{0} 含有多台机器人的关节状态，不知道指哪一台：{1}",
    ),
    (
        "{} has joint {} at {} rad, allowed is {} to {} rad",
        "{0~}的关节 {1} 为 {2} rad，允许 {3} 到 {4} rad",
    ),
    ("{} has more than {} columns", "{0} 超过 {1} 列"),
    ("{} has more than {} points", "{0} 的点超过 {1} 个"),
    (
        "{} has no joint states (sensor_msgs/msg/JointState as CDR); its topics are {}",
        "{0} 没有关节状态（CDR 编码的 sensor_msgs/msg/JointState）；其主题为 {1}",
    ),
    (
        "{} has no points: six numbers a line are needed, x y z Rx Ry Rz",
        "{0} 中没有点：每行需要六个数，x y z Rx Ry Rz",
    ),
    ("{} has no settings", "{0} 没有设置"),
    (
        "{} has {} bytes, at most {} are read",
        "{0} 有 {1} 字节，最多读取 {2} 字节",
    ),
    (
        "{} holds more than {} files; name the folders with the tests",
        "{0} 中超过 {1} 个文件；请指明测试所在的文件夹",
    ),
    (
        "{} is a bag, which does not say tool, payload and place of its arm: run the script with 'run --record FILE' and compare the bag with that recording",
        "{0} 是 bag，不含机械臂的工具、负载和位置：请用 'run --record 文件' 运行脚本，再与该记录比较",
    ),
    (
        "{} is a task of the pendant in XML, and {}, the program that it sends, is XML too",
        "{0} 是示教器的 XML 任务，而它所发送的程序 {1} 也是 XML",
    ),
    (
        "{} is a task of the pendant in XML, and {}, the program that it sends, is not beside it",
        "{0} 是示教器的 XML 任务，而它所发送的程序 {1} 不在旁边",
    ),
    ("{} is called so already", "{0} 已用此名称"),
    ("{} is damaged: {}", "{0} 已损坏：{1~}"),
    (
        "{} is in local mode: it takes no programs from outside. Switch it to remote control first",
        "{0} 处于本地模式，不接收外部程序。请先切换到远程控制",
    ),
    (
        "{} is larger than the {} MiB allowed",
        "{0} 超过允许的 {1} MiB",
    ),
    (
        "{} is no bag in MCAP: no file in that folder ends in .mcap",
        "{0} 不是 MCAP 格式的 bag：该文件夹中没有以 .mcap 结尾的文件",
    ),
    (
        "{} is no finite number; a point v has three",
        "{0~} 不是有限的数；点 v 有三个数",
    ),
    (
        "{} is no finite number; a vertex has three",
        "{0~} 不是有限的数；vertex 有三个数",
    ),
    ("{} is no statement of OBJ", "{0~} 不是 OBJ 的语句"),
    (
        "{} is no {} of ROS 2: letters, digits and single underscores, not a digit first{}",
        "{0} 不是 ROS 2 的{1~}：只能有字母、数字和单个下划线，不以数字开头{2~}",
    ),
    (
        "{} is not a recording of eliteserver: it has no topic /cycle",
        "{0} 不是 eliteserver 的记录：没有主题 /cycle",
    ),
    ("{} is not an MCAP file: {}", "{0} 不是 MCAP 文件：{1~}"),
    ("{} is not understood", "不理解 {0}"),
    ("{} is not understood: left out", "不理解 {0}：已略去"),
    (
        "{} is {} m behind safety plane {}",
        "{0~}在安全平面 {2} 之后 {1} m",
    ),
    ("{} is {}, allowed: {}", "{0} 为 {1}，允许：{2~}"),
    ("{} is {}; {}", "{0} 为 {1}；{2~}"),
    (
        "{} lies in a tilted plane: left out",
        "{0} 位于倾斜平面内：已略去",
    ),
    ("{} line {} is not TOML: {}", "{0} 第 {1} 行不是 TOML：{2~}"),
    (
        "{} line {}: six numbers up to 1000 are needed, x y z Rx Ry Rz in m and rad",
        "{0} 第 {1} 行：需要六个不超过 1000 的数，x y z Rx Ry Rz，单位 m 和 rad",
    ),
    ("{} line {}: {}", "{0} 第 {1} 行：{2~}"),
    (
        "{} lines have no counterpart: the program raises `NotImplementedError` where it reaches them.",
        "{0} 行没有对应：程序运行到那里时引发 `NotImplementedError`。",
    ),
    (
        "{} may not be opened by this user",
        "此用户不能打开端口 {0}",
    ),
    (
        "{} measurements for {} unknowns: {} or more are needed",
        "{0} 个测量值对 {1} 个未知量：需要 {2} 个或更多",
    ),
    (
        "{} of {} has more than {} messages",
        "{1} 的 {0} 多于 {2} 条消息",
    ),
    (
        "{} of {} has not the joints of the arm; the first message has {}",
        "{1} 的 {0} 没有机械臂的关节；第一条消息含有 {2}",
    ),
    ("{} on {} are free", "{1} 上的 {0} 空闲"),
    (
        "{} on {} cannot be opened: {}",
        "无法打开 {1} 上的端口 {0}：{2~}",
    ),
    (
        "{} on {} is taken by another program",
        "{1} 上的端口 {0} 已被其他程序占用",
    ),
    (
        "{} rests with a force reading: three or more with other orientations are needed",
        "带力读数的静止段有 {0} 个：需要三个以上不同的姿态",
    ),
    (
        "{} rests: three are needed (origin, on X, in the XY plane); choose them with --at",
        "静止段有 {0} 个：需要三个（原点、X 轴上、XY 平面内）；请用 --at 选择",
    ),
    (
        "{} rests: with --orientation four at the point and two beside it are needed",
        "静止段有 {0} 个：用 --orientation 时需要在该点的四个和旁边的两个",
    ),
    ("{} runs {} mm into {} {}", "{0~}与{2~}重叠 {1} mm，{3~}"),
    (
        "{} s joint {} at its position limit",
        "{0} s 关节 {1} 到达位置限值",
    ),
    (
        "{} s joint {} at its speed limit",
        "{0} s 关节 {1} 到达速度限值",
    ),
    ("{} s reason {}", "{0} s 原因 {1}"),
    ("{} s to {} s ({} cycles)", "{0} s 到 {1} s（{2} 个周期）"),
    (
        "{} says nothing about identify {}; it is for identify {}",
        "{0} 与 identify {1} 无关；它用于 identify {2}",
    ),
    (
        "{} says something of the ROS 2 node, which is off: give --ros2 as well",
        "{0} 用于 ROS 2 节点，而节点没有启用：请同时给出 --ros2",
    ),
    ("{} takes a number", "{0} 取一个数"),
    ("{} takes nothing behind it", "{0} 后面不能有内容"),
    ("{} takes true or false", "{0} 取 true 或 false"),
    (
        "{} takes {} MB a second, one of them within {} ms; a recording needs {}",
        "{0} 每秒写入 {1} MB，每 MB 最多用时 {2} ms；记录每秒需要 {3} MB",
    ),
    (
        "{} the robot at {}? It may move. [y/N]",
        "{0~}机器人 {1}？它可能会运动。[y/N]",
    ),
    (
        "{} touches {} on the last {} mm, on every line to the target",
        "在通往终点的每条直线上，{0~}在最后 {2} mm 与{1~}相碰",
    ),
    ("{} touches {} {}", "{0~}与{1~}接触，{2~}"),
    (
        "{} triangles are announced, which are {} bytes; {} bytes follow",
        "声明有 {0~} 个三角形，即 {1} 字节；其后有 {2} 字节",
    ),
    (
        "{} was cut off; what it has is compared",
        "{0} 被截断；只比较其已有内容",
    ),
    (
        "{} weights for {} control points",
        "{1} 个控制点有 {0} 个权重",
    ),
    ("{} {} drives this input already", "{0} {1} 已在驱动此输入"),
    (
        "{} {}: {} is {}, which is an output of the tool unless the program makes it an input (set_tool_digital_config): nobody reads it",
        "{0} {1}：{2} 为 {3}，除非程序把它设为输入（set_tool_digital_config），它就是工具的输出：没有人读取它",
    ),
    (
        "{} {}: {} is {}, which is wired to the safety system as {}: the program does not see it alone",
        "{0} {1}：{2} 为 {3}，它作为 {4} 接到安全系统：不只是程序使用它",
    ),
    (
        "{}(): nobody is there to ask, the run is repeated from a recording",
        "{0}()：无人可问，运行是按记录重复的",
    ),
    ("{}, byte {}: {}", "{0~}，字节 {1}：{2~}"),
    (
        "{}, least distance {} mm: {} and {} in line {} at {} s",
        "{0~}，最小间隙 {1} mm：{2~}与{3~}，第 {4} 行，{5} s 时",
    ),
    (
        "{}, line {}, column {}, in {}",
        "{3} 中，{0} 第 {1} 行第 {2} 列",
    ),
    ("{}, line {}: {}", "{0~}，第 {1} 行：{2~}"),
    (
        "{}, nothing that could be touched",
        "{0~}，没有可能碰到的物体",
    ),
    ("{}, read in nanoseconds", "{0}，读取只需几纳秒"),
    (
        "{}, triangle {}: a corner is at {} m; allowed are coordinates within {} m (a file in millimetres needs a scale of 0.001)",
        "{0~}，三角形 {1}：有一个顶点位于 {2} m；坐标允许在 {3} m 以内（以毫米为单位的文件需要 0.001 的 scale）",
    ),
    (
        "{}, triangle {}: the edge from {} to {} m belongs to {} triangles; in a solid every edge belongs to two",
        "{0~}，三角形 {1}：从 {2} 到 {3} m 的边属于 {4} 个三角形；实体的每条边属于两个三角形",
    ),
    (
        "{}, triangle {}: the surface is open: the edge from {} to {} m belongs to one triangle only; in a solid every edge belongs to two",
        "{0~}，三角形 {1}：表面不封闭：从 {2} 到 {3} m 的边只属于一个三角形；实体的每条边属于两个三角形",
    ),
    ("{}, triangle {}: {}", "{0~}，三角形 {1}：{2~}"),
    (
        "{}, which takes a microsecond and more to read",
        "{0}，读取需一微秒以上",
    ),
    (
        "{}, {} rad in {} s, {}; planned in {} s",
        "{0~}，{2} s 内转动 {1} rad，{3~}；规划用时 {4} s",
    ),
    ("{}, {}[{}]: {}", "{0~}，{1}[{2}]：{3~}"),
    ("{}: `model` is {}; {}", "{0}：`model` 为 {1}；{2~}"),
    ("{}: `{}` is {}; {}", "{0}：`{1}` 为 {2}；{3~}"),
    (
        "{}: allowed are files that end with .gcode, .nc, .ngc, .dxf or .csv",
        "{0}：只允许以 .gcode、.nc、.ngc、.dxf 或 .csv 结尾的文件",
    ),
    (
        "{}: argument {} is {}, which does not fit",
        "{0}：参数 {1} 为 {2}，不合适",
    ),
    ("{}: cycles would be missed", "{0~}：会错过周期"),
    (
        "{}: distances are known as far as it runs: {}",
        "{0}：只有运行到的部分才知道间隙：{1~}",
    ),
    (
        "{}: it does not say which arm it is of",
        "{0}：没有说明是哪种机械臂",
    ),
    ("{}: model = {}: {}", "{0}：model = {1}：{2~}"),
    (
        "{}: not told; robots tell globals only, and --set NAME=VALUE makes one",
        "{0}：未知；机器人只报告全局变量，用 --set NAME=VALUE 可以创建",
    ),
    (
        "{}: one of triangles {} and {} is inside out: both run along the edge from {} to {} m in the same direction; corners must be counterclockwise seen from outside",
        "{0~}：三角形 {1} 和 {2} 中有一个里外颠倒：两者沿从 {3} 到 {4} m 的边方向相同；从外面看，顶点必须按逆时针排列",
    ),
    (
        "{}: only the first {} findings are shown",
        "{0}：只显示前 {1} 个发现",
    ),
    ("{}: other in {} cycles", "{0}：{1} 个周期中不同"),
    (
        "{}: the extent along {} is {} m; allowed is {} m and more",
        "{0~}：沿 {1} 的尺寸为 {2} m；允许 {3} m 及以上",
    ),
    (
        "{}: the file has no triangle with an area",
        "{0~}：文件中没有面积不为零的三角形",
    ),
    (
        "{}: the model {} cannot be calibrated, it is not of the shape of the CS arms (axes 2, 3, 4 parallel, axes 4-5 and 5-6 crossing at right angles, flange in the frame of joint 6)",
        "{0}：型号 {1} 不能标定，它不具有 CS 机械臂的结构（轴 2、3、4 平行，轴 4-5 和 5-6 垂直相交，法兰在关节 6 的坐标系中）",
    ),
    (
        "{}: the name ends in no known format of meshes; allowed are .stl, .obj, .gltf and .glb",
        "{0~}：名称的后缀不是已知的网格格式；允许 .stl、.obj、.gltf 和 .glb",
    ),
    (
        "{}: the recording lacks the file {} of its cell",
        "{0}：记录中缺少其单元的文件 {1}",
    ),
    (
        "{}: the rests are too much alike, turn the flange about two axes between them",
        "{0~}：各静止段过于相似，请在它们之间绕两个轴转动法兰",
    ),
    (
        "{}: the scale is {}; allowed is a finite number above 0",
        "{0~}：scale 为 {1}；允许大于 0 的有限的数",
    ),
    (
        "{}: the surface encloses no volume: {} m³ in a box of {} by {} by {} m",
        "{0~}：表面没有围出体积：在 {2} × {3} × {4} m 的范围内为 {1} m³",
    ),
    (
        "{}: the {} at {}, whose flange is up to {} mm ({} mm on average) and {} degrees from where its sheet has it",
        "{0}：{2} 处的 {1}，其法兰与数据表中的位置最多相差 {3} mm（平均 {4} mm）和 {5} 度",
    ),
    ("{}: up to {}, in cycle {}", "{0}：最多 {1}，在周期 {2}"),
    (
        "{}: {} and {} run {} mm into each other in line {} at {} s",
        "{0~}：{1~}与{2~}重叠 {3} mm，第 {4} 行，{5} s 时",
    ),
    (
        "{}: {} cycles as a bag of ROS 2",
        "{0}：{1} 个周期，写为 ROS 2 的 bag",
    ),
    (
        "{}: {} cycles, {} missing, {} out of order left out, {} lost here, {} reconnects{}",
        "{0}：{1} 个周期，缺失 {2} 个，乱序略去 {3} 个，本机丢失 {4} 个，重新连接 {5} 次{6~}",
    ),
    (
        "{}: {} has an unknown key `{}`; the keys are {}",
        "{0}：{1~}中有未知的键 `{2}`；可用的键为 {3~}",
    ),
    ("{}: {} has no `{}`; {}", "{0}：{1~}中没有 `{2}`；{3~}"),
    ("{}: {} has {} = nothing; {}", "{0}：{1} 没有 {2}；{3~}"),
    ("{}: {} has {} = {}; {}", "{0}：{1} 的 {2} = {3}；{4~}"),
    (
        "{}: {} has {} triangles and {} cm³, its convex pieces ({}) keep within {} mm",
        "{0}：{1} 有 {2} 个三角形、{3} cm³，其凸块（{4} 个）偏差在 {5} mm 以内",
    ),
    ("{}: {} robots can be started", "{0}：可以启动 {1} 个机器人"),
    (
        "{}:{}: there are two tests called {}; only the second would ever run",
        "{0}:{1}：有两个名为 {2} 的测试；只有第二个会运行",
    ),
    (
        "{}:{}: {} takes arguments; a test is called without any",
        "{0}:{1}：{2} 有参数；测试调用时没有参数",
    ),
    ("{}; the program may go on", "{0~}；程序可能仍在运行"),
    ("{}; trying again", "{0~}；正在重试"),
    ("| line | name | what |", "| 行 | 名称 | 说明 |"),
    ("| {} | `{}` | {} |", "| {0} | `{1}` | {2~} |"),
];
