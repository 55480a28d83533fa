#!/usr/bin/env python3
"""Writes an OCI image layout of one static program, without a container engine: the same bytes for the same program.

    packaging/image.py --version 0.1.0 --out FOLDER amd64=PROGRAM arm64=PROGRAM …

The image has the program, the user it runs as (number 65532, no root), a folder that is this user's, and nothing else.
"""

import argparse
import gzip
import hashlib
import io
import json
import os
import tarfile
from datetime import datetime, timezone
from pathlib import Path

USER = 65532
HOME = "var/lib/eliteserver"
PORTS = (30001, 30004, 30011, 30020, 29999, 40011, 502, 5020, 8080)
MANIFEST = "application/vnd.oci.image.manifest.v1+json"
EPOCH = int(os.environ.get("SOURCE_DATE_EPOCH", "0"))
MADE = datetime.fromtimestamp(EPOCH, timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def layer(program, licences):
    """The files of the image as a tar, in one fixed order."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w", format=tarfile.USTAR_FORMAT) as tar:

        def put(name, mode, data=None, owner=0):
            entry = tarfile.TarInfo(name)
            entry.type = tarfile.DIRTYPE if data is None else tarfile.REGTYPE
            entry.mode, entry.mtime, entry.uid, entry.gid = mode, EPOCH, owner, owner
            entry.size = len(data or b"")
            tar.addfile(entry, None if data is None else io.BytesIO(data))

        put("etc", 0o755)
        put("etc/group", 0o644, "root:x:0:\neliteserver:x:{}:\n".format(USER).encode())
        people = "root:x:0:0:root:/:/nonexistent\neliteserver:x:{0}:{0}::/{1}:/nonexistent\n".format(USER, HOME)
        put("etc/passwd", 0o644, people.encode())
        put("tmp", 0o1777)
        put("usr", 0o755)
        put("usr/bin", 0o755)
        put("usr/bin/eliteserver", 0o755, Path(program).read_bytes())
        put("usr/share", 0o755)
        put("usr/share/doc", 0o755)
        put("usr/share/doc/eliteserver", 0o755)
        put("usr/share/doc/eliteserver/licences.txt", 0o644, Path(licences).read_bytes())
        put("var", 0o755)
        put("var/lib", 0o755)
        put(HOME, 0o750, owner=USER)
    return out.getvalue()


class Layout:
    """A folder of blobs named after what they hold."""

    def __init__(self, folder):
        self.folder = Path(folder)
        (self.folder / "blobs" / "sha256").mkdir(parents=True)
        (self.folder / "oci-layout").write_text('{"imageLayoutVersion":"1.0.0"}')

    def blob(self, data, media):
        if not isinstance(data, bytes):
            data = json.dumps(data, sort_keys=True, separators=(",", ":")).encode()
        digest = hashlib.sha256(data).hexdigest()
        (self.folder / "blobs" / "sha256" / digest).write_bytes(data)
        return {"mediaType": media, "digest": "sha256:" + digest, "size": len(data)}

    def image(self, architecture, program, licences, version):
        tar = layer(program, licences)
        packed = self.blob(gzip.compress(tar, 9, mtime=0), "application/vnd.oci.image.layer.v1.tar+gzip")
        config = {
            "created": MADE,
            "architecture": architecture,
            "os": "linux",
            "config": {
                "User": "{0}:{0}".format(USER),
                "Entrypoint": ["/usr/bin/eliteserver"],
                # Inside a container the ports are reached through what the engine publishes,
                # never over its own loopback.
                "Cmd": ["serve", "--bind", "0.0.0.0"],
                "WorkingDir": "/" + HOME,
                "Volumes": {"/" + HOME: {}},
                "ExposedPorts": {"{}/tcp".format(port): {} for port in PORTS},
                "StopSignal": "SIGTERM",
                "Labels": {
                    "org.opencontainers.image.version": version,
                    "org.opencontainers.image.licenses": "Apache-2.0",
                },
            },
            "rootfs": {"type": "layers", "diff_ids": ["sha256:" + hashlib.sha256(tar).hexdigest()]},
            "history": [{"created": MADE, "created_by": "packaging/image.py"}],
        }
        manifest = {
            "schemaVersion": 2,
            "mediaType": MANIFEST,
            "config": self.blob(config, "application/vnd.oci.image.config.v1+json"),
            "layers": [packed],
        }
        described = self.blob(manifest, MANIFEST)
        described["platform"] = {"architecture": architecture, "os": "linux"}
        return described

    def index(self, images, version):
        index = {"schemaVersion": 2, "mediaType": "application/vnd.oci.image.index.v1+json", "manifests": images}
        named = self.blob(index, index["mediaType"]) if len(images) > 1 else dict(images[0])
        named["annotations"] = {"org.opencontainers.image.ref.name": version}
        (self.folder / "index.json").write_text(json.dumps(dict(index, manifests=[named]), sort_keys=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--version", required=True)
    parser.add_argument("--out", required=True, help="a folder that is not there yet")
    parser.add_argument("--licences", required=True)
    parser.add_argument("programs", nargs="+", metavar="ARCHITECTURE=PROGRAM")
    args = parser.parse_args()
    layout = Layout(args.out)
    programs = [entry.partition("=") for entry in args.programs]
    images = [layout.image(architecture, program, args.licences, args.version) for architecture, _, program in programs]
    layout.index(images, args.version)


if __name__ == "__main__":
    main()
