// What the settings mean.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { test } from "node:test";
import {
  debugAdapter,
  languageServer,
  launchKeys,
  pageFrom,
  recordRobot,
  recordingBeside,
  run,
  send,
  settingsFrom,
  showRecording,
  test as testing,
} from "../src/settings";
import { ELITESERVER } from "./common";

const none = settingsFrom(() => undefined);

test("nothing set, and nonsense set, are the defaults", () => {
  assert.deepEqual(none, { path: "eliteserver", language: "auto", robotAddress: "", runOptions: [] });
  assert.deepEqual(
    settingsFrom(() => 7),
    none,
  );
  assert.deepEqual(
    settingsFrom((key) => (key === "path" ? "  " : undefined)),
    none,
  );
});

test("every command line is one that the program takes", () => {
  const settings = { ...none, path: ELITESERVER, language: "zh" as const, runOptions: ["--model", "cs612"] };
  const lines = [
    languageServer(settings),
    debugAdapter(settings),
    run(settings, "-a.script", "a.mcap"),
    send(settings, "10.0.0.1", "-a.script"),
    recordRobot(settings, "10.0.0.1", "a.mcap"),
    testing(settings, "test_a.script"),
    showRecording(settings, "-a.mcap", "ready.json"),
  ];
  for (const { command, args } of lines) {
    // Before what is a file, the options are read, and --help ends what would follow.
    const end = args.indexOf("--");
    const asked = [...args.slice(0, end < 0 ? args.length : end), "--help"];
    const told = spawnSync(command, asked, { encoding: "utf8" });
    assert.equal(told.status, 0, `${args.join(" ")}: ${told.stderr}`);
    const unknown = spawnSync(command, [...args.slice(0, 1), "--nonsense"], { encoding: "utf8" });
    assert.notEqual(unknown.status, 0);
  }
});

test("options of run become keys of a launch", () => {
  const keys = launchKeys([
    "--model",
    "cs612",
    "--set",
    "a=1",
    "--set=b=2",
    "--home=0,1,2,3,4,5",
    "--powered-off",
    "stray",
  ]);
  assert.deepEqual(keys, { model: "cs612", set: ["a=1", "b=2"], home: "0,1,2,3,4,5", "powered-off": "stray" });
  assert.deepEqual(launchKeys(["--allow", "fs", "--allow", "net"]), { allow: ["fs", "net"] });
});

test("recordings stand beside their programs, pages at their ports", () => {
  assert.equal(recordingBeside("/a.b/pick.script"), "/a.b/pick.mcap");
  assert.equal(recordingBeside("/a.b/pick"), "/a.b/pick.mcap");
  assert.equal(pageFrom('{"pid": 1, "ports": {"http": 4711}}'), "http://127.0.0.1:4711/");
  assert.equal(pageFrom('{"pid": 1'), undefined);
});
