#!/usr/bin/env python3
"""What registries say today about the versions in the lock files: crates that were yanked, advisories as far as they
are to be had.

    packaging/audit.py [--offline]     with what Cargo knows already, without asking anybody

Licences, places and versions that are there twice do not change by themselves; tests/dependencies.rs looks at them. The
advisories of Rust (RustSec) are a git repository, in no package registry: they are asked for where `cargo audit` is
installed (`cargo install cargo-audit`). Those of npm come from its registry, which mirrors often do not pass on. What
was not looked up is said, and is no failure; a yanked crate or an advisory is.
"""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOCKS = ["Cargo.lock", "fuzz/Cargo.lock"]


def run(*command, cwd=ROOT):
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


def place(name):
    """Where an index keeps a crate: https://doc.rust-lang.org/cargo/reference/registry-index.html#index-files"""
    name = name.lower()
    if len(name) < 4:
        return Path(str(len(name)), *([name[0]] if len(name) == 3 else []), name)
    return Path(name[:2], name[2:4], name)


def entries(name):
    """What the copies that Cargo keeps of its indices have of a crate: version, and whether it is yanked.

    A copy is some bytes of Cargo's own, then version and line of the index in turn, each ended by a zero."""
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    for copy in home.glob("registry/index/*/.cache"):
        if (copy / place(name)).is_file():
            for part in (copy / place(name)).read_bytes().split(b"\0"):
                if part.startswith(b"{"):
                    entry = json.loads(part)
                    yield entry["vers"], entry["yanked"]


def yanked(lock):
    """Prints what is yanked of a lock file; whether all is well."""
    packages = tomllib.loads((ROOT / lock).read_text())["package"]
    wanted = [(p["name"], p["version"]) for p in packages if p.get("source", "").startswith("registry+")]
    known, bad = 0, []
    for name, version in wanted:
        states = [is_yanked for at, is_yanked in entries(name) if at == version]
        known += bool(states)
        if any(states):
            bad.append(f"{name} {version}")
    print(f"{lock}: {known} of {len(wanted)} crates looked up, {len(bad)} of them yanked")
    for crate in bad:
        print(f"  yanked: {crate}; 'cargo update' takes another")
    # Without any the copies are not where, or not what, they were.
    return not bad and known > len(wanted) // 2


def advisories_of_rust():
    if run("cargo", "audit", "--version").returncode != 0:
        print("advisories of Rust: not looked up, cargo-audit is not installed")
        return True
    found = run("cargo", "audit", "--json")
    try:
        report = json.loads(found.stdout)
    except ValueError:
        print(f"advisories of Rust: not looked up: {found.stderr.strip().splitlines()[-1:]}")
        return True
    bad = report["vulnerabilities"]["list"]
    print(f"advisories of Rust: {len(bad)} for Cargo.lock")
    for entry in bad:
        print(
            f"  {entry['package']['name']} {entry['package']['version']}: {entry['advisory']['id']}, "
            f"{entry['advisory']['title']}"
        )
    return not bad


def advisories_of_npm(folder):
    """Of what is bundled into the page or the extension; tools that only build are left out."""
    try:
        report = json.loads(run("npm", "audit", "--omit", "dev", "--json", cwd=ROOT / folder).stdout)
    except (ValueError, FileNotFoundError):
        report = {}
    if "vulnerabilities" not in report:
        print(f"advisories of npm, {folder}: not looked up: {report.get('message', 'npm does not answer')}")
        return True
    bad = report["vulnerabilities"]
    print(f"advisories of npm, {folder}: {len(bad)}")
    for name, entry in sorted(bad.items()):
        print(f"  {name}: {entry['severity']}")
    return not bad


def main():
    arguments = sys.argv[1:]
    if arguments not in ([], ["--offline"]):
        sys.exit(f"audit.py: what is {' '.join(arguments)!r}? There is --offline")
    results = []
    if not arguments:
        # Reads the index of every crate anew and changes nothing.
        for lock in LOCKS:
            asked = run("cargo", "update", "--dry-run", "--manifest-path", str(Path(lock).with_name("Cargo.toml")))
            if asked.returncode != 0:
                print(f"{lock}: the registry was not asked: {asked.stderr.strip().splitlines()[-1:]}")
    results += [yanked(lock) for lock in LOCKS]
    if not arguments:
        results += [advisories_of_rust(), advisories_of_npm("web"), advisories_of_npm("editors/vscode")]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
