"""``python -m elitescript``: the version, the built-in arms, and one forward kinematics to see that it works."""

import elitescript


def main() -> None:
    print(f"elitescript {elitescript.__version__}")
    print(f"models: {', '.join(elitescript.models())}")
    robot = elitescript.Robot("cs66")
    q = [0, -1.5708, 1.5708, -1.5708, -1.5708, 0]
    pose = ", ".join(f"{x:.4f}" for x in robot.get_forward_kin(q))
    print(f'Robot("{robot.name}").get_forward_kin({q}) = [{pose}]')


if __name__ == "__main__":
    main()
