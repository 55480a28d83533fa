//! `--allow fs=DIR`: programs reach what is beneath a folder, and nothing else by whatever way.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set itself up should stop"
)]

use crate::common;

use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use common::{Ran, Standing, run};
use elite_runtime::{FileAccess, NetworkAccess, Permissions, SandboxRoots, TaskEnd};

/// A folder that is open to programs, one beside it with a secret, and links between them.
fn surroundings() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    let (open, other) = (root.path().join("open"), root.path().join("other"));
    std::fs::create_dir_all(open.join("sub")).unwrap();
    std::fs::create_dir(&other).unwrap();
    std::fs::write(open.join("own"), "own").unwrap();
    std::fs::write(open.join("sub/deep"), "deep").unwrap();
    std::fs::write(other.join("secret"), "secret").unwrap();
    symlink(other.join("secret"), open.join("link")).unwrap();
    symlink("../other/secret", open.join("way")).unwrap();
    symlink(&other, open.join("folder")).unwrap();
    symlink("sub/deep", open.join("inner")).unwrap();
    symlink("/proc/self/root", open.join("root")).unwrap();
    symlink(open.join("../other/new"), open.join("nothing")).unwrap();
    symlink(&open, other.join("back")).unwrap();
    root
}

fn in_folder(root: &Path, text: &str) -> Ran {
    let folders = SandboxRoots::open(&[root.join("open")]).unwrap();
    let standing = Standing {
        permissions: Permissions {
            files: FileAccess::Sandboxed(folders),
            processes: true,
            environment: false,
            network: NetworkAccess::Nothing,
        },
        ..Standing::default()
    };
    let text = text.replace("ROOT", root.to_str().unwrap());
    run(&standing, &format!("import os\nimport subprocess\n{text}"))
}

/// Paths that lead to the secret or its folder from inside.
const WAYS: [&str; 13] = [
    "ROOT/other/secret",
    "../other/secret",
    "sub/../../other/secret",
    "ROOT/open/../other/secret",
    "ROOT/open/sub/../../other/secret",
    "link",
    "way",
    "folder/secret",
    "ROOT/open/folder/secret",
    "root/etc/passwd",
    "/proc/self/root/etc/passwd",
    "/proc/self/cwd/../../etc/passwd",
    "/etc/passwd",
];

/// What can be tried with a path `P`.
const CALLS: [&str; 18] = [
    "open('P').read()",
    "open('P', 'w')",
    "open('P', 'a')",
    "open('P', 'r+')",
    "os.stat('P')",
    "os.listdir('P')",
    "os.listdir('P/..')",
    "os.mkdir('P/../d')",
    "os.remove('P/../secret')",
    "os.rmdir('P')",
    "os.rename('P/../secret', 'own')",
    "os.rename('own', 'P/../secret')",
    "os.chmod('P', 0o777)",
    "os.utime('P', (1, 1))",
    "os.chdir('P/..')",
    "os.link('P/../secret', 'hard')",
    "os.symlink('x', 'P/../secret2')",
    "subprocess.run(['true'], cwd='P/..')",
];

#[test]
fn no_call_reaches_what_is_outside_by_any_way() {
    let root = surroundings();
    let mut failures = Vec::new();
    for way in WAYS {
        let mut text = String::new();
        for call in CALLS {
            let call = call.replace('P', way);
            text += &format!(
                "try:\n  r = {call}\n  print(\"REACHED {call}\", r)\n\
                 except OSError as e:\n  print(type(e).__name__, e)\nend\n"
            );
        }
        let ran = in_folder(root.path(), &text);
        assert_eq!(
            (ran.error.as_str(), ran.end),
            ("", TaskEnd::Finished),
            "{way}"
        );
        assert_eq!(ran.printed.lines().count(), CALLS.len(), "{}", ran.printed);
        let reached = ran.printed.lines().filter(|line| line.contains("REACHED"));
        failures.extend(reached.map(str::to_owned));
    }
    assert!(failures.is_empty(), "{failures:#?}");
    let other = root.path().join("other");
    assert_eq!(
        std::fs::read_to_string(other.join("secret")).unwrap(),
        "secret"
    );
    assert_eq!(std::fs::read_dir(&other).unwrap().count(), 2);
    assert_eq!(
        std::fs::read_to_string(root.path().join("open/own")).unwrap(),
        "own"
    );
}

#[test]
fn what_is_inside_works_as_ever() {
    let root = surroundings();
    let ran = in_folder(
        root.path(),
        "print(open('own').read(), open('ROOT/open/sub/deep').read(), open('inner').read())
print(open('ROOT/open/sub/../own').read(), open('ROOT/other/../open/own').read())
with open('new', 'w') as f:
  f.write('1')
with open('new', 'a') as f:
  f.write('2')
with open('new', 'r+') as f:
  f.write('3')
print(open('new').read(), os.path.exists('new'), os.path.exists('ROOT/other/secret'))
os.mkdir('made')
os.rename('new', 'made/new')
os.symlink('made', 'm')
print(sorted(os.listdir('m')), os.readlink('m'), os.path.islink('m'))
os.chdir('made')
print(open('new').read(), os.getcwd() == 'ROOT/open/made')
print(open('../own').read())
os.chmod('new', 0o600)
print(oct(os.stat('new').st_mode & 0o777))
os.remove('new')
os.chdir('ROOT/open')
os.remove('m')
os.rmdir('made')
print(os.stat('.').st_mode == os.stat('ROOT/open').st_mode, 'sub' in os.listdir())
print(subprocess.check_output(['cat', 'own']).decode(), subprocess.check_output(['pwd'], cwd='sub').decode().strip() \
== 'ROOT/open/sub')
",
    );
    assert_eq!(
        (ran.error.as_str(), ran.end),
        ("", TaskEnd::Finished),
        "{}",
        ran.printed
    );
    assert_eq!(
        ran.printed,
        "own deep deep\nown own\n32 True False\n['new'] made True\n32 True\nown\n0o600\nTrue True\nown True\n"
    );
}

#[test]
fn a_refusal_names_the_path_and_the_folder() {
    let root = surroundings();
    let ran = in_folder(root.path(), "open('/etc/passwd')\n");
    let open = root.path().join("open");
    let sentence = format!(
        "PermissionError: /etc/passwd is not within {}, which is what --allow fs= opens to programs",
        open.display()
    );
    assert!(ran.error.contains(&sentence), "{}", ran.error);
    let missing = SandboxRoots::open(&[root.path().join("nowhere")]).unwrap_err();
    assert!(missing.to_string().contains("nowhere"), "{missing}");
    assert!(SandboxRoots::open(&[open.join("own")]).is_err());
}

#[test]
fn a_folder_that_is_exchanged_for_a_link_meanwhile_leads_nowhere() {
    let root = surroundings();
    let open = root.path().join("open");
    std::fs::create_dir(open.join("a")).unwrap();
    std::fs::write(open.join("a/secret"), "harmless").unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let swapping = {
        let (open, stop, other) = (open.clone(), stop.clone(), root.path().join("other"));
        std::thread::spawn(move || {
            symlink(other, open.join("l")).unwrap();
            while !stop.load(Ordering::Relaxed) {
                // a is the folder, then the link, then the folder again.
                let _ = std::fs::rename(open.join("a"), open.join("b"));
                let _ = std::fs::rename(open.join("l"), open.join("a"));
                let _ = std::fs::rename(open.join("a"), open.join("l"));
                let _ = std::fs::rename(open.join("b"), open.join("a"));
            }
        })
    };
    let ran = in_folder(
        root.path(),
        "seen = set()
for i in range(3000):
  try:
    seen.add(open('a/secret').read())
  except OSError:
    seen.add('refused')
  end
end
print(sorted(seen))
",
    );
    stop.store(true, Ordering::Relaxed);
    swapping.join().unwrap();
    assert_eq!(ran.error, "");
    assert!(ran.printed.contains("harmless"), "{}", ran.printed);
    assert!(!ran.printed.contains("'secret'"), "{}", ran.printed);
}
