//! `_files`: the files of the host, with buffers. `open`, `io`, `os` and `os.path` are scripts on top.
//!
//! Nothing here is reached without the permission `fs`. Long operations give other script threads their turn, and no
//! more is read than the task's memory has room for.

use std::cell::{Cell, RefCell};
use std::io::{self, SeekFrom};
use std::rc::Rc;

use super::define::{MethodDef, ModuleBuilder, instance, with_data};
use super::system::{os_error, os_error_about, require};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::host::Capability;
use crate::host::files::{FileStat, HostFile, HostFiles, OpenMode};
use crate::value::data::no_values;
use crate::value::{Bytes, R, Value};

/// Bytes read or written at once; between two such pieces other threads have their turn.
const IO_CHUNK: usize = 1 << 20;
/// Bytes kept in the buffers of a file.
const BUFFER: usize = 8192;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(FUNCTIONS);
    module.class("File", None, METHODS);
    Ok(())
}

/// The files of the host, if programs may reach them.
fn files<'e>(ev: &'e Evaluator<'_>, what: &str) -> R<&'e dyn HostFiles> {
    require(ev, Capability::Files, what)?;
    ev.core
        .host
        .files()
        .ok_or_else(|| ev.raise(ExceptionKind::OSError, "this host has no files"))
}

/// A path, which `os.fspath` has made text of.
fn path<'v>(ev: &Evaluator<'_>, value: &'v Value) -> R<&'v str> {
    match value.as_str() {
        Some(text) if text.contains('\0') => Err(ev.value_error("embedded null byte")),
        Some(text) => Ok(text),
        None => {
            let name = ev.core.types.name_of(value);
            Err(ev.type_error(format!(
                "expected str, bytes or os.PathLike object, not {name}"
            )))
        }
    }
}

fn number(ev: &Evaluator<'_>, value: &Value) -> R<u32> {
    u32::try_from(ev.index(value)?)
        .map_err(|_| ev.raise(ExceptionKind::OverflowError, "the number is out of range"))
}

/// What is known of a file, in the order of `os.stat_result` with the times in nanoseconds.
fn stat_value(stat: &FileStat) -> Value {
    let whole = |number: u64| Value::Int(i64::try_from(number).unwrap_or(i64::MAX));
    Value::tuple(vec![
        Value::Int(i64::from(stat.mode)),
        whole(stat.inode),
        whole(stat.device),
        whole(stat.links),
        Value::Int(i64::from(stat.user)),
        Value::Int(i64::from(stat.group)),
        whole(stat.size),
        Value::Int(stat.accessed_ns),
        Value::Int(stat.modified_ns),
        Value::Int(stat.changed_ns),
    ])
}

/// One call of the system about one path.
fn path_call(
    ev: &Evaluator<'_>,
    args: &[Value],
    what: &str,
    call: impl FnOnce(&dyn HostFiles, &str) -> io::Result<Value>,
) -> R {
    let files = files(ev, what)?;
    call(files, path(ev, &args[0])?).map_err(|error| os_error_about(ev, &error, &args[..1]))
}

/// One call of the system about two paths.
fn two_path_call(
    ev: &Evaluator<'_>,
    args: &[Value],
    what: &str,
    call: impl FnOnce(&dyn HostFiles, &str, &str) -> io::Result<()>,
) -> R {
    let files = files(ev, what)?;
    let (from, to) = (path(ev, &args[0])?, path(ev, &args[1])?);
    match call(files, from, to) {
        Ok(()) => Ok(Value::None),
        Err(error) => Err(os_error_about(ev, &error, &args[..2])),
    }
}

const FUNCTIONS: &[MethodDef] = &[
    ("open", "path mode /", |ev, args| {
        let files = files(ev, "files")?;
        let letters = ev.str(&args[1])?;
        let mode = OpenMode {
            read: letters.contains(['r', '+']),
            write: letters.contains(['w', 'a', 'x', '+']),
            append: letters.contains('a'),
            create: letters.contains(['w', 'a', 'x']),
            exclusive: letters.contains('x'),
            truncate: letters.contains('w'),
        };
        let opened = files.open(path(ev, &args[0])?, mode);
        let host = opened.map_err(|error| os_error_about(ev, &error, &args[..1]))?;
        instance(ev, "_files.File", Rc::new(FileBuffer::new(host)))
    }),
    ("stat", "path follow /", |ev, args| {
        let follow = ev.truth(&args[1])?;
        path_call(ev, args, "os.stat", |files, path| {
            files.stat(path, follow).map(|stat| stat_value(&stat))
        })
    }),
    ("list", "path /", |ev, args| {
        path_call(ev, args, "os.listdir", |files, path| {
            let mut names = files.list(path)?;
            // The system's order is no order; this one is the same on every machine.
            names.sort();
            Ok(Value::list(names.into_iter().map(Value::str).collect()))
        })
    }),
    ("mkdir", "path mode /", |ev, args| {
        let mode = number(ev, &args[1])?;
        path_call(ev, args, "os.mkdir", |files, path| {
            files.make_dir(path, mode).map(|()| Value::None)
        })
    }),
    ("rmdir", "path /", |ev, args| {
        path_call(ev, args, "os.rmdir", |files, path| {
            files.remove_dir(path).map(|()| Value::None)
        })
    }),
    ("remove", "path /", |ev, args| {
        path_call(ev, args, "os.remove", |files, path| {
            files.remove_file(path).map(|()| Value::None)
        })
    }),
    ("rename", "source target /", |ev, args| {
        two_path_call(ev, args, "os.rename", |files, from, to| {
            files.rename(from, to)
        })
    }),
    ("symlink", "target path /", |ev, args| {
        two_path_call(ev, args, "os.symlink", |files, target, path| {
            files.symlink(target, path)
        })
    }),
    ("link", "source target /", |ev, args| {
        two_path_call(ev, args, "os.link", |files, from, to| files.link(from, to))
    }),
    ("readlink", "path /", |ev, args| {
        path_call(ev, args, "os.readlink", |files, path| {
            files.read_link(path).map(Value::str)
        })
    }),
    ("chmod", "path mode /", |ev, args| {
        let mode = number(ev, &args[1])?;
        path_call(ev, args, "os.chmod", |files, path| {
            files.set_mode(path, mode).map(|()| Value::None)
        })
    }),
    ("utime", "path accessed modified /", |ev, args| {
        let (accessed, modified) = (ev.index(&args[1])?, ev.index(&args[2])?);
        path_call(ev, args, "os.utime", |files, path| {
            files
                .set_times(path, accessed, modified)
                .map(|()| Value::None)
        })
    }),
    ("access", "path mode /", |ev, args| {
        let mode = number(ev, &args[1])?;
        path_call(ev, args, "os.access", |files, path| {
            Ok(Value::Bool(files.access(path, mode)))
        })
    }),
    ("getcwd", "", |ev, _| {
        Ok(Value::str(files(ev, "os.getcwd")?.current_dir()))
    }),
    ("chdir", "path /", |ev, args| {
        path_call(ev, args, "os.chdir", |files, path| {
            files.set_current_dir(path).map(|()| Value::None)
        })
    }),
];

/// An open file with its buffers. At most one of them is in use at a time.
#[derive(Debug)]
pub(super) struct FileBuffer {
    host: RefCell<Option<Rc<dyn HostFile>>>,
    /// What was read ahead, and how much of it has been taken.
    ahead: RefCell<Vec<u8>>,
    taken: Cell<usize>,
    /// What is still to be written.
    pending: RefCell<Vec<u8>>,
}

no_values!(FileBuffer);

/// Where lines end.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LineEnd {
    /// `\n`
    Feed,
    /// `\n`, `\r` or `\r\n`
    Any,
    /// `\r`
    Return,
    /// `\r\n`
    Both,
}

impl FileBuffer {
    fn new(host: Rc<dyn HostFile>) -> Self {
        FileBuffer {
            host: RefCell::new(Some(host)),
            ahead: RefCell::default(),
            taken: Cell::new(0),
            pending: RefCell::default(),
        }
    }

    /// The host's file.
    pub(super) fn host(&self, ev: &Evaluator<'_>) -> R<Rc<dyn HostFile>> {
        let host = self.host.borrow().clone();
        host.ok_or_else(|| ev.value_error("I/O operation on closed file."))
    }

    /// Writes what is pending.
    pub(super) fn flush(&self, ev: &Evaluator<'_>) -> R<()> {
        let pending = self.pending.take();
        self.write_through(ev, &pending)
    }

    fn write_through(&self, ev: &Evaluator<'_>, data: &[u8]) -> R<()> {
        let host = self.host(ev)?;
        let mut written = 0;
        while written < data.len() {
            let end = data.len().min(written + IO_CHUNK);
            match host.write(&data[written..end]) {
                Ok(0) => return Err(ev.raise(ExceptionKind::OSError, "nothing could be written")),
                Ok(count) => written += count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(os_error(ev, &error)),
            }
            self.give_way(ev, written)?;
        }
        Ok(())
    }

    /// After each piece of a long operation other threads have their turn.
    fn give_way(&self, ev: &Evaluator<'_>, done: usize) -> R<()> {
        if done >= IO_CHUNK {
            ev.yield_now()?;
        }
        Ok(())
    }

    /// Puts the position back to where the program thinks it is, before writing or moving it.
    fn drop_ahead(&self, ev: &Evaluator<'_>) -> R<()> {
        let left = self.ahead.take().len() - self.taken.replace(0);
        if left > 0 {
            let back = SeekFrom::Current(-i64::try_from(left).unwrap_or(0));
            let moved = self.host(ev)?.seek(back);
            moved.map_err(|error| os_error(ev, &error))?;
        }
        Ok(())
    }

    /// Reads on into the buffer; false at the end.
    fn read_ahead(&self, ev: &Evaluator<'_>, most: usize) -> R<bool> {
        let host = self.host(ev)?;
        let mut ahead = self.ahead.take();
        ahead.drain(..self.taken.replace(0));
        let before = ahead.len();
        let result = ev.check_allocation(before + most).and_then(|()| {
            ahead.resize(before + most, 0);
            loop {
                match host.read(&mut ahead[before..]) {
                    Ok(count) => return Ok(count),
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(os_error(ev, &error)),
                }
            }
        });
        ahead.truncate(before + result.as_ref().copied().unwrap_or(0));
        *self.ahead.borrow_mut() = ahead;
        result.map(|count| count > 0)
    }

    /// Takes bytes out of the buffer; fewer if another thread has taken some meanwhile.
    fn take(&self, count: usize) -> Vec<u8> {
        let count = count.min(self.left());
        let start = self.taken.get();
        self.taken.set(start + count);
        self.ahead.borrow()[start..start + count].to_vec()
    }

    fn left(&self) -> usize {
        self.ahead.borrow().len() - self.taken.get()
    }

    /// Reads `count` bytes, or all there are.
    fn read(&self, ev: &Evaluator<'_>, count: Option<usize>) -> R<Vec<u8>> {
        self.flush(ev)?;
        if let Some(count) = count
            && count <= BUFFER
        {
            while self.left() < count && self.read_ahead(ev, BUFFER)? {}
            return Ok(self.take(count.min(self.left())));
        }
        let mut out = self.take(self.left().min(count.unwrap_or(usize::MAX)));
        let host = self.host(ev)?;
        // What the system says about the size; it may lie, and may change.
        let expected = match (count, host.stat()) {
            (Some(count), _) => count,
            (None, Ok(stat)) => usize::try_from(stat.size).unwrap_or(usize::MAX),
            (None, Err(_)) => 0,
        };
        if count.is_none() {
            ev.check_allocation(expected)?;
        }
        let most = count.unwrap_or(usize::MAX);
        while out.len() < most {
            let piece = IO_CHUNK.min(most - out.len());
            let before = out.len();
            ev.check_allocation(before.saturating_add(piece).saturating_mul(2))?;
            out.resize(before + piece, 0);
            let read = host.read(&mut out[before..]);
            out.truncate(before + read.as_ref().copied().unwrap_or(0));
            match read {
                Ok(0) => break,
                Ok(_) => self.give_way(ev, out.len())?,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(os_error(ev, &error)),
            }
        }
        out.shrink_to_fit();
        Ok(out)
    }

    /// Reads at most `count` characters (bytes, unless `utf8`), one line of them if `line`. With `merge`, `\r\n` counts
    /// as one character.
    fn read_text(&self, ev: &Evaluator<'_>, wanted: &ReadRequest) -> R<Vec<u8>> {
        self.flush(ev)?;
        let (mut at, mut chars) = (0, 0);
        let mut ended = false;
        loop {
            let ahead = self.ahead.borrow();
            let data = &ahead[self.taken.get()..];
            let mut done = false;
            while at < data.len() {
                if chars >= wanted.count {
                    done = true;
                    break;
                }
                let byte = data[at];
                let more = data.get(at + 1);
                // What a `\r` belongs to shows in the byte after it.
                if byte == b'\r' && wanted.ends != LineEnd::Feed && more.is_none() && !ended {
                    break;
                }
                let pair = byte == b'\r' && more == Some(&b'\n');
                let ends = match wanted.ends {
                    LineEnd::Feed => byte == b'\n',
                    LineEnd::Any => byte == b'\n' || byte == b'\r',
                    LineEnd::Return => byte == b'\r',
                    LineEnd::Both => pair,
                };
                let whole = wanted.merge || wanted.line && wanted.ends != LineEnd::Return;
                let joined = pair && ends && whole;
                let width = if joined { 2 } else { wanted.width(byte) };
                if at + width > data.len() && !ended {
                    break;
                }
                at = (at + width).min(data.len());
                chars += 1;
                if wanted.line && ends {
                    done = true;
                    break;
                }
            }
            done |= chars >= wanted.count;
            drop(ahead);
            if done || ended {
                return Ok(self.take(at));
            }
            ended = !self.read_ahead(ev, BUFFER.max(at.min(IO_CHUNK)))?;
            self.give_way(ev, at)?;
        }
    }

    fn seek(&self, ev: &Evaluator<'_>, to: SeekFrom) -> R<u64> {
        self.flush(ev)?;
        self.drop_ahead(ev)?;
        let moved = self.host(ev)?.seek(to);
        moved.map_err(|error| os_error(ev, &error))
    }

    /// Where the program thinks it is.
    fn tell(&self, ev: &Evaluator<'_>) -> R<u64> {
        let here = self.host(ev)?.seek(SeekFrom::Current(0));
        let here = here.map_err(|error| os_error(ev, &error))?;
        Ok(here + self.pending.borrow().len() as u64 - self.left() as u64)
    }
}

impl Drop for FileBuffer {
    /// A file that nobody closed is written out as far as it goes, as in CPython; there is nobody left to tell.
    fn drop(&mut self) {
        let host = self.host.get_mut();
        if let Some(host) = host {
            let pending = self.pending.get_mut();
            let mut written = 0;
            while let Ok(count @ 1..) = host.write(&pending[written..]) {
                written += count;
                if written >= pending.len() {
                    break;
                }
            }
        }
    }
}

/// What a text file wants to read.
struct ReadRequest {
    count: usize,
    utf8: bool,
    ends: LineEnd,
    line: bool,
    merge: bool,
}

impl ReadRequest {
    /// Bytes of the character that begins with `byte`. What is no character is one byte, for the decoder to judge.
    fn width(&self, byte: u8) -> usize {
        match byte {
            0xc2..=0xdf if self.utf8 => 2,
            0xe0..=0xef if self.utf8 => 3,
            0xf0..=0xf4 if self.utf8 => 4,
            _ => 1,
        }
    }
}

fn count(ev: &Evaluator<'_>, value: &Value) -> R<Option<usize>> {
    Ok(match value {
        Value::None => None,
        value => usize::try_from(ev.clamped_index(value)?).ok(),
    })
}

fn bytes(data: Vec<u8>) -> Value {
    Value::Bytes(Rc::new(Bytes::new(data)))
}

fn position(at: u64) -> Value {
    Value::Int(i64::try_from(at).unwrap_or(i64::MAX))
}

fn with_stream(ev: &Evaluator<'_>, args: &[Value], inner: impl FnOnce(&FileBuffer) -> R) -> R {
    let stream = with_data(ev, &args[0], |stream: &Rc<FileBuffer>| Ok(stream.clone()))?;
    inner(&stream)
}

const METHODS: &[MethodDef] = &[
    ("read", "count /", |ev, args| {
        let count = count(ev, &args[1])?;
        with_stream(ev, args, |stream| stream.read(ev, count).map(bytes))
    }),
    ("read_text", "count utf8 ends line merge /", |ev, args| {
        let ends = match args[3].as_str() {
            Some("any") => LineEnd::Any,
            Some("\r") => LineEnd::Return,
            Some("\r\n") => LineEnd::Both,
            _ => LineEnd::Feed,
        };
        let wanted = ReadRequest {
            count: count(ev, &args[1])?.unwrap_or(usize::MAX),
            utf8: ev.truth(&args[2])?,
            ends,
            line: ev.truth(&args[4])?,
            merge: ev.truth(&args[5])?,
        };
        with_stream(ev, args, |stream| stream.read_text(ev, &wanted).map(bytes))
    }),
    ("write", "data /", |ev, args| {
        let Some(data) = ev.bytes_like(&args[1]) else {
            let name = ev.core.types.name_of(&args[1]);
            return Err(ev.type_error(format!("a bytes-like object is required, not '{name}'")));
        };
        with_stream(ev, args, |stream| {
            stream.host(ev)?;
            stream.drop_ahead(ev)?;
            if stream.pending.borrow().len() + data.len() > BUFFER {
                stream.flush(ev)?;
            }
            if data.len() > BUFFER {
                stream.write_through(ev, &data)?;
            } else {
                stream.pending.borrow_mut().extend_from_slice(&data);
            }
            Ok(Value::Int(data.len() as i64))
        })
    }),
    ("seek", "offset whence /", |ev, args| {
        let offset = ev.index(&args[1])?;
        let to = match ev.index(&args[2])? {
            0 => SeekFrom::Start(u64::try_from(offset).map_err(|_| {
                ev.raise_args(
                    ExceptionKind::OSError,
                    vec![Value::Int(22), Value::str("Invalid argument")],
                )
            })?),
            1 => SeekFrom::Current(offset),
            2 => SeekFrom::End(offset),
            other => {
                return Err(ev.value_error(format!("whence value {other} unsupported")));
            }
        };
        with_stream(ev, args, |stream| stream.seek(ev, to).map(position))
    }),
    ("tell", "", |ev, args| {
        with_stream(ev, args, |stream| stream.tell(ev).map(position))
    }),
    ("truncate", "length /", |ev, args| {
        let length = match &args[1] {
            Value::None => None,
            value => Some(u64::try_from(ev.index(value)?).map_err(|_| {
                ev.raise_args(
                    ExceptionKind::OSError,
                    vec![Value::Int(22), Value::str("Invalid argument")],
                )
            })?),
        };
        with_stream(ev, args, |stream| {
            stream.flush(ev)?;
            let length = length.map_or_else(|| stream.tell(ev), Ok)?;
            let cut = stream.host(ev)?.set_len(length);
            cut.map_err(|error| os_error(ev, &error))?;
            Ok(position(length))
        })
    }),
    ("flush", "", |ev, args| {
        with_stream(ev, args, |stream| stream.flush(ev).map(|()| Value::None))
    }),
    ("sync", "", |ev, args| {
        with_stream(ev, args, |stream| {
            stream.flush(ev)?;
            let synced = stream.host(ev)?.sync();
            synced
                .map(|()| Value::None)
                .map_err(|error| os_error(ev, &error))
        })
    }),
    ("stat", "", |ev, args| {
        with_stream(ev, args, |stream| {
            let stat = stream.host(ev)?.stat();
            stat.map(|stat| stat_value(&stat))
                .map_err(|error| os_error(ev, &error))
        })
    }),
    ("close", "", |ev, args| {
        with_stream(ev, args, |stream| {
            if stream.host.borrow().is_none() {
                return Ok(Value::None);
            }
            let flushed = stream.flush(ev);
            stream.host.take();
            stream.ahead.take();
            stream.taken.set(0);
            flushed.map(|()| Value::None)
        })
    }),
    ("closed", "", |ev, args| {
        with_stream(ev, args, |stream| {
            Ok(Value::Bool(stream.host.borrow().is_none()))
        })
    }),
];
