//! What files have beyond std: their kind and numbers, permissions, links, and errors as the system itself numbers
//! them.

use std::fs::{self, File, FileType, Metadata, OpenOptions};
use std::io;
use std::path::Path;

/// What `stat` tells. Where a system has no such number it is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FileStatus {
    /// Kind and permissions, as POSIX has them.
    pub mode: u32,
    /// Number in its file system.
    pub inode: u64,
    /// Number of its file system.
    pub device: u64,
    /// Names it has.
    pub links: u64,
    /// Who owns it.
    pub user: u32,
    /// The group that owns it.
    pub group: u32,
    /// Bytes.
    pub size: u64,
    /// Time of the last read, nanoseconds since 1970.
    pub accessed_ns: i64,
    /// Time of the last write, nanoseconds since 1970.
    pub modified_ns: i64,
    /// Time of the last change of the file or its permissions, nanoseconds since 1970.
    pub changed_ns: i64,
}

/// How a file is opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenMode {
    /// The file is opened for reading.
    pub read: bool,
    /// The file is opened for writing.
    pub write: bool,
    /// Every write goes to the end.
    pub append: bool,
    /// Made if it is not there.
    pub create: bool,
    /// The file must not exist yet.
    pub exclusive: bool,
    /// Emptied first.
    pub truncate: bool,
}

/// Errors that are raised where the system is not asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileError {
    /// There is nothing of this name.
    NotFound,
    /// A folder has this name.
    IsAFolder,
    /// Something else than a folder has this name.
    NotAFolder,
    /// Too many files are open.
    TooManyOpen,
    /// The name is no text.
    NoText,
}

/// What a program may want to do with a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Access {
    /// The file may be read.
    pub read: bool,
    /// The file may be written.
    pub write: bool,
    /// The file may be executed.
    pub run: bool,
}

impl From<FileError> for io::Error {
    fn from(refusal: FileError) -> Self {
        #[cfg(unix)]
        {
            use nix::errno::Errno;
            match refusal {
                FileError::NotFound => Errno::ENOENT,
                FileError::IsAFolder => Errno::EISDIR,
                FileError::NotAFolder => Errno::ENOTDIR,
                FileError::TooManyOpen => Errno::EMFILE,
                FileError::NoText => Errno::EILSEQ,
            }
            .into()
        }
        #[cfg(not(unix))]
        match refusal {
            FileError::NotFound => io::ErrorKind::NotFound.into(),
            FileError::IsAFolder => io::ErrorKind::IsADirectory.into(),
            FileError::NotAFolder => io::ErrorKind::NotADirectory.into(),
            FileError::TooManyOpen => io::Error::other("too many files are open"),
            FileError::NoText => io::ErrorKind::InvalidData.into(),
        }
    }
}

/// What `stat` tells of what was found.
pub fn file_status(found: &Metadata) -> FileStatus {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let nanoseconds = |seconds: i64, rest: i64| seconds.saturating_mul(1_000_000_000) + rest;
        FileStatus {
            mode: found.mode(),
            inode: found.ino(),
            device: found.dev(),
            links: found.nlink(),
            user: found.uid(),
            group: found.gid(),
            size: found.size(),
            accessed_ns: nanoseconds(found.atime(), found.atime_nsec()),
            modified_ns: nanoseconds(found.mtime(), found.mtime_nsec()),
            changed_ns: nanoseconds(found.ctime(), found.ctime_nsec()),
        }
    }
    #[cfg(not(unix))]
    {
        let since = |time: io::Result<std::time::SystemTime>| {
            let time = time.ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
            i64::try_from(time.as_nanos()).ok()
        };
        let modified_ns = since(found.modified()).unwrap_or(0);
        let kind = match (found.is_dir(), found.is_symlink()) {
            (true, _) => 0o040_111,
            (_, true) => 0o120_000,
            _ => 0o100_000,
        };
        let permissions = match found.permissions().readonly() {
            true => 0o444,
            false => 0o666,
        };
        FileStatus {
            mode: kind | permissions,
            links: 1,
            size: found.len(),
            accessed_ns: since(found.accessed()).unwrap_or(modified_ns),
            modified_ns,
            changed_ns: modified_ns,
            ..FileStatus::default()
        }
    }
}

/// Whether opening it could wait, or whoever reads it: a pipe, a socket, a disk.
pub fn may_block(kind: FileType) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        kind.is_fifo() || kind.is_socket() || kind.is_block_device()
    }
    #[cfg(not(unix))]
    {
        let _ = kind;
        false
    }
}

/// Opens as the options say, without waiting, and no terminal becomes that of this process.
///
/// # Errors
/// What the system says.
pub fn open_nonblocking(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    #[cfg(unix)]
    {
        use nix::fcntl::OFlag;
        use std::os::unix::fs::OpenOptionsExt as _;
        options.custom_flags((OFlag::O_NONBLOCK | OFlag::O_NOCTTY).bits());
    }
    options.open(path)
}

/// Opens a file for a program in the mode that it asks for.
///
/// # Errors
/// What the system says.
pub fn open(path: &Path, mode: OpenMode) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options
        .read(mode.read)
        .write(mode.write)
        .append(mode.append)
        .create(mode.create && !mode.exclusive)
        .create_new(mode.exclusive)
        .truncate(mode.truncate);
    open_nonblocking(&mut options, path)
}

/// Makes a folder with permissions, where the system has them.
///
/// # Errors
/// What the system says.
pub fn make_folder(path: &Path, mode: u32) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::DirBuilderExt as _;
        fs::DirBuilder::new().mode(mode).create(path)
    }
    #[cfg(not(unix))]
    {
        let _ = mode;
        fs::create_dir(path)
    }
}

/// Makes a symbolic link.
///
/// # Errors
/// What the system says.
pub fn symlink(target: &Path, path: &Path) -> io::Result<()> {
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(target, path)
    }
    #[cfg(windows)]
    {
        std::os::windows::fs::symlink_file(target, path)
    }
    #[cfg(not(any(unix, windows)))]
    {
        let _ = (target, path);
        Err(crate::needs_linux("a symbolic link"))
    }
}

/// Sets permissions; where a system has only one, whether it may be written.
///
/// # Errors
/// What the system says.
pub fn set_mode(path: &Path, mode: u32) -> io::Result<()> {
    #[cfg(unix)]
    let permissions = {
        use std::os::unix::fs::PermissionsExt as _;
        fs::Permissions::from_mode(mode & 0o7777)
    };
    #[cfg(not(unix))]
    let permissions = {
        let mut permissions = fs::metadata(path)?.permissions();
        permissions.set_readonly(mode & 0o222 == 0);
        permissions
    };
    fs::set_permissions(path, permissions)
}

/// Whether this process may do that with a file.
pub fn can_access(path: &Path, access: Access) -> bool {
    #[cfg(unix)]
    {
        use nix::unistd::AccessFlags;
        let mut wanted = AccessFlags::empty();
        wanted.set(AccessFlags::R_OK, access.read);
        wanted.set(AccessFlags::W_OK, access.write);
        wanted.set(AccessFlags::X_OK, access.run);
        nix::unistd::access(path, wanted).is_ok()
    }
    #[cfg(not(unix))]
    {
        let found = fs::metadata(path);
        found.is_ok_and(|found| !(access.write && found.permissions().readonly()))
    }
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;

    #[test]
    fn refusals_have_the_systems_own_numbers() {
        let system = fs::read("/there/is/nothing").unwrap_err();
        let own = io::Error::from(FileError::NotFound);
        assert_eq!(own.raw_os_error(), system.raw_os_error());
        assert_eq!(own.kind(), system.kind());
    }

    #[test]
    fn what_is_told_of_a_file_is_what_was_set() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "four").unwrap();
        set_mode(&path, 0o640).unwrap();
        let told = file_status(&fs::metadata(&path).unwrap());
        assert_eq!((told.mode & 0o7777, told.size, told.links), (0o640, 4, 1));
        let wanted = Access {
            read: true,
            ..Access::default()
        };
        assert!(can_access(&path, wanted));
        assert!(!can_access(&folder.path().join("other"), Access::default()));
    }
}
