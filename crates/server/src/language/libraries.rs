//! What libraries and the system say of wrong input, in Chinese, in the order of the English ones: clap of a command line,
//! toml of a file, the system of files and connections.

/// Refusals.
pub(super) const SENTENCES: &[(&str, &str)] = &[
    (
        "'{}' requires a subcommand but one was not provided",
        "'{0}' 需要子命令，却没有给出",
    ),
    (
        "Address already in use (os error 98)",
        "地址已被占用（系统错误 98）",
    ),
    ("Broken pipe (os error 32)", "管道已断开（系统错误 32）"),
    (
        "Cannot allocate memory (os error 12)",
        "内存不足（系统错误 12）",
    ),
    (
        "Cannot assign requested address (os error 99)",
        "本机没有此地址（系统错误 99）",
    ),
    (
        "Connection refused (os error 111)",
        "连接被拒绝（系统错误 111）",
    ),
    (
        "Connection reset by peer (os error 104)",
        "连接被对方重置（系统错误 104）",
    ),
    (
        "Connection timed out (os error 110)",
        "连接超时（系统错误 110）",
    ),
    ("EOF while parsing a list", "数组没有结束"),
    ("EOF while parsing a string", "字符串没有结束"),
    ("EOF while parsing a value", "缺少值，文本已结束"),
    ("EOF while parsing an object", "对象没有结束"),
    ("File exists (os error 17)", "已经存在（系统错误 17）"),
    (
        "File name too long (os error 36)",
        "文件名过长（系统错误 36）",
    ),
    ("File too large (os error 27)", "文件过大（系统错误 27）"),
    ("For more information, try '{}'.", "详细信息请用 '{0}'。"),
    (
        "Input/output error (os error 5)",
        "输入输出错误（系统错误 5）",
    ),
    ("Invalid argument (os error 22)", "参数无效（系统错误 22）"),
    ("Invalid input length: {}", "长度 {0} 无效"),
    (
        "Invalid last symbol {}, offset {}.",
        "最后的字符（代码 {0}，位置 {1}）无效",
    ),
    ("Invalid padding", "末尾的填充无效"),
    (
        "Invalid symbol {}, offset {}.",
        "位置 {1} 的字符（代码 {0}）无效",
    ),
    ("Is a directory (os error 21)", "是文件夹（系统错误 21）"),
    (
        "Network is unreachable (os error 101)",
        "网络不可达（系统错误 101）",
    ),
    (
        "No route to host (os error 113)",
        "没有到主机的路由（系统错误 113）",
    ),
    (
        "No space left on device (os error 28)",
        "磁盘已满（系统错误 28）",
    ),
    (
        "No such device or address (os error 6)",
        "没有此设备或地址（系统错误 6）",
    ),
    (
        "No such file or directory (os error 2)",
        "没有此文件或文件夹（系统错误 2）",
    ),
    ("Not a directory (os error 20)", "不是文件夹（系统错误 20）"),
    (
        "Operation not permitted (os error 1)",
        "不允许的操作（系统错误 1）",
    ),
    ("Permission denied (os error 13)", "没有权限（系统错误 13）"),
    (
        "Read-only file system (os error 30)",
        "文件系统只读（系统错误 30）",
    ),
    (
        "Resource temporarily unavailable (os error 11)",
        "资源暂时不可用（系统错误 11）",
    ),
    (
        "Too many levels of symbolic links (os error 40)",
        "符号链接层数过多（系统错误 40）",
    ),
    (
        "Too many open files (os error 24)",
        "打开的文件过多（系统错误 24）",
    ),
    ("Usage: {}", "用法: {0}"),
    ("[possible values: {}]", "[可选值：{0}]"),
    ("[subcommands: {}]", "[子命令：{0}]"),
    ("a similar argument exists: '{}'", "有相近的参数：'{0}'"),
    ("a similar subcommand exists: '{}'", "有相近的子命令：'{0}'"),
    ("a similar value exists: '{}'", "有相近的值：'{0}'"),
    ("a subcommand '{}' exists", "有子命令 '{0}'"),
    (
        "a value is required for '{}' but none was supplied",
        "{0} 需要一个值，却没有给出",
    ),
    ("cannot parse integer from empty string", "空文本不是整数"),
    ("duplicate field `{}`", "键 `{0}` 重复"),
    ("duplicate key", "键重复"),
    (
        "equal sign is needed when assigning values to '{}'",
        "给 {0} 赋值时需要等号",
    ),
    ("error: {}", "错误：{0~}"),
    ("exit status: {}", "退出状态：{0}"),
    ("expected `{}`", "应为 `{0}`"),
    ("expected `{}` or `{}`", "应为 `{0}` 或 `{1}`"),
    ("expected ident", "应为 true、false 或 null"),
    ("expected value", "应为一个值"),
    ("expected {}", "应为{0~}"),
    ("extra `{}`, expected nothing", "多余的 `{0}`"),
    (
        "failed to lookup address information: Name or service not known",
        "找不到该主机名",
    ),
    (
        "failed to lookup address information: Temporary failure in name resolution",
        "暂时无法解析主机名",
    ),
    ("invalid IP address syntax", "不是 IP 地址"),
    (
        "invalid UTF-8 was detected in one or more arguments",
        "参数中有不是 UTF-8 的文本",
    ),
    (
        "invalid basic string, expected `{}`",
        "字符串没有结束，应为 `{0}`",
    ),
    ("invalid digit found in string", "其中有不是数字的字符"),
    ("invalid escape", "转义序列无效"),
    ("invalid key", "键无效"),
    ("invalid length {}, expected {}", "长度 {0} 无效，应为{1~}"),
    (
        "invalid literal string, expected `{}`",
        "字符串没有结束，应为 `{0}`",
    ),
    ("invalid number", "数无效"),
    ("invalid type: {}, expected {}", "类型无效：{0~}，应为{1~}"),
    ("invalid unicode code point", "Unicode 码位无效"),
    (
        "invalid unquoted key, expected {}",
        "不带引号的键无效，应为{0~}",
    ),
    ("invalid value '{}' for '{}'", "{1} 的值 '{0}' 无效"),
    (
        "invalid value '{}' for '{}': {}",
        "{1} 的值 '{0}' 无效：{2~}",
    ),
    ("invalid value: {}, expected {}", "值无效：{0~}，应为{1~}"),
    ("key must be a string", "键必须是字符串"),
    ("key with no value, expected `{}`", "键没有值，应为 `{0}`"),
    (
        "lone leading surrogate in hex escape",
        "转义序列中缺少代理对的后一半",
    ),
    ("missing field `{}`", "缺少键 `{0}`"),
    ("missing value, expected array", "缺少值"),
    ("number out of range", "数超出范围"),
    ("number too large to fit in target type", "数过大"),
    ("number too small to fit in target type", "数过小"),
    ("number would be zero for non-zero type", "不能为 0"),
    ("recursion limit exceeded", "嵌套过深"),
    ("signal: {}", "信号：{0}"),
    ("some similar arguments exist: {}", "有相近的参数：{0}"),
    ("some similar subcommands exist: {}", "有相近的子命令：{0}"),
    ("some similar values exist: {}", "有相近的值：{0}"),
    ("stream did not contain valid UTF-8", "内容不是 UTF-8"),
    (
        "string values must be quoted, expected literal string",
        "字符串值要加引号",
    ),
    (
        "subcommand '{}' exists; to use it, remove the '{}' before it",
        "有子命令 '{0}'；要使用它，请去掉它前面的 '{1}'",
    ),
    (
        "the argument '{}' cannot be used multiple times",
        "参数 {0} 不能重复给出",
    ),
    (
        "the argument '{}' cannot be used with '{}'",
        "参数 {0} 不能与 '{1}' 一起使用",
    ),
    (
        "the argument '{}' cannot be used with one or more of the other specified arguments",
        "参数 {0} 不能与其他给出的参数一起使用",
    ),
    (
        "the argument '{}' cannot be used with:",
        "参数 {0} 不能与以下参数一起使用：",
    ),
    (
        "the following required arguments were not provided:",
        "缺少以下必需的参数：",
    ),
    (
        "the subcommand '{}' cannot be used with '{}'",
        "子命令 {0} 不能与 '{1}' 一起使用",
    ),
    ("tip: {}", "提示：{0~}"),
    (
        "to pass '{}' as a value, use '{}'",
        "要把 '{0}' 作为值，请写 '{1}'",
    ),
    ("trailing characters", "末尾之后还有内容"),
    ("trailing comma", "末尾多余逗号"),
    ("unclosed array, expected `{}`", "数组没有结束，应为 `{0}`"),
    (
        "unclosed inline table, expected `{}`",
        "内联表没有结束，应为 `{0}`",
    ),
    ("unclosed table, expected `{}`", "表头没有结束，应为 `{0}`"),
    ("unexpected argument '{}' found", "没有参数 '{0}'"),
    ("unexpected end of hex escape", "转义序列没有结束"),
    ("unexpected key or value", "多余的键或值"),
    (
        "unexpected key or value, expected newline, `{}`",
        "多余的键或值，应为换行或 `{0}`",
    ),
    (
        "unexpected value '{}' for '{}' found; no more were expected",
        "多余的值 '{0}'：{1} 不再接受更多的值",
    ),
    (
        "unknown field `{}`, expected `{}`",
        "未知的键 `{0}`，应为 `{1}`",
    ),
    (
        "unknown field `{}`, expected `{}` or `{}`",
        "未知的键 `{0}`，应为 `{1}` 或 `{2}`",
    ),
    (
        "unknown field `{}`, expected one of {}",
        "未知的键 `{0}`，应为以下之一：{1}",
    ),
    (
        "unknown field `{}`, there are no fields",
        "未知的键 `{0}`，这里没有键",
    ),
    (
        "unknown variant `{}`, expected `{}`",
        "未知的值 `{0}`，应为 `{1}`",
    ),
    (
        "unknown variant `{}`, expected `{}` or `{}`",
        "未知的值 `{0}`，应为 `{1}` 或 `{2}`",
    ),
    (
        "unknown variant `{}`, expected one of {}",
        "未知的值 `{0}`，应为以下之一：{1}",
    ),
    ("unrecognized subcommand '{}'", "没有子命令 '{0}'"),
    ("{} is not in {}", "{0} 不在 {1} 之内"),
    ("{}: {}", "{0}：{1~}"),
];

/// What stands in them.
pub(super) const WORDS: &[(&str, &str)] = &[
    ("a boolean", "布尔值"),
    ("a map", "表"),
    ("a sequence", "数组"),
    ("a string", "字符串"),
    ("an array of length {}", "长度为 {0} 的数组"),
    ("an object", "对象"),
    ("bool", "布尔值"),
    ("boolean `{}`", "布尔值 `{0}`"),
    ("f32", "数"),
    ("f64", "数"),
    ("floating point `{}`", "浮点数 `{0}`"),
    ("i64", "整数"),
    ("integer `{}`", "整数 `{0}`"),
    ("map", "表"),
    ("sequence", "数组"),
    ("string \"{}\"", "字符串 \"{0}\""),
    ("string {}", "字符串 {0}"),
    ("u16", "非负整数"),
    ("u32", "非负整数"),
    ("u64", "非负整数"),
    ("u8", "非负整数"),
    ("usize", "非负整数"),
];
