"""Every entry of the counter with the types of its arguments and its result: what is compiled when a wheel is built.

A line reads as the entry's own head, with types; those of `ARGUMENTS` need not be repeated, and what is indented goes
on the line above. Scalars are `int`, `float` and `bool`. An array is its element and its shape, `float[n, 7]`, in C
order: a number, or a name in capitals of the entry's file or of `layout`, is that size, and a letter any size, the same
wherever it stands in a line. Behind an array, `&` says that the entry writes to it.
"""

ARGUMENTS = """
family: float[4, limb.SIZE]
T: float[4, 4]
poses: float[n, 4, 4]
first: int
last: int
psi: float
psis: float[k]
branch: int
seed: float[7]
seeded: bool
seeds: float[m, 7]
respect: bool
verdicts: byte[n]&
H: float[HAND]
given: int
side: float
tie: float
settings: float[path.SETTINGS, 7]
start: float[s, 7]
limited: bool
bodies: float[b, BODY_ROW]
groups: int[g, GROUP]
pairs: int[p, 2]
slack: float[SLACK]
local: float[l, LOCAL_ROW]&
ready: int[g]&
found: float[f, 3]
solids: float[s, SOLID]
of_solid: int[s, OF_SOLID]
points: float[i, 3]
shaped: float[h, SHAPED]
of_body: int[h, OF_BODY]
couples: int[c, PAIR]
outer: float[2, OUTER]
port: float[p]
"""
"""What is meant by names that have one meaning in all rooms; a line may say otherwise."""

ENTRIES = """
pose.solve(family, T, branch, seed, seeded, respect, out: float[ROW]&) -> int
pose.solve_at(family, T, psi, branch, seed, seeded, respect, out: float[ROW]&) -> int
pose.lead(family, T, psi, branch, before: float[7], seed, seeded, respect, out: float[ROW]&) -> bool
pose.solve_range(family, poses, first, last, branch, seeds, respect, out: float[n, ROW]&, verdicts)
pose.solve_at_range(family, poses, first, last, psis, branch, seeds, respect, out: float[n, ROW]&, verdicts)
pose.angles_towards(family, poses, points: float[k, 3], out: float[n]&)
pose.solve_near(family, T, psi, branch, seed, seeded, respect, out: float[ROW]&) -> int
pose.solve_near_range(family, poses, first, last, psis, branch, seeds, respect, out: float[n, ROW]&, verdicts)
pose.solve_all(family, T, psi, respect, out: float[8, ROW]&) -> int
pose.solve_all_range(family, poses, first, last, psis, respect, out: float[r, ROW]&, verdicts)
pose.solve_intervals(family, T, respect, out: float[MOST_INTERVALS, ROW]&) -> int
pose.pack_limits(P: float[limb.SIZE]&, lower: float[7], upper: float[7])
pose.measure_shifts(P: float[limb.SIZE], configurations: float[n, 7], shifts: float[n, SHIFTS]&)
pose.check_pose(T) -> int
pose.self_motion(family, T, found, respect, out: float[n, ROW]&) -> int
pose.intervals_range(family, poses, first, last, respect, rows: float[r, 3]&, counts: int[n]&, verdicts)
    -> (int, int)
pose.intervals(family, T, respect, out: float[MOST_INTERVALS, 3]&) -> int
free_splits.free_splits(family, T, respect, out: float[MOST_SPLITS, SPLIT_ROW]&) -> int
kinematics.forward_range(family, q: float[n, 7], first, last, out: float[n, 4, 4]&)
kinematics.jacobian_range(family, q: float[n, 7], first, last, out: float[n, 6, 7]&)
kinematics.arm_angle_jacobian(family, q: float[7], g: float[7]&) -> bool
kinematics.self_motion_tangent(family, q: float[7], out: float[7]&) -> bool
kinematics.configuration_arm_angle(family, q: float[7]) -> (float, int)
kinematics.centres_range(family, q: float[n, 7], first, last, out: float[3, n, 3]&)
optimum.optimise(family, T, kind: int, second: int, tolerance: float, resolution: float, params: float[PARAMS],
    respect, solution: float[ROW]&, out: float[OUT]&) -> int
optimum.sample(family, T, respect, runs: float[MOST_RUNS, RUN]&, rows: float[n, SAMPLE]&) -> (int, int, int)
optimum.star(family, T, q: float[7], respect, runs: float[MOST_RUNS, RUN]&, rows: float[SPARE_ROWS, SAMPLE]&) ->
    (int, int)
optimum.brackets(rows: float[n, SAMPLE], values: float[n], runs: float[MOST_RUNS, RUN], k: int,
    out: float[MAX_BRACKETS, BRACKET]&) -> int
optimum.next_point(S: float[search.STATE]&) -> (float, bool)
optimum.answer(S: float[search.STATE]&, f: float) -> bool
optimum.begin(S: float[search.STATE]&, bracket: float[BRACKET], resolution: float)
optimum.posture(family, T, rows: float[n, SAMPLE], run: float[RUN], x: float, respect, solution: float[ROW]&) ->
    bool
optimum.interval(family, T, rows: float[n, SAMPLE], run: float[RUN]) -> (float, float)
path.choose_keys(family, poses, has_known: bool[n], keys: bool[n]&, verdicts: int[n]&)
path.sweep(family, poses, keys: int[k], first, carried: int, stop: byte[1], known: float[n, 7], has_known: bool[n],
    held: float[h, HELD], held_ends: int[u], held_alone: bool[n], allowed: float[a, 3], allowed_ends: int[i, 2],
    near: float[n, 7], radius: float[n], spacing: float[n], start, settings, limited, exact: bool,
    nodes: float[N, NODE]&, cost: float[N]&, strips: float[M, STRIP]&, ends: int[e, 4]&) -> (int, int)
path.go_back(keys: int[k], first, count: int, following: int, settings, limited, nodes: float[N, NODE],
    cost: float[N], strips: float[M, STRIP], ends: int[e, 4], q: float[n, 7]&, psi: float[n]&, branch: int[n]&,
    bounds: float[n, 2]&) -> (int, float)
path.fill_between(family, poses, keys: int[k], reached: bool[n]&, settings, q: float[n, 7]&, psi: float[n]&,
    branch: int[n]&, bounds: float[n, 2]&, missed: bool[n]&)
path.refine(family, poses, chain: int[c], fixed: bool[n], bounds: float[n, 2], widths: float[m], enough: float, start,
    settings, limited, q: float[n, 7]&, psi: float[n]&, branch: int[n]&) -> float
path.finish(family, poses, chain: int[c], q: float[n, 7], psi: float[n], branch: int[n], out: float[n, ROW]&)
path.polish(family, poses, chain: int[c], fixed: bool[n], loose: bool[c], bounds: float[n, 2], start, settings,
    kind: int, scale: float[7], weights: float[w], enough: float, q: float[n, 7]&, psi: float[n]&,
    branch: int[n]&) -> float
path_bound.cover(family, poses, first, known: float[n, 7], has_known: bool[n], extra: float[n, 7], longest: float,
    cells: float[M, CELL]&, ends: int[e]&) -> int
path_bound.cut(family, poses, coarse: float[c, CELL], coarse_ends: int[k], longest: float,
    cells: float[M, CELL]&, ends: int[e]&) -> int
path_bound.relax(cells: float[M, CELL], ends: int[e], backward: bool, settings, worth: float[M, WORTH]&)
path_bound.costs_to_end(keys: int[k], first, count: int, behind: int, most: float, stop: byte[1], settings, limited,
    nodes: float[N, NODE]&, cost: float[N], strips: float[M, STRIP]&, ends: int[e, 4], after: float[N]&) -> int
path_bound.reach(cells: float[M, CELL], ends: int[e], backward: bool, limits: float[7], settings,
    spans: float[M, 2]&) -> bool
path.bridge(family, poses, starts: float[n, 7]&, met: bool[n]&)
task.read_tasks(raw: float[n, TASK], given, out: float[n, TASK]&) -> (int, int)
task.posture(family, H, x: float[TASK], given, side, tie, out: float[POSTURE]&)
task.posture_range(family, H, tasks: float[n, TASK], first, last, given, side, tie, out: float[n, POSTURE]&)
task.solve_tasks(family, H, tasks: float[n, TASK], first, last, given, side, tie, seeds, respect,
    out: float[n, TASK_SOLUTION]&)
yardstick.transcendental(angles: float[n, 8], out: float[n]&)
collision.forbidden(family, T, bodies, groups, pairs, slack, local, ready, arcs: float[2, MOST_ARCS, 2]&,
    counts: int[2]&)
collision.free_intervals(family, T, bodies, groups, pairs, slack, local, ready, found, n: int, out: float[o, 3]&) ->
    int
collision.clearance(family, T, bodies, groups, pairs, local, ready, elbow: int, psi, out: float[WIDE]&)
collision.widest(family, T, bodies, groups, pairs, local, ready, found, n: int, tolerance: float,
    out: float[WIDE]&)
collision.best_within(family, T, found, n: int, branch, seed, seeded, respect, out: float[ROW]&) ->
    float
collision.free_range(family, limits: float[4, limb.SIZE], poses, first, last, respect, bodies, groups, pairs, slack,
    local, ready, rows: float[r, 3]&, counts: int[n]&, verdicts) -> (int, int)
collision.march(family, T, found, n: int, bodies, groups, pairs, slack, local, ready,
    out: float[o, 3]&) -> int
collision.solve_range(family, limits: float[4, limb.SIZE], poses, first, last, branch, seeds, respect, limited, bodies,
    groups, pairs, slack, local, ready, out: float[n, ROW]&, verdicts)
collision.edges(family, starts: float[n, 7], ends: float[n, 7], bodies, groups, pairs, slack: float[n, SLACK], local,
    ready, out: float[n, EDGE]&) -> int
collision.free_by_solids(family, T, found, ranges: float[r, 3], margin: float, bodies, groups, pairs, slack, local,
    ready, solids, of_solid, points, shaped, of_body, couples, outer, out: float[o, 3]&, rest: float[q, REST]&) ->
    (int, float, int)
collision.march_by_solids(family, T, found, bodies, groups, pairs, slack, local, ready, solids, of_solid, points,
    shaped, of_body, couples, outer, out: float[o, 3]&) -> int
control.tick(family, weights: float[WEIGHTS], ports: float[n, PORT], states: float[n, STATE]&, bounds: float[b],
    motion: float[2, 7], work: float[w, 7]&) -> bool
control.profile_values(port, distances: float[n], forces: float[n]&, energies: float[n]&)
control.converging_force(port, peak: float, sizes: float[n], forces: float[n]&)
control.free_response(port, mass: float, start: float, dt: float, positions: float[n]&)
control.sampled_response(port, state: float[STATE]&, setting: float[4], forces: float[m]&, out: float[n, 3]&)
maps.reachable_range(family, poses, first, last, out: int[n]&)
maps.margin_range(family, poses, first, last, out: float[n]&)
maps.measure_range(family, poses, first, last, limits: float[2], margin: int, out: float[n, c]&)
maps.measure_cells(family, points: float[n, 3], rotations: float[m, 9], limits: float[2], margin: int,
    out: float[o, c]&)
freedom.solve_range(family, poses, first, last, freedom: float[FREEDOM], turns: float[t, 9], few: int, seeds, respect,
    work: float[WORK]&, starts: float[MOST_STARTS, START]&, out: float[n, ROW]&, verdicts)
track.update(family, state: float[STATE]&, settings: float[s], T, given, work: float[8, 16, 9]&, out: float[STEP]&)
"""
