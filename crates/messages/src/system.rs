//! What the operating system says of files and connections, by the number of its error.

use std::fmt;
use std::io::{self, ErrorKind};

use crate::{Language, Localized, Text};

impl Localized for io::Error {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self
            .get_ref()
            .and_then(|source| source.downcast_ref::<Text>());
        match (language, self.raw_os_error(), text) {
            (Language::Chinese, Some(number), _) => match of_number(number) {
                Some(chinese) => write!(f, "{chinese}（系统错误 {number}）"),
                None => write!(f, "系统错误 {number}"),
            },
            (Language::Chinese, None, Some(text)) => text.fmt_in(language, f),
            (Language::Chinese, None, None) if self.get_ref().is_none() => {
                f.write_str(of_kind(self.kind()))
            }
            _ => fmt::Display::fmt(self, f),
        }
    }
}

/// The text of an error of Linux (`errno.h`); none for errors that files and connections do not have.
const fn of_number(number: i32) -> Option<&'static str> {
    Some(match number {
        1 => "不允许的操作",
        2 => "没有此文件或文件夹",
        5 => "输入输出错误",
        6 => "没有此设备或地址",
        11 => "资源暂时不可用",
        12 => "内存不足",
        13 => "没有权限",
        17 => "已经存在",
        20 => "不是文件夹",
        21 => "是文件夹",
        22 => "参数无效",
        24 => "打开的文件过多",
        27 => "文件过大",
        28 => "磁盘已满",
        30 => "文件系统只读",
        32 => "管道已断开",
        36 => "文件名过长",
        40 => "符号链接层数过多",
        98 => "地址已被占用",
        99 => "本机没有此地址",
        101 => "网络不可达",
        104 => "连接被对方重置",
        110 => "连接超时",
        111 => "连接被拒绝",
        113 => "没有到主机的路由",
        _ => return None,
    })
}

/// The text of an error that the standard library found without asking the operating system.
const fn of_kind(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::UnexpectedEof => "数据意外结束",
        ErrorKind::WriteZero => "无法继续写入",
        ErrorKind::InvalidData => "数据无效",
        ErrorKind::InvalidInput => "参数无效",
        ErrorKind::NotFound => "没有此文件或文件夹",
        ErrorKind::PermissionDenied => "没有权限",
        ErrorKind::AlreadyExists => "已经存在",
        ErrorKind::TimedOut => "超时",
        ErrorKind::ConnectionRefused => "连接被拒绝",
        ErrorKind::ConnectionReset => "连接被对方重置",
        ErrorKind::ConnectionAborted => "连接已中断",
        ErrorKind::BrokenPipe => "管道已断开",
        ErrorKind::AddrInUse => "地址已被占用",
        ErrorKind::Interrupted => "操作被中断",
        ErrorKind::Unsupported => "此系统不支持",
        ErrorKind::OutOfMemory => "内存不足",
        _ => "输入输出错误",
    }
}
