"""All joint positions of many flange poses at once, in closed form from the URDF, without the product's help."""

import numpy as np


class Inverse:
    """For arms whose joints 2 to 4 are parallel and whose last three axes are offset as those of the CS series."""

    def __init__(self, arm):
        origins = [origin for origin, _, _ in arm.joints]
        self.arm = arm
        self.d1 = origins[0][2, 3]
        self.a2, self.a3 = origins[2][0, 3], origins[3][0, 3]
        self.d4 = origins[3][2, 3]
        self.d5, self.d6 = -origins[4][1, 3], origins[5][1, 3]

    def __call__(self, poses):
        """Joint positions (N, 8, 6) of flange poses (N, 4, 4), NaN where there are none; proven by forward
        kinematics."""
        found = np.full((len(poses), 8, 6), np.nan)
        x, y = (poses[:, k, 3] - self.d6 * poses[:, k, 2] for k in range(2))
        with np.errstate(invalid="ignore", divide="ignore"):
            for column in range(8):
                shoulder, wrist, elbow = (1 if column >> bit & 1 else -1 for bit in range(3))
                q1 = np.arctan2(y, x) + shoulder * np.arccos(self.d4 / np.hypot(x, y)) + np.pi / 2
                s1, c1 = np.sin(q1), np.cos(q1)
                q5 = wrist * np.arccos((poses[:, 0, 3] * s1 - poses[:, 1, 3] * c1 - self.d4) / self.d6)
                s5 = np.sin(q5)
                q6 = np.arctan2(
                    (-poses[:, 0, 1] * s1 + poses[:, 1, 1] * c1) / s5,
                    (poses[:, 0, 0] * s1 - poses[:, 1, 0] * c1) / s5,
                )
                # Joint 4 as seen from joint 1: joints 2 to 4 turn in a plane.
                after = self._fixed(4, q5) @ self._fixed(5, q6)
                planar = np.linalg.inv(self._fixed(0, q1) @ self.arm.joints[1][0]) @ poses @ np.linalg.inv(after)
                px, py = planar[:, 0, 3], planar[:, 1, 3]
                turn = np.arctan2(planar[:, 1, 0], planar[:, 0, 0])
                q3 = elbow * np.arccos((px**2 + py**2 - self.a2**2 - self.a3**2) / (2 * self.a2 * self.a3))
                q2 = np.arctan2(py, px) - np.arctan2(self.a3 * np.sin(q3), self.a2 + self.a3 * np.cos(q3))
                found[:, column] = np.stack([q1, q2, q3, turn - q2 - q3, q5, q6], axis=1)
        # The closed form is believed only where it leads back to the pose.
        reached = np.eye(4)
        for joint in range(6):
            reached = reached @ self._fixed(joint, found[..., joint])
        wrong = ~(np.abs(reached - poses[:, None]).max(axis=(2, 3)) < 1e-8)
        found[wrong] = np.nan
        return found

    def _fixed(self, joint, angle):
        """Transforms of a joint from the link before it."""
        turned = np.zeros((*np.shape(angle), 4, 4))
        turned[..., 0, 0] = turned[..., 1, 1] = np.cos(angle)
        turned[..., 1, 0] = np.sin(angle)
        turned[..., 0, 1] = -turned[..., 1, 0]
        turned[..., 2, 2] = turned[..., 3, 3] = 1.0
        return self.arm.joints[joint][0] @ turned
