//! The sentences about the robot in Chinese, in the order of the English ones. A test holds them against the source.

/// Errors of builtins, refusals, stops, warnings and advice.
pub(super) const SENTENCES: &[(&str, &str)] = &[
    (
        "InternalError: {}; this is a fault of the controller, not of the program: please report it",
        "InternalError: {0}；这是控制器的缺陷，不是程序的：请报告",
    ),
    (
        "RTSI watchdog: {} is not set often enough, {}",
        "RTSI 看门狗：{0} 设置得不够频繁，{1~}",
    ),
    ("SyntaxError: {}", "SyntaxError: {0~}"),
    ("Thread over the max size: {}", "线程数超过上限：{0}"),
    (
        "TimeoutError: a secondary program has to be short, this one was ended after waiting for a second",
        "TimeoutError: 次要程序必须简短，这个程序等待一秒后被结束",
    ),
    ("[SEC] Exception: {}", "[SEC] Exception: {0~}"),
    (
        "a blend radius of {} m is more than there is room for here, it is shortened to {} m",
        "交融半径 {0} m 超出此处的余地，缩短为 {1} m",
    ),
    (
        "a conveyor is tracked already; end that first with stop_conveyor_tracking()",
        "已在跟踪传送带；请先用 stop_conveyor_tracking() 结束",
    ),
    (
        "a direction has no end that could be blended: the blend radius of {} m is not used",
        "方向没有可交融的终点：交融半径 {0} m 不起作用",
    ),
    (
        "a duration of {} s is too short, the motion takes {} s",
        "{0} s 的时间太短，运动需要 {1} s",
    ),
    (
        "a program runs; stop it before a part is placed by hand",
        "程序正在运行；请先停止程序，再手动放置工件",
    ),
    ("a protective stop was asked for", "保护性停止被触发"),
    (
        "a speed of {} {}/s is more than the joints can do here, it is limited to {} {}/s",
        "速度 {0} {1}/s 超出关节在此的能力，限制为 {2} {3}/s",
    ),
    (
        "a turntable is tracked that does not turn the tool; end that first with stop_conveyor_tracking()",
        "正在跟踪不转动工具的转台；请先用 stop_conveyor_tracking() 结束",
    ),
    (
        "an acceleration of {} {}/s² is more than the joints can do here, it is limited to {} {}/s²",
        "加速度 {0} {1}/s² 超出关节在此的能力，限制为 {2} {3}/s²",
    ),
    (
        "an emergency stop was asked for; release it, then power on and release the brakes",
        "紧急停止被触发；请先复位，再上电并松开抱闸",
    ),
    (
        "another motion (command {}) is still running; only one motion at a time can move the arm",
        "另一个运动（命令 {0}）仍在进行；同一时刻只能有一个运动驱动手臂",
    ),
    (
        "bit {} cannot be switched ({}); it stays as it is",
        "第 {0} 位不能切换（{1}），保持不变",
    ),
    (
        "choose another position for the joints between them",
        "请为它们之间的关节选择其他位置",
    ),
    (
        "clean-up behind a stop is ended at line {}: {}",
        "停止后的清理在第 {0} 行结束：{1~}",
    ),
    (
        "collision at joint {}: {} Nm from outside (allowed {} Nm), as a push of {} N at the TCP makes; the sensor at the tool may read another force",
        "关节 {0} 碰撞：外力矩 {1} Nm（允许 {2} Nm），相当于 TCP 处 {3} N 的推力；工具上的传感器可能读到不同的力",
    ),
    ("divide millimetres by 1000", "请把毫米除以 1000"),
    ("emergency stop: {}", "紧急停止：{0~}"),
    (
        "encoder_enable_pulse_decode(): B must be the other one of 16 and 17 in quadrature mode, got {}",
        "encoder_enable_pulse_decode()：正交模式下 B 必须是 16 和 17 中的另一个，给出的是 {0}",
    ),
    (
        "end_interpreter(): interpreter mode is not active, nothing ends",
        "end_interpreter()：解释器模式未启用，没有可结束的",
    ),
    (
        "force mode is on; end it first with end_force_mode()",
        "力控模式已开启；请先用 end_force_mode() 结束",
    ),
    (
        "get_inverse_kin(): no joint positions of {} reach p = {} with this TCP",
        "get_inverse_kin()：{0} 没有关节位置能以此 TCP 到达 p = {1}",
    ),
    (
        "if these are joint positions, movej() is the function for them",
        "如果这些是关节位置，请用 movej()",
    ),
    (
        "internal fault {} in the motion thread; please report it with the recording",
        "运动线程内部故障 {0}；请连同记录一起报告",
    ),
    (
        "interpreter_mode() can only be called in the main thread",
        "interpreter_mode() 只能在主线程中调用",
    ),
    (
        "interpreter_mode() cannot be called inside interpreter mode",
        "interpreter_mode() 不能在解释器模式中调用",
    ),
    (
        "interpreter_mode(): nobody can send statements here, there is no port 30020; run the program on a server (eliteserver serve)",
        "interpreter_mode()：这里无法接收语句，没有 30020 端口；请在服务器上运行程序（eliteserver serve）",
    ),
    (
        "is_within_safety_limits(): either p or q must be given, {}",
        "is_within_safety_limits()：必须给出 p 或 q，{0}",
    ),
    (
        "it switches a second supply at the tool of the large arms, which is not simulated; leave the call out, \
         or define a function of this name",
        "它用于接通大型机械臂工具端的第二路电源，这里不作仿真；请去掉该调用，或自行定义同名函数",
    ),
    ("its parameters are {}", "它的参数有 {0}"),
    (
        "join_thread(): thread {} cannot wait for its own end",
        "join_thread()：线程 {0} 不能等待自身结束",
    ),
    (
        "joint {} does not follow: actual and target differ by {} rad (allowed {} rad); a collision or an overload",
        "关节 {0} 没有跟随：实际与目标相差 {1} rad（允许 {2} rad）；发生碰撞或过载",
    ),
    (
        "joint {} was about to exceed its speed limit: {} rad/s, allowed {} rad/s",
        "关节 {0} 即将超速：{1} rad/s，允许 {2} rad/s",
    ),
    (
        "joint {} was about to leave its range at {} rad (allowed {} to {} rad)",
        "关节 {0} 即将在 {1} rad 处超出范围（允许 {2} 到 {3} rad）",
    ),
    (
        "joint {} would go to {} rad, allowed is {} to {} rad",
        "关节 {0} 将到达 {1} rad，允许 {2} 到 {3} rad",
    ),
    (
        "lengths are in metres: divide millimetres by 1000",
        "长度以米为单位：把毫米除以 1000",
    ),
    (
        "move to a pose with movel(), or turn it into joint positions with get_inverse_kin()",
        "用 movel() 移动到位姿，或用 get_inverse_kin() 换算为关节位置",
    ),
    (
        "no trajectory found for this target (planner error {})",
        "找不到到达该目标的轨迹（规划器错误 {0}）",
    ),
    (
        "path offsets are enabled; end them first with path_offset_disable()",
        "路径偏移已启用；请先用 path_offset_disable() 结束",
    ),
    (
        "path_offset_set(): offset must have components of at most {}, got {}",
        "path_offset_set()：offset 的分量不能超过 {0}，给出的是 {1}",
    ),
    (
        "pause(): nobody is there to resume the program, so it goes on",
        "pause()：没有人可以恢复程序，因此继续执行",
    ),
    ("popup \"{}\": {}", "弹窗 \"{0}\"：{1}"),
    (
        "powerdown(): the arm is switched off",
        "powerdown()：手臂断电",
    ),
    ("protective stop: {}", "保护性停止：{0~}"),
    (
        "rtsi_set_watchdog(): action must be \"ignore\", \"pause\" or \"stop\", got {}",
        "rtsi_set_watchdog()：action 必须是 \"ignore\"、\"pause\" 或 \"stop\"，给出的是 {0}",
    ),
    (
        "rtsi_set_watchdog(): variable must be the name of an RTSI input, got {}",
        "rtsi_set_watchdog()：variable 必须是 RTSI 输入的名称，给出的是 {0}",
    ),
    (
        "safety plane {} of the cell would be crossed there",
        "在那里会越过单元的安全平面 {0}",
    ),
    (
        "set_payload(): m must be 0 to {} kg on {}, got {}",
        "set_payload()：{1} 上 m 必须为 0 到 {0} kg，给出的是 {2}",
    ),
    (
        "socket_open(): {} sockets are open already, more are not allowed; close one with socket_close()",
        "socket_open()：已打开 {0} 个连接，不能再多；请用 socket_close() 关闭一个",
    ),
    (
        "speeds of joints are in rad/s: turn degrees into radians with d2r()",
        "关节速度以 rad/s 为单位：用 d2r() 把度换算为弧度",
    ),
    (
        "start, via point and target make no circular arc: two of them coincide, or they lie on a straight line",
        "起点、中间点和目标点不能构成圆弧：有两点重合，或三点共线",
    ),
    (
        "start_thread() is not supported in interpreter mode",
        "解释器模式不支持 start_thread()",
    ),
    (
        "start_thread(): args must be a tuple or a list, not {}",
        "start_thread()：args 必须是元组或列表，不能是 {0}",
    ),
    (
        "start_thread(): function must be a function, not {}",
        "start_thread()：function 必须是函数，不能是 {0}",
    ),
    ("str_at(): source string empty", "str_at()：源字符串为空"),
    (
        "the TCP was about to exceed its speed limit: {} m/s, allowed {} m/s",
        "TCP 即将超速：{0} m/s，允许 {1} m/s",
    ),
    (
        "the arm can go no further in this direction than {} m: {}",
        "手臂沿该方向最多只能前进 {0} m：{1~}",
    ),
    (
        "the arm is led by hand; this is possible once the input with the action freedrive is low again",
        "手臂正在被手动引导；带有自由驱动动作的输入恢复低电平后才能进行",
    ),
    (
        "the arm passes a singular position there, joint {} would have to turn {} rad at once",
        "手臂在那里经过奇异位置，关节 {0} 须瞬间转动 {1} rad",
    ),
    (
        "the arm slows down: joint {} is near the end of its range or turns too fast for the wanted motion",
        "手臂减速：关节 {0} 接近其范围的边界，或对所需运动而言转动过快",
    ),
    (
        "the arm still decelerates; this is possible once it stands",
        "手臂仍在减速；停稳后才能进行",
    ),
    ("the cell has no parts", "单元中没有工件"),
    (
        "the conveyor carries the TCP to where the arm cannot follow",
        "传送带把 TCP 带到手臂无法跟随之处",
    ),
    (
        "the elbow was about to exceed its speed limit: {} m/s, allowed {} m/s",
        "肘部即将超速：{0} m/s，允许 {1} m/s",
    ),
    (
        "the force at the TCP is {} N (allowed {} N)",
        "TCP 受力为 {0} N（允许 {1} N）",
    ),
    (
        "the left side is {}, the right side is {}",
        "左边为 {0~}，右边为 {1~}",
    ),
    (
        "the left side is {}, the right side is {}, one ends after item {}",
        "左边为 {0~}，右边为 {1~}，其一在下标 {2} 之后结束",
    ),
    (
        "the left side is {}, the right side is {}, they differ first at character {}",
        "左边为 {0~}，右边为 {1~}，首个不同在下标 {2} 处",
    ),
    (
        "the left side is {}, the right side is {}, they differ first at item {}: {} and {}",
        "左边为 {0~}，右边为 {1~}，首个不同在下标 {2} 处：{3} 与 {4}",
    ),
    (
        "the motion stopped at its end instead of blending: the next one came too late or turns too sharply \
         for the speed",
        "运动在终点停下而没有交融：下一个运动来得太晚，或以此速度转弯过急",
    ),
    (
        "the path cannot be followed {} % of the way along: {}",
        "路径在 {0} % 处无法跟随：{1~}",
    ),
    (
        "the path offset is {} m and {} rad; path_offset_set_max_offset() allows {} m and {} rad",
        "路径偏移为 {0} m 和 {1} rad；path_offset_set_max_offset() 允许 {2} m 和 {3} rad",
    ),
    (
        "the path offset leads the TCP to where the arm cannot follow",
        "路径偏移把 TCP 带到手臂无法跟随之处",
    ),
    ("the pose is out of reach", "位姿不可达"),
    ("the program was stopped: ", "程序已停止："),
    (
        "the program was stopped: {} takes its place",
        "程序已停止：由 {0} 取代",
    ),
    (
        "the protective stop ends the program in line {}",
        "保护性停止使程序在第 {0} 行结束",
    ),
    (
        "the robot mode is {} and the safety mode {}; the arm moves only when they are RUNNING and NORMAL or REDUCED",
        "机器人模式为 {0}，安全模式为 {1}；只有在 RUNNING 且 NORMAL 或 REDUCED 时手臂才能运动",
    ),
    (
        "the robot mode is {}, this needs {}",
        "机器人模式为 {0}，此操作需要 {1}",
    ),
    (
        "the target is {} m away, no arm reaches that far: it is taken as a direction, and the arm goes there until \
         something stops it",
        "目标在 {0} m 之外，没有手臂能到达：将其视为方向，手臂沿该方向运动，直到被停止",
    ),
    (
        "the target lies {} m behind safety plane {} of the cell",
        "目标点在单元的安全平面 {1} 之后 {0} m",
    ),
    (
        "the tool was about to cross safety plane {} of the cell: it would come to rest {} m behind it",
        "工具即将越过单元的安全平面 {0}：将停在其后 {1} m 处",
    ),
    ("there is no part \"{}\"", "没有工件 \"{0}\""),
    (
        "there is no word {} in the controller's Modbus map",
        "控制器的 Modbus 表中没有字 {0}",
    ),
    (
        "to_num(): illegal string {}: not a number",
        "to_num()：字符串 {0} 不合法：不是数",
    ),
    ("to_num(): number too large: {}", "to_num()：数过大：{0}"),
    (
        "turn degrees into radians with d2r()",
        "请用 d2r() 把度换算为弧度",
    ),
    (
        "turn joint positions into a pose with get_forward_kin()",
        "用 get_forward_kin() 把关节位置换算为位姿",
    ),
    (
        "word {} cannot be set to {}: {}",
        "字 {0} 不能设为 {1}：{2}",
    ),
    (
        "{} and {} were about to run into each other, by {} mm where the arm would come to rest",
        "{0~}与{1~}即将相撞，手臂停下处重叠 {2} mm",
    ),
    (
        "{} and {} would run into each other there, by {} mm",
        "{0~}与{1~}在那里会相撞，重叠 {2} mm",
    ),
    (
        "{} folds the arm into itself: {} and {} would be in the same place",
        "{0~}会使机械臂碰到自己：{1~}和{2~}会在同一位置",
    ),
    (
        "{} has a position of {}: positions are in metres",
        "{0~}的位置为 {1}：位置以米为单位",
    ),
    (
        "{} has an angle of {}: angles are in radians, and {} is a full turn",
        "{0~}的角度为 {1}：角度以弧度为单位，{2} 为一整圈",
    ),
    (
        "{} is not allowed for word {} ({})",
        "字 {1} 不允许取值 {0}（{2}）",
    ),
    (
        "{} is out of reach: {} m from the shoulder, a {} reaches {} m",
        "{0~}够不到：距肩部 {1} m，{2} 只能到达 {3} m",
    ),
    (
        "{} is out of reach: {} m from the shoulder, a {} with a tool of {} m reaches {} m",
        "{0~}够不到：距肩部 {1} m，{2} 带 {3} m 的工具只能到达 {4} m",
    ),
    (
        "{} is out of reach: {} m from the shoulder, the largest arm with a long tool reaches {} m",
        "{0~}够不到：距肩部 {1} m，最大的机械臂带长工具也只能到达 {2} m",
    ),
    (
        "{} is {} {}, far beyond what the arm can do",
        "{0~}为 {1} {2}，远超机械臂的能力",
    ),
    (
        "{} is {}, allowed are {} to {}; {} is used",
        "{0} 为 {1}，允许 {2} 到 {3}；采用 {4}",
    ),
    ("{} is {}; it must be {}", "{0~} 为 {1}；应为 {2~}"),
    (
        "{} must be \"base\", \"tool\" or a pose, got {}",
        "{0} 必须是 \"base\"、\"tool\" 或位姿，给出的是 {1}",
    ),
    (
        "{} must be a list of {} entries, each 0 or 1, got {} entries",
        "{0} 必须是 {1} 项的列表，每项为 0 或 1，给出了 {2} 项",
    ),
    (
        "{} must be a number other than 0, got {}",
        "{0} 必须是不为 0 的数，给出的是 {1}",
    ),
    ("{} must be {}, got {}", "{0} 必须是{1~}，给出的是 {2}"),
    (
        "{} must be {}, got {} numbers",
        "{0} 必须是{1~}，给出了 {2} 个数",
    ),
    (
        "{} must be {}, not {} ({})",
        "{0} 必须是{1~}，不能是 {2}（{3}）",
    ),
    (
        "{} takes a pose, {}() returns joint positions",
        "{0~}需要位姿，{1}() 返回的是关节位置",
    ),
    (
        "{} takes joint positions, {}() returns a pose",
        "{0~}需要关节位置，{1}() 返回的是位姿",
    ),
    (
        "{}() came with edition {} of the vendor's software; this controller follows edition 2.15",
        "{0}() 从厂家软件 {1} 版开始提供；本控制器遵循 2.15 版",
    ),
    ("{}() has no parameter '{}'", "{0}() 没有参数 '{1}'"),
    (
        "{}() moves the arm and cannot be used in a secondary program (sec)",
        "{0}() 会使手臂运动，不能用在次要程序（sec）中",
    ),
    (
        "{}() moves the arm; only the debug console of a program that runs here may move it",
        "{0}() 会使手臂运动；只有在此处运行的程序的调试控制台才可以使它运动",
    ),
    ("{}() needs '{}'", "{0}() 需要 '{1}'"),
    (
        "{}() takes at most {} arguments, got {}",
        "{0}() 最多接受 {1} 个参数，给出了 {2} 个",
    ),
    (
        "{}() waits and cannot be used in a secondary program (sec)",
        "{0}() 会等待，不能用在次要程序（sec）中",
    ),
    (
        "{}() waits; only the debug console of a program that runs here may wait",
        "{0}() 会等待；只有在此处运行的程序的调试控制台才可以等待",
    ),
    ("{}(): '{}' is given twice", "{0}()：'{1}' 给出了两次"),
    (
        "{}(): '{}' takes {}, but is {}; {}",
        "{0}()：'{1}' 需要{2~}，却是{3~}；{4~}",
    ),
    (
        "{}(): an argument is nested deeper than {}",
        "{0}()：参数嵌套超过 {1} 层",
    ),
    (
        "{}(): index out of range: must be 0 to {}, got {}",
        "{0}()：下标超出范围：必须为 0 到 {1}，给出的是 {2}",
    ),
    (
        "{}(): nobody plays {}:{}, and scripts may use no other machine (--allow net=played)",
        "{0}()：没有测试扮演 {1}:{2}，脚本不允许使用其他机器（--allow net=played）",
    ),
    (
        "{}(): scripts may not use the network; start the server with --allow net",
        "{0}()：脚本不允许使用网络；请以 --allow net 启动服务器",
    ),
    (
        "{}(): the keys of a dictionary must be texts, not {}",
        "{0}()：字典的键必须是文本，不能是 {1}",
    ),
    (
        "{}(): the motion ended with a stop: {}",
        "{0}()：运动因停止而结束：{1~}",
    ),
    (
        "{}(): the result is longer than {} characters: it would have {}",
        "{0}()：结果超过 {1} 个字符：将有 {2} 个",
    ),
    (
        "{}(): the wait ended without a result",
        "{0}()：等待结束但没有结果",
    ),
    (
        "{}(): thread_id must be a handle from start_thread, not {}",
        "{0}()：thread_id 必须是 start_thread 返回的句柄，不能是 {1}",
    ),
    (
        "{}(): thread_id {} was never returned by start_thread",
        "{0}()：start_thread 从未返回过 thread_id {1}",
    ),
    ("{}(): {}", "{0}()：{1~}"),
    (
        "{}(): {} cannot be sent; allowed are None, bool, int, float, str, bytes, list, tuple and dict",
        "{0}()：{1} 不能发送；允许 None、bool、int、float、str、bytes、list、tuple 和 dict",
    ),
    (
        "{}[{}] must be True, False, 0 or 1, got {}",
        "{0}[{1}] 必须是 True、False、0 或 1，给出的是 {2}",
    ),
    (
        "{}[{}] must be a finite number, got {}",
        "{0}[{1}] 必须是有限的数，给出的是 {2}",
    ),
    (
        "{}[{}] must be a number, not {} ({})",
        "{0}[{1}] 必须是数，不能是 {2}（{3}）",
    ),
    (
        "{}[{}] must be {}, got {}",
        "{0}[{1}] 必须是{2~}，给出的是 {3}",
    ),
];

/// Words that stand in sentences.
pub(super) const WORDS: &[(&str, &str)] = &[
    ("'{}' of {}()", "{1}() 的 '{0}'"),
    ("-2147483648 to 2147483647", "-2147483648 到 2147483647"),
    ("0 or more", "不小于 0"),
    ("0 to 1000 kg", "0 到 1000 kg"),
    ("0 to 1000 m/s or rad/s", "0 到 1000 m/s 或 rad/s"),
    ("0 to 16777215", "0 到 16777215"),
    ("0 to 1e9 s", "0 到 1e9 s"),
    ("0 to 255", "0 到 255"),
    ("0 to 3", "0 到 3"),
    ("0 to 4294967295", "0 到 4294967295"),
    ("0 to 65535", "0 到 65535"),
    ("True or False", "True 或 False"),
    ("a component of gravity", "重力的分量"),
    ("a component of speed_limits", "speed_limits 的分量"),
    ("a component of target_wrench", "target_wrench 的分量"),
    ("a component of the external wrench", "外力旋量的分量"),
    ("a component of the payload", "负载的分量"),
    ("a component of the payload's inertia", "负载惯量的分量"),
    ("a component of the push", "推力的分量"),
    ("a coordinate of center", "center 的坐标"),
    ("a coordinate of reference_frame", "reference_frame 的坐标"),
    ("a coordinate of the TCP", "TCP 的坐标"),
    ("a coordinate of the centre of gravity", "重心的坐标"),
    ("a finite number", "有限的数"),
    ("a finite number other than 0", "不为 0 的有限数"),
    ("a list", "列表"),
    ("a list of True and False", "True 和 False 的列表"),
    ("a list of numbers", "数的列表"),
    ("a list of {} numbers", "{0} 个数的列表"),
    ("a list or a string", "列表或字符串"),
    ("a number", "数"),
    ("a number > 0", "大于 0 的数"),
    ("a number >= 0", "不小于 0 的数"),
    ("a number from {} to {}", "{0} 到 {1} 的数"),
    ("a number or a list of numbers", "数或数的列表"),
    ("a pose", "位姿"),
    (
        "a pose [x, y, z, Rx, Ry, Rz] in m and rad",
        "位姿 [x, y, z, Rx, Ry, Rz]（m 和 rad）",
    ),
    ("a pose of finite numbers", "由有限的数组成的位姿"),
    ("a stopped program cannot wait", "已停止的程序不能等待"),
    ("a string", "字符串"),
    ("a text of {} characters: {}", "{0} 个字符的字符串：{1}"),
    ("a {} of {} items", "{1} 项的 {0}"),
    ("a {} of {} items: {}, …", "{1} 项的 {0}：{2}, …"),
    ("an angle of the TCP", "TCP 的角度"),
    ("an integer", "整数"),
    ("an integer of at most 64 bits", "不超过 64 位的整数"),
    ("angles of at most 100 rad", "不超过 100 rad 的角度"),
    ("any finite number", "有限的数"),
    ("at least {}", "至少 {0}"),
    ("at most 10 m", "不超过 10 m"),
    ("at most 100 m from the base", "距基座不超过 100 m"),
    ("at most 1000 m", "不超过 1000 m"),
    ("at most 100000 N or Nm", "不超过 100000 N 或 Nm"),
    ("at most 100000 kg m²", "不超过 100000 kg m²"),
    ("at most 30 m/s²", "不超过 30 m/s²"),
    ("base", "基座"),
    ("forearm", "前臂"),
    ("it has called very many functions", "调用的函数过多"),
    ("it has computed for 0.5 s", "已计算 0.5 秒"),
    ("joint positions", "关节位置"),
    ("more than 0", "大于 0"),
    ("nothing is done", "不做处理"),
    (
        "positive and at most the sum of the other two",
        "正数，且不超过另两个之和",
    ),
    (
        "set after encoder_enable_set_tick_count() for this encoder",
        "在对该编码器调用 encoder_enable_set_tick_count() 之后设置",
    ),
    ("shoulder", "肩部"),
    ("six joint positions in rad", "六个关节位置（rad）"),
    ("the TCP pose", "TCP 位姿"),
    ("the duration of the push", "推力的时长"),
    ("the joint positions of the arm", "手臂的关节位置"),
    (
        "the largest principal moment of the payload's inertia",
        "负载惯量的最大主矩",
    ),
    ("the length of direction", "方向的长度"),
    ("the payload mass", "负载质量"),
    ("the program is paused", "程序暂停"),
    ("the program is stopped", "程序停止"),
    ("the tick count", "计数"),
    ("upper arm", "上臂"),
    ("wrist 1", "手腕 1"),
    ("wrist 2", "手腕 2"),
    ("wrist 3", "手腕 3"),
    ("{} to {}", "{0} 到 {1}"),
];
