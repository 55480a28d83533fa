//! The sentences about texts of programs in Chinese, in the order of the English ones. A test holds them against the
//! source.

/// Findings, labels and advice.
pub(super) const SENTENCES: &[(&str, &str)] = &[
    (
        "'$ LINE' takes a number and a text",
        "'$ LINE' 需要一个数和一段文本",
    ),
    ("'*' may appear only once", "'*' 只能出现一次"),
    (
        "'*' unpacking follows '**' unpacking",
        "'*' 解包不能在 '**' 解包之后",
    ),
    (
        "'/' must follow positional parameters, once and before '*'",
        "'/' 必须在位置参数之后、'*' 之前，且只出现一次",
    ),
    (
        "':' after an expression: only a name, an attribute or an item can be annotated",
        "表达式后的 ':'：只有名称、属性或元素可以带注解",
    ),
    (
        "':=' cannot rebind the iteration variable '{}'",
        "':=' 不能重新绑定迭代变量 '{0}'",
    ),
    (
        "':=' needs parentheses around it here; a statement assigns with '='",
        "这里的 ':=' 需要括号；语句中赋值用 '='",
    ),
    (
        "':=' within a comprehension cannot be used in a class body",
        "类体中的推导式不能使用 ':='",
    ),
    ("'=' assigns, '==' compares", "'=' 用于赋值，'==' 用于比较"),
    (
        "'=' assigns; use '==' to compare",
        "'=' 用于赋值；比较请用 '=='",
    ),
    (
        "'break', 'continue' and 'return' cannot appear in an except* block",
        "'break'、'continue' 和 'return' 不能出现在 except* 块中",
    ),
    (
        "'end' closes the whole statement: write it once, after the last branch",
        "'end' 结束整个语句：只在最后一个分支之后写一次",
    ),
    (
        "'except*' needs the types it takes",
        "'except*' 需要给出异常类型",
    ),
    ("'return' outside a function", "'return' 不在函数内"),
    (
        "'sec' heads a program of its own: nothing else can stand in the same text",
        "'sec' 开头的是独立的程序：同一文本中不能有其他内容",
    ),
    (
        "'self' is the first parameter of a method: def name(self)",
        "'self' 是方法的第一个参数：def name(self)",
    ),
    (
        "'try' needs at least one 'except' or a 'finally'",
        "'try' 至少需要一个 'except' 或 'finally'",
    ),
    ("'yield' inside a comprehension", "推导式中不能有 'yield'"),
    ("'yield' outside a function", "'yield' 不在函数内"),
    (
        "'{} {}': two names side by side mean nothing",
        "'{0} {1}'：两个名称并列没有意义",
    ),
    (
        "'{}' is a keyword and cannot be a name",
        "'{0}' 是关键字，不能用作名称",
    ),
    ("'{}' is imported but never used", "导入了 '{0}' 却从未使用"),
    (
        "'{}' is neither a number nor a name",
        "'{0}' 既不是数也不是名称",
    ),
    ("'{}' is not a number", "'{0}' 不是数"),
    ("'{}' outside a loop", "'{0}' 不在循环内"),
    ("'{}' without a matching {}", "'{0}' 没有对应的{1~}"),
    ("`{}` alone calls nothing", "单独的 `{0}` 没有调用任何函数"),
    ("`{}` has no function `{}`", "`{0}` 没有函数 `{1}`"),
    (
        "`{}` is a function: its arguments are in parentheses",
        "`{0}` 是函数：参数写在圆括号中",
    ),
    (
        "a 'global' line only says which names are global, it sets nothing",
        "'global' 行只声明哪些名称是全局的，不赋值",
    ),
    (
        "a bare 'except:' must be the last one",
        "不带类型的 'except:' 必须是最后一个",
    ),
    (
        "a block begins with ':' and ends with 'end'",
        "块以 ':' 开始，以 'end' 结束",
    ),
    (
        "a block that does nothing has 'pass' in it, a loop that waits 'sync()'",
        "什么都不做的块写 'pass'，等待的循环写 'sync()'",
    ),
    (
        "a bytes literal can hold ASCII characters and escapes only",
        "bytes 中只能有 ASCII 字符和转义",
    ),
    ("a call has parentheses", "调用要带圆括号"),
    ("a comment begins with '#'", "注释以 '#' 开头"),
    (
        "a comprehension cannot unpack with '*'",
        "推导式不能用 '*' 解包",
    ),
    (
        "a decimal number cannot start with 0; write octal numbers as 0o17",
        "十进制数不能以 0 开头；八进制数请写作 0o17",
    ),
    ("a directive needs a line of its own", "指令需要单独一行"),
    (
        "a generator expression needs parentheses unless it is the only argument",
        "生成器表达式不是唯一的参数时需要括号",
    ),
    (
        "a line that begins with '$' is a directive, and this one has no name",
        "以 '$' 开头的行是指令，而这一行没有名称",
    ),
    (
        "a parameter that collects arguments cannot have a default",
        "收集参数的形参不能有默认值",
    ),
    (
        "a pose is a plain list: write [x, y, z, rx, ry, rz] without 'p'",
        "位姿就是普通列表：写成 [x, y, z, rx, ry, rz]，不带 'p'",
    ),
    (
        "a positional argument follows '**' unpacking",
        "位置参数不能在 '**' 解包之后",
    ),
    (
        "a positional argument follows a keyword argument",
        "位置参数不能在关键字参数之后",
    ),
    (
        "a program asks nobody at the robot: popup() shows a message",
        "程序不向机器人旁的人提问：popup() 显示消息",
    ),
    (
        "a relative import finds nothing: a program is no part of a package",
        "相对导入找不到任何模块：程序不属于任何包",
    ),
    (
        "a secondary program takes no parameters",
        "次要程序不能有参数",
    ),
    (
        "a single '}' is not allowed in an f-string; write '}}'",
        "f-string 中不能有单独的 '}'；请写作 '}}'",
    ),
    (
        "a starred expression cannot stand here",
        "这里不能使用带星号的表达式",
    ),
    (
        "a starred target must be in a list or tuple; add a comma: '*name,'",
        "带星号的目标必须在列表或元组中；请加逗号：'*name,'",
    ),
    (
        "a statement with a block needs a line of its own",
        "带块的语句需要单独一行",
    ),
    (
        "a thread is a function that start_thread() begins: write 'def' in place of 'thread'",
        "线程是由 start_thread() 启动的函数：把 'thread' 改为 'def'",
    ),
    ("after this 'break'", "在这个 'break' 之后"),
    ("after this 'continue'", "在这个 'continue' 之后"),
    ("after this 'raise'", "在这个 'raise' 之后"),
    ("after this 'return'", "在这个 'return' 之后"),
    ("an f-string", "f-string"),
    (
        "an f-string field needs an expression",
        "f-string 的字段需要一个表达式",
    ),
    (
        "an object is the first parameter of its methods, called 'self' by custom",
        "对象是其方法的第一个参数，习惯上叫 'self'",
    ),
    (
        "angles are in radians: write d2r(90) in place of 90°",
        "角度以弧度为单位：请用 d2r(90) 代替 90°",
    ),
    (
        "annotated name '{}' can't be {}",
        "带注解的名称 '{0}' 不能是 {1}",
    ),
    (
        "blanks before a tab in the indentation; a tab goes to the next multiple of 8",
        "缩进中制表符之前有空格；制表符对齐到 8 的倍数",
    ),
    ("call it as {}", "调用写作 {0}"),
    ("call it as {}({}{})", "调用写作 {0}({1}{2})"),
    (
        "call sleep() or sync() in it",
        "请在其中调用 sleep() 或 sync()",
    ),
    ("cannot assign to {}", "不能给{0~}赋值"),
    ("cannot delete {}", "不能删除{0~}"),
    (
        "cannot have both 'except' and 'except*' on the same 'try'",
        "同一个 'try' 不能同时有 'except' 和 'except*'",
    ),
    (
        "cannot join a bytes literal and a string literal",
        "bytes 与字符串不能拼接",
    ),
    (
        "cannot use a starred expression here",
        "这里不能使用带星号的表达式",
    ),
    ("closed here", "在此结束"),
    ("did you mean '", "是否想写 '"),
    ("did you mean 'def'", "是否想写 'def'"),
    ("did you mean 'elif'", "是否想写 'elif'"),
    ("did you mean 'for'", "是否想写 'for'"),
    ("did you mean '{}'", "是否想写 '{0}'"),
    ("did you mean {}", "是否想写 {0}"),
    (
        "duplicate argument '{}' in function definition",
        "函数定义中参数 '{0}' 重复",
    ),
    ("expected '!s', '!r' or '!a'", "应为 '!s'、'!r' 或 '!a'"),
    ("expected '(' after '$ LINE:'", "'$ LINE:' 之后应为 '('"),
    ("expected ':' after '$ LINE'", "'$ LINE' 之后应为 ':'"),
    (
        "expected an indented block after {}",
        "{0~}之后应有缩进的块",
    ),
    ("expected {}, found {}", "应为{0~}，却是{1~}"),
    ("first used here", "首次在此使用"),
    (
        "import * only allowed at module level",
        "import * 只能用在模块顶层",
    ),
    ("it has {}", "它有 {0}"),
    ("it is defined here", "在这里定义"),
    (
        "it looks like a blank: write a blank in its place",
        "它看起来像空格：请换成普通空格",
    ),
    (
        "keyword argument '{}' is given twice",
        "关键字参数 '{0}' 重复",
    ),
    (
        "leave out the word 'global' here: names of the top level are global",
        "这里去掉 'global' 一词：顶层的名称就是全局的",
    ),
    (
        "more than {} items in one 'with'",
        "一个 'with' 中超过 {0} 项",
    ),
    (
        "movej() turns the joints to a place, movel() leads the TCP there along a straight line",
        "movej() 以关节运动到目标，movel() 使 TCP 沿直线到达目标",
    ),
    (
        "name '{}' is assigned to before {} declaration",
        "名称 '{0}' 在 {1} 声明之前被赋值",
    ),
    (
        "name '{}' is nonlocal and global",
        "名称 '{0}' 同时声明为 nonlocal 和 global",
    ),
    (
        "name '{}' is parameter and {}",
        "名称 '{0}' 既是参数又声明为 {1}",
    ),
    (
        "name '{}' is used prior to {} declaration",
        "名称 '{0}' 在 {1} 声明之前被使用",
    ),
    (
        "named parameters must follow a bare '*'",
        "单独的 '*' 之后必须有命名参数",
    ),
    (
        "no binding for nonlocal '{}' found",
        "找不到 nonlocal '{0}' 的绑定",
    ),
    ("no way leads past this", "没有路径越过这里"),
    ("nobody can see it: delete it", "它不可见：请删除"),
    (
        "nonlocal declaration not allowed at module level",
        "模块顶层不能有 nonlocal 声明",
    ),
    (
        "numpy is not there: lists, math and the functions for poses are",
        "没有 numpy：可以用列表、math 和位姿函数",
    ),
    (
        "only a name can stand before '=' in a call",
        "调用中 '=' 之前只能是名称",
    ),
    ("only one target may be starred", "只能有一个带星号的目标"),
    ("opened here", "在此打开"),
    (
        "parameter '{}' without a default follows one with a default",
        "没有默认值的参数 '{0}' 在有默认值的参数之后",
    ),
    (
        "private names need a class whose name has at most {} bytes",
        "使用私有名称的类，其名称最多 {0} 字节",
    ),
    ("programs can import {}", "程序可以导入 {0}"),
    (
        "remove it, or call it '_{}' if that is meant",
        "请删除它；若有意如此，可命名为 '_{0}'",
    ),
    (
        "set the name on a line of its own, below this one",
        "在下面单独写一行给它赋值",
    ),
    (
        "several exception types need parentheses",
        "多个异常类型需要括号",
    ),
    ("str(…) makes a text of a value", "str(…) 把值变成文本"),
    (
        "the block was closed by 'end' above, but its lines go on",
        "块已由上面的 'end' 结束，但其行仍在继续",
    ),
    (
        "the character {} (U+{}) has no meaning here",
        "字符 {0}（U+{1}）在此没有意义",
    ),
    (
        "the expression of an f-string field cannot contain '#'",
        "f-string 字段的表达式中不能有 '#'",
    ),
    (
        "the expression of an f-string field cannot contain a backslash",
        "f-string 字段的表达式中不能有反斜杠",
    ),
    ("the name '{}' is not defined", "名称 '{0}' 未定义"),
    (
        "the name in '$ LINE' must be a string literal, not {}",
        "'$ LINE' 中的名称必须是字符串，不能是 {0}",
    ),
    (
        "the node of '$ LINE' must be a whole number from 1 to {}, not {}",
        "'$ LINE' 的节点必须是 1 到 {0} 的整数，不能是 {1}",
    ),
    (
        "the replacement fields of this f-string nest too deeply",
        "这个 f-string 的替换字段嵌套过深",
    ),
    (
        "the text ends after this line continuation '\\'",
        "文本在这个续行符 '\\' 之后结束",
    ),
    (
        "the text has {} bytes, {} are allowed",
        "文本有 {0} 字节，最多允许 {1}",
    ),
    (
        "the text is too large: to read it would take more than {} MiB",
        "文本过大：读取它需要超过 {0} MiB",
    ),
    (
        "the third part of '$ LINE' must be \"before\" or \"after\", not {}",
        "'$ LINE' 的第三部分必须是 \"before\" 或 \"after\"，不能是 {0}",
    ),
    (
        "the variable '{}' is assigned but never used",
        "变量 '{0}' 被赋值却从未使用",
    ),
    (
        "there is a way through this endless loop that does not wait: while it is taken, the loop keeps the controller busy",
        "这个无限循环中有一条不等待的路径：走这条路径时会使控制器一直繁忙",
    ),
    ("there is no directive '{}'", "没有指令 '{0}'"),
    ("there is no module '{}'", "没有模块 '{0}'"),
    (
        "there is no switch: use 'if' and 'elif'",
        "没有 switch：请用 'if' 和 'elif'",
    ),
    (
        "this 'end' closes nothing: no block starts at its column",
        "这个 'end' 没有可结束的块：没有块从它所在的列开始",
    ),
    (
        "this compares and does nothing with the answer",
        "这里做了比较，却没有使用结果",
    ),
    (
        "this expression is deeper than {} levels",
        "这个表达式超过 {0} 层",
    ),
    (
        "this f-string field is never closed: expected '}'",
        "这个 f-string 字段没有结束：缺少 '}'",
    ),
    ("this is its value", "它的值在这里"),
    ("this is never reached", "这里永远不会执行到"),
    (
        "this line begins with a tab, which goes to the next multiple of 8 columns: use blanks, as the lines around it",
        "这一行以制表符开头，制表符跳到 8 的下一个倍数列：请像周围的行一样使用空格",
    ),
    (
        "this line is indented, but no block is open",
        "这一行有缩进，但没有打开的块",
    ),
    (
        "this line's indentation matches no open block",
        "这一行的缩进与任何打开的块都不一致",
    ),
    (
        "this loop asks again and again without waiting in between: it keeps the controller busy",
        "这个循环不断查询而不等待：会使控制器一直繁忙",
    ),
    ("this loop has no way out", "这个循环无法退出"),
    (
        "this loop never ends and never waits: it keeps the controller busy",
        "这个循环既不结束也不等待：会使控制器一直繁忙",
    ),
    ("this nests deeper than {} levels", "嵌套超过 {0} 层"),
    (
        "this number has {} digits, {} are allowed",
        "这个数有 {0} 位，最多允许 {1} 位",
    ),
    (
        "this string is not closed before the line ends",
        "这个字符串在行尾之前没有结束",
    ),
    ("this {} is never closed", "这个{0~}没有结束"),
    (
        "to stop the program where it does not hold, write 'assert' before it",
        "如果要在条件不成立时停止程序，请在前面写 'assert'",
    ),
    (
        "unexpected character after line continuation '\\'",
        "续行符 '\\' 之后有意外的字符",
    ),
    ("use '==' to compare", "比较请用 '=='"),
    (
        "variables are not declared: write 'name = value'",
        "变量无需声明：请写 'name = value'",
    ),
    (
        "write '$ LINE: (7, \"name\")', with \"before\" or \"after\" as third part if wanted",
        "写作 '$ LINE: (7, \"name\")'，需要时第三部分为 \"before\" 或 \"after\"",
    ),
    ("write 'and'", "请写 'and'"),
    ("write 'elif'", "请写 'elif'"),
    (
        "write 'except (A, B):'; to name the exception, 'except A as e:'",
        "请写 'except (A, B):'；命名异常写 'except A as e:'",
    ),
    ("write 'for i in range(3):'", "请写 'for i in range(3):'"),
    (
        "write 'for i in range(first, last + 1):'",
        "请写 'for i in range(first, last + 1):'",
    ),
    (
        "write 'for i in range(n):' or 'while True:'",
        "写 'for i in range(n):' 或 'while True:'",
    ),
    (
        "write 'import math' at the beginning of the program",
        "请在程序开头写 'import math'",
    ),
    (
        "write 'import time' at the beginning of the program",
        "请在程序开头写 'import time'",
    ),
    ("write 'not'", "请写 'not'"),
    ("write 'or'", "请写 'or'"),
    (
        "write 'while not' and the condition",
        "写 'while not' 加条件",
    ),
    ("write 'x += 1'", "请写 'x += 1'"),
    (
        "write a loop: 'while not get_standard_digital_in(0): sync()'",
        "请写循环：'while not get_standard_digital_in(0): sync()'",
    ),
    (
        "write math.pi, and 'import math' at the beginning of the program",
        "请写 math.pi，并在程序开头写 'import math'",
    ),
    ("write {}(…) in place of {}[…]", "把 {1}[…] 改写为 {0}(…)"),
    (
        "{} (U+{}) has no meaning here",
        "{0~}（U+{1}）在这里没有意义",
    ),
    ("{} after the '**' parameter", "{0~}在 '**' 参数之后"),
    (
        "{} cannot be changed by an augmented assignment",
        "{0~}不能用增量赋值修改",
    ),
    ("{} closes nothing", "{0~}没有对应的左括号"),
    ("{} does not match {}", "{0~}与{1~}不匹配"),
    ("{} is never closed", "{0~}没有关闭"),
    ("{} is not supported", "不支持{0~}"),
    ("{}() has no parameter '{}'", "{0}() 没有参数 '{1}'"),
    ("{}() needs '{}'", "{0}() 需要 '{1}'"),
    (
        "{}() takes at most {} arguments, got {}",
        "{0}() 最多接受 {1} 个参数，给出了 {2} 个",
    ),
];

/// What stands in them.
pub(super) const WORDS: &[(&str, &str)] = &[
    ("',' or '}'", "',' 或 '}'"),
    ("',' or the end of the line", "',' 或行尾"),
    ("',' or {}", "',' 或{0~}"),
    ("':' after the dict key", "字典键之后的 ':'"),
    ("':' after {}", "{0~}之后的 ':'"),
    (
        "'def' or 'class' after the decorator",
        "装饰器之后的 'def' 或 'class'",
    ),
    (
        "'else' of the conditional expression",
        "条件表达式的 'else'",
    ),
    ("'if', loop or 'try'", "'if'、循环或 'try'"),
    ("a character of no width", "零宽字符"),
    ("a comparison", "比较"),
    ("a comprehension", "推导式"),
    ("a conditional expression", "条件表达式"),
    ("a dict literal", "字典"),
    ("a function call", "函数调用"),
    ("a lambda", "lambda"),
    ("a list", "列表"),
    ("a literal", "字面量"),
    ("a name", "名称"),
    ("a named expression", "命名表达式"),
    ("a no-break space", "不间断空格"),
    ("a number", "数"),
    ("a set display", "集合"),
    ("a slice", "切片"),
    ("a space of a special width", "特殊宽度的空格"),
    ("a starred expression", "带星号的表达式"),
    ("a string", "字符串"),
    ("a tuple", "元组"),
    ("a wide space", "全角空格"),
    ("a yield expression", "yield 表达式"),
    ("an attribute", "属性"),
    ("an expression", "表达式"),
    ("an indented line", "缩进的行"),
    ("an index", "下标"),
    ("an item", "元素"),
    ("an unknown character", "未知字符"),
    ("string", "字符串"),
    ("the 'elif' condition", "'elif' 条件"),
    ("the 'for' line", "'for' 行"),
    ("the 'if' condition", "'if' 条件"),
    ("the 'match' statement", "'match' 语句"),
    ("the 'type' statement", "'type' 语句"),
    ("the 'while' condition", "'while' 条件"),
    ("the 'with' line", "'with' 行"),
    ("the class header", "类头"),
    ("the end of the block", "块的结尾"),
    ("the end of the expression", "表达式的结尾"),
    ("the end of the line", "行尾"),
    ("the end of the program", "程序的结尾"),
    ("the function header", "函数头"),
    ("the number {}", "数 {0}"),
    ("triple-quoted string", "三引号字符串"),
];
