"""The joint-speed limiter of force mode against quadprog (Goldfarb and Idnani's dual method), an independent solver.

    cargo run -p force --example problems | python tests/peers/qp_gap.py

Prints the largest gap of the objective and the largest difference of the joint speeds; exit 1 when a gap is over 1e-6.
"""

import json
import sys

import numpy
import quadprog

REGULARISATION = 1e-6


def main():
    gaps, differences, methods = [], [], {}
    for line in sys.stdin:
        problem = json.loads(line)
        jacobian = numpy.array(problem["jacobian"])
        wanted, before, found = (numpy.array(problem[k]) for k in ("wanted", "before", "qd"))
        lower, upper = numpy.array(problem["lower"]), numpy.array(problem["upper"])
        # A component that is too fast already is only kept from becoming faster.
        limits = numpy.maximum(problem["limits"], abs(jacobian @ before))
        quadratic = jacobian.T @ jacobian + REGULARISATION * numpy.eye(6)
        linear = jacobian.T @ wanted
        rows = numpy.vstack([numpy.eye(6), -numpy.eye(6), jacobian, -jacobian])
        bounds = numpy.concatenate([lower, -upper, -limits, -limits])
        best = quadprog.solve_qp(quadratic, linear, rows.T, bounds)[0]
        objective = lambda qd: qd @ quadratic @ qd / 2 - linear @ qd
        gaps.append(objective(found) - objective(best))
        differences.append(abs(found - best).max())
        methods[problem["method"]] = methods.get(problem["method"], 0) + 1
        assert (rows @ found >= bounds - 1e-9).all()
    print(f"{len(gaps)} problems {methods}: largest gap {max(gaps):.1e}, least {min(gaps):.1e},")
    print(f"largest difference of a joint speed {max(differences):.1e} rad/s")
    return max(gaps) > 1e-6


if __name__ == "__main__":
    sys.exit(main())
