//! Help texts in Chinese, in the order of the English ones. A test holds them against the command line.

/// Help texts, headings and comments of examples.
pub(super) const HELP: &[(&str, &str)] = &[
    (
        "A TOML file that says what stands around the arm [default: nothing]",
        "说明机械臂周围有什么的 TOML 文件 [默认：无]",
    ),
    (
        "A TOML file whose keys are the names of the options of run",
        "TOML 文件，其键就是 run 的选项名",
    ),
    (
        "A TOML file whose keys are the names of these options; options given here come first",
        "TOML 文件，其键就是这些选项的名称；这里给出的选项优先",
    ),
    (
        "A TOML file with the lengths and twists measured of this very arm; without --model its own counts [default: as the model]",
        "含有这台机械臂实测长度和扭角的 TOML 文件；没有 --model 时以它的型号为准 [默认：同型号值]",
    ),
    (
        "A frame, from rests at its origin, on its x axis, in its xy plane",
        "坐标系：由在原点、x 轴上、xy 平面内的静止段求出",
    ),
    (
        "A function, for everything about it; or words, for the functions that have all of them in name or description",
        "函数名，显示它的全部说明；或若干词，列出名称或说明中含有全部这些词的函数",
    ),
    (
        "A global variable of the session; repeat it for more: --set speed=0.25 --set 'name=\"left\"'",
        "会话的全局变量；可重复给出：--set speed=0.25 --set 'name=\"left\"'",
    ),
    (
        "A global variable that is set before the program; repeat it for more: --set speed=0.25 --set 'name=\"left\"'",
        "程序开始前设置的全局变量；可重复给出：--set speed=0.25 --set 'name=\"left\"'",
    ),
    (
        "A layer of a drawing; repeat it for more [default: all]",
        "图纸的图层；可重复给出 [默认：全部]",
    ),
    (
        "A picture of both and of what is between them",
        "画出两者及其差别",
    ),
    (
        "A recording, or a bag of ROS 2: its folder or an MCAP file",
        "一个记录，或一个 ROS 2 bag：其文件夹或 MCAP 文件",
    ),
    (
        "A script or a recording (.mcap) to debug here, at the terminal; without it an editor talks to the debugger on standard input and output",
        "在终端上调试的脚本或记录（.mcap）；不给出时，由编辑器通过标准输入输出与调试器通信",
    ),
    ("A table", "表格"),
    (
        "Address that every port listens on [default: 127.0.0.1]",
        "所有端口监听的地址 [默认：127.0.0.1]",
    ),
    (
        "Addresses of the machines that the node may speak with: DDS goes out to the network by the interfaces that lead there [default: this machine alone]",
        "节点可以与之通信的机器的地址：DDS 从通往那里的网络接口发出 [默认：仅本机]",
    ),
    (
        "An open controller for Elite Robots CS arms, with a simulated arm",
        "Elite Robots CS 系列机械臂的开放控制器，带仿真机械臂",
    ),
    (
        "An open controller for Elite Robots CS arms, with a simulated arm.\n\nWithout a command it starts the controller, as `serve` does.",
        "Elite Robots CS 系列机械臂的开放控制器，带仿真机械臂。\n\n不给出命令时启动控制器，与 `serve` 相同。",
    ),
    (
        "Another name of this machine, or of a machine whose pages may ask, on the http and Foxglove ports; repeat it for more [default: this machine's own names]",
        "本机的另一个名称，或其页面可以在 http 和 Foxglove 端口上提问的机器的名称；可重复给出 [默认：本机自己的名称]",
    ),
    ("Another one", "另一个记录"),
    (
        "Be a node of ROS 2 as well, named elite_controller: topics, services and the action of the vendor's driver",
        "同时作为 ROS 2 节点，名称为 elite_controller：厂家驱动的主题、服务和动作",
    ),
    (
        "Begin a new file of the recording at this size or after this time: 500MB, 8h [default: one file]",
        "达到此大小或经过此时间后换新的记录文件：500MB、8h [默认：一个文件]",
    ),
    (
        "Begin cycles this long after a multiple of the step on the machine's clock, µs, so that several controllers on one machine do not all wake at once [default: when it starts]",
        "每个周期在本机时钟的步长倍数之后这么久开始，µs，使同一台机器上的多个控制器不会同时醒来 [默认：启动的时刻]",
    ),
    (
        "Begin of what --plot draws, s [default: the whole recording]",
        "--plot 所画的开始时刻，s [默认：整个记录]",
    ),
    (
        "Beside the recording x.mcap write the bag of ROS 2 x: a folder that ros2 bag, rosbags and Foxglove read",
        "在记录 x.mcap 旁写入 ROS 2 bag x：ros2 bag、rosbags 和 Foxglove 可读的文件夹",
    ),
    (
        "Bias of the force sensor, and what hangs below it, from rests",
        "力传感器的零偏及其下所挂物体：由静止段求出",
    ),
    (
        "Check the program, and that the arm reaches every point; status 1 where not",
        "检查程序，并检查机械臂能否到达每个点；不能时状态为 1",
    ),
    ("Chinese", "中文"),
    ("Columns", "分列"),
    (
        "Columns for people, or a JSON array",
        "给人看的分列文本，或一个 JSON 数组",
    ),
    (
        "Compare with another recording, cycle by cycle. Exit status 1 if they differ",
        "与另一个记录逐周期比较。不同时退出状态为 1",
    ),
    (
        "Count the executed lines of the programs under test and write them as an lcov trace file",
        "统计被测程序执行过的行，写成 lcov 跟踪文件",
    ),
    (
        "Cyclic data in both directions [default: 30004]",
        "双向周期数据 [默认：30004]",
    ),
    (
        "Cyclic data out; inputs are refused [default: 30004]",
        "发送周期数据；拒绝输入 [默认：30004]",
    ),
    (
        "Debug a program forwards and backwards: at the terminal, or from an editor (Debug Adapter Protocol)",
        "正向和反向调试程序：在终端上，或由编辑器（Debug Adapter Protocol）进行",
    ),
    (
        "Do not ask before something may move a robot that is not this machine",
        "在可能使本机以外的机器人运动之前不再询问",
    ),
    (
        "Do not follow the program: end once it is sent",
        "不跟踪程序：发送后即结束",
    ),
    (
        "Draw joint positions, speeds, torques and force over time",
        "画出关节位置、速度、力矩和力随时间的变化",
    ),
    ("Draw the cell from two sides", "从两个方向画出单元"),
    (
        "Draw the least distance over time",
        "画出最小间隙随时间的变化",
    ),
    (
        "Dry and viscous friction of each joint",
        "各关节的干摩擦和粘性摩擦",
    ),
    (
        "End in an orderly way when standard input is closed: for whoever starts the server and may vanish",
        "标准输入关闭时有序结束：供启动服务器后可能消失的程序使用",
    ),
    ("End of what --plot draws, s", "--plot 所画的结束时刻，s"),
    ("English", "英文"),
    ("Examples:", "示例："),
    ("Factor of the speeds of the file", "文件中速度的系数"),
    ("Factor of the speeds, 0.05 to 1", "速度的系数，0.05 到 1"),
    (
        "Files and folders with tests. The settings of a test are in test.toml beside it, or in a folder above up to the one named here; its keys are the options of run, timeout and wall-timeout",
        "含有测试的文件和文件夹。测试的设置在其旁边的 test.toml 中，或在上级文件夹中，直到这里给出的文件夹；其键为 run 的选项、timeout 和 wall-timeout",
    ),
    (
        "Find a way around what is in the way and write it as a program; what comes out was driven on a simulated arm. Exit status: 0 a path was found, 1 there is none, 2 wrong arguments",
        "求一条绕过障碍的路径并写成程序；结果已在仿真机械臂上运行过。退出状态：0 找到路径，1 没有路径，2 参数错误",
    ),
    (
        "Find payload, friction, tool, frame or the bias of the force sensor in recordings. Exit status: 0 found, 1 the data cannot tell, 2 unreadable",
        "由记录辨识负载、摩擦、工具、坐标系或力传感器的零偏。退出状态：0 找到，1 数据不足以判断，2 无法读取",
    ),
    (
        "Find where the base should stand so that the arm reaches all points, far from the ends of its joints' ranges. Exit status: 0 found, 1 no place fits, 2 wrong arguments",
        "求基座应放在哪里，使机械臂能到达所有点且远离关节范围的边界。退出状态：0 找到，1 没有合适的位置，2 参数错误",
    ),
    (
        "Folder for the log files that the vendor's controller writes [default: not written]",
        "放置厂家控制器所写日志文件的文件夹 [默认：不写]",
    ),
    (
        "Folder of the task files; names in scripts and commands cannot leave it [default: ./tasks]",
        "任务文件夹；脚本和命令中的名称不能越出它 [默认：./tasks]",
    ),
    ("For people", "给人看"),
    (
        "For people, or one JSON object",
        "给人看的文本，或一个 JSON 对象",
    ),
    (
        "For people, or one JSON object a motion and one for all",
        "给人看的文本，或每个运动一个、总计一个 JSON 对象",
    ),
    (
        "For people, with annotations for GitHub's pages",
        "给人看，并带 GitHub 页面的注释",
    ),
    (
        "Health and metrics [default: 8080]",
        "健康状况和指标 [默认：8080]",
    ),
    ("How far any joint may be apart", "任一关节最多可相差多少"),
    (
        "How far the path may be from that of the file, m",
        "路径与文件中的路径最多可相差多少，m",
    ),
    ("How long to wait, s", "等待多久，s"),
    (
        "How long; otherwise until Ctrl-C",
        "时长；不给出时直到 Ctrl-C",
    ),
    (
        "How many tests run at once [default: one a core]",
        "同时运行多少个测试 [默认：每个核心一个]",
    ),
    (
        "How often, at most what the controller does",
        "频率，最高为控制器的频率",
    ),
    ("How results are told", "如何报告结果"),
    (
        "How services are mapped onto DDS: as by rmw_fastrtps or as by rmw_cyclonedds [default: fastdds]",
        "服务如何映射到 DDS：按 rmw_fastrtps 或按 rmw_cyclonedds [默认：fastdds]",
    ),
    (
        "In its place, run this script here with the recording's arm, tool, payload and start position",
        "代替它：在本机以记录的机械臂、工具、负载和起始位置运行此脚本",
    ),
    ("Inches", "英寸"),
    (
        "Its dashboard, which is asked whether the robot takes programs from outside",
        "它的 dashboard，用来询问机器人是否接受外部程序",
    ),
    ("Its port for cyclic data", "它的周期数据端口"),
    ("Its port for scripts and states", "它的脚本和状态端口"),
    (
        "Its port for statements in interpreter mode",
        "它的解释器模式语句端口",
    ),
    (
        "Its tool centre point from the flange, m and rad [default: 0,0,0,0,0,0]",
        "它从法兰到工具中心点的位姿，m 和 rad [默认：0,0,0,0,0,0]",
    ),
    (
        "Joint acceleration of the program, rad/s²",
        "程序的关节加速度，rad/s²",
    ),
    (
        "Joint positions at start, rad [default: 0,-1.5708,1.5708,-1.5708,-1.5708,0]",
        "开始时的关节位置，rad [默认：0,-1.5708,1.5708,-1.5708,-1.5708,0]",
    ),
    (
        "Joint positions that the path passes; repeat it for more, in this order",
        "路径经过的关节位置；可重复给出，按此顺序",
    ),
    ("Joint speed of the program, rad/s", "程序的关节速度，rad/s"),
    ("Keep the recording of that run", "保留那次运行的记录"),
    (
        "Keep the recordings of failed tests in this folder",
        "把失败测试的记录保留在此文件夹",
    ),
    (
        "Keep this much of finished recordings, remove the oldest: files of this run, and with a new file in ./recordings those of earlier runs [default: all]",
        "保留这么多已完成的记录，删除最旧的：本次运行的文件，以及（记录为 ./recordings 中的新文件时）以前运行的文件 [默认：全部]",
    ),
    (
        "Keep what is driven now as what path_near() compares with",
        "把现在的运动保存为 path_near() 的比较基准",
    ),
    (
        "Lay two recordings over each other and tell how far they are apart. Exit status: 0 within the bound, 1 beyond, 2 unreadable",
        "把两个记录叠在一起，报告相差多少。退出状态：0 在界限内，1 超出，2 无法读取",
    ),
    (
        "Length of a control cycle, 1 to 8 ms [default: 4]",
        "控制周期的长度，1 到 8 ms [默认：4]",
    ),
    (
        "Length of a straight approach against the tool axis, m; in drawings at every contour [default: none]",
        "逆着工具轴线直线进刀的长度，m；图纸中用于每个轮廓 [默认：无]",
    ),
    (
        "Lines that stay as they are: 12-30, or 12; repeat it for more",
        "保持不变的行：12-30 或 12；可重复给出",
    ),
    (
        "List the builtin functions of the script language, search them, or show one. Exit status: 0 shown, 1 none found",
        "列出、查找或显示脚本语言的内置函数。退出状态：0 已显示，1 没有找到",
    ),
    (
        "Listen on this port of this machine for editors, one client after the other; 0: any free port",
        "在本机此端口上等待编辑器连接，一次一个；0：任一空闲端口",
    ),
    (
        "Live data for the Foxglove app [default: off]",
        "供 Foxglove 应用使用的实时数据 [默认：off]",
    ),
    (
        "Live data for the Foxglove app, read-only [default: off]",
        "供 Foxglove 应用使用的实时数据，只读 [默认：off]",
    ),
    (
        "Log lines on stderr for people (text) or machines (json) [default: text]. RUST_LOG filters them",
        "标准错误上的日志行，给人看（text）或给机器看（json）[默认：text]。由 RUST_LOG 过滤",
    ),
    (
        "Longest search, s of this machine's time",
        "最长搜索时间，本机的秒数",
    ),
    (
        "Longest simulated time of a test; over that of test.toml [default: 60]",
        "每个测试的最长仿真时间；优先于 test.toml [默认：60]",
    ),
    (
        "Longest simulated time of the program, s",
        "程序的最长仿真时间，s",
    ),
    (
        "Longest time of the machine in which no simulated time passes; over that of test.toml [default: 30]",
        "没有仿真时间经过的最长本机时间；优先于 test.toml [默认：30]",
    ),
    (
        "Look whether the file can be started, and start nothing",
        "只检查文件能否启动，不启动任何控制器",
    ),
    (
        "Look whether this machine can run the controller as it is set up, and say what to do. Exit status: 0 it can, 1 something keeps it from running",
        "检查本机能否按设置运行控制器，并说明该怎么做。退出状态：0 能，1 有妨碍运行的问题",
    ),
    (
        "Make a program faster that does the same: speeds, blends, waypoints; every step is proven by running it. Prints what changed. Exit status: 0 done, also if nothing can be gained, 1 the program fails or touches something as it is, 2 it cannot be run",
        "把程序改得更快而效果不变：速度、交融、路点；每一步都经运行验证，并打印所作的改动。退出状态：0 完成（没有可加快之处也是 0），1 程序本身失败或碰到物体，2 无法运行",
    ),
    (
        "Mass, centre of gravity and inertia of what hangs on the flange",
        "法兰上所装物体的质量、重心和惯量",
    ),
    ("Messages", "消息"),
    (
        "Messages a second on topics that come cyclically [default: every cycle]",
        "周期性主题每秒的消息数 [默认：每个周期]",
    ),
    ("Metres", "米"),
    ("Millimetres", "毫米"),
    ("One JSON array", "一个 JSON 数组"),
    ("One JSON object", "一个 JSON 对象"),
    ("One JSON object a line", "每行一个 JSON 对象"),
    ("One JSON object a test and line", "每个测试一行 JSON 对象"),
    (
        "One-line commands of the dashboard [default: 29999]",
        "dashboard 的单行命令 [默认：29999]",
    ),
    ("Only list the tests", "只列出测试"),
    (
        "Only tests whose path::name holds this text; one whose name it is exactly runs alone",
        "只运行 path::name 中含有此文本的测试；名称与它完全相同的测试单独运行",
    ),
    (
        "Parse and check scripts without running them. Exit status: 0 clean, 1 findings, 2 unreadable",
        "只解析和检查脚本，不运行。退出状态：0 没有问题，1 有发现，2 无法读取",
    ),
    (
        "Payload, its centre of gravity, and its inertia about that as Ixx,Iyy,Izz,Ixy,Ixz,Iyz: kg, m, kg m² [default: 0]",
        "负载、其重心及绕重心的惯量 Ixx,Iyy,Izz,Ixy,Ixz,Iyz：kg、m、kg m² [默认：0]",
    ),
    (
        "Payload: from the torques of the joints instead of the force reading",
        "负载：用关节力矩代替力读数",
    ),
    ("Ports and server", "端口与服务"),
    ("Ports of --serve", "--serve 的端口"),
    (
        "Print a topic as a table with one header line",
        "把一个主题打印成带一行表头的表格",
    ),
    ("Print help", "显示帮助"),
    (
        "Print help (see a summary with '-h')",
        "显示帮助（摘要用 '-h'）",
    ),
    (
        "Print help (see more with '--help')",
        "显示帮助（详细说明用 '--help'）",
    ),
    (
        "Print the completion script of a shell",
        "打印 shell 的补全脚本",
    ),
    (
        "Print the programs, with when each line ran, how often and how long",
        "打印程序，以及每行何时运行、次数和时长",
    ),
    ("Print the state at this time, s", "打印此时刻的状态，s"),
    (
        "Print this message or the help of the given subcommand(s)",
        "显示此说明或子命令的帮助",
    ),
    ("Print version", "显示版本"),
    (
        "Print when a condition held, the line and the position then: \"safety_mode != normal\"",
        "打印条件何时成立，以及当时的行和位置：\"safety_mode != normal\"",
    ),
    (
        "Process of the editor; the server ends with it, as with the one that 'initialize' names",
        "编辑器的进程；它结束时服务器也结束，与 'initialize' 中给出的进程相同",
    ),
    ("ROS 2", "ROS 2"),
    (
        "Read a cell file: what it describes, which point is connected to what, and what is doubtful. Exit status: 0 clean, 1 findings, 2 unreadable",
        "读取单元文件：它描述了什么，哪个点与什么相连，有什么可疑之处。退出状态：0 没有问题，1 有发现，2 无法读取",
    ),
    (
        "Read a recording: a summary, a state, a table, or run it again",
        "读取记录：摘要、某时刻的状态、表格，或重新运行",
    ),
    (
        "Read the arm's own kinematics from a robot into a calibration file. Exit status: 0 written, 2 not",
        "从机器人读取机械臂自身的运动学参数，写入标定文件。退出状态：0 已写入，2 没有写入",
    ),
    (
        "Record what a robot, real or simulated, does. Exit status: 0 recorded, 2 no connection or no recording",
        "记录真实或仿真机器人的动作。退出状态：0 已记录，2 没有连接或没有记录",
    ),
    (
        "Recordings of `run`, `serve` or `record`",
        "`run`、`serve` 或 `record` 的记录",
    ),
    (
        "Remarks for people, or one JSON object a remark: line, kind, name, text",
        "给人看的说明，或每条一个 JSON 对象：line、kind、name、text",
    ),
    (
        "Rigid bodies with contact, the same in the rapier engine, or an arm that is always where it should be [default: rigid]",
        "带接触的刚体、用 rapier 引擎的刚体，或总在应处位置的机械臂 [默认：rigid]",
    ),
    ("Robot", "机器人"),
    (
        "Robot state as on the primary port, nothing in, in every control mode [default: 30011; any free port where the primary port is not 30001]",
        "与主端口相同的机器人状态，不接收任何内容，适用于所有控制模式 [默认：30011；主端口不是 30001 时为任一空闲端口]",
    ),
    (
        "Robot state out; scripts are refused [default: 30001]",
        "发送机器人状态；拒绝脚本 [默认：30001]",
    ),
    (
        "Run one script to its end without opening ports. Exit status: 0 ended, 1 failed, 2 does not compile",
        "不打开端口，把一个脚本运行到结束。退出状态：0 已结束，1 失败，2 不能编译",
    ),
    (
        "Run the programs in this cell on an ideal arm as well, as far as they go without help from outside, and tell the motions that run into something",
        "还在此单元中的理想机械臂上运行程序，直到需要外部帮助为止，并报告与物体相碰的运动",
    ),
    (
        "Run the recorded commands on a fresh controller and compare. Exit status 1 if a cycle differs",
        "在新的控制器上运行所记录的命令并比较。有周期不同时退出状态为 1",
    ),
    (
        "Run the tests of programs: every test_ function of test_*.script and *_test.script files. Exit status: 0 all passed, 1 some failed, 2 nothing to run",
        "运行程序的测试：test_*.script 和 *_test.script 文件中的每个 test_ 函数。退出状态：0 全部通过，1 有失败，2 没有可运行的测试",
    ),
    (
        "Run the text without a word of what check finds in it",
        "运行时不提示 check 的发现",
    ),
    (
        "Scripts in, robot state out; 0: any free port, off: not started [default: 30001]",
        "接收脚本，发送机器人状态；0：任一空闲端口，off：不启动 [默认：30001]",
    ),
    (
        "Scripts, and folders whose scripts are looked at; - reads stdin",
        "脚本，以及在其中查找脚本的文件夹；- 表示标准输入",
    ),
    (
        "Seed of random() and of every simulated noise [default: 0]",
        "random() 和所有仿真噪声的种子 [默认：0]",
    ),
    (
        "Seed of the order and of every controller; over that of test.toml [default: 0]",
        "测试顺序和每个控制器的种子；优先于 test.toml [默认：0]",
    ),
    (
        "Send a program to a robot, real or simulated, and follow it. Exit status: 0 ended, 1 failed or stopped, 2 not sent",
        "把程序发送到真实或仿真的机器人并跟踪它。退出状态：0 已结束，1 失败或被停止，2 没有发送",
    ),
    (
        "Send the recording through the ports, as if live",
        "像实时一样通过端口发送记录",
    ),
    (
        "Send the text whatever is found in it",
        "不论文本中有什么发现都发送",
    ),
    (
        "Short for --control local: scripts are refused, and clients of the primary port are closed",
        "--control local 的简写：拒绝脚本，并关闭主端口的客户端",
    ),
    (
        "Single lines of script in, their values out [default: 40011; any free port where the primary port is not 30001]",
        "接收单行脚本，返回其值 [默认：40011；主端口不是 30001 时为任一空闲端口]",
    ),
    (
        "Something of the cell that hangs on the flange, as it lies when the arm is at the start",
        "单元中装在法兰上的物体，其位置以机械臂在起点时为准",
    ),
    (
        "Speed at work, m/s [default: that of the file, else 0.05]",
        "加工速度，m/s [默认：文件中的速度，否则 0.05]",
    ),
    (
        "Speed of --serve, 1 is as recorded",
        "--serve 的速度，1 为记录时的速度",
    ),
    (
        "Standard input and output; the only way there is, some editors say so",
        "标准输入输出；这是唯一的方式，有些编辑器会这样给出",
    ),
    (
        "Start many controllers on this machine, a process and an address each, and look after them. SIGHUP restarts one after the other with the file as it is then. Exit status: 0 after a signal, 2 they cannot be started",
        "在本机启动多个控制器并照看它们，每个各有一个进程和地址。收到 SIGHUP 时按当时的文件逐个重启。退出状态：0 收到信号后，2 无法启动",
    ),
    (
        "Start the controller: every service, one simulated arm. Ends with SIGINT or SIGTERM",
        "启动控制器：所有服务和一台仿真机械臂。收到 SIGINT 或 SIGTERM 时结束",
    ),
    (
        "Start with the power off and the brakes engaged, as a real controller does",
        "启动时断电并抱闸，与真实控制器相同",
    ),
    (
        "Statements for interpreter mode [default: 30020]",
        "解释器模式的语句 [默认：30020]",
    ),
    (
        "Status 1 where something of the file is not understood",
        "文件中有不理解的内容时状态为 1",
    ),
    (
        "Stop the program after this long: simulated seconds, or seconds of the machine in which no simulated time passes [default: never]",
        "经过这么久后停止程序：仿真时间的秒数，或没有仿真时间经过的本机秒数 [默认：不停止]",
    ),
    (
        "TCP poses in the frame of the cell, one a line: x y z Rx Ry Rz, m and rad; # begins a comment",
        "单元坐标系中的 TCP 位姿，每行一个：x y z Rx Ry Rz，m 和 rad；# 之后是注释",
    ),
    (
        "Tell how near every motion of a program comes to anything in its cell: the program is run on an ideal arm that contacts do not stop. Exit status: 0 it keeps the margin, 1 it does not or fails, 2 it cannot be run",
        "报告程序的每个运动离单元中的物体有多近：程序在不因接触而停止的理想机械臂上运行。退出状态：0 间隙足够，1 间隙不足或程序失败，2 无法运行",
    ),
    (
        "The DDS domain, 0 to 232 [default: ROS_DOMAIN_ID, else 0]",
        "DDS 域，0 到 232 [默认：ROS_DOMAIN_ID，否则 0]",
    ),
    (
        "The TCP, from rests of its tip at one point",
        "TCP：由尖端停在同一点的各静止段求出",
    ),
    (
        "The TCP: the tip stays at one point while the tool turns",
        "TCP：尖端停在一点，工具绕它转动",
    ),
    (
        "The address of the interface whose whole network the node speaks with [default: this machine alone]",
        "网络接口的地址，节点与其整个网络通信 [默认：仅本机]",
    ),
    (
        "The arm that --check asks, and whose rapid moves may go through joint space [default: cs66]",
        "--check 所用的机械臂，快速移动也可按它在关节空间中进行 [默认：cs66]",
    ),
    (
        "The arm that the scripts are for: what it cannot reach is found as well [default: any arm]",
        "脚本所用的机械臂：它够不到的目标也会被发现 [默认：任意机械臂]",
    ),
    (
        "The arm: cs63, cs66, cs612, cs616, cs620, cs625, or the path of a URDF file [default: cs66]",
        "机械臂：cs63、cs66、cs612、cs616、cs620、cs625，或 URDF 文件的路径 [默认：cs66]",
    ),
    (
        "The base may be turned about its vertical as well",
        "基座也可以绕竖直轴转动",
    ),
    ("The calibration file to write", "要写的标定文件"),
    ("The cell file (TOML)", "单元文件（TOML）"),
    (
        "The controller's own Modbus server [default: 502 where this user may open it, else 5020]",
        "控制器自身的 Modbus 服务器 [默认：此用户可以打开时为 502，否则 5020]",
    ),
    (
        "The distance that every motion has to keep, m",
        "每个运动必须保持的间隙，m",
    ),
    (
        "The distance that is kept at every point, m",
        "在每个点保持的间隙，m",
    ),
    ("The distance that is kept, m", "保持的间隙，m"),
    (
        "The distance that is kept, m; motions that are nearer already come no nearer",
        "保持的间隙，m；原来更近的运动不会变得更近",
    ),
    (
        "The folder; it is made where it is not there",
        "文件夹；不存在时新建",
    ),
    (
        "The frame of the file in the base frame, m and rad [default: 0,0,0,0,0,0]",
        "文件的坐标系在基座坐标系中的位姿，m 和 rad [默认：0,0,0,0,0,0]",
    ),
    (
        "The http port of a controller of ours, which tells what programs print [default: 8080; off where the primary port is not 30001]",
        "本软件控制器的 http 端口，用来显示程序打印的内容 [默认：8080；主端口不是 30001 时为 off]",
    ),
    (
        "The language of findings, errors, stops and, for editors, of hover texts: en or zh [default: that of LANG; for editors that of the client's locale]",
        "发现、错误、停止以及编辑器悬停文本的语言：en 或 zh [默认：LANG 的语言；编辑器用客户端的语言]",
    ),
    (
        "The language server for editors, on standard input and output. Exit status: 0 after 'shutdown', 1 the client vanished",
        "供编辑器使用的语言服务器，通过标准输入输出通信。退出状态：0 收到 'shutdown' 之后，1 客户端消失",
    ),
    (
        "The last piece is a line along the z axis of the tool of this length, m",
        "最后一段是沿工具 z 轴的直线，长度为此值，m",
    ),
    (
        "The line of the program that switches the tool on (M3, M7, M8; begin of a contour)",
        "打开工具的程序行（M3、M7、M8；轮廓开始）",
    ),
    (
        "The line that switches it off (M5, M9; end of a contour)",
        "关闭工具的程序行（M5、M9；轮廓结束）",
    ),
    ("The primary port of the server", "服务器的主端口"),
    (
        "The process of the ROS 2 node, which serve --ros2 starts; nobody else can",
        "ROS 2 节点的进程，由 serve --ros2 启动；其他方式都不能启动",
    ),
    (
        "The program in URScript; - reads it from stdin",
        "URScript 程序；- 表示从标准输入读取",
    ),
    ("The recording", "记录"),
    (
        "The recording of every cycle [default: a new file in ./recordings for serve, off for run]",
        "每个周期的记录 [默认：serve 为 ./recordings 中的新文件，run 为 off]",
    ),
    (
        "The recording; an existing file is replaced",
        "记录；已有的文件会被取代",
    ),
    (
        "The report for people, or as one JSON object",
        "给人看的报告，或一个 JSON 对象",
    ),
    (
        "The robot: a name or an address of a controller, real or ours",
        "机器人：真实或本软件控制器的名称或地址",
    ),
    (
        "The script; - reads it from stdin",
        "脚本；- 表示从标准输入读取",
    ),
    (
        "The serial line at the tool, bytes both ways, with the settings that a program gives it [default: off]",
        "工具端的串口，双向字节，采用程序给出的设置 [默认：off]",
    ),
    ("The shell", "shell 的名称"),
    (
        "The toolpath: .gcode, .nc, .ngc, .dxf or .csv",
        "刀具路径：.gcode、.nc、.ngc、.dxf 或 .csv",
    ),
    (
        "Tool centre point from the flange, m and rad [default: 0,0,0,0,0,0]",
        "从法兰到工具中心点，m 和 rad [默认：0,0,0,0,0,0]",
    ),
    (
        "Tool, frame, sensor: the rests at these times, s, instead of every rest",
        "工具、坐标系、传感器：只用这些时刻的静止段，s，而不是所有静止段",
    ),
    (
        "Tool: the last three rests are the point, the tip moved along tool +x, the tip moved into +y of its xy plane",
        "工具：最后三个静止段依次为该点、尖端沿工具 +x 移动后、尖端移到工具 xy 平面 +y 一侧后",
    ),
    (
        "Tools for assistants that write robot programs (Model Context Protocol), on standard input and output: check, run and test programs on a simulated arm, look functions and recordings up. Files are those beneath the folder it is started in. Exit status: 0 the client has left, 1 it left before it began, 2 it broke the protocol",
        "供编写机器人程序的助手使用的工具（Model Context Protocol），通过标准输入输出通信：在仿真机械臂上检查、运行和测试程序，查询函数和记录。文件限于启动时所在的文件夹之内。退出状态：0 客户端已离开，1 客户端在开始前离开，2 客户端违反协议",
    ),
    (
        "Turn a program of Universal Robots (URScript) into one of this controller. Exit status: 0 complete, 1 something has no counterpart, 2 unreadable",
        "把 Universal Robots 的程序（URScript）变成本控制器的程序。退出状态：0 完整，1 有内容没有对应，2 无法读取",
    ),
    (
        "Turn a toolpath (G-code, DXF, CSV) into a program. Exit status: 0 done, 1 the path is impossible or, with --strict, not wholly understood, 2 unreadable",
        "把刀具路径（G 代码、DXF、CSV）变成程序。退出状态：0 完成，1 路径不可行，或用 --strict 时有不理解的内容，2 无法读取",
    ),
    (
        "Type statements that a robot carries out at once. Exit status: 0, 1 a line of a pipe was discarded or failed, 2 no connection",
        "输入语句，由机器人立即执行。退出状态：0，1 管道中有一行被丢弃或失败，2 没有连接",
    ),
    (
        "Under the virtual clock, simulated seconds a second [default: as many as the node keeps up with]",
        "虚拟时钟下每秒的仿真秒数 [默认：节点跟得上的最大值]",
    ),
    (
        "Unit of the lengths in a table [default: mm]",
        "表格中长度的单位 [默认：mm]",
    ),
    (
        "Use what was recorded from this time on, s",
        "只用此时刻之后的记录，s",
    ),
    (
        "Use what was recorded up to this time, s",
        "只用此时刻之前的记录，s",
    ),
    (
        "Wait until a server answers. Exit status: 0 it does, 1 it did not in time",
        "等待服务器应答。退出状态：0 已应答，1 未及时应答",
    ),
    (
        "Wall time, or simulated time as fast as the machine can [default: realtime for serve, virtual for run]",
        "实际时间，或尽机器所能的仿真时间 [默认：serve 为 realtime，run 为 virtual]",
    ),
    (
        "Watch every program from its start, so that a debugger may attach to one that has begun; programs compute slower then",
        "从一开始就监视每个程序，使调试器可以附加到已开始的程序；程序的计算因此变慢",
    ),
    ("What is looked for", "要辨识什么"),
    (
        "What scripts may reach beyond the robot; repeat it for more, the list replaces the default [default: net]",
        "脚本除机器人之外可以使用什么；可重复给出，所给的列表取代默认值 [默认：net]",
    ),
    (
        "What scripts may reach beyond the robot; repeat it for more, the list replaces the default [default: net]\n\nnet: connections to and from anywhere. net=played: to machines that a test plays, and no others. fs: every file that this user may read or write, nothing is held back. fs=DIR: the files beneath that folder only, no link leads out of it; relative paths count from it. process: programs of this user, which reach files and network themselves. env: environment variables.",
        "脚本除机器人之外可以使用什么；可重复给出，所给的列表取代默认值 [默认：net]\n\nnet：与任何地方建立连接。net=played：只与测试所扮演的机器连接。fs：此用户可以读写的所有文件，不作限制。fs=DIR：只限该文件夹之内的文件，链接也不能越出；相对路径从它算起。process：以此用户运行的程序，它们自己可以使用文件和网络。env：环境变量。",
    ),
    ("What the motion shall tell", "运动要用来辨识什么"),
    (
        "What the names of joints and frames begin with [default: nothing]",
        "关节和坐标系的名称以什么开头 [默认：无]",
    ),
    (
        "What the names of topics, services and the action begin with [default: /]",
        "主题、服务和动作的名称以什么开头 [默认：/]",
    ),
    (
        "Where the base may stand, m [default: as far from the points as the arm reaches]",
        "基座可以放置的区域，m [默认：离各点不超过机械臂的到达距离]",
    ),
    (
        "Where the path begins, rad [default: --home]",
        "路径的起点，rad [默认：--home]",
    ),
    (
        "Where the path ends: six joint positions in rad, or a pose of the TCP in m and rad, 'p[x,y,z,Rx,Ry,Rz]'",
        "路径的终点：六个关节位置（rad），或 TCP 的位姿（m 和 rad），'p[x,y,z,Rx,Ry,Rz]'",
    ),
    ("Where the server runs", "服务器在哪里运行"),
    (
        "Where the tool points, in that frame",
        "工具在该坐标系中的指向",
    ),
    (
        "Where to write process id and ports as JSON once every port listens",
        "所有端口开始监听后，把进程号和端口以 JSON 写到哪里",
    ),
    (
        "Where to write the program [default: standard output]",
        "程序写到哪里 [默认：标准输出]",
    ),
    (
        "Where to write the translated program [default: standard output]",
        "翻译后的程序写到哪里 [默认：标准输出]",
    ),
    (
        "Which program of a recording, from 1 [default: 1]",
        "记录中的第几个程序，从 1 数起 [默认：1]",
    ),
    (
        "Which robots: `[[robot]]` tables with `name`, `bind` and options of `serve`, `[defaults]`",
        "哪些机器人：带 `name`、`bind` 和 `serve` 选项的 `[[robot]]` 表，以及 `[defaults]`",
    ),
    (
        "Who controls the robot at start: the network (remote), the pendant alone (local), or the pendant with remote control switched off in the settings, as it leaves the factory (mixed) [default: remote]",
        "启动时由谁控制机器人：网络（remote）、仅示教器（local），或设置中关闭了远程控制的示教器，即出厂状态（mixed）[默认：remote]",
    ),
    (
        "With --cell: also tell the motions that come nearer to something than this, m",
        "与 --cell 一起：还报告离物体比这更近的运动，m",
    ),
    (
        "With --cell: joint positions at start, rad",
        "与 --cell 一起：开始时的关节位置，rad",
    ),
    (
        "With --cell: tool centre point from the flange, m and rad",
        "与 --cell 一起：从法兰到工具中心点，m 和 rad",
    ),
    ("With the source line and a caret", "带源代码行和插入符"),
    (
        "With the source line and a caret for people, or one JSON object a finding and line",
        "给人看的源代码行和插入符，或每个发现一行 JSON 对象",
    ),
    (
        "Write a page about what was changed and what is missing",
        "写一页报告：改了什么、缺什么",
    ),
    (
        "Write a program whose motion lets `identify` tell. Exit status: 0 written, 2 there is no room for the motion",
        "写一个程序，其运动可供 `identify` 辨识。退出状态：0 已写入，2 没有运动的空间",
    ),
    (
        "Write it as a bag of ROS 2 (MCAP, CDR) into this new folder",
        "写成 ROS 2 的 bag（MCAP、CDR），放入这个新文件夹",
    ),
    (
        "Write the answer as tables of a cell file",
        "把结果写成单元文件的表",
    ),
    ("Write the manual pages into a folder", "把手册页写入文件夹"),
    ("Write the program there", "把程序写到此文件"),
    (
        "Write the program there; without it the program is printed",
        "把程序写到此文件；不给出时打印程序",
    ),
    ("Write the results as JUnit XML", "把结果写成 JUnit XML"),
    ("a recording, backwards as well", "记录，也可反向"),
    (
        "every *.script below the folder",
        "文件夹之内的所有 *.script",
    ),
    ("for an editor", "供编辑器使用"),
    ("on the page, as if live", "在页面上，像实时一样"),
    ("rmw_cyclonedds", "按 rmw_cyclonedds"),
    ("rmw_fastrtps", "按 rmw_fastrtps"),
    (
        "the page is at http://127.0.0.1:8080/",
        "页面在 http://127.0.0.1:8080/",
    ),
];
