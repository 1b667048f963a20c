"""All solutions of contact problems of one or two nodes that move in a plane, state by state.

S is ordered as (normal of every node, tangential of every node), the second tangential
direction is neither coupled nor loaded, the coefficient of friction F is constant. Every
node is open, sticks, or slips in one of two directions: each choice is a linear system, and
a solution where its inequalities hold.
"""

import itertools

import numpy

OPEN, STICK, FORTH, BACK = "open", "stick", "forth", "back"
STATES = (OPEN, STICK, FORTH, BACK)
SIGN = {FORTH: 1.0, BACK: -1.0}


def solve_state(S, h, friction, states):
    """The multipliers of one choice of states, `None` where its system is singular."""
    m = len(states)
    matrix, rhs = S.copy(), h.copy()
    for i, state in enumerate(states):
        if state == OPEN:
            matrix[i] = 0.0
            matrix[i, i], rhs[i] = 1.0, 0.0
        if state != STICK:
            matrix[m + i] = 0.0
            matrix[m + i, m + i], rhs[m + i] = 1.0, 0.0
        if state in SIGN:
            matrix[m + i, i] = -SIGN[state] * friction
    if numpy.linalg.cond(matrix) > 1e14:
        return None, 0
    return numpy.linalg.solve(matrix, rhs), numpy.sign(numpy.linalg.det(matrix))


def holds(S, h, friction, states, multiplier, slack):
    """Whether the inequalities hold, up to `slack` times the sizes of stresses and ways."""
    m = len(states)
    r = S @ multiplier - h
    stress, way = numpy.abs(multiplier).max() * slack, numpy.abs(h).max() * slack
    for i, state in enumerate(states):
        normal, tangential = multiplier[i], multiplier[m + i]
        good = {
            OPEN: r[i] >= -way,
            STICK: normal >= -stress and abs(tangential) <= friction * normal + stress,
            FORTH: normal >= -stress and -r[m + i] >= -way,
            BACK: normal >= -stress and r[m + i] >= -way,
        }[state]
        if not good:
            return False
    return True


def all_solutions(S, h, friction, slack=0.0):
    """All of the 4^m choices whose inequalities hold: states, multipliers, sign of det."""
    found = []
    for states in itertools.product(STATES, repeat=len(h) // 2):
        multiplier, sign = solve_state(S, h, friction, states)
        if multiplier is not None and holds(S, h, friction, states, multiplier, slack):
            found.append((states, multiplier, sign))
    return found


def one_node_slip_runs_to_infinity(S):
    """F* = S_nn / |S_nt|."""
    return S[0, 0] / abs(S[0, 1])
