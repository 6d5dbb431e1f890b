"""The true chain: forward kinematics, Newton's method for one posture and for eight, answers measured."""
