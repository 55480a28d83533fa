# Messages of a line computer: JSON in and out, words counted, paths and numbers taken out of text, a report built.
import json
import re


def message(number):
    return {
        "id": number,
        "cell": "cell-%02d" % (number % 7),
        "parts": [
            {
                "name": "part_%d" % (part * number % 13),
                "ok": (part + number) % 4 != 0,
                "weight": part * 0.125 + number % 10,
            }
            for part in range(4)
        ],
        "note": "checked by line %d, shift %s\n\"%s\"" % (number % 5, "abc"[number % 3], "x" * (number % 9)),
    }


NUMBER = re.compile(r"line (\d+), shift (\w)")
words = {}
weights = {}
shifts = {}
size = 0
for number in range(2500):
    text = json.dumps(message(number), sort_keys=number % 2 == 0)
    size += len(text)
    back = json.loads(text)
    for part in back["parts"]:
        if part["ok"]:
            weights[part["name"]] = weights.get(part["name"], 0.0) + part["weight"]
    found = NUMBER.search(back["note"])
    key = (int(found.group(1)), found.group(2))
    shifts[key] = shifts.get(key, 0) + 1
    for word in back["note"].replace(",", " ").replace('"', " ").split():
        words[word.lower()] = words.get(word.lower(), 0) + 1
report = []
for name in sorted(weights):
    report.append("{:<10}|{:>12.3f}|{}".format(name, weights[name], name.title().rjust(9, ".")))
lines = "\n".join(report)
upper = "".join(c.upper() if c.isalpha() else "_" for c in lines)
counts = (size, len(words), words["checked"], len(shifts), sum(shifts.values()), len(lines), upper.count("_"))
print("checksum", *counts, report[0])
