//! Manual 9.2, 9.3 and 9.5, and `print` and `sync` of 1.2: the task's own state, messages, time, flags.

use elite_lang::{ExceptionKind, Unwind, Value};
use messages::{Text, text};
use motion_api::{MachineCommand, Seconds};

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Phrase, Range, phrase,
};
use crate::message::{Message, Severity};
use crate::panel::{FLAGS, Operator, Popup, PopupStyle, WatchdogAction, is_rtsi_input};
use crate::task::{Effect, TaskRequest, Wait};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "print",
        section: "1.2.2",
        category: Category::Other,
        summary: phrase(
            "Writes the values, joined by one blank, to the log; to standard output under `run`.",
            "把各值以一个空格连接后写入日志；用 `run` 运行时写到标准输出。",
        ),
        params: &[Parameter {
            default: ParameterDefault::EmptyTuple,
            ..parameter(
                "values",
                ParameterType::Variadic,
                phrase(
                    "what to write; Python's keywords sep and end work too",
                    "要输出的内容；也可用 Python 的关键字参数 sep 和 end",
                ),
            )
        }],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: None,
    },
    Builtin {
        name: "sync",
        section: "1.2.5",
        summary: phrase(
            "Gives up the rest of the control cycle and goes on in the next one.",
            "让出本控制周期的剩余时间，在下一周期继续。",
        ),
        waits: true,
        ..system(sync)
    },
    Builtin {
        name: "pause",
        section: "9.2.1",
        summary: phrase(
            "Holds the whole task until it is resumed from outside; the arm decelerates on its \
             path.",
            "暂停整个任务直到外部恢复；手臂在路径上减速。",
        ),
        ..system(pause)
    },
    Builtin {
        name: "halt",
        section: "9.2.2",
        summary: phrase(
            "Ends the whole task, as a success.",
            "结束整个任务，视为成功。",
        ),
        ..system(halt)
    },
    Builtin {
        name: "textmsg",
        section: "9.3.1",
        summary: phrase(
            "Writes both parts, joined, to the log.",
            "把两部分连接后写入日志。",
        ),
        params: &[
            parameter(
                "s1",
                ParameterType::Printable,
                phrase("first part", "第一部分"),
            ),
            Parameter {
                default: ParameterDefault::EmptyText,
                ..parameter(
                    "s2",
                    ParameterType::Printable,
                    phrase("second part", "第二部分"),
                )
            },
        ],
        ..system(textmsg)
    },
    Builtin {
        name: "popup",
        section: "9.3.2",
        summary: phrase(
            "Shows a window; with blocking=True the thread waits until it is closed, \
                  except in a secondary program.",
            "显示弹窗；blocking=True 时线程等待其关闭，次级程序中除外。",
        ),
        params: &[
            parameter(
                "s",
                ParameterType::Printable,
                phrase("what it says", "显示的内容"),
            ),
            Parameter {
                default: ParameterDefault::Text("Popup"),
                ..parameter(
                    "title",
                    ParameterType::Printable,
                    phrase("the window's title", "窗口标题"),
                )
            },
            flag("warning", phrase("looks like a warning", "以警告样式显示")),
            flag(
                "error",
                phrase(
                    "looks like an error; stronger than warning",
                    "以错误样式显示；优先于 warning",
                ),
            ),
            flag(
                "blocking",
                phrase("wait until the window is closed", "等待窗口关闭"),
            ),
        ],
        ..system(popup)
    },
    Builtin {
        name: "sleep",
        section: "9.5.1",
        summary: phrase("Waits.", "等待。"),
        params: &[Parameter {
            unit: "s",
            ..parameter(
                "t",
                ParameterType::Number(Range::Any),
                phrase(
                    "how long; 0 or less returns at once",
                    "时长；不大于 0 时立即返回",
                ),
            )
        }],
        waits: true,
        ..system(sleep)
    },
    Builtin {
        name: "set_flag",
        section: "9.5.2",
        summary: phrase(
            "Sets an internal flag; it keeps its level when the program ends.",
            "设置内部标志；程序结束后保持。",
        ),
        params: &[
            FLAG_INDEX,
            parameter("b", ParameterType::Boolean, phrase("level", "电平")),
        ],
        ..system(set_flag)
    },
    Builtin {
        name: "get_flag",
        section: "9.5.3",
        summary: phrase("Level of an internal flag.", "内部标志的状态。"),
        params: &[FLAG_INDEX],
        returns: phrase("bool", "bool"),
        ..system(get_flag)
    },
    Builtin {
        name: "get_steptime",
        section: "9.5.4",
        summary: phrase("Length of one control cycle.", "一个控制周期的长度。"),
        returns: phrase("float, s", "float，s"),
        ..system(get_steptime)
    },
    Builtin {
        name: "get_task_path",
        section: "5.36",
        summary: phrase("The folder in which tasks are kept.", "存放任务的目录。"),
        returns: phrase("str", "str"),
        ..system(get_task_path)
    },
    Builtin {
        name: "controller_timestamp",
        section: "9.5.5",
        summary: phrase(
            "The controller's clock; under the virtual clock simulated time since \
             2026-01-01T00:00:00Z.",
            "控制器时钟；虚拟时钟下为自 2026-01-01T00:00:00Z 起的仿真时间。",
        ),
        returns: phrase(
            "float, s since 1970-01-01T00:00:00Z",
            "float，自 1970-01-01T00:00:00Z 起的 s",
        ),
        ..system(controller_timestamp)
    },
    Builtin {
        name: "rtsi_set_watchdog",
        section: "9.5.6",
        summary: phrase(
            "Watches how often an RTSI input is set; the watch ends with the program.",
            "监视 RTSI 输入的设置频率；随程序结束。",
        ),
        params: &[
            parameter(
                "variable",
                ParameterType::Text,
                phrase("name of an RTSI input variable", "RTSI 输入变量的名称"),
            ),
            Parameter {
                unit: "Hz",
                ..parameter(
                    "frequency",
                    ParameterType::Number(Range::Positive),
                    phrase("lowest rate", "最低频率"),
                )
            },
            parameter(
                "action",
                ParameterType::Text,
                phrase(
                    "what happens below it: \"ignore\", \"pause\" or \"stop\"",
                    "低于该频率时的处理：\"ignore\"、\"pause\" 或 \"stop\"",
                ),
            ),
        ],
        ..system(rtsi_set_watchdog)
    },
    Builtin {
        name: "powerdown",
        section: "9.5.7",
        summary: phrase(
            "Ends the task and switches the arm's power off; the server itself goes on.",
            "结束任务并关闭手臂电源；服务器继续运行。",
        ),
        ..system(powerdown)
    },
];

const FLAG_INDEX: Parameter = parameter(
    "n",
    ParameterType::Integer(0, FLAGS as i64 - 1),
    phrase("which flag", "标志编号"),
);

const fn system(run: fn(&mut Call<'_, '_>) -> Result<Value, Unwind>) -> Builtin {
    Builtin {
        name: "",
        section: "",
        category: Category::System,
        summary: phrase("", ""),
        params: &[],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(run),
    }
}

const fn parameter(name: &'static str, kind: ParameterType, meaning: Phrase) -> Parameter {
    Parameter {
        name,
        aliases: &[],
        kind,
        default: ParameterDefault::Required,
        unit: "",
        meaning,
    }
}

const fn flag(name: &'static str, meaning: Phrase) -> Parameter {
    Parameter {
        default: ParameterDefault::Boolean(false),
        ..parameter(name, ParameterType::Boolean, meaning)
    }
}

fn sync(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let cycle = call.context().robot().moment().cycle;
    call.wait(Wait::Cycle(cycle + 1))?;
    Ok(Value::None)
}

fn sleep(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let Some(time) = Seconds::new(call.number(0)?) else {
        return Ok(Value::None);
    };
    let state = call.context().robot().state();
    let step = Seconds::new(state.step_time).unwrap_or_default();
    let cycles = time.cycles(step);
    if cycles > 0 {
        call.wait(Wait::Cycle(state.cycle.saturating_add(cycles)))?;
    }
    Ok(Value::None)
}

fn pause(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    if call.context().panel().operator() == Operator::Absent {
        let text = text!(
            "pause(): nobody is there to resume the program, so it goes on",
            "pause()：没有人可以恢复程序，因此继续执行"
        );
        log(call, Severity::Warning, text);
        return Ok(Value::None);
    }
    call.context().request(TaskRequest::Pause);
    if !call.context().is_secondary() {
        // The task is held before this thread has its next turn.
        call.wait(Wait::Turn)?;
    }
    Ok(Value::None)
}

fn halt(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.context().request(TaskRequest::Halt);
    // The task is ending; this thread only has to wait until it is unwound.
    call.wait(Wait::Never)?;
    Ok(Value::None)
}

fn powerdown(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    // The arm decelerates before its power goes.
    call.send(MachineCommand::PowerOff)?;
    log(
        call,
        Severity::Info,
        text!(
            "powerdown(): the arm is switched off",
            "powerdown()：手臂断电"
        ),
    );
    halt(call)
}

fn get_steptime(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    Ok(Value::Float(call.context().robot().state().step_time))
}

fn get_task_path(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    Ok(Value::str(
        call.context().task_folder().root().to_string_lossy(),
    ))
}

fn controller_timestamp(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    Ok(Value::Float(call.context().unix_time()))
}

fn set_flag(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (n, level) = (call.integer(0)?, call.boolean(1)?);
    let number = n as u8;
    call.show_effect(&Effect::Flag { number, level })?;
    Ok(Value::None)
}

fn get_flag(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let n = call.integer(0)?;
    Ok(Value::Bool(call.context().flag(n as u8)))
}

fn rtsi_set_watchdog(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (variable, frequency, action) = (call.text(0)?, call.number(1)?, call.text(2)?);
    if !is_rtsi_input(&variable) {
        let text = text!(
            "rtsi_set_watchdog(): variable must be the name of an RTSI input, got {variable:?}",
            "rtsi_set_watchdog()：variable 必须是 RTSI 输入的名称，给出的是 {variable:?}"
        );
        return Err(call.error(ExceptionKind::ValueError, text));
    }
    let Some(action) = WatchdogAction::from_name(&action) else {
        let text = text!(
            "rtsi_set_watchdog(): action must be \"ignore\", \"pause\" or \"stop\", got {action:?}",
            "rtsi_set_watchdog()：action 必须是 \"ignore\"、\"pause\" 或 \"stop\"，给出的是 {action:?}"
        );
        return Err(call.error(ExceptionKind::ValueError, text));
    };
    let context = call.context();
    let now = context.robot().moment().time;
    task_memory::uncounted(|| {
        context
            .panel()
            .with_watchdogs(|dogs| dogs.watch(&variable, frequency, action, now));
    });
    Ok(Value::None)
}

fn textmsg(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let text = shown(call, 0, "")? + &shown(call, 1, "")?;
    let bytes = text.len();
    let message = Message::log(Severity::Info, call.origin(), Text::verbatim(text));
    call.show_effect(&Effect::Message(message))?;
    call.native().charge_output(bytes)?;
    Ok(Value::None)
}

fn popup(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (text, title) = (shown(call, 0, "")?, shown(call, 1, "Popup")?);
    let (warning, error) = (call.boolean(2)?, call.boolean(3)?);
    let (style, severity) = match (error, warning) {
        (true, _) => (PopupStyle::Error, Severity::Error),
        (false, true) => (PopupStyle::Warning, Severity::Warning),
        (false, false) => (PopupStyle::Message, Severity::Info),
    };
    let (context, panel) = (call.context(), call.context().panel());
    // Nothing may wait in a secondary program, whatever the argument says (manual 9.3.2).
    let blocking = call.boolean(4)? && !context.is_secondary();
    log(
        call,
        severity,
        text!("popup \"{title}\": {text}", "弹窗 \"{title}\"：{text}"),
    );
    if panel.operator() == Operator::Absent {
        return Ok(Value::None);
    }
    // The panel keeps its own copy, which others close.
    let id = task_memory::uncounted(|| {
        panel.open_popup(Popup {
            title: title.clone(),
            text: text.clone(),
            style,
            blocking,
        })
    });
    if blocking {
        call.wait(Wait::Popup(id))?;
    }
    Ok(Value::None)
}

/// The argument as `str()` shows it.
fn shown(call: &mut Call<'_, '_>, index: usize, default: &str) -> Result<String, Unwind> {
    match call.given(index).cloned() {
        Some(value) => call.native().str(&value),
        None => Ok(default.to_owned()),
    }
}

fn log(call: &mut Call<'_, '_>, severity: Severity, text: Text) {
    let origin = call.origin();
    call.context()
        .observer()
        .message(&Message::log(severity, origin, text));
}
