#!/usr/bin/env python3
"""What is in a package that is not ours: a bill of materials (CycloneDX 1.5, JSON) and the licences with their texts.

    packaging/inventory.py --package server --target x86_64-unknown-linux-musl --sbom FILE --licences FILE

Reads `cargo metadata` (the crates that end up in the program: no tests, no macros, no build scripts), the lock files,
and the sources of the crates and of the page's libraries where cargo and npm have put them. Nothing is fetched.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import uuid
from datetime import datetime, timezone
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: Files of a crate that carry its licence.
TEXTS = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)[^/]*", re.IGNORECASE)
#: Linked into every program beside the crates.
STANDARD_LIBRARY = ("rust-std", "MIT OR Apache-2.0")
MUSL = ("musl", "MIT")


def expression(licence):
    """SPDX of today for what older crates write."""
    return re.sub(r"\s*/\s*", " OR ", licence)


def crates(package, target):
    """The crates linked into a package of the workspace for a target, by name and version; its own crates apart."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", target]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    packages = {p["id"]: p for p in metadata["packages"]}
    nodes = {n["id"]: n for n in metadata["resolve"]["nodes"]}
    start = next(p["id"] for p in metadata["packages"] if p["name"] == package and p["source"] is None)

    def linked(node):
        for dep in nodes[node]["deps"]:
            macro = any("proc-macro" in t["kind"] for t in packages[dep["pkg"]]["targets"])
            if (packages[dep["pkg"]]["name"], "v" + packages[dep["pkg"]]["version"]) not in within:
                continue
            if not macro and any(kind["kind"] is None for kind in dep["dep_kinds"]):
                yield dep["pkg"]

    # Metadata knows crates that a feature would bring; what is linked, `cargo tree` says.
    command = [
        "cargo",
        "tree",
        "--locked",
        "--package",
        package,
        "--edges",
        "normal,no-proc-macro",
        "--prefix",
        "none",
        "--format",
        "{p}",
        "--target",
        target,
    ]
    tree = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    within = {tuple(line.split(" ")[:2]) for line in tree.splitlines()}

    seen, waiting = {start}, [start]
    while waiting:
        for dep in linked(waiting.pop()):
            if dep not in seen:
                seen.add(dep)
                waiting.append(dep)
    found = sorted((packages[i] for i in seen if packages[i]["source"]), key=lambda p: (p["name"], p["version"]))
    version = packages[start]["version"]
    edges = {i: sorted(d for d in linked(i) if packages[d]["source"]) for i in seen if packages[i]["source"]}
    return version, found, edges


def checksums():
    """SHA-256 of crates as the lock file has them."""
    lock = (ROOT / "Cargo.lock").read_text()
    entry = re.compile(r'name = "([^"]+)"\nversion = "([^"]+)"\nsource = "[^"]+"\nchecksum = "([0-9a-f]{64})"')
    return {(name, version): checksum for name, version, checksum in entry.findall(lock)}


def page():
    """The libraries of the pendant page: name, version, licence, folder."""
    lock = json.loads((ROOT / "web" / "package-lock.json").read_text())
    for place, entry in sorted(lock["packages"].items()):
        if place and not entry.get("dev"):
            yield place.rpartition("node_modules/")[2], entry["version"], entry["license"], ROOT / "web" / place


def texts(folder):
    """The licence texts in a folder, by name; empty where a crate was published without."""
    if not folder.is_dir():
        return {}
    files = sorted(
        f for f in folder.iterdir() if f.is_file() and TEXTS.fullmatch(f.name) and f.suffix not in (".rs", ".py")
    )
    return {f.name: f.read_text(errors="replace").strip() for f in files}


def bill(package, version, found, edges, libraries, linked):
    sums = checksums()
    by_id = {p["id"]: "pkg:cargo/{}@{}".format(p["name"], p["version"]) for p in found}
    components = []
    for p in found:
        component = {
            "type": "library",
            "bom-ref": by_id[p["id"]],
            "name": p["name"],
            "version": p["version"],
            "licenses": [{"expression": expression(p["license"])}] if p["license"] else [],
            "purl": by_id[p["id"]],
        }
        if p["description"]:
            component["description"] = " ".join(p["description"].split())
        if (p["name"], p["version"]) in sums:
            component["hashes"] = [{"alg": "SHA-256", "content": sums[p["name"], p["version"]]}]
        components.append(component)
    for name, at, licence, _ in libraries:
        purl = "pkg:npm/{}@{}".format(name.replace("@", "%40"), at)
        components.append(
            {
                "type": "library",
                "bom-ref": purl,
                "name": name,
                "version": at,
                "licenses": [{"expression": licence}],
                "purl": purl,
            }
        )
    for name, at, licence in linked:
        components.append(
            {"type": "library", "bom-ref": name, "name": name, "version": at, "licenses": [{"expression": licence}]}
        )
    made = datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", "0")), timezone.utc)
    body = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "timestamp": made.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "component": {
                "type": "application",
                "bom-ref": package,
                "name": package,
                "version": version,
                "licenses": [{"expression": "Apache-2.0"}],
            },
        },
        "components": components,
        "dependencies": [{"ref": package, "dependsOn": [c["bom-ref"] for c in components]}]
        + [{"ref": by_id[i], "dependsOn": [by_id[d] for d in edges[i]]} for i in sorted(by_id)],
    }
    # Named after what it says: the same content, the same number.
    body["serialNumber"] = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(body, sort_keys=True)).urn
    return body


def licences(found, libraries, linked):
    """One text: who is in it, then every licence text once with those that carry it."""
    rows, bodies, without = [], {}, []
    entries = [
        (p["name"], p["version"], expression(p["license"] or "see its text"), Path(p["manifest_path"]).parent)
        for p in found
    ]
    for name, version, licence, folder in entries + list(libraries):
        rows.append("{} {}: {}".format(name, version, licence))
        of = texts(folder)
        if not of:
            without.append("{} {}".format(name, version))
        for body in of.values():
            bodies.setdefault(body, []).append("{} {}".format(name, version))
    rows += ["{} {}: {}".format(*entry) for entry in linked]
    out = ["Works of others in this package", "", *rows, ""]
    if without:
        out += ["Published without a text of their own, under the licences above: " + ", ".join(without) + ".", ""]
    for body, names in sorted(bodies.items(), key=lambda item: (-len(item[1]), item[1])):
        out += ["=" * 80, "For " + ", ".join(sorted(set(names))) + ":", "", body, ""]
    return "\n".join(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("package", "target", "sbom", "licences"):
        parser.add_argument("--" + name, required=True)
    args = parser.parse_args()
    version, found, edges = crates(args.package, args.target)
    libraries = list(page())
    missing = [name for name, _, _, folder in libraries if not folder.is_dir()]
    if missing:
        sys.exit(
            "the libraries of the page are not there ({}): `npm --prefix web ci` fetches them".format(
                ", ".join(missing)
            )
        )
    rustc = subprocess.run(["rustc", "--version"], check=True, capture_output=True, text=True).stdout.split()[1]
    linked = [(STANDARD_LIBRARY[0], rustc, STANDARD_LIBRARY[1])]
    if args.target.endswith("musl"):
        linked.append((MUSL[0], os.environ.get("MUSL_VERSION", "1.2"), MUSL[1]))
    sbom = bill(args.package, version, found, edges, libraries, linked)
    Path(args.sbom).write_text(json.dumps(sbom, indent=1, sort_keys=True) + "\n")
    Path(args.licences).write_text(licences(found, libraries, linked))


if __name__ == "__main__":
    main()
