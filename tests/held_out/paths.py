"""Paths, excitation and crossings by the words of the contract: the time law by Gauss-Legendre quadrature, straight
lines by slerp and Newton's method, crossings as maximal runs of equal steps in s."""

import math

import numpy as np
from figures import worst
from mechanics import CHUNK, frame, rotation_exp, rotation_log, rpy

GAUSS = np.polynomial.legendre.leggauss(20)


class JointPath:
    def __init__(self, robot, waypoints, feed, tcp):
        self.robot, self.q = robot, np.array(waypoints, dtype=float)
        tcp_r, tcp_p = tcp
        times, self.standing = [], 0
        for a, b in zip(self.q, self.q[1:]):
            pieces = max(1, math.ceil(np.abs(b - a).max() / 0.1))
            nodes = ((np.arange(pieces)[:, None] + 0.5 * (GAUSS[0] + 1)[None, :]) / pieces).ravel()
            weights = np.tile(0.5 * GAUSS[1] / pieces, pieces)
            _, _, jac = robot.tool(a + (b - a) * nodes[:, None], tcp_r, tcp_p)
            length = (weights * np.linalg.norm(jac[:, :3] @ (b - a), axis=1)).sum()
            if length > 1e-9:
                times.append(length / feed)
            else:
                move = np.abs(b - a)
                times.append(max((m / v for m, v in zip(move, robot.velocity) if m > 0), default=0.0))
                self.standing += times[-1] > 0
        self.time = np.concatenate([[0.0], np.cumsum(times)])
        self.duration = self.time[-1]
        keep = np.concatenate([[True], np.diff(self.time) > 0])
        self.time, self.q = self.time[keep], self.q[keep]

    def at(self, s):
        t = np.asarray(s) * self.duration
        if len(self.time) == 1:
            return np.repeat(self.q[:1], len(t), axis=0)
        k = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, len(self.time) - 2)
        u = ((t - self.time[k]) / (self.time[k + 1] - self.time[k]))[:, None]
        return self.q[k] + (self.q[k + 1] - self.q[k]) * u


class PosePath:
    """Straight lines of the tool centre point; the arm's branch is the one that the program starts in."""

    def __init__(self, robot, poses, feed, tcp, start):
        self.robot, self.poses, self.tcp = robot, poses, tcp
        times, q = [], start
        self.ok = True
        self.least_singular = np.inf
        track_q, track_t = [start], [0.0]
        for (ra, pa), (rb, pb) in zip(poses, poses[1:]):
            length = np.linalg.norm(pb - pa)
            turn = rotation_log(ra.T @ rb)
            steps = max(2, math.ceil(length / 0.004), math.ceil(np.linalg.norm(turn) / 0.02))
            ways, track = np.zeros(len(robot.moving)), []
            for i in range(1, steps + 1):
                u = i / steps
                goal = ra @ rotation_exp(turn * u)
                new, residual = robot.solve_pose(goal[None], (pa + (pb - pa) * u)[None], *tcp, q[None], steps=8)
                new = new[0]
                if not residual[0] < 1e-9 or np.abs(new - q).max() > 0.5:
                    self.ok = False
                    return
                if (new < robot.lower).any() or (new > robot.upper).any():
                    self.ok = False
                    return
                jac = robot.tool(new[None], *tcp)[2][0]
                self.least_singular = min(self.least_singular, np.linalg.svd(jac, compute_uv=False)[-1])
                ways += np.abs(new - q)
                q = new
                track.append(q)
            duration = length / feed if length > 1e-9 else (ways / robot.velocity).max()
            if duration > 0:
                start_t = sum(times)
                track_q += track
                track_t += [start_t + duration * i / steps for i in range(1, steps + 1)]
            times.append(duration)
        self.time = np.concatenate([[0.0], np.cumsum(times)])
        self.duration = self.time[-1]
        self.track_t, self.track_q = np.array(track_t), np.array(track_q)

    def pose(self, s):
        t = np.asarray(s) * self.duration
        rotation, point = np.empty((len(t), 3, 3)), np.empty((len(t), 3))
        k = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, max(len(self.time) - 2, 0))
        if len(self.poses) == 1 or self.duration == 0:
            rotation[:], point[:] = self.poses[0]
            return rotation, point
        for i in np.unique(k):
            here = k == i
            (ra, pa), (rb, pb) = self.poses[i], self.poses[i + 1]
            u = ((t[here] - self.time[i]) / (self.time[i + 1] - self.time[i]))[:, None]
            rotation[here] = ra @ rotation_exp(u * rotation_log(ra.T @ rb))
            point[here] = pa + (pb - pa) * u
        return rotation, point

    def at(self, s):
        s = np.asarray(s, dtype=float)
        t = s * self.duration
        seeds = np.stack([np.interp(t, self.track_t, c) for c in self.track_q.T], axis=1)
        if self.duration == 0:
            return np.repeat(self.track_q[:1], len(s), axis=0)
        out = []
        rotation, point = self.pose(s)
        for i in range(0, len(s), CHUNK):
            q, residual = self.robot.solve_pose(rotation[i : i + CHUNK], point[i : i + CHUNK], *self.tcp, seeds[i : i + CHUNK])
            worst("own inverse kinematics residual", residual.max())
            out.append(q)
        return np.concatenate(out)


def joints_of(robot, rows):
    """deg -> rad; a prismatic joint's rows are mm."""
    return np.where(robot.slides, np.array(rows, dtype=float) / 1000, np.radians(np.array(rows, dtype=float)))


def poses_of(job, rows):
    rw, pw = frame(job.get("work_object"))
    out = []
    for row in rows:
        r = rpy(np.radians(row.get("rpy_deg", [0, 0, 0])))
        out.append((rw @ r, pw + rw @ (np.array(row["xyz_mm"], dtype=float) / 1000)))
    return out


def lines_of(job):
    """[(source, harmonic, order)]; what coincides is told once, as tooth passing."""
    z, policy = job["tool"]["teeth"], job.get("policy", {})
    lines = [("tooth_passing", h, h * z) for h in range(1, policy.get("tooth_passing_harmonics", 2) + 1)]
    taken = {order for *_, order in lines}
    lines += [("spindle", h, h) for h in range(1, policy.get("spindle_harmonics", 1) + 1) if h not in taken]
    return lines


def rpm_of(operation, s):
    if "spindle_rpm" in operation:
        return np.full(len(s), float(operation["spindle_rpm"]))
    points = operation["spindle_schedule"]
    return np.interp(s, [p["s"] for p in points], [p["rpm"] for p in points])


def runs_of(state, s):
    """Maximal stretches of one state: [(certainty, from, to, first, last)], ends halfway between samples."""
    change = np.flatnonzero(np.diff(state)) + 1
    edges = np.concatenate([[0], change, [len(state)]])
    out = []
    for a, b in zip(edges, edges[1:]):
        if state[a]:
            begin = s[0] if a == 0 else 0.5 * (s[a - 1] + s[a])
            end = s[-1] if b == len(state) else 0.5 * (s[b - 1] + s[b])
            out.append((["", "uncertain", "certain"][state[a]], begin, end, a, b))
    return out


def states(job, robot, operation, s, f, tip):
    """(line, mode) -> array of 0 none, 1 uncertain, 2 certain."""
    policy = job.get("policy", {})
    separation = policy.get("separation_percent", 10) / 100
    wide = separation + policy.get("model_uncertainty_percent", robot.uncertainty) / 100
    least = policy.get("min_tip_response_um_per_n", 0)
    rpm = rpm_of(operation, s)
    for line in lines_of(job):
        exc = line[2] * rpm / 60
        ignored = np.zeros(len(s), dtype=bool)
        for low, high in policy.get("ignore_hz", []):
            ignored |= (exc >= low) & (exc <= high)
        for r in range(robot.n):
            apart = np.abs(exc - f[:, r])
            state = (apart < f[:, r] * wide).astype(int) + (apart < f[:, r] * separation)
            state[ignored] = 0
            if least > 0:
                state[tip[:, r] < least] = 0
            if state.any():
                yield line, r, state, apart / f[:, r], exc
