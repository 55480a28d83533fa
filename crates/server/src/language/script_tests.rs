//! What tests of robot programs report, in Chinese, in the order of the English ones. A test holds them against the
//! source. Apart from the other sentences, since what programs say themselves stands beside them.

/// Findings of the object `test`, and the report.
pub(super) const SENTENCES: &[(&str, &str)] = &[
    (
        "a name in functions is {}, not a text",
        "functions 中的一个名称为 {0}，不是字符串",
    ),
    (
        "a program runs already; wait for its end or stop it first",
        "已有程序在运行；请先等待其结束或将其停止",
    ),
    (
        "a program was stopped and has not ended within {} s",
        "程序被停止，{0} s 内没有结束",
    ),
    ("again: {}", "再次运行：{0}"),
    (
        "always: `{}` did not hold at {} s, cycle {}",
        "always：`{0}` 不成立，时刻 {1} s，周期 {2}",
    ),
    (
        "always: `{}` did not hold at {} s, cycle {}, line {} of the program",
        "always：`{0}` 不成立，时刻 {1} s，周期 {2}，程序第 {3} 行",
    ),
    (
        "always: `{}` did not hold at {} s, cycle {}, line {} of the program; {}",
        "always：`{0}` 不成立，时刻 {1} s，周期 {2}，程序第 {3} 行；{4~}",
    ),
    (
        "always: `{}` did not hold at {} s, cycle {}, line {} of the test",
        "always：`{0}` 不成立，时刻 {1} s，周期 {2}，测试第 {3} 行",
    ),
    (
        "always: `{}` did not hold at {} s, cycle {}, line {} of the test; {}",
        "always：`{0}` 不成立，时刻 {1} s，周期 {2}，测试第 {3} 行；{4~}",
    ),
    (
        "always: `{}` did not hold at {} s, cycle {}; {}",
        "always：`{0}` 不成立，时刻 {1} s，周期 {2}；{3~}",
    ),
    (
        "another server of this test has that port",
        "此测试的另一个服务器已占用该端口",
    ),
    (
        "answers[{}] must be a text, bytes, or a function of the message, not {}",
        "answers[{0}] 应为字符串、bytes 或以消息为参数的函数，不能是 {1}",
    ),
    ("cannot read the program {}: {}", "无法读取程序 {0}：{1~}"),
    (
        "cannot read {}: {}; eliteserver test --update writes it from this run",
        "无法读取 {0}：{1}；eliteserver test --update 会由本次运行写出它",
    ),
    (
        "distances are measured in tests whose file names test.clearance()",
        "只有文件中出现 test.clearance() 的测试才测量间隙",
    ),
    (
        "frame is {}; allowed are \"base\" and \"tool\"",
        "frame 为 {0}；允许 \"base\" 和 \"tool\"",
    ),
    (
        "function must be callable, not {}",
        "function 必须可调用，不能是 {0}",
    ),
    (
        "functions must be a dict from names to functions or values, not {}",
        "functions 应为由名称到函数或值的 dict，不能是 {0}",
    ),
    ("line {}: {}", "第 {0} 行：{1~}"),
    (
        "names are the columns of --csv /cycle, line, program, command and the names of modes; functions are norm, and part, held, count, fallen of a cell with parts",
        "可用的名称有 --csv /cycle 的各列、line、program、command 和各模式的名称；函数有 norm，以及带工件单元的 part、held、count、fallen",
    ),
    (
        "never: `{}` held at {} s, cycle {}",
        "never：`{0}` 成立，时刻 {1} s，周期 {2}",
    ),
    (
        "never: `{}` held at {} s, cycle {}, line {} of the program",
        "never：`{0}` 成立，时刻 {1} s，周期 {2}，程序第 {3} 行",
    ),
    (
        "never: `{}` held at {} s, cycle {}, line {} of the program; {}",
        "never：`{0}` 成立，时刻 {1} s，周期 {2}，程序第 {3} 行；{4~}",
    ),
    (
        "never: `{}` held at {} s, cycle {}, line {} of the test",
        "never：`{0}` 成立，时刻 {1} s，周期 {2}，测试第 {3} 行",
    ),
    (
        "never: `{}` held at {} s, cycle {}, line {} of the test; {}",
        "never：`{0}` 成立，时刻 {1} s，周期 {2}，测试第 {3} 行；{4~}",
    ),
    (
        "never: `{}` held at {} s, cycle {}; {}",
        "never：`{0}` 成立，时刻 {1} s，周期 {2}；{3~}",
    ),
    (
        "no simulated time passed for {} s: something computes without waiting (--wall-timeout)",
        "{0} s 内没有仿真时间流逝：有程序只计算而不等待（--wall-timeout）",
    ),
    ("nobody waits for the test any more", "不再有人等待这个测试"),
    (
        "nothing has moved yet, or there is nothing that could be touched",
        "还没有运动，或没有可能碰到的物体",
    ),
    (
        "port is {}; allowed are whole numbers from 0 to 65535, 0 is any",
        "port 为 {0}；允许 0 到 65535 的整数，0 为任意端口",
    ),
    (
        "pose is {}; six numbers of at most {} are needed: x, y, z in m, Rx, Ry, Rz in rad",
        "pose 为 {0}；需要六个绝对值不超过 {1} 的数：x、y、z（m），Rx、Ry、Rz（rad）",
    ),
    ("printed:", "输出："),
    ("seven numbers are needed", "需要七个数"),
    ("slowest: {}", "最慢：{0}"),
    (
        "state is {}; allowed are \"normal\", \"protective_stop\" and \"emergency_stop\"",
        "state 为 {0}；允许 \"normal\"、\"protective_stop\" 和 \"emergency_stop\"",
    ),
    (
        "the answer to message {} must be a text, bytes or None, not {}",
        "对第 {0} 条消息的回答应为字符串、bytes 或 None，不能是 {1}",
    ),
    (
        "the arm is not ready after {} s: its robot mode is {}, its safety mode {}",
        "{0} s 后机械臂仍未就绪：机器人模式为 {1}，安全模式为 {2}",
    ),
    ("the call is no XML-RPC", "调用不是 XML-RPC"),
    (
        "the cell has no parts: none of its tables is [world], [[part]], [[gripper]] and their like",
        "单元中没有工件：没有 [world]、[[part]]、[[gripper]] 等表",
    ),
    ("the condition cannot be read:", "无法读取条件："),
    (
        "the file has {} bytes, at most {} are read",
        "文件有 {0} 字节，最多读取 {1} 字节",
    ),
    ("the first line must be {}", "第一行应为 {0}"),
    (
        "the program under test did not end in its time",
        "被测程序没有按时结束",
    ),
    (
        "the program under test did not end in its time in line {}",
        "被测程序在第 {0} 行没有按时结束",
    ),
    ("the program under test ended", "被测程序结束"),
    (
        "the program under test ended by a protective stop",
        "被测程序因保护性停止而结束",
    ),
    (
        "the program under test ended by a protective stop in line {}",
        "被测程序在第 {0} 行因保护性停止而结束",
    ),
    (
        "the program under test ended by an emergency stop",
        "被测程序因紧急停止而结束",
    ),
    (
        "the program under test ended by an emergency stop in line {}",
        "被测程序在第 {0} 行因紧急停止而结束",
    ),
    (
        "the program under test ended in line {}",
        "被测程序在第 {0} 行结束",
    ),
    ("the program under test failed", "被测程序失败"),
    (
        "the program under test failed in line {}",
        "被测程序在第 {0} 行失败",
    ),
    ("the program under test was stopped", "被测程序被停止"),
    (
        "the program under test was stopped in line {}",
        "被测程序在第 {0} 行被停止",
    ),
    (
        "the program was stopped and had not ended after {} s",
        "程序被停止，{0} s 后仍未结束",
    ),
    ("the test emergency_stop", "测试因紧急停止而结束"),
    ("the test failed", "测试失败"),
    (
        "the test had not ended after {} s of simulated time (--timeout)",
        "仿真时间 {0} s 后测试仍未结束（--timeout）",
    ),
    ("the test is over", "测试已结束"),
    (
        "the test is too long for conditions: {} cycles were not kept",
        "测试对条件来说太长：有 {0} 个周期没有保留",
    ),
    ("the test protective_stop", "测试因保护性停止而结束"),
    ("the test stopped", "测试被停止"),
    ("the test timeout", "测试超时"),
    ("there is no gripper {}", "没有夹爪 {0}"),
    ("there is no method {}", "没有方法 {0}"),
    ("there is no sink {}", "没有工件出口 {0}"),
    ("timeout: {}", "超时：{0~}"),
    (
        "w is {}; six numbers are needed: force in N, moment in Nm",
        "w 为 {0}；需要六个数：力（N）、力矩（Nm）",
    ),
    (
        "{} answers, at most {} are taken",
        "{0} 个回答，最多 {1} 个",
    ),
    (
        "{} does not compile: line {}: {}",
        "{0} 不能编译：第 {1} 行：{2~}",
    ),
    ("{} has no cycle", "{0~}没有周期"),
    (
        "{} is not within {} of {}: {}",
        "{0} 与 {2} 的差不在 {1} 以内：{3~}",
    ),
    (
        "{} is {}; allowed are numbers from {} to {}",
        "{0} 为 {1}；允许 {2} 到 {3} 的数",
    ),
    ("{} must be a text, not {}", "{0} 应为字符串，不能是 {1}"),
    (
        "{} passed, {} could not be run; {} simulated in {}",
        "通过 {0}，无法运行 {1}；仿真 {2}，用时 {3}",
    ),
    (
        "{} passed, {} failed, {} could not be run; {} simulated in {}",
        "通过 {0}，失败 {1}，无法运行 {2}；仿真 {3}，用时 {4}",
    ),
    (
        "{} passed, {} failed; {} simulated in {}",
        "通过 {0}，失败 {1}；仿真 {2}，用时 {3}",
    ),
    (
        "{} passed; {} simulated in {}",
        "通过 {0}；仿真 {1}，用时 {2}",
    ),
    ("{} servers are open already", "已打开 {0} 个服务器"),
    ("{} simulated in {}", "仿真 {0}，用时 {1}"),
    (
        "{} things wait for their time already",
        "已有 {0} 件事在等待",
    ),
    (
        "{} was expected, but nothing was raised: the value is {}",
        "应引发 {0}，却没有引发异常：值为 {1}",
    ),
    (
        "{} was expected, but this was raised: {}",
        "应引发 {0}，却引发了：{1}",
    ),
    ("{}:{}: {}", "{0}:{1}：{2~}"),
    (
        "{}; columns of replay --csv /cycle can be read as well",
        "{0~}；也可以读取 replay --csv /cycle 的列",
    ),
    (
        "{}[{}] is {}; addresses are whole numbers from 0 to 65535, a value is {}",
        "{0}[{1}] 为 {2}；地址为 0 到 65535 的整数，值应为{3~}",
    ),
    ("… {} lines before", "… 前面还有 {0} 行"),
];

/// What stands in them.
pub(super) const WORDS: &[(&str, &str)] = &[
    ("True or False", "True 或 False"),
    ("a whole number from 0 to 65535", "0 到 65535 的整数"),
    (
        "one has {} items, the other {}",
        "一个有 {0} 项，另一个有 {1} 项",
    ),
    (
        "one has {} items, the other {} at {}",
        "位置 {2}：一个有 {0} 项，另一个有 {1} 项",
    ),
    ("one is a number, the other is not", "一个是数，另一个不是"),
    (
        "one is a number, the other is not at {}",
        "位置 {0}：一个是数，另一个不是",
    ),
    ("part {}", "工件 {0}"),
    ("part {}; {}", "工件 {0}；{1~}"),
    ("the test", "测试"),
    ("they are nested too deeply", "嵌套过深"),
    ("they differ by {}", "相差 {0}"),
    ("they differ by {} at {}", "位置 {1} 处相差 {0}"),
    (
        "{} and {} cannot be compared at {}; numbers and lists of numbers can",
        "位置 {2}：{0} 与 {1} 不能比较；数和数的列表可以",
    ),
    (
        "{} and {} cannot be compared; numbers and lists of numbers can",
        "{0} 与 {1} 不能比较；数和数的列表可以",
    ),
    ("{} was {}", "{0} 为 {1}"),
    ("{} was {} mm from {}", "{0~}与{2~}相距 {1} mm"),
    ("{} was {} mm from {}; {}", "{0~}与{2~}相距 {1} mm；{3~}"),
    ("{} was {}; {}", "{0} 为 {1}；{2~}"),
];
