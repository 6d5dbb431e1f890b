"""Entry points: one tick of a torque controller, its force profiles, and a mass on one axis."""

import math

from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.chain.gravity import hold
from srs_ik.kernels.chain.kinematics import joint_lines
from srs_ik.kernels.control.impedance import along_axis, response
from srs_ik.kernels.control.ports import Motion, act
from srs_ik.kernels.control.profile import energy, force
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.control import GRAVITY, LARGEST_SPEED, LINES, MAX_TORQUE, TORQUE, TURNED, WEIGHT
from srs_ik.kernels.layout.limb import LIMITED

LARGEST_ANGLE = 1e6


@entry
def tick(family, weights, ports, states, bounds, motion, work):
    """Write the torques for the angles and speeds in motion (2, 7) into the first row of work (WORK, 7).

    Notes in states (n, STATE) what the ports (n, PORT) felt. Returns whether angles and speeds are finite and not
    absurdly large; where they are not, nothing is written.
    """
    for joint in range(7):
        if not (abs(motion[0, joint]) <= LARGEST_ANGLE and abs(motion[1, joint]) <= LARGEST_SPEED):
            return False
    P = row(family, LIMITED)
    q = read7(row(motion, 0))
    J = work[LINES : LINES + 6]
    now = Motion(q, read7(row(motion, 1)), joint_lines(P, q, J), J)
    for joint in range(7):
        work[TORQUE, joint] = 0.0
        work[WEIGHT, joint] = 0.0
    for i in range(len(ports)):
        act(P, row(ports, i), states[i], now, work)
    if bounds[GRAVITY] == 1.0:
        hold(P, row(weights, 0), q, work, TURNED, WEIGHT)
    for joint in range(7):
        largest = bounds[MAX_TORQUE + joint]
        work[TORQUE, joint] = max(-largest, min(largest, work[TORQUE, joint] + work[WEIGHT, joint]))
    return True


@entry
def profile_values(port, distances, forces, energies):
    """Write force and energy of a port's profile at distances (n,)."""
    for i in range(len(distances)):
        forces[i] = force(port, distances[i])
        energies[i] = energy(port, distances[i])


@entry
def converging_force(port, peak, sizes, forces):
    """Write the force of a port at sizes (n,) of an error that shrinks from a peak."""
    for i in range(len(sizes)):
        forces[i] = response(port, sizes[i], peak, True)


@entry
def free_response(port, mass, start, dt, positions):
    """Write the error of a free mass on one axis, let go at `start` at rest, every dt (s) into positions (n,).

    The law of convergence in continuous time, by the method of Runge and Kutta of order 4.
    """
    x, v = start, 0.0
    for i in range(len(positions)):
        positions[i] = x
        a1 = -response(port, x, start, True) / mass
        v2 = v + 0.5 * dt * a1
        a2 = -response(port, x + 0.5 * dt * v, start, True) / mass
        v3 = v + 0.5 * dt * a2
        a3 = -response(port, x + 0.5 * dt * v2, start, True) / mass
        v4 = v + dt * a3
        a4 = -response(port, x + dt * v3, start, True) / mass
        x += dt / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v += dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@entry
def sampled_response(port, state, setting, forces, out):
    """A mass on one axis under a controller that samples, holds its force, and acts late.

    setting (4,): mass (kg), start (m), period and delay (s). forces (periods of delay + 2,) is work space. Each row of
    out (n, 3) is position (m), speed (m/s) and force (N) at a sample; between two changes of the force the motion is
    a parabola, without error.
    """
    mass, x, v, period = setting[0], setting[1], 0.0, setting[2]
    late = min(math.floor(setting[3] / period + 1e-9), len(forces) - 2)
    rest = max(setting[3] - late * period, 0.0)
    for i in range(len(forces)):
        forces[i] = 0.0
    for k in range(len(out)):
        for i in range(late + 1):
            forces[late + 1 - i] = forces[late - i]
        forces[0] = along_axis(port, state, 0, -x, v)
        out[k, 0], out[k, 1], out[k, 2] = x, v, forces[0]
        a = forces[late + 1] / mass
        x += rest * (v + 0.5 * rest * a)
        v += rest * a
        a = forces[late] / mass
        h = period - rest
        x += h * (v + 0.5 * h * a)
        v += h * a
