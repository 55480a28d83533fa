// The grammar as the editor reads it: the same engine, the same regular expressions.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { before, test } from "node:test";
import * as oniguruma from "vscode-oniguruma";
import * as textmate from "vscode-textmate";
import { EXTENSION, json } from "./common";

let grammar: textmate.IGrammar;

before(async () => {
  const wasm = createRequire(path.join(EXTENSION, "package.json")).resolve("vscode-oniguruma/release/onig.wasm");
  await oniguruma.loadWASM(readFileSync(wasm));
  const registry = new textmate.Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
      createOnigString: (text) => new oniguruma.OnigString(text),
    }),
    loadGrammar: async () =>
      textmate.parseRawGrammar(JSON.stringify(json("syntaxes/elitescript.tmLanguage.json")), "elitescript.json"),
  });
  const loaded = await registry.loadGrammar("source.elitescript");
  assert(loaded);
  grammar = loaded;
});

/** The pieces of a text with their innermost scopes, without the language's name. */
function pieces(text: string): [string, string][] {
  let state = textmate.INITIAL;
  return text.split("\n").flatMap((line) => {
    const read = grammar.tokenizeLine(line, state);
    state = read.ruleStack;
    return read.tokens.map((token): [string, string] => {
      const scope = token.scopes.at(-1) ?? "";
      return [line.slice(token.startIndex, token.endIndex), scope.replace(/\.?elitescript$/, "")];
    });
  });
}

/** The scope of a piece of a text. */
function scope(text: string, piece: string): string {
  const found = pieces(text).find(([shown]) => shown.trim() === piece);
  assert(found, `${piece} is no piece of ${JSON.stringify(pieces(text))}`);
  return found[1];
}

test("blocks, their ends and secondary programs", () => {
  const text =
    "sec lamp():\n    set_standard_digital_out(0, True)\nend\n\ndef f(a, b=1, *rest, **more):\n    return a\nend";
  assert.equal(scope(text, "sec"), "storage.type.function");
  assert.equal(scope(text, "lamp"), "entity.name.function");
  assert.equal(scope(text, "end"), "keyword.control.end");
  assert.equal(scope(text, "set_standard_digital_out"), "entity.name.function.call");
  assert.equal(scope(text, "True"), "constant.language");
  for (const parameter of ["a", "b", "rest", "more"])
    assert.equal(scope(text, parameter), "variable.parameter.function");
  assert.equal(scope(text, "return"), "keyword.control.flow");
});

test("`end` is a word like any other elsewhere", () => {
  assert.equal(scope("x = end + 1", "end"), "variable.other.readwrite");
  assert.equal(scope("ending = 1", "ending"), "variable.other.readwrite");
  assert.equal(scope("f(end=1)", "end"), "variable.parameter.function-call");
  assert.equal(scope("def f():; g(); end;", "end"), "keyword.control.end");
});

test("directives", () => {
  const text = '    $ LINE: (7, "Approach")\nmovej(q)';
  assert.equal(scope(text, "$"), "punctuation.definition.directive");
  assert.equal(scope(text, "LINE"), "keyword.control.directive");
  assert.equal(scope(text, "7"), "constant.numeric.dec");
  assert.equal(scope(text, "Approach"), "string.quoted.single");
  assert.equal(scope(text, "movej"), "entity.name.function.call");
});

test("numbers", () => {
  for (const [number, kind] of [
    ["0x1F", "hex"],
    ["0b10_1", "bin"],
    ["0o17", "oct"],
    ["1_000", "dec"],
    ["1.5", "float"],
    ["1e-3", "float"],
    [".5", "float"],
    ["2j", "imaginary"],
  ] as const) {
    assert.equal(scope(`x = ${number}`, number), `constant.numeric.${kind}`, number);
  }
  assert.equal(scope("a1 = 2", "a1"), "variable.other.readwrite");
});

test("texts: escapes, raw ones, fields, and what follows them", () => {
  assert.equal(scope("x = 'a\\e\\o12b'", "\\e"), "constant.character.escape");
  assert.equal(scope("x = 'a\\o12b'", "\\o12"), "constant.character.escape");
  assert.equal(scope("x = f'v {speed:.2f} {{}}'", "speed"), "variable.other.readwrite");
  assert.equal(scope("x = f'v {speed:.2f} {{}}'", "{{"), "constant.character.escape");
  assert.equal(scope("x = r'\\d+'", "\\d+"), "string.quoted.raw.single");
  assert.equal(scope("x = '''one\ntwo''' + y", "y"), "variable.other.readwrite");
  assert.equal(scope("x = 'open\ny = 1", "y"), "variable.other.readwrite");
  assert.equal(scope("x = 1  # a 'comment'\ny = 1", "y"), "variable.other.readwrite");
  assert.equal(scope("x = 1 # note", "note"), "comment.line.number-sign");
});

test("names in Chinese, members, full-width brackets", () => {
  assert.equal(scope("速度 = 0.25", "速度"), "variable.other.readwrite");
  assert.equal(scope("a.速度", "速度"), "variable.other.member");
  assert.equal(scope("movej（q)", "（"), "invalid.illegal.full-width");
});

test("no line of the shipped programs leaves a text or a bracket open for the next", () => {
  for (const name of [
    "../../examples/first_light.script",
    "../../examples/testing/pick.script",
    "../../examples/testing/test_pick.script",
  ]) {
    const text = readFileSync(path.join(EXTENSION, name), "utf8");
    const last = pieces(`${text}\nlast`).at(-1);
    assert.deepEqual(last, ["last", "variable.other.readwrite"], name);
  }
});
