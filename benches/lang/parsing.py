# Lines as a sensor or a PLC sends them: splitting, converting, formatting answers.
def line(number):
    fields = (number, number * 0.25, -number / 8, number % 5 != 0, "abc"[number % 3] * 3)
    return "ID=%d;X=%.3f;Y=%.3f;OK=%s;T=%s" % fields


def parse(text):
    fields = {}
    for part in text.split(";"):
        name, _, value = part.partition("=")
        fields[name] = value
    return fields


total = 0.0
good = 0
answers = []
for number in range(30000):
    fields = parse(line(number).strip())
    if fields["OK"] == "True":
        good += 1
        total += float(fields["X"]) + float(fields["Y"])
    answers.append("{:06d}|{:>9}|{}".format(int(fields["ID"]), fields["X"], fields["T"].upper()))
text = "\n".join(answers)
print("checksum", good, round(total, 3), len(text), text.count("AAA"), answers[-1])
