//! Long operations on integers give what short ones give, and a stop ends them.

use crate::support;

use elite_lang::{Resume, ResumeOutcome};
use support::Task;

#[test]
fn long_products_quotients_and_powers_agree_with_each_other() {
    let output = Task::new().run(
        "
import math
seed = 12345
def number(bits):
    global seed
    value = 0
    for _ in range(bits // 61 + 1):
        seed = (seed * 6364136223846793005 + 1442695040888963407) % 2**64
        value = value << 61 | seed >> 3
    return value >> value.bit_length() - bits | 1 << bits - 1
for n in [2**63 - 1, 2**63, 2**64 + 3, 10**30]:
    if math.perm(n, 0) != 1 or math.comb(n, 0) != 1 or math.comb(n, n) != 1: print('nothing to choose', n)
    if math.perm(n, 3) != n * (n - 1) * (n - 2) or math.comb(n, 2) != n * (n - 1) // 2: print('choices', n)
    if math.comb(n, n - 2) != n * (n - 1) // 2 or math.comb(5, n) or math.perm(5, n): print('other choices', n)
prime = 2**61 - 1
sizes = [1, 64, 2000, 140_000, 290_001]
for m in sizes:
    for n in sizes:
        a, b = number(m), number(n)
        p = a * b
        if p % prime != (a % prime) * (b % prime) % prime: print('product', m, n)
        if p // a != b or p % b != 0: print('exact quotient', m, n)
        for x, y in [(a, b), (-a, b), (a, -b), (-a, -b)]:
            q, r = divmod(x, y)
            if q * y + r != x or not (0 <= r < y or y < r <= 0): print('quotient', m, n)
            if x // y != q or x % y != r: print('parts', m, n)
for bits in sizes:
    a = number(bits)
    r = math.isqrt(a)
    if not r * r <= a < (r + 1) * (r + 1): print('root', bits)
    if math.isqrt(a * a) != a or math.isqrt(a * a - 1) != a - 1: print('root of a square', bits)
for bits in [1, 64, 65, 200, 3000]:
    for other in [1, 64, 65, 190, 2000, 7000]:
        a, b, c = number(bits), number(other), number(100)
        g = math.gcd(a * c, b * c)
        if g % c or a * c % g or b * c % g: print('gcd', bits, other)
        x, y = a, b
        while y: x, y = y, x % y
        if g != x * c or math.gcd(-a, b) != x or math.gcd(b, a) != x: print('gcd is not the greatest', bits, other)
        if math.lcm(a, b) * x != a * b: print('lcm', bits, other)
for base in [2, 3, -3, 10, -24, number(100)]:
    for exponent in [1, 2, 63, 700]:
        power = 1
        for _ in range(exponent): power *= base
        if base ** exponent != power: print('power', base, exponent)
for bits in [10, 64, 700, 9000]:
    for sign in [1, -1]:
        m = sign * number(bits)
        a, e = number(2 * bits), number(40)
        if pow(a, 65, m) != a ** 65 % m: print('power modulo', bits, sign)
        if pow(a, e, m) * a % m != pow(a, e + 1, m): print('next power modulo', bits, sign)
        if math.gcd(a, m) == 1 and pow(a, -1, m) * a % m != 1 % m: print('inverse', bits, sign)
e = (1 << 3000) + 12345
m = number(3001)
if pow(7, e, m) * 7 % m != pow(7, e + 1, m): print('long exponent')
print('done')
",
    );
    assert_eq!(output, "done\n");
}

#[test]
fn a_stop_ends_long_operations_on_integers() {
    for operation in [
        "math.gcd((1 << 4_000_000) - 1, 3 ** 2_000_000)",
        "math.lcm((1 << 2_000_000) - 1, 3 ** 600_000)",
        "pow(3, (1 << 100_000) - 1, (1 << 100_000) - 3)",
        "pow(3 ** 1_000_000, -1, (1 << 2_000_000) - 1)",
        "math.isqrt(3 ** 2_000_000)",
        "3 ** 2_000_000 // 7 ** 500_000",
        "(3 ** 900_000) * (7 ** 700_000)",
        "7 ** 1_390_000",
    ] {
        let text = format!("import math\nwhile True:\n    x = {operation}\n");
        let task = Task::new();
        let mut thread = task.spawn(&text);
        for _ in 0..20 {
            let step = thread.resume(Resume::Continue, 10_000);
            assert!(matches!(step, ResumeOutcome::OutOfFuel), "{operation}");
        }
        let step = thread.resume(Resume::Stop, 10_000);
        assert!(
            matches!(step, ResumeOutcome::Stopped),
            "{operation}: {step:?}"
        );
    }
}
