//! What Python's own functions, types and exceptions are, in English and in Chinese. A test holds the names against
//! those of the language.

/// One sentence about a name in both languages.
pub(super) fn sentence(name: &str) -> Option<(&'static str, &'static str)> {
    let at = NAMES
        .binary_search_by_key(&name, |(known, ..)| known)
        .ok()?;
    Some((NAMES[at].1, NAMES[at].2))
}

/// Python's names with their explanations, in the order of the names.
const NAMES: &[(&str, &str, &str)] = &[
    (
        "ArithmeticError",
        "The base of errors in calculations.",
        "计算错误的基类。",
    ),
    (
        "AssertionError",
        "An `assert` whose condition was false.",
        "`assert` 的条件不成立。",
    ),
    (
        "AttributeError",
        "The object has no such attribute, or it cannot be set.",
        "对象没有该属性，或该属性不能设置。",
    ),
    (
        "BaseException",
        "The base of all exceptions; programs derive theirs from Exception.",
        "所有异常的基类；程序自己的异常应派生自 Exception。",
    ),
    (
        "BaseExceptionGroup",
        "Several exceptions of any kind raised together.",
        "同时引发的一组任意异常。",
    ),
    (
        "BlockingIOError",
        "An operation would have to wait on something that was told not to.",
        "对设为不等待的对象进行的操作本该等待。",
    ),
    (
        "BrokenPipeError",
        "Something was written where nobody reads any more.",
        "写入时另一端已不再读取。",
    ),
    (
        "BufferError",
        "A buffer cannot be changed while it is in use.",
        "缓冲区正在使用，不能更改。",
    ),
    (
        "BytesWarning",
        "A warning about doubtful use of bytes.",
        "关于 bytes 可疑用法的警告。",
    ),
    (
        "ChildProcessError",
        "An operation on a child process failed.",
        "对子进程的操作失败。",
    ),
    (
        "ConnectionAbortedError",
        "The other end gave the connection up.",
        "对方放弃了连接。",
    ),
    (
        "ConnectionError",
        "The base of errors of connections.",
        "连接错误的基类。",
    ),
    (
        "ConnectionRefusedError",
        "The other end refused the connection.",
        "对方拒绝连接。",
    ),
    (
        "ConnectionResetError",
        "The other end reset the connection.",
        "对方重置了连接。",
    ),
    (
        "DeprecationWarning",
        "A warning about something that will go away.",
        "关于将被移除之物的警告。",
    ),
    (
        "EOFError",
        "There was nothing left to read.",
        "已无内容可读。",
    ),
    ("Ellipsis", "The value of `...`.", "`...` 的值。"),
    (
        "EnvironmentError",
        "Another name of OSError.",
        "OSError 的别名。",
    ),
    (
        "Exception",
        "The base of exceptions that programs raise and catch.",
        "程序引发和捕获的异常的基类。",
    ),
    (
        "ExceptionGroup",
        "Several exceptions raised together; `except*` catches them by kind.",
        "同时引发的一组异常；`except*` 按类型捕获。",
    ),
    (
        "FileExistsError",
        "The file is there already.",
        "文件已存在。",
    ),
    (
        "FileNotFoundError",
        "There is no such file or folder.",
        "没有该文件或文件夹。",
    ),
    (
        "FloatingPointError",
        "An error in floating-point arithmetic.",
        "浮点运算错误。",
    ),
    (
        "FutureWarning",
        "A warning about something that will mean something else.",
        "关于含义将改变之物的警告。",
    ),
    (
        "GeneratorExit",
        "Raised in a generator that is closed.",
        "生成器被关闭时在其中引发。",
    ),
    ("IOError", "Another name of OSError.", "OSError 的别名。"),
    (
        "ImportError",
        "A module, or a name of it, cannot be imported.",
        "模块或其中的名称不能导入。",
    ),
    (
        "ImportWarning",
        "A warning about a doubtful import.",
        "关于可疑导入的警告。",
    ),
    (
        "IndentationError",
        "The indentation of a text is wrong.",
        "文本的缩进有误。",
    ),
    (
        "IndexError",
        "The index is beyond the end of a sequence.",
        "下标超出序列范围。",
    ),
    (
        "InterruptedError",
        "A signal interrupted a system call.",
        "系统调用被信号中断。",
    ),
    (
        "IsADirectoryError",
        "It is a folder where a file was expected.",
        "应为文件之处是文件夹。",
    ),
    (
        "KeyError",
        "A dict does not have this key.",
        "字典没有该键。",
    ),
    (
        "KeyboardInterrupt",
        "The person at the keyboard interrupted the program.",
        "操作者用键盘中断了程序。",
    ),
    (
        "LookupError",
        "The base of IndexError and KeyError.",
        "IndexError 与 KeyError 的基类。",
    ),
    (
        "MemoryError",
        "The memory of the task is used up.",
        "任务的内存已用尽。",
    ),
    (
        "ModuleNotFoundError",
        "There is no module of this name.",
        "没有该名称的模块。",
    ),
    ("NameError", "Nothing has this name.", "该名称未定义。"),
    (
        "NotADirectoryError",
        "It is a file where a folder was expected.",
        "应为文件夹之处是文件。",
    ),
    (
        "NotImplemented",
        "What an operator's method returns where it does not know the other operand.",
        "运算符方法不认识另一操作数时返回的值。",
    ),
    (
        "NotImplementedError",
        "A method that derived classes have to provide.",
        "须由派生类提供的方法。",
    ),
    (
        "OSError",
        "The system refused an operation; `errno` tells why.",
        "系统拒绝了操作；原因见 `errno`。",
    ),
    (
        "OverflowError",
        "The result of a calculation is too large.",
        "计算结果过大。",
    ),
    (
        "PendingDeprecationWarning",
        "A warning about something that will go away later.",
        "关于以后将被移除之物的警告。",
    ),
    ("PermissionError", "It is not permitted.", "没有权限。"),
    (
        "ProcessLookupError",
        "There is no such process.",
        "没有该进程。",
    ),
    (
        "RecursionError",
        "Calls are nested too deeply.",
        "调用嵌套过深。",
    ),
    (
        "ReferenceError",
        "What a weak reference meant is gone.",
        "弱引用所指的对象已不存在。",
    ),
    (
        "ResourceWarning",
        "A warning about something that was not closed.",
        "关于未关闭资源的警告。",
    ),
    (
        "RuntimeError",
        "An error that has no kind of its own.",
        "没有专门类型的错误。",
    ),
    (
        "RuntimeWarning",
        "A warning about doubtful behaviour.",
        "关于可疑行为的警告。",
    ),
    (
        "StopAsyncIteration",
        "An asynchronous iterator has no more values.",
        "异步迭代器没有更多的值。",
    ),
    (
        "StopIteration",
        "An iterator has no more values.",
        "迭代器没有更多的值。",
    ),
    ("SyntaxError", "A text is no program.", "文本不符合语法。"),
    (
        "SyntaxWarning",
        "A warning about doubtful syntax.",
        "关于可疑语法的警告。",
    ),
    (
        "SystemError",
        "An error within the interpreter.",
        "解释器内部错误。",
    ),
    (
        "SystemExit",
        "Ends the program where nothing catches it.",
        "若未被捕获则结束程序。",
    ),
    (
        "TabError",
        "Indentation mixes blanks and tabs.",
        "缩进混用空格与制表符。",
    ),
    (
        "TimeoutError",
        "Something took longer than it may.",
        "操作超时。",
    ),
    (
        "TypeError",
        "A value is of a type that does not fit.",
        "值的类型不符。",
    ),
    (
        "UnboundLocalError",
        "A local variable has no value yet.",
        "局部变量尚未赋值。",
    ),
    (
        "UnicodeDecodeError",
        "Bytes are no text in this encoding.",
        "字节不是该编码的文本。",
    ),
    (
        "UnicodeEncodeError",
        "A text has no form in this encoding.",
        "文本不能用该编码表示。",
    ),
    (
        "UnicodeError",
        "The base of errors of encodings.",
        "编码错误的基类。",
    ),
    (
        "UnicodeTranslateError",
        "A text cannot be translated.",
        "文本不能转换。",
    ),
    (
        "UnicodeWarning",
        "A warning about doubtful text.",
        "关于可疑文本的警告。",
    ),
    (
        "UserWarning",
        "A warning that a program gives.",
        "程序给出的警告。",
    ),
    (
        "ValueError",
        "A value is of the right type, but does not fit.",
        "值的类型正确但不合适。",
    ),
    ("Warning", "The base of warnings.", "警告的基类。"),
    ("ZeroDivisionError", "A division by zero.", "除数为零。"),
    (
        "__debug__",
        "True; `assert` statements count.",
        "为 True；`assert` 语句有效。",
    ),
    (
        "__import__",
        "Imports the module of this name, as `import` does.",
        "导入该名称的模块，同 `import`。",
    ),
    (
        "__name__",
        "The name of the module; of the program it is `__main__`.",
        "模块的名称；程序的为 `__main__`。",
    ),
    ("abs", "The absolute value of a number.", "数的绝对值。"),
    (
        "all",
        "Whether all values are true; of none at all it is True.",
        "是否所有值都为真；没有值时为 True。",
    ),
    (
        "any",
        "Whether any value is true; of none at all it is False.",
        "是否有任一值为真；没有值时为 False。",
    ),
    (
        "ascii",
        "The value as `repr` shows it, with all beyond ASCII escaped.",
        "同 `repr`，非 ASCII 字符用转义表示。",
    ),
    (
        "bin",
        "A whole number as binary digits with the prefix `0b`.",
        "整数的二进制文本，前缀 `0b`。",
    ),
    (
        "bool",
        "Whether a value is true: zero, None and what is empty are not.",
        "值的真假：零、None 和空的值为假。",
    ),
    (
        "bytearray",
        "Bytes that can be changed: of a text, of numbers from 0 to 255, or so many zeros.",
        "可更改的字节序列：由文本、0 到 255 的数或零的个数得到。",
    ),
    (
        "bytes",
        "Bytes that cannot be changed: of a text, of numbers from 0 to 255, or so many zeros.",
        "不可更改的字节序列：由文本、0 到 255 的数或零的个数得到。",
    ),
    (
        "callable",
        "Whether a value can be called.",
        "值是否可以调用。",
    ),
    (
        "chr",
        "The character with this number in Unicode.",
        "Unicode 编号对应的字符。",
    ),
    (
        "classmethod",
        "Makes a method that finds the class in front of its arguments.",
        "使方法的第一个实参为类。",
    ),
    (
        "compile",
        "Makes code of a text, for `exec` and `eval`.",
        "把文本编译为供 `exec` 和 `eval` 使用的代码。",
    ),
    (
        "complex",
        "A complex number of a real and an imaginary part, or of a text.",
        "由实部和虚部或文本得到的复数。",
    ),
    (
        "delattr",
        "Deletes an attribute by its name.",
        "按名称删除属性。",
    ),
    (
        "dict",
        "A dictionary: of pairs, of another one, or of keyword arguments.",
        "字典：由键值对、另一字典或关键字实参得到。",
    ),
    (
        "dir",
        "The names that an object has, in order; without one those in the present scope.",
        "对象所有名称的有序列表；无实参时为当前作用域的名称。",
    ),
    (
        "divmod",
        "Quotient and remainder: `(a // b, a % b)`.",
        "商和余数：`(a // b, a % b)`。",
    ),
    (
        "enumerate",
        "Pairs of a count and a value, counting from `start`.",
        "计数与值的对，从 `start` 起计数。",
    ),
    (
        "eval",
        "The value of an expression that is given as a text.",
        "以文本给出的表达式的值。",
    ),
    (
        "exec",
        "Executes statements that are given as a text.",
        "执行以文本给出的语句。",
    ),
    ("exit", "Ends the program.", "结束程序。"),
    (
        "filter",
        "The values for which a function is true.",
        "使函数为真的那些值。",
    ),
    (
        "float",
        "A floating-point number of a number or a text.",
        "由数或文本得到的浮点数。",
    ),
    (
        "format",
        "A value as a text, as a format such as `.3f` says.",
        "按 `.3f` 之类的格式把值写成文本。",
    ),
    (
        "frozenset",
        "A set that cannot be changed.",
        "不可更改的集合。",
    ),
    (
        "getattr",
        "An attribute by its name; `default` where there is none.",
        "按名称取属性；没有时为 `default`。",
    ),
    (
        "globals",
        "The global variables by name.",
        "按名称的全局变量字典。",
    ),
    (
        "hasattr",
        "Whether an object has an attribute of this name.",
        "对象是否有该名称的属性。",
    ),
    (
        "hash",
        "The number by which dicts and sets find a value.",
        "字典和集合查找值所用的数。",
    ),
    (
        "hex",
        "A whole number as hexadecimal digits with the prefix `0x`.",
        "整数的十六进制文本，前缀 `0x`。",
    ),
    (
        "id",
        "A number that tells an object from all others that are there.",
        "区别于其他现存对象的编号。",
    ),
    (
        "input",
        "A line that is read from the person at the keyboard.",
        "从键盘读取的一行文本。",
    ),
    (
        "int",
        "A whole number of a number, cut towards zero, or of a text in a base.",
        "由数（向零取整）或某进制的文本得到的整数。",
    ),
    (
        "isinstance",
        "Whether a value is of a type, of one derived from it, or of any of several.",
        "值是否属于某类型、其派生类型或几个类型之一。",
    ),
    (
        "issubclass",
        "Whether a class is another one or derived from it.",
        "类是否为另一类或其派生类。",
    ),
    (
        "iter",
        "An iterator over the values of an object.",
        "对象各值的迭代器。",
    ),
    (
        "len",
        "The number of things in a list, a text, a dict or another container.",
        "列表、文本、字典等容器中元素的个数。",
    ),
    (
        "list",
        "A list of the values of anything that can be gone through.",
        "由任何可迭代对象的各值组成的列表。",
    ),
    (
        "locals",
        "The local variables by name.",
        "按名称的局部变量字典。",
    ),
    (
        "map",
        "What a function returns for each value.",
        "函数对每个值的返回值。",
    ),
    (
        "max",
        "The largest of the values, or of the arguments; `key` says by what.",
        "各值或各实参中最大者；`key` 指定比较依据。",
    ),
    (
        "min",
        "The smallest of the values, or of the arguments; `key` says by what.",
        "各值或各实参中最小者；`key` 指定比较依据。",
    ),
    (
        "next",
        "The next value of an iterator; `default` where there is none.",
        "迭代器的下一个值；没有时为 `default`。",
    ),
    ("object", "The base of all classes.", "所有类的基类。"),
    (
        "oct",
        "A whole number as octal digits with the prefix `0o`.",
        "整数的八进制文本，前缀 `0o`。",
    ),
    (
        "open",
        "Opens a file, which needs the permission `--allow fs`; use it in `with`, which closes it.",
        "打开文件，须有权限 `--allow fs`；宜用于 `with`，由其关闭。",
    ),
    (
        "ord",
        "The number of a character in Unicode.",
        "字符的 Unicode 编号。",
    ),
    (
        "pow",
        "A power; with a third argument its remainder.",
        "幂；有第三个实参时取余。",
    ),
    (
        "print",
        "Writes the values as texts, with `sep` between them and `end` behind them.",
        "把各值写成文本，以 `sep` 分隔、`end` 结尾。",
    ),
    (
        "property",
        "Makes an attribute of methods that get and set it.",
        "由取值和设值的方法构成属性。",
    ),
    ("quit", "Ends the program.", "结束程序。"),
    (
        "range",
        "Whole numbers from `start` up to `stop`, which is not among them, by `step`.",
        "从 `start` 到 `stop`（不含）、步长为 `step` 的整数。",
    ),
    (
        "repr",
        "A value as a text, as a program would write it where that can be.",
        "值的文本，尽可能与程序中的写法相同。",
    ),
    (
        "reversed",
        "The values from the last to the first.",
        "从最后到最前的各值。",
    ),
    (
        "round",
        "The nearest number with so many digits behind the point; of two as near the even one.",
        "保留若干位小数的最近的数；同样近时取偶数。",
    ),
    (
        "set",
        "A set of the values, each of them once.",
        "由各值组成的集合，每个值一次。",
    ),
    (
        "setattr",
        "Sets an attribute by its name.",
        "按名称设置属性。",
    ),
    (
        "slice",
        "What stands between the brackets of `values[start:stop:step]`.",
        "`values[start:stop:step]` 方括号中的切片。",
    ),
    (
        "sorted",
        "A new list of the values in order; `key` says by what, `reverse` turns it round.",
        "各值排序后的新列表；`key` 指定依据，`reverse` 反序。",
    ),
    (
        "staticmethod",
        "Makes a method that finds neither the object nor the class in front of its arguments.",
        "使方法的实参前既无对象也无类。",
    ),
    (
        "str",
        "A value as a text; bytes with their encoding.",
        "值的文本；字节按编码转换。",
    ),
    (
        "sum",
        "The sum of the values, beginning with `start`.",
        "各值之和，从 `start` 加起。",
    ),
    (
        "super",
        "The methods of the classes that a class is derived from.",
        "基类的方法。",
    ),
    (
        "tuple",
        "A tuple of the values: a list that cannot be changed.",
        "由各值组成的元组：不可更改的列表。",
    ),
    (
        "type",
        "The type of a value; with three arguments a new class.",
        "值的类型；有三个实参时为新的类。",
    ),
    (
        "unichr",
        "The character with this number in Unicode, as `chr`.",
        "Unicode 编号对应的字符，同 `chr`。",
    ),
    (
        "vars",
        "The attributes of an object by name.",
        "对象属性按名称的字典。",
    ),
    (
        "zip",
        "Tuples of the first values, of the second ones, and so on, until the shortest ends.",
        "依次由各个第一个值、第二个值等组成的元组，到最短者结束。",
    ),
];
